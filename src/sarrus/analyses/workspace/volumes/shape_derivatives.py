"""Derivatives of a workspace by the numbers of a design: the speed of its boundary along the normal, integrated.

On the boundary c·u + lam·(rows - goal) is stationary in q, so that a change of design moves it along the normal c by

    c·δu = lam·(rows_b δb - δgoal) + c·u_b δb

with the elements' own derivatives `_b`: no second derivative is needed, and none of the curve.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import NamedTuple

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
from ..problem.arguments import refuse_other
from ..problem.rows import Problem
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
def area_gradient(found: Workspace, wrt: Iterable[str]) -> ShapeDerivative:
    """Compute the exact derivative of the area of a workspace.

    Parameters
    ----------
    found : Workspace
    wrt : parameters: of the model (``"q2.point.x"``), of its elements (``"q2[point].s_i.x"``), of the functions
        (``"link_3(1, 0, 0).x[x].s_j.x"`` for the point that is the output), or ends of limits (``"q1.angle highest"``)

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
    region = map_of(found).region()
    numbers = _Numbers(region.problem, wrt)
    total, kinked = area_rates(region)
    return ShapeDerivative("area", found.area, numbers.derivatives(total), kinked)


def area_rates(region: Region) -> tuple[Array, float]:
    """Derivatives of an area by all numbers of its problem, and the length of the boundary where it has kinks."""
    numbers = _Numbers(region.problem, ())
    total, kinked = np.zeros(sum(numbers.sizes)), 0.0
    for k in np.flatnonzero(region.bounds).tolist():
        piece = region.division.pieces[k]
        total += _along(_owner(region, k), numbers)
        kinked += piece.arc.length * (len({region.branches[n].stratum.key for n, *_ in piece.owners}) > 1)
    units = region.problem.units[region.problem.outputs]
    return total * float(units.prod()), kinked * float(units[0])


def _owner(region: Region, k: int) -> BranchPart:
    """The branch that a piece of the boundary is part of, one that cannot be crossed, with the parameters there."""
    owners = region.division.pieces[k].owners
    n, first, last = next((one for one in owners if region.crossings[one[0]].side), owners[0])
    return BranchPart(region.branches[n], region.crossings[n].side or 1, first, last)


@reports_warnings
@one_thread_if_small
def volume_gradient(found: WorkspaceVolume, wrt: Iterable[str]) -> ShapeDerivative:
    """Compute the exact derivative of a volume from ``workspace_volume(..., derivatives=True)``.

    It is the integral of the derivatives of the slices' areas; where areas jump, at level parts of the boundary, their
    heights move, too.

    Parameters
    ----------
    found : WorkspaceVolume
    wrt : see `area_gradient`

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
    from ...sensitivity.parameters.parameters import listed

    refuse_other(found, WorkspaceVolume)
    rates = found.rates
    if rates is None:
        message = "Map it by workspace_volume(..., derivatives=True)"
        raise SarrusError(f"{found.name}: this volume was mapped without derivatives. {message}.")
    assert isinstance(rates.slices, Problem)
    slices, heights = (_Numbers(p, ()).places for p in (rates.slices, search_of(rates.reach).problem))
    none = dict.fromkeys(listed(wrt), 0.0)
    numbers = _Numbers(rates.slices, [name for name in none if name in slices or name not in heights])
    theirs = [name for name in none if name in heights or name not in slices]
    by = none | numbers.derivatives(rates.total)
    error = none | {name: abs(rate) for name, rate in numbers.derivatives(rates.missed).items()}
    for height, jump in rates.jumps:
        for name, rate in end_gradient(rates.reach, height, theirs).by.items():
            by[name] += jump * rate
    return ShapeDerivative("volume", found.volume, by, rates.kinked, error)


@reports_warnings
@one_thread_if_small
def end_gradient(found: WorkspaceRange, value: float, wrt: Iterable[str]) -> ShapeDerivative:
    """Compute the exact derivative of an end of a range, or of another critical value.

    Parameters
    ----------
    found : WorkspaceRange
    value : one of its critical values, nearly
    wrt : see `area_gradient`

    Raises
    ------
    SarrusError
        If there is no such number, no critical value, or the constraints alone are singular there.
    """
    refuse_other(found, WorkspaceRange, complete=False)
    search = search_of(found)
    problem = search.problem
    unit = float(problem.units[problem.outputs[0]])
    values = [one * unit for one in search.values()]
    nearest = min(values, key=lambda one: abs(one - value), default=value)
    moving = [
        (abs(one - value), n)
        for n, one in enumerate(values)
        if abs(one - nearest) < TRACED * unit and abs(search.found[n].x[-1]) > VANISHES
    ]
    if not moving:
        raise SarrusError(
            f"{found.output}: no end at {nearest:.6g} moves. Ask for another of its critical values."
        )
    key, x = search.found[min(moving)[1]]
    numbers = _Numbers(problem, wrt)
    rates = numbers.derivatives(numbers.row(Stratum(problem, key), x) / x[-1] * unit)
    return ShapeDerivative(found.output, nearest, rates)


@reports_warnings
@one_thread_if_small
def distance_gradient(found: Workspace, point: ArrayLike, wrt: Iterable[str]) -> ShapeDerivative:
    """Compute the exact derivative of the distance of a point from the boundary of a workspace.

    The foot of the perpendicular is found by Newton's method; where it lies moves to first order only along the
    boundary, so that the boundary's speed there is the derivative.

    Parameters
    ----------
    found : Workspace
        Both outputs are lengths, or both are angles.
    point : (2,) inside, where the distance counts positive, or outside, where it counts negative
    wrt : see `area_gradient`

    Raises
    ------
    SarrusError
        If there is no such number, the outputs have different units, there is no boundary, or the nearest place is a
        corner or one where the constraints alone are singular.
    """
    refuse_other(found, Workspace)
    region, place = map_of(found).region(), place_of(point)
    problem = region.problem
    unit, other = problem.units[problem.outputs].tolist()
    if found.units[0] != found.units[1]:
        raise SarrusError(
            f"{found.name}: {found.units[0]} and {found.units[1]} make no distance. Choose other outputs."
        )
    p, numbers = place / (unit, other), _Numbers(problem, wrt)
    owner, x = _foot(region, p)
    c, u = x[-2:], problem.values(x[: problem.n])[problem.m + problem.outputs]
    length = float(np.linalg.norm(c))
    if length < VANISHES:
        raise SarrusError(
            f"{found.name}: the nearest place of the boundary has no speed. Choose another point."
        )
    inwards = -owner.side * unit / length
    rates = numbers.derivatives(inwards * numbers.row(owner.branch.stratum, x))
    return ShapeDerivative("distance", inwards * float((u - p) @ c), rates)


class BranchPart(NamedTuple):
    """The branch of a piece of the boundary, the side of c on which the outputs stay, and its parameters there."""

    branch: Branch
    side: int
    first: float
    last: float


def _foot(region: Region, p: Array) -> tuple[BranchPart, Array]:
    """The part of the boundary that is nearest to a place, and the unknowns at the foot."""
    edges = np.flatnonzero(region.bounds).tolist()
    if not edges:
        name = region.problem.system.name
        raise SarrusError(f"{name}: there is no boundary. Use a workspace with one.")
    _, at, k = min((*region.division.pieces[k].arc.nearest(p)[::-1], k) for k in edges)
    arc, owner = region.division.pieces[k].arc, _owner(region, k)
    place, points = owner.first + at / arc.end * (owner.last - owner.first), owner.branch.points
    first = min(int(place), len(points) - 2)
    guess, away = Step(points[first], points[first + 1]).x(place - first), np.inf
    with suppress(NoPoint):
        x, linear = correct(owner.branch.stratum, guess, _perpendicular(region.problem, p))
        u = linear.values[region.problem.m + region.problem.outputs]
        away = float(np.linalg.norm(u - arc.point(at)))
    if away > ON_CURVE:
        raise SarrusError("point: the nearest place of the boundary is a corner. Choose another point.")
    return owner, x


def _perpendicular(problem: Problem, p: Array) -> Row:
    """The way from a place to the outputs is along the normal c."""

    def row(x: Array, linear: Tangents) -> tuple[float, Array]:
        outputs, c = problem.m + problem.outputs, x[-2:]
        d, gradient = linear.values[outputs] - p, np.zeros(len(x))
        gradient[: problem.n] = c[1] * linear.J[outputs[0]] - c[0] * linear.J[outputs[1]]
        gradient[-2:] = -d[1], d[0]
        return float(d[0] * c[1] - d[1] * c[0]), gradient

    return row


def _along(owner: BranchPart, numbers: _Numbers) -> Array:
    """The integral of the boundary's speed outwards over a part of a branch."""
    points, (low, high) = owner.branch.points, sorted((owner.first, owner.last))
    total, (nodes, weights) = np.zeros(sum(numbers.sizes)), gauss()
    for k in range(int(low), min(int(np.ceil(high)), len(points) - 1)):
        step, first = Step(points[k], points[k + 1]), max(low - k, 0.0)
        outputs, length = step.quintic(), min(high - k, 1.0) - first
        for tau, weight in zip(first + length * nodes, length * weights, strict=True):
            x = step.x(tau)
            slope = (np.arange(1, 6) * tau ** np.arange(5)) @ outputs[1:]
            normal = float(np.linalg.norm(x[-2:]))
            if normal > VANISHES:
                speed = numbers.row(owner.branch.stratum, x) / normal
                total -= owner.side * weight * float(np.linalg.norm(slope)) * speed
    return total


def _without_places(names: Sequence[str]) -> dict[str, str]:
    """Names without the place of the point, ``link.x[x].s_j.x`` for ``link(1, 0, 0).x[x].s_j.x``, if one is meant."""
    short = [IN_BRACKETS.sub("", name) for name in names]
    return {
        one: name for one, name in zip(short, names, strict=True) if short.count(one) == 1 and one != name
    }


class _Numbers:
    """Gradients of the boundary's motion by all numbers: of elements, of functions, of limits; free of units.

    `places` are those of numbers of functions and of limits, by name.
    """

    def __init__(self, problem: Problem, wrt: Iterable[str]) -> None:
        from ...sensitivity.parameters.parameters import Parameters, UnknownParameter, listed

        self.problem, self.names, system = problem, listed(wrt), problem.system
        functions = problem.functions.axis_names(Axis.PARAMETERS)
        limits = [f"{problem.table[k].name} {end}" for k in problem.limited for end in ("lowest", "highest")]
        self.sizes = (system.nb, len(functions), len(limits))
        self.places = {name: system.nb + n for n, name in enumerate([*functions, *limits])}
        self.places |= {short: self.places[name] for short, name in _without_places([*self.places]).items()}
        others = [name for name in self.names if name not in self.places]
        try:
            self._parameters = Parameters(system, others) if others else None
        except UnknownParameter as error:
            raise SarrusError(
                f"{error}. Or of a function or limit: {suggest(others[0], self.places)}"
            ) from None
        if self._parameters and self._parameters.names != others:
            raise SarrusError(f"name numbers one by one: {', '.join(self._parameters.names)}")

    def row(self, stratum: Stratum, x: Array) -> Array:
        """lam·(rows_b - goal_b) + c·u_b at a point (all numbers,)."""
        p, weights = self.problem, stratum.weights(x)
        real, (lam, own) = x[: p.n] * p.scale, p.unscaled(weights)
        by_b, by_own = p.system.Phi_b(real).T @ lam, p.functions.Phi_b(real).T @ own
        by_limits = np.zeros((len(p.limited), 2))
        for i, end in stratum.active:
            k = p.limited[i]
            slope = p.table[k].slope(float(p.limits[int(k)][end])) / p.units[k]
            by_limits[i, end] = -x[stratum.multiplier((i, end))] * slope
        return np.concatenate([by_b[: self.sizes[0]], by_own[: self.sizes[1]], by_limits.reshape(-1)])

    def derivatives(self, total: Array) -> dict[str, float]:
        """Return the derivatives by the requested names."""
        from ...sensitivity.chain.chain import Gradients

        found = {name: float(total[place]) for name, place in self.places.items()}
        if self._parameters:
            system, nb = self.problem.system, self.sizes[0]
            none, by_c = np.zeros((system.nq, 1)), np.zeros((len(system.joint_coordinates.b), 1))
            by_b = np.pad(total[:nb], (0, len(system.b) - nb))[:, None]
            rates = self._parameters.gradient(Gradients(by_b, none, none), by_c)[:, 0].tolist()
            found |= zip(self._parameters.names, rates, strict=True)
        return {name: found[name] for name in self.names}
