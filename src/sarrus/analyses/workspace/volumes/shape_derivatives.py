"""Derivatives of a workspace by the numbers of a design: the speed of its boundary along the normal, integrated.

On the boundary c·u + lam·(rows - goal) is stationary in q, so that a change of design moves it along the normal c by

    c·δu = lam·(rows_b δb - δgoal) + c·u_b δb

with the elements' own derivatives `_b`: no second derivative is needed, and none of the curve.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ....algebra import Array
from ....elements.operators import Axis
from ....linalg.threads import one_thread_if_small
from ....model import SarrusError
from ....model.announcement import reports_warnings
from ....model.show import suggest
from ....results.maps.workspace import TRACED, Workspace, place_of
from ....results.maps.workspace_volume import ShapeDerivative, WorkspaceRange, WorkspaceVolume
from ...sensitivity.chain.chain import Gradients
from ...sensitivity.parameters.parameters import Parameters, UnknownParameter, listed
from ..problem.arguments import refuse_other
from ..problem.rows import Problem
from ..regions.arrangement import Owner
from ..regions.crossing import VANISHES
from ..regions.mapping import map_of
from ..regions.region import Region
from ..tracing.explore import ON_CURVE, Branch
from ..tracing.point import Step, gauss
from ..tracing.stratum import NoPoint, Row, Stratum, Tangents, correct
from .extremes import search_of

IN_BRACKETS = re.compile(r"\([^()]*\)")


@reports_warnings
@one_thread_if_small
def area_gradient(found: Workspace, wrt: Iterable[str], *, strict: bool = False) -> ShapeDerivative:
    """Compute the exact derivative of the area of a workspace.

    Parameters
    ----------
    found : Workspace
    wrt : parameters: of the model (``"q2.point.x"``), of its elements (``"q2[point].s_i.x"``), of the functions
        (``"link_3(1, 0, 0).x[x].s_j.x"`` for the point that is the output), or ends of limits (``"q1.angle highest"``)
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    ShapeDerivative
        The area has a kink where two curves with different causes lie on each other; the length of such parts of the
        boundary is reported in `kinked`, and the derivative is that with one of them.

    Raises
    ------
    SarrusError
        If there is no such number.
    """
    refuse_other(found, Workspace)
    names, map_ = listed(wrt), map_of(found)
    numbers = _Numbers(map_.problem, names)
    total, kinked = area_rates(map_.problem, map_.region())
    rates = numbers.derivatives(total)
    return ShapeDerivative("area", found.area, dict(zip(names, rates, strict=True)), kinked)


def area_rates(problem: Problem, region: Region) -> tuple[Array, float]:
    """Derivatives of an area by all numbers of a problem, and the length of the boundary where it has kinks."""
    numbers = _Numbers(problem, ())
    total, kinked = numbers.nothing(), 0.0
    for k in np.flatnonzero(region.bounds).tolist():
        piece = region.division.pieces[k]
        owner = next((one for one in piece.owners if region.crossings[one[0]].side), piece.owners[0])
        total += _along(region, owner, numbers)
        kinked += piece.arc.length * (len({region.branches[n].stratum.key for n, *_ in piece.owners}) > 1)
    units = problem.units[problem.outputs]
    return total * float(units.prod()), kinked * float(units[0])


@reports_warnings
@one_thread_if_small
def volume_gradient(found: WorkspaceVolume, wrt: Iterable[str], *, strict: bool = False) -> ShapeDerivative:
    """Compute the exact derivative of a volume from ``workspace_volume(..., derivatives=True)``.

    It is the integral of the derivatives of the slices' areas; where areas jump, at level parts of the boundary, their
    heights move, too.

    Parameters
    ----------
    found : WorkspaceVolume
    wrt : see `area_gradient`
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    ShapeDerivative
        `error` is the difference to half as many slices; `kinked` is the area of parts of the boundary that two
        causes make at once.

    Raises
    ------
    SarrusError
        If there is no such number, or the volume was mapped without derivatives.
    """
    refuse_other(found, WorkspaceVolume)
    names, rates = listed(wrt), found.rates
    if rates is None:
        message = "Map it by workspace_volume(..., derivatives=True)"
        raise SarrusError(f"{found.name}: this volume was mapped without derivatives. {message}.")
    of_slices, of_heights = rates.slices, search_of(rates.reach).problem
    assert isinstance(of_slices, Problem)
    known = [set(_Numbers(problem, ()).own) for problem in (of_slices, of_heights)]
    mine, theirs = [
        [name for name in names if name in own or name not in other] for own, other in (known, known[::-1])
    ]
    numbers = _Numbers(of_slices, mine)
    by = dict.fromkeys(names, 0.0) | dict(zip(mine, numbers.derivatives(rates.total), strict=True))
    error = dict.fromkeys(names, 0.0) | dict(zip(mine, abs(numbers.derivatives(rates.missed)), strict=True))
    for height, jump in rates.jumps:
        for name, rate in end_gradient(rates.reach, height, theirs).by.items():
            by[name] += jump * rate
    return ShapeDerivative("volume", found.volume, by, rates.kinked, error)


@reports_warnings
@one_thread_if_small
def end_gradient(
    found: WorkspaceRange, value: float, wrt: Iterable[str], *, strict: bool = False
) -> ShapeDerivative:
    """Compute the exact derivative of an end of a range, or of another critical value.

    Parameters
    ----------
    found : WorkspaceRange
    value : one of its critical values, nearly
    wrt : see `area_gradient`
    strict : raise the first warning as a `StrictError`

    Raises
    ------
    SarrusError
        If there is no such number, no critical value, or the constraints alone are singular there.
    """
    refuse_other(found, WorkspaceRange, complete=False)
    search, names = search_of(found), listed(wrt)
    problem = search.problem
    unit = float(problem.units[problem.outputs[0]])
    values = [one * unit for one in search.values()]
    message = min(values, key=lambda one: abs(one - value), default=value)
    alike = [
        (abs(one - value), n)
        for n, one in enumerate(values)
        if abs(one - message) < TRACED * unit and abs(search.found[n].x[-1]) > VANISHES
    ]
    if not alike:
        raise SarrusError(
            f"{found.output}: no end at {message:.6g} moves. Ask for another of its critical values."
        )
    start = search.found[min(alike)[1]]
    numbers = _Numbers(problem, names)
    rates = numbers.derivatives(numbers.row(Stratum(problem, start.key), start.x) / start.x[-1]) * unit
    return ShapeDerivative(found.output, message, dict(zip(names, rates, strict=True)))


@reports_warnings
@one_thread_if_small
def distance_gradient(
    found: Workspace, point: ArrayLike, wrt: Iterable[str], *, strict: bool = False
) -> ShapeDerivative:
    """Compute the exact derivative of the distance of a point from the boundary of a workspace.

    The foot of the perpendicular is found by Newton's method; where it lies moves to first order only along the
    boundary, so that the boundary's speed there is the derivative.

    Parameters
    ----------
    found : Workspace
        Both outputs are lengths, or both are angles.
    point : (2,) inside, where the distance counts positive, or outside, where it counts negative
    wrt : see `area_gradient`
    strict : raise the first warning as a `StrictError`

    Raises
    ------
    SarrusError
        If there is no such number, the outputs have different units, there is no boundary, or the nearest place is a
        corner or one where the constraints alone are singular.
    """
    refuse_other(found, Workspace)
    map_, names, place = map_of(found), listed(wrt), place_of(point)
    problem, region = map_.problem, map_.region()
    units = problem.units[problem.outputs]
    if found.units[0] != found.units[1]:
        raise SarrusError(
            f"{found.name}: {found.units[0]} and {found.units[1]} make no distance. Choose other outputs."
        )
    p, numbers = place / units, _Numbers(problem, names)
    branch, side, x = _foot(region, p)
    c, u = x[-2:], problem.values(x[: problem.n])[problem.m + problem.outputs]
    length = float(np.linalg.norm(c))
    if length < VANISHES:
        raise SarrusError(
            f"{found.name}: the nearest place of the boundary has no speed. Choose another point."
        )
    distance = -side * float((u - p) @ c) / length
    speed = -side * numbers.row(branch.stratum, x) / length
    rates = numbers.derivatives(speed) * float(units[0])
    return ShapeDerivative("distance", distance * float(units[0]), dict(zip(names, rates, strict=True)))


def _foot(region: Region, p: Array) -> tuple[Branch, int, Array]:
    """The branch of the boundary that is nearest to a place, its open side, and the unknowns at the foot."""
    edges = np.flatnonzero(region.bounds).tolist()
    if not edges:
        name = region.problem.system.name
        raise SarrusError(f"{name}: there is no boundary. Use a workspace with one.")
    near = [(*region.division.pieces[k].arc.nearest(p)[::-1], k) for k in edges]
    _, at, k = min(near)
    piece = region.division.pieces[k]
    n, low, high = next((one for one in piece.owners if region.crossings[one[0]].side), piece.owners[0])
    branch, place = region.branches[n], low + at / piece.arc.end * (high - low)
    first = min(int(place), len(branch.points) - 2)
    guess = Step(branch.points[first], branch.points[first + 1]).x(place - first)
    away, x = np.inf, guess
    try:
        x, linear = correct(branch.stratum, guess, _perpendicular(region.problem, p))
        u = linear.values[region.problem.m + region.problem.outputs]
        away = float(np.linalg.norm(u - piece.arc.point(at)))
    except NoPoint:
        pass
    if away > ON_CURVE:
        raise SarrusError("point: the nearest place of the boundary is a corner. Choose another point.")
    return branch, region.crossings[n].side or 1, x


def _perpendicular(problem: Problem, p: Array) -> Row:
    """The way from a place to the outputs is along the normal c."""

    def row(x: Array, linear: Tangents) -> tuple[float, Array]:
        outputs, c = problem.m + problem.outputs, x[-2:]
        d, gradient = linear.values[outputs] - p, np.zeros(len(x))
        gradient[: problem.n] = c[1] * linear.J[outputs[0]] - c[0] * linear.J[outputs[1]]
        gradient[-2:] = -d[1], d[0]
        return float(d[0] * c[1] - d[1] * c[0]), gradient

    return row


def _along(region: Region, owner: Owner, numbers: _Numbers) -> Array:
    """The integral of the boundary's speed outwards over a part of a branch."""
    n, low, high = owner
    branch, side = region.branches[n], region.crossings[n].side or 1
    low, high = min(low, high), max(low, high)
    total = numbers.nothing()
    for k in range(int(low), min(int(np.ceil(high)), len(branch.points) - 1)):
        total -= side * _in_step(branch, k, max(low - k, 0.0), min(high - k, 1.0), numbers)
    return total


def _in_step(branch: Branch, k: int, low: float, high: float, numbers: _Numbers) -> Array:
    step = Step(branch.points[k], branch.points[k + 1])
    outputs, nodes, weights = step.quintic(), *gauss()
    total = numbers.nothing()
    for tau, weight in zip(low + (high - low) * nodes, (high - low) * weights, strict=True):
        x = step.x(tau)
        slope = (np.arange(1, 6) * tau ** np.arange(5)) @ outputs[1:]
        length = float(np.linalg.norm(x[len(x) - 2 :]))
        if length > VANISHES:
            total += weight * float(np.linalg.norm(slope)) / length * numbers.row(branch.stratum, x)
    return total


def _without_places(names: Sequence[str]) -> dict[str, str]:
    """Names without the place of the point, ``link.x[x].s_j.x`` for ``link(1, 0, 0).x[x].s_j.x``, if one is meant."""
    short = [IN_BRACKETS.sub("", name) for name in names]
    return {
        one: name for one, name in zip(short, names, strict=True) if short.count(one) == 1 and one != name
    }


class _Numbers:
    """Gradients of the boundary's motion by all numbers: of elements, of functions, of limits; free of units.

    `own` are the names of those of functions and of limits.
    """

    def __init__(self, problem: Problem, names: Sequence[str]) -> None:
        self.problem, system = problem, problem.system
        self.sizes = (system.nb, len(problem.functions.axis_names(Axis.PARAMETERS)), 2 * len(problem.limited))
        limits = [f"{problem.table[k].name} {end}" for k in problem.limited for end in ("lowest", "highest")]
        own = problem.functions.axis_names(Axis.PARAMETERS)
        self.own = [*own, *limits]
        self._places = {name: self.sizes[0] + n for n, name in enumerate(self.own)}
        self._places |= {short: self._places[name] for short, name in _without_places(self.own).items()}
        self._names = list(names)
        others = [name for name in names if name not in self._places]
        try:
            self._parameters = Parameters(system, others) if others else None
        except UnknownParameter as error:
            raise SarrusError(
                f"{error}. Or of a function or limit: {suggest(others[0], self._places)}"
            ) from None
        if self._parameters and self._parameters.names != others:
            raise SarrusError(f"name numbers one by one: {', '.join(self._parameters.names)}")

    def nothing(self) -> Array:
        return np.zeros(sum(self.sizes))

    def row(self, stratum: Stratum, x: Array) -> Array:
        """lam·(rows_b - goal_b) + c·u_b at a point (all numbers,)."""
        p, weights = self.problem, stratum.weights(x)
        real, (lam, own) = x[: p.n] * p.scale, p.unscaled(weights)
        by_b = p.system.Phi_b(real).T @ lam
        by_own = p.functions.Phi_b(real).T @ own
        by_limits = np.zeros((len(p.limited), 2))
        for limit in stratum.active:
            table = p.limited[limit[0]]
            by_limits[limit] = (
                -x[stratum.multiplier(limit)] * p.table[table].slope(_bound(p, limit)) / p.units[table]
            )
        return np.concatenate([by_b[: self.sizes[0]], by_own[: self.sizes[1]], by_limits.reshape(-1)])

    def derivatives(self, total: Array) -> Array:
        """Return the derivatives by the requested names."""
        system = self.problem.system
        found = {name: float(total[place]) for name, place in self._places.items()}
        if self._parameters:
            none = np.zeros((system.nq, 1))
            by_b = np.zeros((len(system.b), 1))
            by_b[: self.sizes[0], 0] = total[: self.sizes[0]]
            by_c = np.zeros((len(system.joint_coordinates.b), 1))
            rates = self._parameters.gradient(Gradients(by_b, none, none), by_c)
            found |= {
                name: float(rate) for name, rate in zip(self._parameters.names, rates[:, 0], strict=True)
            }
        return np.array([found[name] for name in self._names])


def _bound(problem: Problem, limit: tuple[int, int]) -> float:
    return float(problem.limits[int(problem.limited[limit[0]])][limit[1]])
