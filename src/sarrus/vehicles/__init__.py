"""Vehicles: the kinematics and compliance of suspensions on a rig, and manoeuvres of vehicles that drive.

A `Corner` names the wheel and the parts that guide it, the rig adds pads and drivers to the model, and a characteristic
is a function of the recorded positions of a wheel: its slopes and its derivatives follow from those of kinematics.

A manoeuvre is a run from straight driving, `rolling_start`, with the responses by which it is judged.
"""

from .corner import Corner as Corner
from .cornering import constant_radius_cornering as constant_radius_cornering
from .cornering import steady_state_cornering as steady_state_cornering
from .cornering import steering_response as steering_response
from .handling import sine_with_dwell as sine_with_dwell
from .handling import step_steer as step_steer
from .handling import straight_braking as straight_braking
from .lane_change import double_lane_change as double_lane_change
from .manoeuvre import Manoeuvre as Manoeuvre
from .manoeuvre import VehicleNames as VehicleNames
from .result import Suspension as Suspension
from .ride import ride as ride
from .ride import weighting_filters as weighting_filters
from .rolling_start import rolling_start as rolling_start
from .suspension import suspension as suspension
from .swept_sine import SweptSine as SweptSine
from .swept_sine import swept_sine_steer as swept_sine_steer
from .wheel import Vehicle as Vehicle
