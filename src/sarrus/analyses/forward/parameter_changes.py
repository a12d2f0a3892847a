"""Changes of accelerations and multipliers with parameters that no compiled code has, at one state."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ...outputs.recording import States
from ...system import System
from ...system.cached import once
from ...system.curves.curve_derivatives import CurveDerivatives
from ...system.operators.joints import JointCoordinates
from ..position.coordinate_set import CoordinateSet
from ..sensitivity.chain.start import curved_equations
from ..sensitivity.implicit.solved_states import as_steps
from ..sensitivity.parameters.parameters import Parameters, listed
from ..sensitivity.sampling.reported import Changes, Reporter
from .forward_loop import PivotOrder

State = tuple[float, Array, Array, Array, Array]  # t, q, v, and the a and λ that belong to them


class ParameterChanges(NamedTuple):
    """Derivatives of the parameters of elements and of joint coordinates by parameters that are named.

    Attributes
    ----------
    names : of the parameters (p)
    b : (len(b), p) by them of the elements' parameters
    c : (…, p) of those of the joints' coordinates
    """

    names: tuple[str, ...]
    b: Array
    c: Array

    @classmethod
    def of(cls, system: System, names: str | Sequence[str]) -> ParameterChanges:
        """Those of some names.

        Raises
        ------
        SarrusError
            For unknown parameters, and for one that is named twice.
        """
        sizes, names = (len(system.b), len(system.joint_coordinates.b)), listed(names)
        _refuse_doubled(system, names)
        if not len(names):
            return cls((), *(np.zeros((size, 0)) for size in sizes))
        parameters = Parameters(system, names)
        b, _, _, c = parameters.along(np.eye(len(parameters.names)))
        return cls(tuple(parameters.names), b, c[: sizes[1]])

    def second(self, system: System) -> tuple[ParameterChanges, Array]:
        """Second derivatives by pairs of the parameters, those that are not zero, and the pairs (2, n).

        Raises
        ------
        SarrusError
            For parameters that have none, such as one in a square root whose value is zero.
        """
        pairs, b, c = list[tuple[int, int]](), list[Array](), list[Array]()
        parameters, unit = Parameters(system, self.names), np.eye(len(self.names))
        for j, k in combinations_with_replacement(range(len(unit)), 2):
            of_b, _, _, of_c = parameters.second(unit[j], unit[k])
            of_c = of_c[: len(self.c)]
            if not np.isfinite([of_b @ of_b, of_c @ of_c]).all():
                raise SarrusError(
                    f"{system.name}: {self.names[j]} has no second derivative at its value. Leave it out, or change it."
                )
            if of_b.any() or of_c.any():
                pairs.append((j, k))
                b.append(of_b)
                c.append(of_c)
        names = tuple(self.names[j] for j, _ in pairs)
        columns = (np.reshape(x, (len(names), len(size))).T for x, size in ((b, self.b), (c, self.c)))
        return ParameterChanges(names, *columns), np.array(pairs, dtype=np.int64).reshape(-1, 2).T.copy()

    def refuse_curves(
        self, system: System, advice: str = "Take `derivatives` from Python, or leave it out."
    ) -> None:
        """Refuse parameters of tables and formulas, whose derivatives are not compiled.

        Raises
        ------
        SarrusError
            If there is one.
        """
        for name, change in zip(self.names, self.b.T, strict=True):
            if change[system.nb :].any():
                raise SarrusError(
                    f"{system.name}: {name} changes a table or formula, for which derivatives are not compiled. "
                    f"{advice}"
                )

    def refuse_other(self, system: System, b: object) -> None:
        """Refuse parameters of the model with another b than the system's: only the elements' own are known then.

        Raises
        ------
        SarrusError
            If there is one.
        """
        for name in () if b is None else self.names:
            if name not in _element_parameters(system):
                raise SarrusError(
                    f"{system.name}: {name} is no parameter of an element. Leave out b, or name parameters of "
                    "system.parameter_names."
                )

    def of_coordinates(self, system: System, independent: CoordinateSet) -> Array:
        """The derivatives of the parameters of independent coordinates (len(measured.b), p).

        Raises
        ------
        SarrusError
            For coordinates that no joint has, which other elements measure.
        """
        every, measured = system.joint_coordinates, independent.measured
        derivatives = np.zeros((len(measured.b), len(self.names)))
        if not self.names:
            return derivatives
        places, known = _places_of_parameters(measured), _places_of_parameters(every)
        for output, row in zip(independent.outputs, independent.row.tolist(), strict=True):
            if row >= 0 and output.name not in every.names:
                raise SarrusError(
                    f"{system.name}: derivatives by parameters are not supported in the coordinate {output.name}. Name "
                    "coordinates of joints or bodies."
                )
            if row >= 0:
                derivatives[places[row]] = self.c[known[every.index(output.name)]]
        return derivatives


def _refuse_doubled(system: System, names: Sequence[str]) -> None:
    """Refuse a parameter that is named twice, alone or by its vector: it would have one column."""
    count = Counter(names)
    for name in names:
        vectors = {name.rsplit(".", n)[0] for n in range(1, name.count(".") + 1)}
        if count[name] > 1 or not (vectors - system.model.parameters.keys()).isdisjoint(count):
            raise SarrusError(f"{system.name}: wrt has {name} twice. Name each parameter once.")


@once
def _element_parameters(system: System) -> frozenset[str]:
    return frozenset(system.parameter_names)


def _places_of_parameters(of: JointCoordinates) -> dict[int, slice]:
    """The parameters of each coordinate among all, by row."""
    parameters = dict[int, slice]()
    for p in of.populations:
        size = p.kind.size()
        for k, row in enumerate(p.rows.ravel().tolist()):
            parameters[row] = slice(p.at + k * size, p.at + (k + 1) * size)
    return parameters


def curve_changes(system: System, order: PivotOrder, state: State, b: Array, changes: Array) -> Array:
    """The parts of changes of a and λ (nq + m, k) that come from changes (len(b), k) of tables and formulas.

    The matrix must have been factorized at the state.
    """
    t, q, v, a, lam = state
    at = {"t": t, "q": q, "v": v, "lam": lam, "xi": a}
    right = np.zeros((system.nq + system.m, changes.shape[1]))
    for sign, entries, row, height in curved_equations(CurveDerivatives(system), b, at, system.nq, system.m):
        right[row : row + height] -= sign * entries.along(changes, height)[0]
    assert order.matrix is not None
    right[system.nq :] *= 1.0 - order.matrix.numbers.left_out[:, None]
    return np.column_stack([order.matrix.solve(column) for column in right.T])


def minimum_norm_changes(
    system: System, rows: Array, state: State, b: Array, changes: Array, lam: Array
) -> Array:
    """The changes of multipliers of minimum norm, where constraints other than those of `rows` are redundant.

    Parameters
    ----------
    changes : (len(b), k) of the elements' parameters
    lam : (m, 2 nq + k) changes by q, v and these, of multipliers of independent constraints
    """
    (t, q, v, a, now), nq, left_out = state, system.nq, np.ones((1, system.m), dtype=bool)
    left_out[0, rows] = False
    states = States(np.array([t]), q[None], v[None], a[None], lambda: now[None])
    steps = as_steps(system, states, b[system.memory_places][None], b, left_out)
    minimum = Reporter(system, steps, moving=False).slopes(0)
    if minimum is None:
        return lam
    width = lam.shape[1]
    of_b = np.hstack([np.zeros((len(b), 2 * nq)), changes])
    return minimum.along(Changes(np.eye(nq, width), of_b, np.zeros(width)), lam)
