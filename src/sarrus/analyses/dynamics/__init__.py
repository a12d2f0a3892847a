"""Integration in time: one method in one file, behind one `simulate`."""

from typing import Any

from .alpha import HHT, GeneralizedAlpha
from .events import Event, Impact
from .ida import IDA
from .ode import ODE
from .radau import Radau
from .recipe import repeat, resume
from .simulation import simulate

METHODS: dict[str, Any] = {kind.__name__.lower(): kind for kind in (HHT, GeneralizedAlpha, Radau, ODE, IDA)}

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
