"""The state of a linearization: an equilibrium, an assembly, or a state that keeps its independent coordinates.

With coordinates c(q), first-order states and their values given, a state on the constraints follows from

    Φ(q, b) = 0,  c(q, b) = const,    Φ_q v + Φ_t = 0,  ċ(q, v, b) = const.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ....algebra import Array
from ....model.announcement import collecting
from ....outputs.motion import states_of
from ....results import Assembly, AssemblyRequest, Equilibrium, StateSpace
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives
from ...position.assembly_derivatives import AssemblyDerivatives, NoDerivative
from ...position.initial_state import start_of
from ...position.joint_space import followed_coordinates, held_coordinates
from ..chain.start import Start
from ..parameters.design_start import own_rates, own_start
from ..steps.sweep_loop import NodeArrays
from .matrices import MatricesAbout
from .recorded_outputs import RecordedCoordinates
from .rest import Conditions, RestingState
from .solved_states import Moves, SolvedStates


def linearized_state(system: System, plant: StateSpace) -> SolvedStates:
    """The state of a linearization, with its matrices.

    Raises
    ------
    NoDerivative
        If the search for its equilibrium failed.
    """
    start = plant.start
    if start is not None and not start.success:
        raise NoDerivative(
            f"{plant.name}: the matrices are about a state that was not found. {start.message}"
        )
    state = RestingState(system, start) if isinstance(start, Equilibrium) else GivenState(system, plant)
    coordinates = RecordedCoordinates(system, state.states, plant)
    if isinstance(state, GivenState) and start is None:
        state.held = HeldCoordinates(system, state, coordinates)
    state.about = MatricesAbout(state, plant, coordinates)
    return state


class GivenState(SolvedStates):
    """A state with the accelerations and multipliers that belong to it.

    Attributes
    ----------
    held : the conditions on the state, if it is no assembly
    """

    held: HeldCoordinates | None = None

    def __init__(self, system: System, plant: StateSpace) -> None:
        super().__init__(system, states_of(plant), system.b[system.memory_places][None])
        self._start = None if isinstance(plant.start, Equilibrium) else plant.start

    @cached_property
    def _assembly(self) -> AssemblyDerivatives:
        with collecting():  # warnings of the linearization itself have been issued
            return AssemblyDerivatives(self.system, start_of(self.system, self._start))

    @cached_property
    def _by_model(self) -> Array:
        """The parameters of joint coordinates, and the given rates, by those of the model, which follow them."""
        count, rates = len(self.system.joint_coordinates.b), list(self.system.model.rates)
        own = own_rates(self.system, start_of(self.system, self._start))
        found = np.zeros((count + len(own), count + len(rates)))
        found[:count, :count] = np.eye(count)
        for row, name in enumerate(own):
            found[count + row, count:] = [float(name == of_model) for of_model in rates]
        return found

    @cached_property
    def _own(self) -> tuple[bool, bool]:
        """Whether the guess of the assembly is the model's."""
        return own_start(self.system, self._start)

    @cached_property
    def motion(self) -> Start:
        """The derivatives of accelerations and multipliers."""
        return Start(self.system, self.steps, CurveDerivatives(self.system))

    def along(self, moves: Moves) -> NodeArrays:
        if self.held:
            q, v = self.held.along(moves)
        else:
            dq, dv = (own * x for own, x in zip(self._own, (moves.q, moves.v), strict=True))
            q, v = self._assembly.along(moves.b, dq=dq, dv=dv, dc=self._by_model @ moves.c)
        return NodeArrays(*(x[None] for x in (q, v, *self.motion.along(q, v, moves.b))))

    def gradient(self, by: NodeArrays) -> Moves:
        q, v, b = self.motion.transposed(*self.motion.adjoint(by.a[0], by.lam[0]))
        q, v = by.q[0] + q, by.v[0] + v
        if self.held:
            through = self.held.gradient(q[:, 0], v[:, 0])
        else:
            found = self._assembly.adjoint(q[:, 0], v[:, 0])
            own_q, own_v = self._own
            parts = found.b, own_q * found.q, own_v * found.v, self._by_model.T @ found.c
            through = Moves(*(x[:, None] for x in parts))
        return through._replace(b=through.b + b)


class HeldCoordinates(AssemblyDerivatives):
    """Derivatives of a state whose independent coordinates, their rates and first-order states stay.

    Parameters
    ----------
    system : System
    state : for its values, and independent equations
    coordinates : the independent ones
    """

    def __init__(self, system: System, state: SolvedStates, coordinates: RecordedCoordinates) -> None:
        t, q, v = float(state.states.t[0]), state.states.q[0], state.states.v[0]
        unit = np.ones(system.nq)
        asked = AssemblyRequest(
            q, v, unit, unit, held_coordinates(system, ()), followed_coordinates(system), {}, t
        )
        none = np.zeros(system.m)
        super().__init__(
            system,
            Assembly(q, v, True, "a given state", 0.0, 0, lam=none, mu=none, nearest=True, asked=asked),
        )
        self._coordinates = coordinates
        self.conditions = Conditions(system, state, coordinates)

    def along(self, moves: Moves) -> tuple[Array, Array]:  # type: ignore[override]
        nq, of = self._system.nq, self._coordinates
        c, rate = of.by_parameters(moves.b, moves.c)
        q = self.conditions.solve((self._first @ moves.b)[nq:], -c)
        gaps = (self._second @ np.concatenate([q, moves.b]))[nq:]
        return q, self.conditions.solve(gaps, -rate - of.rate_q @ q)

    def gradient(self, q_bar: Array, v_bar: Array) -> Moves:  # type: ignore[override]
        nq, of, system = self._system.nq, self._coordinates, self._system
        rows, rates = self.conditions.transposed(v_bar)
        second = self._second.transposed(np.concatenate([np.zeros(nq), rows]))
        first_rows, first = self.conditions.transposed(q_bar + second[:nq] - of.rate_q.T @ rates)
        by_b = second[nq:] + self._first.transposed(np.concatenate([np.zeros(nq), first_rows]))
        b, c = of.gradient_by_parameters(-first, -rates)
        none = np.zeros((system.nq, 1))
        return Moves((by_b + b)[:, None], none, none, c[:, None])
