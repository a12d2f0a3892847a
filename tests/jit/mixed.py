"""A model of every element between random bodies, and its operators assembled by hand from plain kernels."""

from dataclasses import dataclass

import numpy as np
from tests.elements.own import OWN, Coupler, Driven, Implicit, Strained, Tangle

from sarrus import model
from sarrus.elements import BUILT_IN, Normalization
from sarrus.elements import Primitive as Constraint
from sarrus.elements.element import WIDTHS, InertiaElement
from sarrus.elements.evaluation import dense, element_from
from sarrus.elements.operators import Axis
from sarrus.functions import exp, sin, sqrt
from sarrus.model.laws.curve import Curve, Formula
from sarrus.model.laws.surface import Surface
from sarrus.model.primitive import Primitive
from sarrus.system import System

GROUND, AT_REST = np.array([0.0, 0, 0, 1, 0, 0, 0]), np.zeros(7)
BODY_OPERANDS = ("q", "xi", "eta", "v", "a")


def part_of(base):
    """A joint or force that consists of the elements it is given."""

    @dataclass(frozen=True, eq=False)
    class Given(base):
        pieces: tuple[Primitive, ...] = ()

        def primitives(self, poses):
            yield from self.pieces

    return Given


def mixed_system(joint, force, seed=0, names=("a", "b", "c"), kinds=(*BUILT_IN, *OWN)):
    """A system with every element on random bodies, each also with the ground as its first and second body."""
    random = np.random.default_rng(seed)
    joints, forces = [], []
    for kind in kinds:
        if kind is not Normalization and not (issubclass(kind, InertiaElement) and kind.bodies == 1):
            pieces = joints if issubclass(kind, Constraint) else forces
            pieces += [
                Primitive(kind, on, values(kind, random), f"{kind.__name__} {n}")
                for n, on in enumerate(places(kind, names, random))
            ]
    bodies = [
        model.Body(n, mass=1 + k, inertia=(3 + k, 4, 5), center_of_mass=(0.1, 0.2, k) if k else None)
        for k, n in enumerate(names)
    ]
    parts = [joint("joints", tuple(joints))], [force("forces", tuple(forces))]
    return System(model.Model("mixed", bodies, *parts, gravity=(1.0, 2.0, -9.0)))


PLACES = {  # three and four bodies, some of them the ground, some met twice
    Driven: (("a", "b"), ("ground", "b")),
    Coupler: (("a", "b", "a"), ("b", "ground", "c")),
    Tangle: (("a", "b", "c", "a"), ("b", "b", "a", "ground")),
    Strained: (("b", "a"), ("c", "ground")),
    Implicit: (("a", "c"), ("ground", "b")),
}


def places(kind, names, random):
    if kind in PLACES:
        return PLACES[kind]
    if kind.bodies == 1:
        return [(str(n),) for n in random.choice(names, 2)]
    first, second = (str(n) for n in random.choice(names, 2, replace=False))
    if kind.bodies == 4:
        return [(first, second, first, "ground"), ("ground", first, second, first)]
    return [(first, second), (second, first), ("ground", first), (second, "ground")]


POSITIVE = ("width", "creep", "stribeck", "exponent")  # fields that a model holds positive


def values(kind, random):
    return tuple(value(name, field, random) for name, field in kind.fields.items() if field != "Time")


def value(name, field, random):
    if name == "formula":
        return Formula(lambda x: exp(sin(x)) + x * x / sqrt(2 + x * x))
    if field == "Curve":
        return Curve((-2.0, 0.0, 2.0), tuple(tuple(c) for c in random.normal(size=(2, 4))))
    if field == "Surface":
        return Surface([-2.0, 0.0, 2.0], [-2.0, 0.0, 2.0], random.normal(size=(3, 3)))
    if WIDTHS[field] > 1:
        return tuple(random.normal(size=WIDTHS[field]))
    number = float(random.normal())
    return 1 + abs(number) if name in POSITIVE else number


def random_state(system, seed=1):
    random = np.random.default_rng(seed)
    state = {name: random.normal(size=system.nq) for name in BODY_OPERANDS}
    return {**state, "lam": random.normal(size=system.m), "t": 0.7}


def by_hand(system, operator, state):
    """An operator of a system, summed element by element from the kernels in plain NumPy, as a dense array."""
    lengths = {Axis.ROWS: system.m, Axis.COORDINATES: system.nq, Axis.PARAMETERS: system.nb}
    result = np.zeros([lengths[axis] for axis in operator.axes])
    for population in system.populations:
        kind, size = population.kind, population.kind.size()
        for k in range(population.count if operator in kind.family else 0):
            numbers = slice(population.at + k * size, population.at + (k + 1) * size)
            rows = slice(population.rows[k], population.rows[k] + kind.rows)
            bodies = [population.bodies[k][slot] if slot >= 0 else -7 for slot in population.variant.slots]
            local = {name: _of_bodies(state[name], bodies, name) for name in BODY_OPERANDS}
            local |= {"lam": state["lam"][rows] if kind.rows else None, "t": state["t"]}
            element = element_from(kind, system.b[numbers], system.b, state["t"])
            value = dense(element, operator, local).astype(float)
            place = {Axis.ROWS: np.r_[rows], Axis.PARAMETERS: np.r_[numbers]}
            place[Axis.COORDINATES] = np.concatenate([b + np.arange(7) for b in bodies])
            where = [place[axis] for axis in operator.axes]
            own = [index >= 0 for index in where]
            np.add.at(result, np.ix_(*(w[o] for w, o in zip(where, own, strict=True))), value[np.ix_(*own)])
    return result


def _of_bodies(vector, bodies, name):
    at_rest = GROUND if name == "q" else AT_REST
    return np.concatenate([vector[b : b + 7] if b >= 0 else at_rest for b in bodies])
