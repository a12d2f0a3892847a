"""The methods of simulation by the names that files and the shell use."""

from __future__ import annotations

from typing import Any

from .alpha import HHT, GeneralizedAlpha
from .ida import IDA
from .ode import ODE
from .radau import Radau

METHODS: dict[str, Any] = {kind.__name__.lower(): kind for kind in (HHT, GeneralizedAlpha, Radau, ODE, IDA)}
