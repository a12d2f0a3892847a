"""Manipulability and conditioning of a mechanism, at positions and over a workspace."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...linalg.svd import singular
from ...linalg.threads import one_thread_if_small
from ...model import SarrusError
from ...model.announcement import announce, reports_warnings
from ...model.coordinates import POSITION, by_body
from ...results import ResultList
from ...results.maps.workspace import Workspace
from ...results.maps.workspace_field import Quantity, WorkspaceField
from ...system import System
from ..arguments import refuse_for_positions
from ..progress import Progress
from .problem.arguments import functions
from .problem.formulation import DEPENDENT, TURN, formulate, refuse_inputs
from .problem.random_positions import Samples
from .problem.rows import Problem
from .problem.settle import TRIES, allowed, constrained, reach, settle
from .problem.watch import CELLS as COUNTED
from .problem.watch import Stop, reached, stopped, watched
from .regions.mapping import map_of


class Dexterity(NamedTuple):
    """Manipulability and dexterity of a mechanism at positions.

    `jacobian` is (outputs, inputs) du/dv; `manipulability` sqrt(det J Jᵀ), the area of the outputs' ellipse over π for
    unit rates of the inputs; `condition` the ratio of its axes, 1 if all directions are equal, infinite if one is
    lost; `conditioning` its inverse.
    """

    jacobian: Array
    manipulability: float
    condition: float

    @property
    def conditioning(self) -> float:
        """The conditioning: 1 if all directions are equal, 0 if one is lost."""
        return 1 / self.condition


@reports_warnings
@one_thread_if_small
def dexterity(
    system: System,
    q: ArrayLike,
    output: Iterable[Any],
    inputs: Iterable[Any],
    *,
    fixed: Mapping[Any, float] | None = None,
) -> list[Dexterity]:
    """Compute manipulability and dexterity at given positions.

    Parameters
    ----------
    system : System
    q : (nq,) or (k, nq) positions that satisfy the constraints
    output, inputs : functions of the position
    fixed : functions that keep their values
    """
    refuse_for_positions(system, "dexterity")
    problem = formulate(system, output, fixed=fixed, inputs=inputs, singular="inputs")
    positions = np.atleast_2d(np.asarray(q, dtype=float))
    if positions.shape[-1] != problem.n or not np.isfinite(positions).all():
        message = (
            f"q must be finite coordinates, shape ({problem.n},) or (k, {problem.n}), got {positions.shape}"
        )
        raise SarrusError(f"{message}. Pass system.q0 or a result's q.")
    refuse_inputs(problem, len(problem.normal), problem.freedoms, problem.unfixed)
    return ResultList(_dexterity(problem, one, problem.normal) for one in positions / problem.scale)


def _dexterity(problem: Problem, q: Array, inputs: Array) -> Dexterity:
    """Dexterity at a scaled position; inputs by their places in the table."""
    J = problem.jacobian(q)
    rows, _ = constrained(problem)
    free = problem.n - len(rows)
    Z = singular(J[rows])[2][problem.n - free :].T
    U, V = (J[problem.m + k] @ Z * problem.units[k][:, None] for k in (problem.outputs, inputs))
    found = U @ _inverse(V, np.finfo(float).eps * max(V.shape))[0]
    sizes = singular(found)[1]
    condition = float(sizes[0] / sizes[-1]) if sizes[-1] > 0 else np.inf
    return Dexterity(found, float(np.prod(sizes)), condition)


def _inverse(matrix: Array, tolerance: float) -> tuple[Array, Array]:
    """The pseudoinverse, and the directions that leave all rows as they are; smaller singular values are zero."""
    left, sizes, right = singular(matrix)
    k = np.flatnonzero(sizes > tolerance * sizes.max(initial=0.0))
    return np.asarray(right[k].T / sizes[k] @ left[:, k].T), right[len(matrix) :]


CELLS = {2: 60, 3: 30}
STARTS = 200  # random positions from which assembly modes are filled


@reports_warnings
@one_thread_if_small
def workspace_field(
    found: Workspace,
    inputs: Iterable[Any] = (),
    *,
    turn: Any = None,
    cells: int | None = None,
    starts: int = STARTS,
    seed: int = 0,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
) -> WorkspaceField:
    """Compute dexterity, number of solutions and range of orientation on a grid in a workspace.

    All solutions of the inverse kinematics are computed at the centres of the cells of a grid: from random positions,
    by Newton's method from the solutions of neighbouring cells, and along motions with constant outputs.

    Parameters
    ----------
    found : Workspace
        With two degrees of freedom besides the fixed functions, or three for the range of orientation.
    inputs : functions of the position, as many as there are degrees of freedom; without them, manipulability and
        conditioning are left out
    turn : an angle whose range is computed, such as ``"platform.rotation_z"``, with three degrees of freedom
    cells : number of cells along the longer side of the boundary; by default 60, or 30 with three degrees of freedom
    starts : number of random positions
    seed : of the random positions
    progress : True for a bar on the terminal, or a function that is called with the number of cells filled so far
    time_limit : seconds of the clock after which it ends with the cells filled so far, and a warning

    Returns
    -------
    WorkspaceField
        `solutions` where they are single; `manipulability`, sqrt(det J Jᵀ), and `conditioning`, the inverse of J's
        condition number, of the best and of the worst solution at each place; `turn`, the length [rad] of all values
        that the angle can have there.

    Raises
    ------
    SarrusError
        If a name is unknown, numbers of inputs and degrees of freedom do not fit, or nothing can be reached.
    """
    map_ = map_of(found)
    _, output, limits, fixed = map_.asked
    driven, rotating = functions(inputs), () if turn is None else (turn,)
    problem = formulate(
        map_.problem.system,
        output,
        limits=limits,
        fixed=fixed,
        inputs=(*driven, *rotating),
        singular="inputs",
    )
    _refuse_counts(problem, len(driven), bool(rotating))
    if not any(part.loops for part in found.components):
        raise SarrusError(f"{found.name}: nothing can be reached, so there is no field. See its message.")
    x, y, inside = _grid(found, CELLS[problem.freedoms] if cells is None else cells)
    if not inside.any():
        raise SarrusError(f"{found.name}: no cell's centre lies inside. Give more cells.")
    units = problem.units[problem.outputs]
    places = np.stack(np.meshgrid(x, y), axis=-1)[inside] / units
    flood = Flood(problem, places, list(around(inside)))
    drawn = islice(Samples(problem, seed), starts)
    with watched(progress, len(places), done="filled", unit=COUNTED, time_limit=time_limit):
        stop = stopped(lambda: _fill(flood, drawn, map_.met))
    values: dict[Quantity, Array] = {}
    for name, column in _columns(flood, problem.normal[: len(driven)], problem.normal[len(driven) :]):
        values[name] = np.full(inside.shape, np.nan)
        values[name][inside] = column
    names = [problem.table[k].name for k in problem.normal]
    counts = [len(some) for some in flood.at]
    field = WorkspaceField(
        found,
        tuple(names[: len(driven)]),
        names[-1] if rotating else "",
        x,
        y,
        values,
        sum(counts),
        counts.count(0),
        stop.status if stop else "incomplete" if 0 in counts else "mapped",
    )
    announce([] if field.success else [_shortcoming(field, stop)])
    return field


def _shortcoming(field: WorkspaceField, stop: Stop | None) -> str:
    if stop:
        return (
            f"{field.name}: {stop.reason}, and solutions are missing. Allow more time, or give fewer cells."
        )
    message = f"{field.name}: no position was found at {field.missed} places inside the boundary"
    return f"{message}. Give more starts."


def _refuse_counts(problem: Problem, inputs: int, rotating: bool) -> None:
    name, freedoms = problem.system.name, problem.freedoms
    if freedoms not in (2, 3):
        raise SarrusError(
            f"{name}: {freedoms} degrees of freedom are too many. Fix functions until two or three are left."
        )
    refuse_inputs(problem, inputs, freedoms, problem.unfixed, 0)
    if rotating and freedoms == 2:
        raise SarrusError(f"{name}: no rotation is free while two outputs are constant. Leave `turn` out.")
    if rotating and problem.table[problem.normal[-1]].kind != "angle":
        raise SarrusError(
            f"{problem.table[problem.normal[-1]].name}: is no angle. Pass the name of an angle as `turn`."
        )
    if not inputs and not rotating and freedoms == 3:
        raise SarrusError(
            f"{name}: there are infinitely many solutions at every place. Name its inputs, or the rotation (turn)."
        )


def _grid(found: Workspace, cells: int) -> tuple[Array, Array, Array]:
    """Centres of cells around the boundary, and which of them lie inside."""
    corners = np.concatenate([loop for part in found.components for loop in part.loops])
    low, high = corners.min(axis=0), corners.max(axis=0)
    alike = found.units[0] == found.units[1]
    size = (high - low).max() / cells if alike else (high - low) / cells
    counts = np.maximum(np.ceil((high - low) / size - 1e-9), 1).astype(int)
    first = 0.5 * (low + high) - 0.5 * (counts - 1) * size
    x, y = (a + np.arange(n) * h for a, n, h in zip(first, counts, np.broadcast_to(size, 2), strict=True))
    points = np.stack(np.meshgrid(x, y), axis=-1)
    return x, y, found.contains(points.reshape(-1, 2)).reshape(points.shape[:2])


def _fill(flood: Flood, drawn: Iterable[Array], met: Iterable[Array]) -> None:
    """All positions that random ones lead to; a place that nothing led to is tried from those nearest to it."""
    problem, places = flood.problem, flood.places
    outputs = problem.m + problem.outputs
    for q in (*met, *drawn):
        away = np.linalg.norm(places - problem.values(q)[outputs], axis=1)
        flood.take(int(np.argmin(away)), q)
    flood.spread()
    random = np.random.default_rng(0)
    for k in [k for k, some in enumerate(flood.at) if not some]:
        near = np.argsort(np.linalg.norm(places - places[k], axis=1))[:TRIES]
        known = [q for other in near for q in flood.at[other]]
        there = reach(problem, places[k], np.array(known), random) if known else None
        if there is not None:
            flood.take(k, there)
            flood.spread()


QUALITIES: tuple[tuple[Quantity, Quantity], ...] = (
    ("manipulability", "worst_manipulability"),
    ("conditioning", "worst_conditioning"),
)


def _columns(flood: Flood, driven: Array, rotating: Array) -> Iterator[tuple[Quantity, Array]]:
    """Quantities at all places."""
    problem = flood.problem
    if problem.freedoms == 2:
        yield "solutions", np.array([len(some) or np.nan for some in flood.at])
    if len(driven):
        measures = [[_dexterity(problem, q, driven) for q in some] for some in flood.at]
        for best, worst in QUALITIES:
            numbers = [[getattr(one, best) for one in some] or [np.nan] for some in measures]
            yield best, np.array([max(some) for some in numbers])
            yield worst, np.array([min(some) for some in numbers])
    if len(rotating):
        yield "turn", np.array([_range(problem, rotating[0], strides) for strides in flood.strides])


def _range(problem: Problem, turn: int, strides: list[tuple[Array, Array]]) -> float:
    """The length of all values of an angle along strides."""
    ends = np.array([[problem.values(q)[problem.m + turn] for q in pair] for pair in strides])
    if not len(ends):
        return float("nan")
    change = (ends[:, 1] - ends[:, 0] + np.pi) % TURN - np.pi
    first = np.where(change < 0, ends[:, 1], ends[:, 0]) % TURN
    parts = np.column_stack([first, first + abs(change)])
    over = parts[:, 1] > TURN
    wrapped = np.column_stack([np.zeros(over.sum()), parts[over, 1] - TURN])
    return _covered(np.concatenate([np.minimum(parts, TURN), wrapped]))


def _covered(parts: Array) -> float:
    """The length of the union of intervals (k, 2)."""
    low, high = parts[np.argsort(parts[:, 0])].T
    before = np.maximum.accumulate(np.append(-np.inf, high[:-1]))
    return float(np.maximum(0.0, high - np.maximum(low, before)).sum())


SAME = 1e-3  # free of units: positions nearer to each other are one, where they are single
STRIDE = 0.15  # free of units: of motions that leave the outputs where they are
HALVINGS = 12  # of a stride that ends at a limit


class Flood:
    """Positions at places; `spread` them until nothing is new.

    Parameters
    ----------
    problem : Problem
    places : (count, 2) values of the outputs, free of units
    neighbours : of every place

    Attributes
    ----------
    at : positions of each place
    strides : of each place, pairs of positions that a motion joins which leaves the outputs where they are
    """

    def __init__(self, problem: Problem, places: Array, neighbours: Sequence[Sequence[int]]) -> None:
        self.problem, self.places, self.neighbours = problem, places, neighbours
        rows, self._goal = constrained(problem)
        self._rows = np.concatenate([rows, problem.m + problem.outputs])
        self.at: list[list[Array]] = [[] for _ in places]
        self.strides: list[list[tuple[Array, Array]]] = [[] for _ in places]
        self._open: deque[tuple[int, Array]] = deque()
        self._filled = 0
        self._apart = 0.5 * STRIDE if problem.freedoms > len(problem.outputs) else SAME

    def take(self, k: int, q: Array) -> bool:
        """Move a position to a place and keep it there, if that is possible and it is new."""
        there = self._settled(k, q)
        return there is not None and self._keep(k, there)

    def spread(self) -> None:
        """Go on from all positions until nothing is new."""
        while self._open:
            reached(self._filled, COUNTED)
            k, q = self._open.popleft()
            inverse, still = _inverse(self.problem.jacobian(q)[self._rows], DEPENDENT)
            for other in self.neighbours[k]:
                step = inverse[:, -self.places.shape[1] :] @ (self.places[other] - self.places[k])
                near = max(0.5 * float(np.linalg.norm(step)), self._apart)
                if self._known(other, q + step, near) is None:
                    self.take(other, q + step)
            for way in (*still, *-still):
                self._stride(k, q, way)

    def _keep(self, k: int, q: Array) -> bool:
        if self._known(k, q, self._apart) is not None:
            return False
        self._filled += not self.at[k]
        self.at[k].append(q)
        self._open.append((k, q))
        return True

    def _stride(self, k: int, q: Array, way: Array) -> None:
        """A motion that leaves the outputs where they are, up to the next position or to a limit."""
        known = self._known(k, q + STRIDE * way, self._apart)
        there = self._settled(k, q + STRIDE * way) if known is None else known
        if there is None:
            there = self._last(k, q, way)
        elif known is None:
            self._keep(k, there)
        self.strides[k].append((q, there))

    def _last(self, k: int, q: Array, way: Array) -> Array:
        """The farthest position along a stride that keeps the limits."""
        low, high, found = 0.0, 1.0, q
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            there = self._settled(k, q + middle * STRIDE * way)
            low, high, found = (low, middle, found) if there is None else (middle, high, there)
        return found

    def _settled(self, k: int, q: Array) -> Array | None:
        there = settle(self.problem, q, self._rows, np.concatenate([self._goal, self.places[k]]), steps=12)
        if there is None or not allowed(self.problem, there) or not self.problem.built(there):
            return None
        return there

    def _known(self, k: int, q: Array, near: float) -> Array | None:
        """The position of a place that is nearest to another one, if it is near."""
        if not self.at[k]:
            return None
        away = _distances(np.array(self.at[k]), q)
        nearest = int(np.argmin(away))
        return self.at[k][nearest] if away[nearest] < near else None


def _distances(known: Array, q: Array) -> Array:
    """Return the distances of positions (count, n) from another one, without units and signs of Euler parameters."""
    d = by_body(known - q) ** 2
    flipped = by_body(known + q)[..., POSITION:] ** 2
    turned = np.minimum(d[..., POSITION:].sum(axis=2), flipped.sum(axis=2))
    return np.asarray(np.sqrt(d[..., :POSITION].sum(axis=(1, 2)) + turned.sum(axis=1)))


def around(inside: Array) -> Iterator[list[int]]:
    """For each cell of a grid that is inside, in the grid's order, the numbers of those beside it."""
    number = np.full(np.add(inside.shape, 2), -1)
    number[1:-1, 1:-1][inside] = np.arange(int(inside.sum()))
    for i, j in np.argwhere(inside) + 1:
        beside = (number[i - 1, j], number[i + 1, j], number[i, j - 1], number[i, j + 1])
        yield [int(n) for n in beside if n >= 0]
