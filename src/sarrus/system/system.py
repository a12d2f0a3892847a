"""The class System: a model compiled to arrays, once."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from copy import copy
from functools import cached_property
from inspect import signature
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..algebra import Array
from ..deferred import corrector, forward
from ..elements import OPERATORS
from ..elements.operators import Axis
from ..model import Input, Model
from ..model.announcement import accepts_strict, announce
from ..model.coordinates import coordinates_of
from ..model.deprecated import withdrawn
from ..model.expansion.blueprint import Placement, blueprint
from ..model.expansion.marker import Marker, marker
from ..model.expansion.suspicions import Suspicions
from ..model.quantity import InputNumber
from ..model.show import quote, suggest
from ..model.states.block import CLOCKED, UNUSED, StateInertia
from ..model.states.input import with_input_values
from ..rendering import Display
from .check import Report, check_derivatives
from .curves.curve_potentials import curve_potentials, has_curve_potential
from .layout import Layout
from .operators.constraints import ConstraintOperators
from .operators.element_values import ElementValues, memory_places
from .operators.inertia import ForceOperators, InertiaOperators
from .operators.joints import JointCoordinates, SystemJoint
from .operators.operators import Operators
from .operators.reactions import Wrench, wrench
from .structure.population import Population, normalizations, places_of, populate
from .structure.structure import structure_of

MAIN = ("M", "Phi", "Phi_q", "Q", "gamma")  # those that a system itself completes
SUPPORT = (*(name for name in vars(Operators) if name[0] != "_" and name != "compile"), "memory_places")
STATE = ("populations", "potentials", "remember", "remembered", "structure", "with_memory")  # of analyses
HIDDEN = {*OPERATORS, *SUPPORT, *STATE} - {*MAIN}  # found when they are typed, but not completed


class System(Display, ConstraintOperators, InertiaOperators, ForceOperators):
    """The equations of motion of a model and all their derivatives.

        M(q) a + Φ_q(q, t)ᵀ lam = Q(q, v, t) + S(q, v),    Φ(q, t) = 0

    Parameters
    ----------
    model : Model

    Attributes
    ----------
    warnings : messages about legal but suspicious input; results of its analyses contain them, too
    name : the model's name
    bodies : names of the bodies
    layout : where the coordinates of each body are in q and v, see `Layout`
    states : first-order states by name, with their place in v and unit; `moving` coordinates of bodies are before them
    followed_states : those that drivers follow, which are coordinates, with their place in q
    inputs : inputs by name, with the places of their numbers in `b`, see `InputPlaces`
    nq, m : number of coordinates, of constraint equations (joints and normalizations)
    m_holonomic : how many of these are equations Φ(q, t) = 0; those behind them restrict velocities only
    q0, v0 : coordinates and velocities of the model, perhaps not yet assembled (nq,)
    given_v0 : true for the velocities that the model gives (nq,)
    b : the parameter vector: the parameters of all elements (nb,), named by `parameter_names`; points and axes of
        redundant joints that disagree by rounding are corrected
    memory_places : indices in `b` of the elements' state variables between accepted states
    rows : joint or driver name -> its equations' rows in Φ
    joint_coordinates : angles and displacements of all joints, see `JointCoordinates`
    counted_coordinates : these, and behind them the rotations of bodies about global axes; runs count their revolutions
    structure : data common to systems that differ only in parameter values

    Raises
    ------
    ModelError
        If anything is wrong in the model: part, file and line, remedy.
    """

    @accepts_strict
    def __init__(self, model: Model) -> None:
        plan = blueprint(model)
        self.warnings = announce(Suspicions(model, plan).messages())
        self.name = plan.name
        self.model = model
        self.bodies = plan.bodies
        self.q0, self.v0, self.given_v0 = plan.q, plan.v, plan.given
        self.states, self.followed_states = plan.states, plan.followed_states
        self.layout = Layout.of(plan.owners)
        self.nq = self.layout.size
        placed = *plan.placed, *normalizations(plan.owners)
        self.populations, self.b = populate(placed, self.layout.firsts)
        self.m, self.m_holonomic = _rows(self.populations), _rows(self._holonomic_populations())
        self.nb = max((p.end for p in self.populations), default=0)
        self.structure = structure_of(self.populations, self.layout.widths, self.m, self.nb)
        self._markers: dict[str, Marker] = {}
        self.rows = self._rows_of_joints()
        self.memory_places = memory_places(self.populations)
        self.inputs = input_places(model, plan.placed, self.populations, self.b)
        self.joint_coordinates = JointCoordinates(plan.coordinates, self.layout)
        self.counted_coordinates = JointCoordinates(plan.coordinates, self.layout, plan.rotations)
        self.b, rounded = corrector()(self)
        self.warnings += announce(rounded)

    def headline(self) -> str:
        """The name and size of the system."""
        bodies = "1 body" if len(self.bodies) == 1 else f"{len(self.bodies)} bodies"
        return f"{self.name}: {bodies}, {self.nq} coordinates, {self.m} constraint equations"

    @property
    def operators(self) -> AllOperators:
        """All operators of the equations of motion, such as ``Phi_qT_lam_q_xi_q``."""
        return AllOperators(self)

    def __dir__(self) -> list[str]:
        return [name for name in super().__dir__() if name not in HIDDEN]

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name.startswith("_"):
                raise AttributeError(name)
            sarrus = sys.modules["sarrus"]
            if name in sarrus.__all__ and callable(public := getattr(sarrus, name)):
                hint = f"Analyses are functions: sarrus.{name}({next(iter(signature(public).parameters), '')}, ...)."
            else:
                own = (one for one in dir(self) if not one.startswith("_"))
                hint = suggest(name, [*own, *OPERATORS, *sarrus.__all__])
            if name in ("output", "outputs"):
                hint = "List them by sarrus.outputs.outputs_of(system)."
            gone = withdrawn("System", name)
            raise AttributeError(gone or f"A system has no attribute {quote(name)}. {hint}")

    def _rows_of_joints(self) -> dict[str, Array]:
        rows: dict[str, list[int]] = {}
        for p in self.populations:
            for owner, first in zip(p.owners, p.rows, strict=True) if p.kind.rows else ():
                if owner:  # not normalizations, nor unused slots of states
                    rows.setdefault(owner, []).extend(range(first, first + p.kind.rows))
        return {
            owner: np.array(sorted(found)) for owner, found in sorted(rows.items(), key=lambda r: min(r[1]))
        }

    def _holonomic_populations(self) -> list[Population]:
        return [p for p in self.populations if not p.kind.nonholonomic]

    @property
    def holonomic(self) -> System:
        """The system without its nonholonomic constraints, which do not restrict positions; itself if it has none.

        Parameters and the other rows of Φ have the same places in both.
        """
        if self.m_holonomic == self.m:
            return self
        found = copy(self)
        found.populations, found.m = self._holonomic_populations(), self.m_holonomic
        found.structure = structure_of(found.populations, self.layout.widths, found.m, self.nb)
        every = {joint: rows[rows < found.m] for joint, rows in self.rows.items()}
        found.rows = {joint: rows for joint, rows in every.items() if len(rows)}
        return found

    def counts(self) -> dict[str, int]:
        """Bodies, coordinates, joint equations, normalizations, degrees of freedom, and elements by kind."""
        kinds: dict[str, int] = {}
        for p in self.populations:
            if p.count:
                kinds[p.kind.__name__] = kinds.get(p.kind.__name__, 0) + p.count
        hidden = ("Normalization", StateInertia.__name__, *(kind.__name__ for kind in (*UNUSED, *CLOCKED)))
        return {
            "bodies": len(self.bodies),
            "coordinates": self.moving,
            "joint_equations": sum(len(rows) for rows in self.rows.values()),
            "normalizations": len(self.bodies),
            "degrees_of_freedom": self.nq - self.m - len(self.states),
            **({"states": len(self.states)} if self.states else {}),
            **{name: count for name, count in kinds.items() if name not in hidden},
        }

    def coordinates_of(self, body: str) -> slice:
        """Indices of a body's seven coordinates in q.

        Raises
        ------
        KeyError
            If there is no such body.
        """
        return coordinates_of(body, self.bodies, self.name)

    def joint(self, name: str) -> SystemJoint:
        """Return a joint with its angles and displacements as functions of q.

        Raises
        ------
        KeyError
            If there is no joint of this name that has any.
        """
        return SystemJoint(self.joint_coordinates, name)

    def marker(self, joint: str) -> Marker:
        """Return bodies, points and axes of a joint or driver; a driver of a joint has those of the joint.

        Raises
        ------
        KeyError
            If there is none of this name.
        """
        if joint not in self.rows:
            raise KeyError(f"no joint {quote(joint)} in {self.name}. {suggest(joint, self.rows)}")
        if joint not in self._markers:
            self._markers[joint] = marker(self.model, joint)
        return self._markers[joint]

    def reaction(self, joint: str, q: ArrayLike, lam: ArrayLike, t: float = 0.0) -> Wrench:
        """Force and torque of a joint or driver on its body j, at its point there, in global axes [N], [N m].

        The force is -Φ_{r_j}ᵀ lam, the torque about body j's origin, in its axes, -½ G_j Φ_{p_j}ᵀ lam. A coupling's
        is that on body j of the joint that follows, `joint_j` or `rack`, through all joints that it couples.

        Parameters
        ----------
        joint : name of a joint or driver
        q, lam : (nq,), (m,)
        t : time [s]

        Raises
        ------
        KeyError
            If there is no joint of this name.
        """
        return wrench(self, self.marker(joint), self.rows[joint], np.asarray(q), np.asarray(lam), t)

    def remember(self, q: Array, b: Array, t: float = 0.0) -> None:
        """Write the state variables of elements at an accepted state into `b`, e.g. the revolutions of an RSDA."""
        if len(self.memory_places):
            b[self.memory_places] = self.remembered(np.asarray(q, dtype=float), b, t)

    def with_inputs(self, values: Mapping[str, Any]) -> System:
        """Return the system with other values of inputs by name; itself if there are none.

        Parameters
        ----------
        values : by name, numbers or laws as of `Input`

        Raises
        ------
        ModelError
            If the model has no input of a name, or a value is wrong.
        """
        return System(with_input_values(self.model, values)) if values else self

    def with_memory(self, memory: Array) -> System:
        """Return the system with other state variables of elements (k,) at `memory_places`; itself if equal."""
        if not len(memory) or np.array_equal(memory, self.b[self.memory_places]):
            return self
        found = copy(self)
        found.b = self.b.copy()
        found.b[self.memory_places] = memory
        return found

    @property
    def forward_dynamics(self) -> Any:
        """The function (q, v, t, u, b) -> a, λ of the equations of motion, and its derivatives; see `ForwardDynamics`.

        ``system.forward_dynamics(q, v)`` returns accelerations (nq,) and multipliers (m,),
        ``system.forward_dynamics.derivatives(q, v)`` also their derivatives.
        """
        found = self.__dict__.get("_forward_dynamics")
        if found is None or found.system is not self:  # of a copy
            found = self.__dict__["_forward_dynamics"] = forward()(self)
        return found

    @cached_property
    def remembered(self) -> ElementValues:
        """The state variables of elements at a state; they are stored at `memory_places` in the parameters."""
        return ElementValues("remember", self.populations)

    @cached_property
    def potentials(self) -> ElementValues:
        """Return the potential energies of all elements that have one, except those with curves. [J]"""
        return ElementValues("potential", [p for p in self.populations if not has_curve_potential(p.variant)])

    def potential_energy(self, q: ArrayLike, t: float = 0.0, *, b: Any = None) -> float:
        """Potential energy of gravity, springs and bushings, and of users' elements with `potential`. [J]

        That of a spring with a law for its stiffness is integrated from its free length or angle on, to round-off,
        however narrow features of the law are. Actuators, contacts, stops, tyres and loads have none.
        """
        numbers, q = self.b if b is None else b, np.asarray(q, dtype=float)
        curved = curve_potentials(self.populations, numbers, {}, np.array([float(t)]), q[None])
        return float(self.potentials(q, numbers, t).sum() + curved[0])

    @property
    def parameter_names(self) -> list[str]:
        """The name of every parameter in `b`, e.g. ``spring[tsda].k``."""
        return self.axis_names(Axis.PARAMETERS)

    @property
    def row_names(self) -> list[str]:
        """The name of every constraint equation, e.g. ``pin: f_i.h_j``."""
        return self.axis_names(Axis.ROWS)

    @property
    def coordinate_names(self) -> list[str]:
        """The name of every coordinate, e.g. ``crank.p.e0``."""
        return self.axis_names(Axis.COORDINATES)

    def check_derivatives(self, q: Any = None, *, seed: int = 0, progress: Any = None) -> Report:
        """Compare every operator with an independent one, block by block; see `check_derivatives`."""
        return check_derivatives(self, q, seed=seed, progress=progress)


def _rows(populations: list[Population]) -> int:
    """Return the number of equations."""
    return sum(p.count * p.kind.rows for p in populations)


class AllOperators(ConstraintOperators, InertiaOperators, ForceOperators):
    """The operators of a system's equations of motion by name, ``system.operators.Phi_qT_lam_q_xi_q(q, lam, xi)``.

    Parameters
    ----------
    system : a system; it has the same methods
    """

    def __init__(self, system: Operators) -> None:
        self.populations, self.structure = system.populations, system.structure
        self.nq, self.m, self.b = system.nq, system.m, system.b

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"There is no operator {quote(name)}. {suggest(name, OPERATORS)}")

    def __dir__(self) -> list[str]:
        return [*OPERATORS]

    def __repr__(self) -> str:
        return f"<operators {', '.join(OPERATORS)}>"


class InputPlaces(NamedTuple):
    """Where the number of an input is in the parameter vector `b`: once for each element that it occurs in.

    Attributes
    ----------
    places : indices in b; none for an input that varies in time, whose law is stored in each of these elements
    unit : of the input
    varies : whether it is a law over time
    is_set : whether it has a value
    driving : whether drivers follow it
    """

    places: Array
    unit: str
    varies: bool
    is_set: bool
    driving: bool


def input_places(
    model: Model, placed: Sequence[Placement], populations: Sequence[Population], b: Array
) -> dict[str, InputPlaces]:
    """The places of all inputs of a model by name."""
    inputs = [force for force in model.forces if isinstance(force, Input)]
    if not inputs:
        return {}
    own: dict[str, list[int]] = {one.name: [] for one in inputs}
    for place, value in places_of(populations, placed, b):
        if isinstance(value, InputNumber):
            own[value.name].append(place)
    rows = [(p.at, p.end) for p in populations if p.kind.rows]
    return {
        one.name: InputPlaces(
            np.array(own[one.name], dtype=np.int64), one.unit, one.constant is None, one.value is not None,
            any(begin <= place < end for place in own[one.name] for begin, end in rows),
        )
        for one in inputs
    }  # fmt: skip
