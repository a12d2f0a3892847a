"""Multibody system analysis with exact derivatives.

    Model → System → analysis → result → view

A model is what a person says; a system is that model compiled to arrays; analyses take a system and give back results,
which are values. Names are imported when they are first used, so that ``import sarrus`` is quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .analyses import ODE as ODE
    from .analyses import assemble as assemble
    from .analyses import simulate as simulate
    from .model import RSDA as RSDA
    from .model import TSDA as TSDA
    from .model import AngleFriction as AngleFriction
    from .model import AngleStop as AngleStop
    from .model import AxisAngle as AxisAngle
    from .model import Body as Body
    from .model import Bushing as Bushing
    from .model import Curve as Curve
    from .model import Cylindrical as Cylindrical
    from .model import Distance as Distance
    from .model import Drag as Drag
    from .model import EulerAngles as EulerAngles
    from .model import Fixed as Fixed
    from .model import Formula as Formula
    from .model import Frame as Frame
    from .model import LengthStop as LengthStop
    from .model import Model as Model
    from .model import ModelError as ModelError
    from .model import Point as Point
    from .model import PointForce as PointForce
    from .model import Revolute as Revolute
    from .model import RoadTyre as RoadTyre
    from .model import SarrusError as SarrusError
    from .model import SphereContact as SphereContact
    from .model import Spherical as Spherical
    from .model import Torque as Torque
    from .model import Translational as Translational
    from .model import TravelFriction as TravelFriction
    from .model import TravelStop as TravelStop
    from .model import Tyre as Tyre
    from .model import Universal as Universal
    from .model import ViscousDrag as ViscousDrag
    from .model import ground as ground
    from .model import load as load
    from .results import Assembly as Assembly
    from .results import Trajectory as Trajectory
    from .system import System as System

__version__ = "0.1.0"

_HOMES = {
    "model": (
        "AngleFriction AngleStop AxisAngle Body Bushing Curve Cylindrical Distance Drag EulerAngles Fixed Formula "
        "Frame LengthStop Model ModelError Point PointForce RSDA Revolute RoadTyre SarrusError SphereContact "
        "Spherical TSDA Torque Translational TravelFriction TravelStop Tyre Universal ViscousDrag ground load"
    ),
    "system": "System",
    "analyses": "ODE assemble simulate",
    "results": "Assembly Trajectory",
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names.split()}

__all__ = [*sorted(_HOME_OF), "__version__"]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'sarrus' has no attribute {name!r}")
    value = getattr(import_module(f".{_HOME_OF[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
