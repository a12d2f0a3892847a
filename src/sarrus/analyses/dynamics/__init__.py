"""Integration in time: one method in one file, behind one `simulate`."""

from .events.events import Event, Impact
from .integrators.alpha import HHT, GeneralizedAlpha
from .integrators.described import Radau
from .integrators.ode import ODE
from .recipe import repeat, resume
from .simulation import simulate

__all__ = [
    "HHT",
    "ODE",
    "Event",
    "GeneralizedAlpha",
    "Impact",
    "Radau",
    "repeat",
    "resume",
    "simulate",
]
