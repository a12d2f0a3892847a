"""Integration in time: one method in one file, behind one `simulate`."""

from .alpha import HHT, GeneralizedAlpha
from .events import Event, Impact
from .ida import IDA
from .methods import METHODS
from .ode import ODE
from .radau import Radau
from .recipe import repeat, resume
from .simulation import simulate

__all__ = [
    "HHT",
    "IDA",
    "METHODS",
    "ODE",
    "Event",
    "GeneralizedAlpha",
    "Impact",
    "Radau",
    "repeat",
    "resume",
    "simulate",
]
