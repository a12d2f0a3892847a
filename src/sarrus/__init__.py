"""Multibody system analysis with exact derivatives.

    Model → System → analysis → result → view

A model is what you describe; a system is that model compiled to arrays; analyses take a system and return results,
which are values. Names are imported when they are first used, so that ``import sarrus`` is quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from . import deferred, exports

if (
    TYPE_CHECKING
):  # what is public, for type checkers and for `exports`: of these packages, all that they import
    from .analyses import *
    from .analyses.sensitivity import sensitivity as sensitivity
    from .analyses.sensitivity import sensitivity_by_checkpoints as sensitivity_by_checkpoints
    from .analyses.workspace import workspace as workspace
    from .analyses.workspace import workspace_field as workspace_field
    from .analyses.workspace import workspace_range as workspace_range
    from .analyses.workspace import workspace_volume as workspace_volume
    from .io import *
    from .model import *
    from .results import Assembly as Assembly
    from .results import Equilibrium as Equilibrium
    from .results import EventRecord as EventRecord
    from .results import FrequencyResponse as FrequencyResponse
    from .results import Gradient as Gradient
    from .results import Hessian as Hessian
    from .results import InputSingularities as InputSingularities
    from .results import Mobility as Mobility
    from .results import Modes as Modes
    from .results import Optimum as Optimum
    from .results import Reaction as Reaction
    from .results import ShapeDerivative as ShapeDerivative
    from .results import Singularity as Singularity
    from .results import Solution as Solution
    from .results import State as State
    from .results import StateSpace as StateSpace
    from .results import Trajectory as Trajectory
    from .results import Workspace as Workspace
    from .results import WorkspaceField as WorkspaceField
    from .results import WorkspaceRange as WorkspaceRange
    from .results import WorkspaceVolume as WorkspaceVolume
    from .results import load_run as load_run
    from .studies import *
    from .system import System as System
    from .vehicles import *
    from .views import animate as animate
    from .views import view as view

__version__ = "0.3.0"  # of the package, the documentation and tags


_HOME_OF = dict(exports.names(__file__))

__all__ = [*sorted(_HOME_OF), "__version__"]  # pyright: ignore[reportUnsupportedDunderAll]


deferred.importer.register(lambda: import_module(".io", __name__).load_any)
deferred.exporter.register(lambda: import_module(".io", __name__).export)
deferred.renderer.register(lambda: import_module(".views", __name__))
deferred.equilibrium.register(lambda: import_module(".analyses.equilibria.statics", __name__).equilibrium)
deferred.forward.register(
    lambda: import_module(".analyses.forward.forward_dynamics", __name__).ForwardDynamics
)
deferred.sharers.register(
    lambda: import_module(".analyses.redundancy.redundant_constraints", __name__).sharing
)
deferred.corrector.register(lambda: import_module(".analyses.redundancy.rounding", __name__).corrected)
deferred.accumulator.register(
    lambda: import_module(".analyses.dynamics.dense_output.accumulated", __name__).accumulated
)
deferred.estimator.register(
    lambda: import_module(".analyses.sensitivity.derivatives", __name__).error_estimates
)
deferred.saver.register(lambda: import_module(".results.writing", __name__).save_finished)


def __getattr__(name: str) -> Any:
    if name in _HOME_OF:
        globals()[name] = value = getattr(import_module(_HOME_OF[name], __name__), name)
        return value
    gone = import_module(".model.deprecated", __name__).withdrawn("sarrus", name)
    raise AttributeError(gone or f"module 'sarrus' has no attribute {name!r}.{_near(name)}")


def _near(name: str) -> str:
    """What takes the place of a name of another program, or else a question that names a similar public name."""
    if name.startswith("_"):
        return ""
    if known := import_module(".model.checks.other_programs", __name__).instead_of(name):
        return f" {known}"
    near: str = import_module(".model.show", __name__).suggest(name, __all__)
    return f" {near}" if near.startswith("Did") else ""


def __dir__() -> list[str]:
    return __all__
