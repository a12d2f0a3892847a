"""Verification of a result: the analysis is repeated with finer settings, and both are compared."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, cast

import numpy as np

from ..algebra import Array
from ..model.announcement import Call, reports_warnings
from ..model.checks.arguments import Number
from ..outputs.bodies import CARDAN
from ..outputs.motion import several
from ..outputs.units import in_base
from ..results import Gradient, Trajectory, Workspace
from ..results.comparison import ComparedValue, Comparison
from ..results.motion.tables import columns
from ..results.result import Result
from .arguments import kind
from .driven.kinematics import kinematics
from .dynamics.error_goal import finer
from .dynamics.integrators.differentiable import method_with_options
from .dynamics.simulation import arguments_of, simulate
from .dynamics.stepping.step_control import with_control
from .dynamics.stepping.tolerance import Tolerances
from .equations.length import extent
from .equilibria.balance import FINISHED
from .equilibria.statics import equilibrium
from .sensitivity.combined import Part
from .sensitivity.derivatives import sensitivity
from .workspace.analysis import workspace
from .workspace.regions.mapping import WorkspaceMap

DIGITS = 4.0
STRIDE = 0.5  # of the longest step of a run, along curves, and between times: that of the finer analysis
ONCE = {
    "progress": None,
    "save": None,
    "executor": None,
}
ANGLES = {
    *CARDAN,
    *(f"rotation_{axis}" for axis in "xyz"),
}  # of bodies, which jump by a turn; axes are compared
Arguments = Mapping[str, Any]


@reports_warnings
def verify(
    result: Result,
    responses: Part | Sequence[Part] = (),
    wrt: Sequence[str] | None = None,
    factor: float = 0.1,
    *,
    digits: float = DIGITS,
) -> Comparison:
    """Repeat an analysis with finer settings, and compare its values and derivatives.

    With J of the result and J' of the finer analysis, log10(|J| / |J' - J|) digits agree. A run is repeated with
    tolerances that are smaller by a factor, and with steps of at most half its longest one; steps of a given length are
    shorter by the square root of the factor. `kinematics` is repeated with twice as many times, `equilibrium` with
    steps that are shorter by the factor, and `workspace` with steps along its curves of half the length, twice as many
    tests and other random numbers.

    A difference below the tolerance of the result times the size of the motion is round-off: digits are then those of
    this size. Two analyses that agree can share an error: a pulse over which both step, or a law that is wrong.

    Parameters
    ----------
    result : from `simulate`, `kinematics`, `equilibrium` or `workspace`; also a saved run, from `load_run` or `resume`
    responses : as for `sensitivity`. Without them all outputs of `Trajectory.to_frame` are compared, at the times of
        the result and at its end: the table has the worst of each unit, relative to the largest of this unit
    wrt : names of parameters; the derivatives of the responses with respect to them are compared, too
    factor : of the tolerances, less than 1
    digits : in how many digits all numbers must agree

    Returns
    -------
    Comparison
        Printed, it is a table: value, finer value, difference [units of the value], digits. ``agree`` is the outcome

    Raises
    ------
    ValueError
        If the analysis failed, for parameters without responses, and as `sensitivity`.
    TypeError
        For results of other analyses.
    """
    Number(positive=True)("factor", factor)
    if factor >= 1:
        raise ValueError(f"factor must be less than 1, got {factor}. Leave it out for 0.1.")
    parts = [responses] if isinstance(responses, str) or not isinstance(responses, Sequence) else [*responses]
    if wrt is not None and not parts:
        raise ValueError('verify: wrt needs responses. Name at least one, such as "slider.x".')
    repetition, analysed = _repetition(result), cast(Any, result)
    if not analysed.success:
        raise ValueError(f"verify: this analysis failed. {analysed.message}")
    if parts and isinstance(analysed, Workspace):
        raise ValueError("verify: a workspace has no responses. Leave them out.")
    arguments = {**repetition.arguments, **{n: x for n, x in ONCE.items() if n in repetition.arguments}}
    if repetition.analysis is simulate:
        arguments["limits"] = None  # of time and steps; those of a workspace are what is analysed
    if parts and repetition.analysis is simulate:
        arguments["store"] = "steps"
        analysed = simulate(**arguments) if analysed.steps is None else analysed
    settings, refinement, tolerance = REFINED[repetition.analysis](analysed, arguments, factor)
    fine = repetition.analysis(**settings)
    values = [*_compared(analysed, fine, tolerance)] if fine.success else []
    derivatives: list[ComparedValue] = []
    if parts and fine.success:
        sizes = {value.unit: value.scale for value in values}
        first, second = (sensitivity(run, parts, () if wrt is None else wrt) for run in (analysed, fine))
        values, derivatives = _of_responses(first, second, sizes, tolerance)
    message = _other_end(analysed, fine)
    return Comparison(analysed.name, tuple(values), tuple(derivatives), digits, fine, refinement, message)


class Repetition(NamedTuple):
    """An analysis with its arguments, by which a result is computed again."""

    analysis: Callable[..., Any]
    arguments: Arguments


def _repetition(result: Any) -> Repetition:
    call, map_ = getattr(result, "call", None), getattr(result, "map", None)
    if call is None and isinstance(map_, WorkspaceMap):
        call = Call(workspace, (map_.problem.system, *map_.asked[1:2]), map_.options())
    if isinstance(result, Trajectory) and (arguments := arguments_of(result)) is not None:
        return Repetition(simulate, arguments)
    if isinstance(call, Call) and call.analysis in REFINED:
        return Repetition(call.analysis, call.arguments)
    analyses = ", ".join(analysis.__name__ for analysis in REFINED)
    raise TypeError(
        f"verify needs a result of {analyses}, where it was computed, got {kind(result)}. Verify the run or the "
        "equilibrium that it is made from."
    )


Refined = tuple[Arguments, str, float]


def _run(run: Trajectory, arguments: Arguments, factor: float) -> Refined:
    """A run with smaller tolerances; a step of given length is shorter."""
    method = method_with_options(arguments["method"])
    smaller = finer(method, factor)
    tolerance = float(Tolerances.of(run.system or arguments["system"], method.rtol, None).rtol_q.max())
    if step := getattr(smaller, "step", None):
        return {**arguments, "method": smaller}, f"steps of {step:.3g} s", tolerance
    steps = np.asarray(run.history)[:, 1]
    longest = min(method.max_step, STRIDE * float(steps.max()) if len(steps) else np.inf)
    refinement = f"tolerances times {factor:g} and steps of at most {longest:.3g} s"
    return {**arguments, "method": with_control(smaller, max_step=longest)}, refinement, tolerance


def _motion(run: Trajectory, arguments: Arguments, factor: float) -> Refined:
    """A prescribed motion at more times."""
    times = np.sort(np.concatenate([run.t, run.t[:-1] + STRIDE * np.diff(run.t)]))
    return {**arguments, "times": times, "until": None}, "twice as many times", FINISHED


def _rest(rest: Any, arguments: Arguments, factor: float) -> Refined:
    """An equilibrium on a way of shorter steps."""
    longest, iterations = factor * arguments["longest"], int(arguments["iterations"] / factor)
    settings = {**arguments, "longest": longest, "iterations": iterations}
    return settings, f"steps of at most {longest:g} of the model's size", FINISHED


def _map(map_: Workspace, arguments: Arguments, factor: float) -> Refined:
    """A map with shorter steps, tested by other random positions."""
    tests = {name: 2 * arguments[name] for name in ("samples", "rays")}
    settings = {
        **arguments,
        **tests,
        "verify": True,
        "seed": arguments["seed"] + 1,
        "longest": STRIDE * arguments["longest"],
    }
    return settings, "half the steps along curves and other random positions", FINISHED


REFINED: dict[Any, Callable[[Any, Arguments, float], Refined]] = {
    simulate: _run, kinematics: _motion, equilibrium: _rest, workspace: _map
}  # fmt: skip


def _other_end(result: Any, fine: Any) -> str:
    """A message if the finer analysis came to another end."""
    if not fine.success:
        return f"The finer analysis failed. {fine.message}"
    end, finer_end = _end(result), _end(fine)
    differ = "; ".join(
        f"{name} {end[name]} and {finer_end[name]}" for name in end if end[name] != finer_end[name]
    )
    return f"The result and the finer one differ: {differ}." if differ else ""


def _end(result: Any) -> dict[str, Any]:
    """What two results that agree share exactly."""
    if isinstance(result, Trajectory):
        return {"status": result.status, "events": len(result.events)}
    if isinstance(result, Workspace):
        return {
            "parts": len(result.components),
            "voids": sum(len(region.loops) - 1 for region in result.components),
        }
    return {"stability": result.stability}


def _compared(result: Any, fine: Any, tolerance: float) -> Iterator[ComparedValue]:
    """The worst output of each unit."""
    if isinstance(result, Workspace):
        for name in ("area", "perimeter"):
            value, better = float(getattr(result, name)), float(getattr(fine, name))
            yield ComparedValue(name, "", value, better, abs(better))
        return
    if getattr(result, "events", ()) and fine.events:
        value, better = result.events[-1].t, fine.events[-1].t
        yield ComparedValue("time of the last event", "s", value, better, abs(better))
    outputs, other = _outputs(result), _outputs(fine)
    _, *places = np.intersect1d(outputs.t, other.t, return_indices=True)
    rows, instants = (np.append(at, -1) for at in places)  # the end, too, whenever it is
    for unit in dict.fromkeys(outputs.units):
        of_unit = np.array([unit_of_output == unit for unit_of_output in outputs.units])
        a, b = outputs.values[of_unit][:, rows], other.values[of_unit][:, instants]
        scale = float(np.nanmax(np.abs([a, b]), initial=0.0))
        gap = np.where(np.isnan(a) & np.isnan(b), 0.0, np.nan_to_num(abs(b - a), nan=np.inf))
        n, k = np.unravel_index(np.argmax(gap), gap.shape)
        title = f"{np.array(outputs.names)[of_unit][n]} at t = {outputs.t[rows[k]]:.6g} s"
        pair = float(a[n, k]), float(b[n, k])
        yield ComparedValue(title, unit, *pair, _scale(pair, scale, _natural_size(fine, unit), tolerance))


def _natural_size(result: Any, unit: str) -> float:
    """What mass, extent and duration amount to in a unit: it decides what round-off is where all is zero."""
    system, t = result.system, np.atleast_1d(result.t)
    base = {
        "m": extent(system, system.q0),
        "kg": float(system.M(system.q0).diagonal().max()),
        "s": np.ptp(t) or 1.0,
    }
    powers = in_base(unit)
    watts = powers.pop("W", 0)
    for name, power in (("kg", 1), ("m", 2), ("s", -3)):
        powers[name] = powers.get(name, 0) + watts * power
    return float(np.prod([base.get(name, 1.0) ** power for name, power in powers.items()]))


class Outputs(NamedTuple):
    """Outputs (n, nt) of a result over time, the last ones at the end of a run."""

    names: Sequence[str]
    units: Sequence[str]
    t: Array
    values: Array


def _outputs(result: Any) -> Outputs:
    shown = [output for output in columns(result, ()) if output.name.rpartition(".")[2] not in ANGLES]
    t, values = np.atleast_1d(result.t), np.array([output.values for output in shown])
    names, units = [output.name for output in shown], [output.unit for output in shown]
    if isinstance(result, Trajectory) and result.final is not None and result.system is not None:
        last = several(result.system, result.final, names)
        t, values = np.append(t, result.final.t), np.hstack([values, [output.values for output in last]])
    return Outputs(names, units, t, values)


def _of_responses(
    gradient: Gradient, fine: Gradient, sizes: Mapping[str, float], tolerance: float
) -> tuple[list[ComparedValue], list[ComparedValue]]:
    """Responses, and derivatives: those of one unit are compared with the largest of them."""
    values, derivatives = [], []
    for n, (title, unit) in enumerate(zip(gradient.responses, gradient.response_units, strict=True)):
        pair = float(gradient.values[n]), float(fine.values[n])
        size = sizes.get(unit, abs(pair[1]))
        values.append(ComparedValue(title, unit, *pair, _scale(pair, abs(pair[1]), size, tolerance)))
        by = [gradient.unit(name, n) for name in gradient.names]
        for k, name in enumerate(gradient.names):
            same = [j for j, unit in enumerate(by) if unit == by[k]]
            largest = float(np.nanmax(abs(fine.matrix[n, same]), initial=0.0))
            pair = float(gradient.matrix[n, k]), float(fine.matrix[n, k])
            scale = _scale(pair, largest, size / (abs(gradient.at[k]) or 1.0), tolerance)
            derivatives.append(ComparedValue(f"{title} by {name}", by[k], *pair, scale))
    return values, derivatives


def _scale(pair: tuple[float, float], scale: float, size: float, tolerance: float) -> float:
    """The size of which digits are counted: that of the motion for a difference below the tolerance of the analysis."""
    return max(scale, size) if abs(pair[1] - pair[0]) <= tolerance * size else scale
