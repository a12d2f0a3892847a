"""Integration in time: one method in one file, behind one `simulate`."""

from .events.events import Event, Impact
from .integrators.alpha import HHT, GeneralizedAlpha
from .integrators.ida import IDA
from .integrators.ode import ODE
from .integrators.radau import Radau
from .methods.registry import METHODS, integration_method, solver
from .simulation import simulate
from .time_loop.recipe import repeat, resume

for _kind in (Radau, HHT, GeneralizedAlpha):
    integration_method(_kind)
for _other in (ODE, IDA):
    solver(_other)

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
