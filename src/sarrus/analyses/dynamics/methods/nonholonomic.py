"""Methods for systems with nonholonomic constraints, whose last rows Φ_q v = 0 have no Φ.

Where a method solves Φ = 0 for the multipliers λ, these rows are solved for λ too, in the same places: the equation of
positions has the holonomic rows, and one of velocities the others. Its scale is such that both depend alike on the
unknowns. Where a method solves both, Φ = 0 for λ and Φ_q v + Φ_t = 0 for μ, the equation of velocities keeps its
holonomic rows; there is no μ of the others.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

from ....system import System
from .description import ALL, HOLONOMIC, NONHOLONOMIC, Description, Equation, Operation, Stage, Step


def method_for(system: System, method: Description) -> Description:
    """The method as it is for a system: itself, if all constraints are holonomic."""
    return method if system.m_holonomic == system.m else _adapted(method)


def operation_for(system: System, operation: Operation) -> Operation:
    """The same for another operation."""
    if system.m_holonomic == system.m:
        return operation
    return replace(operation, step=adapted(operation.step, operation.unknowns))


@lru_cache(32)
def _adapted(method: Description) -> Description:
    return replace(method, step=partial(_step, method))


def _step(method: Description, h: Any, ratio: Any) -> Step:
    return adapted(method.step(h, ratio), method.unknowns)


def adapted(step: Step, unknowns: Collection[str]) -> Step:
    """A step whose equations of positions and velocities are divided by rows."""
    return step._replace(equations=tuple(_divided(step, unknowns)))


def _divided(step: Step, unknowns: Collection[str]) -> Iterator[Equation]:
    of_velocity = {one.stage: one.scale for one in step.equations if one.kind == "velocity"}
    of_position = {one.stage for one in step.equations if one.kind == "position"}
    for one in step.equations:
        stage = step.stages[one.stage]
        if one.rows != ALL:
            yield one
        elif one.kind == "position":
            yield one._replace(rows=HOLONOMIC)
            if stage.v:
                scale = of_velocity.get(one.stage, one.scale * _ratio(stage, unknowns))
                yield Equation("velocity", one.stage, scale, NONHOLONOMIC)
        elif one.kind == "velocity" and one.stage in of_position:
            yield one._replace(rows=HOLONOMIC)
        else:
            yield one


def _ratio(stage: Stage, unknowns: Collection[str]) -> Any:
    """Return the ratio of the derivatives of q and v of a stage with respect to an unknown."""
    common = next((name for name in unknowns if name in stage.q and name in stage.v), None)
    return 1.0 if common is None else stage.q[common] / stage.v[common]
