"""Integration in time: one method in one file, behind one `simulate`."""

from typing import Any

from .events.events import Event, Impact
from .integrators.alpha import HHT, GeneralizedAlpha
from .integrators.ida import IDA
from .integrators.ode import ODE
from .integrators.radau import Radau
from .simulation import simulate
from .time_loop.recipe import repeat, resume

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
