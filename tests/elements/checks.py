"""Checks of element kernels as functions that raise AssertionError. The tests and the mutation run both call them."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import NamedTuple
from unittest.mock import patch

import mpmath
import numpy as np
import pytest
from tests.elements import definitions
from tests.elements.own import OWN
from tests.elements.states import (
    COMPLEX,
    DIGITS,
    FRACTIONS,
    WHOLE,
    State,
    converted,
    is_polynomial,
    name_entry,
    names,
    on_sphere,
    state,
)
from tests.paper import paper
from tests.paper.paper import along, derivative, equal, rational, tangent, unit

from sarrus import algebra, euler
from sarrus.elements import BUILT_IN, OPERATORS, Bushing, SphereContact
from sarrus.elements.curve import StoredCurve
from sarrus.elements.evaluation import partition
from sarrus.elements.operators import DERIVATIVES
from sarrus.model.geometry.rotation import product

EXACT_NUMBERS = (int, Fraction, np.integer)


class Check(NamedTuple):
    """A named check; `kind` is the element that it is about, or None for `euler`."""

    kind: type | None
    name: str
    run: Callable[[], None]


def derivative_of_an_operator(kind, name, arithmetic, seed=0):
    """The kernel of a derivative against differences of the kernel that it differentiates, in a random direction."""
    derivative_at(state(kind, arithmetic, seed), name, seed)


def derivative_at(here, name, seed=0):
    """The same at a state."""
    rule = DERIVATIVES[name]
    contracted = _contracted(rule.of, rule.along)
    value = here(name)
    assert_exact(value, here.arithmetic)
    direction = here.direction(rule.by, seed)
    found = value * direction if rule.by == "t" else value @ direction
    expected = here.difference(contracted, rule.by, direction)
    assert np.all(here.same(found, expected)), _first_wrong(here, name, value, contracted)


def at_depth(here, widths):
    """The state of a contact with its depth changed to so many widths."""
    kind = here.kind
    field, depth = definitions.DEPTHS[kind]
    numbers, at = here.numbers.copy(), names(kind).index(field)
    e, q, t = here.element, here.operands["q"], here.operands["t"]
    missing = widths * e.width - depth(e, q, t)
    numbers[at] += float(missing if field == "radius" else -missing / e.sign)
    if "damping" in kind.fields:
        numbers[names(kind).index("damping")] *= 1e-3  # or fast random rates would lift it off
    there = replace(here, numbers=numbers)
    assert float(depth(there.element, q, t)) == pytest.approx(widths * e.width)
    return there


def _contracted(name, direction):
    def f(there: State):
        value = there(name)
        return value @ there.operands[direction] if direction else value

    return f


def _first_wrong(here, name, value, f):
    """Which entries of a derivative are wrong, found column by column."""
    by, wrong = DERIVATIVES[name].by, []
    if by == "t":
        return f"{here.kind.__name__}.{name} is wrong"
    for n in range(value.shape[1]):
        direction = 0 * here.direction(by)
        direction[n] += 1
        rows = np.flatnonzero(~here.same(value[:, n], here.difference(f, by, direction)))
        wrong += [name_entry(here.kind, OPERATORS[name], (m, n)) for m in rows]
    return f"{here.kind.__name__}.{name} is wrong at {'; '.join(wrong[:6])}"


def assert_exact(value, arithmetic):
    """In exact numbers nothing is ever rounded."""
    if arithmetic in (WHOLE, FRACTIONS):
        assert all(isinstance(x, EXACT_NUMBERS) for x in np.ravel(value)), "a float in an exact result"


def operator_that_follows(kind, name, arithmetic, seed=0):
    """An operator that is not coded, against its definition."""
    here = state(kind, arithmetic, seed)
    x = here.operands
    expected = {
        "Phi_q_xi": lambda: here.difference(lambda s: s("Phi"), "q", x["xi"]),
        "Phi_qT_lam": lambda: x["lam"] @ here("Phi_q"),
        "M_a": lambda: here("M") @ x["a"],
        "gamma": lambda: -here.difference(_derivative_along_v, "q", x["v"]) - _time_terms(here),
        "gamma_q": lambda: -here("Phi_q_xi_q_eta_q"),
        "gamma_v": lambda: -2 * here("Phi_q_xi_q"),
        "gamma_b": lambda: -here("Phi_q_xi_q_eta_b"),
    }
    if name in ("gamma_q", "gamma_v", "gamma_b"):
        if kind.timed:
            return  # checked by differences of gamma
        here = replace(here, operands={**x, "xi": x["v"], "eta": x["v"]})
    assert np.all(here.same(here(name), expected[name]()))


def _derivative_along_v(there):
    """Φ_q v; by complex step the kernel, itself checked, since a complex step cannot be taken twice."""
    v = there.operands["v"]
    if there.arithmetic == COMPLEX:
        return there("Phi_q") @ v
    return there.difference(lambda s: s("Phi"), "q", v)


def _derivative_to_t(there, one):
    if there.arithmetic == COMPLEX:
        return there("Phi_t") * one
    return there.difference(lambda s: s("Phi"), "t", one)


def _time_terms(here):
    """2 (Φ_q v)_t + Φ_tt."""
    if not here.kind.timed:
        return 0 * here("Phi")
    one = here.direction("t")
    mixed = here.difference(_derivative_along_v, "t", one)
    twice = here.difference(lambda s: _derivative_to_t(s, one), "t", one)
    return 2 * mixed / one + twice / (one * one)


def constraint(kind, arithmetic, seed=0):
    """Φ against its definition."""
    here = state(kind, arithmetic, seed)
    expected = definitions.CONSTRAINTS[kind](here.element, here.operands["q"])
    assert np.all(here.same(here("Phi"), expected))


def mass_matrix(kind, arithmetic, seed=0):
    """vᵀM v and its polar form against twice the kinetic energy; M is symmetric."""
    here = state(kind, arithmetic, seed)
    v, u, M = here.operands["v"], here.operands["xi"], here("M")

    def energy(v):
        return twice_kinetic_energy(replace(here, operands={**here.operands, "v": v}))

    assert_exact(M, arithmetic)
    assert np.all(here.same(v @ M @ v, energy(v)))
    assert np.all(here.same(4 * (u @ M @ v), energy(u + v) - energy(u - v)))
    assert np.all(here.same(M, M.T))


def twice_kinetic_energy(here):
    """Of a body, with ω' = 2 G ṗ, or of a coordinate: I ξ̇²."""
    e, q, v = here.element, here.operands["q"], here.operands["v"]
    if here.kind in definitions.JOINT_INERTIAS:
        coordinate = definitions.JOINT_INERTIAS[here.kind]
        rate = here.difference(lambda s: coordinate(e, s.operands["q"]), "q", v)
        return e.inertia * rate * rate
    return 2 * kinetic_energy(e, definitions.INERTIAS[here.kind](e), q, v, 2 * paper.G(q[3:]) @ v[3:])


def mass_matrix_without_G(kind):
    """The same on unit p with ω' from AᵀȦ, for tangent ṗ."""
    here = on_sphere(state(kind, FRACTIONS))
    q, v, M = here.operands["q"], here.operands["v"], here("M")
    spin = paper.A(q[3:]).T @ along(paper.A, q[3:], v[3:])
    assert equal(spin, -spin.T)
    omega = paper.vec(spin[2, 1], spin[0, 2], spin[1, 0])
    element = here.element
    assert v @ M @ v == 2 * kinetic_energy(element, definitions.INERTIAS[kind](element), q, v, omega)


def kinetic_energy(e, c, q, v, omega):
    """Of a body with centre of mass c: ½ m |ṙ_c|² + ½ ω'ᵀJω'; twice 2T is exact in whole numbers too."""
    xx, yy, zz, xy, xz, yz = e.inertia
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    r_c = v[:3] + along(lambda p: paper.A(p) @ c, q[3:], v[3:])
    return (e.mass * (r_c @ r_c) + omega @ J @ omega) / Fraction(2)


def lagrange(kind, arithmetic, seed=0):
    """S = T_q - (T_v)_q v with T = ½ vᵀM v."""
    here = state(kind, arithmetic, seed)
    v, u = here.operands["v"], here.direction("q", seed)
    twice_T_q = here.difference(lambda s: v @ s("M") @ v, "q", u)
    momentum = here.difference(lambda s: u @ s("M") @ v, "q", v)
    assert np.all(here.same(2 * (here("S") @ u), twice_T_q - 2 * momentum))


def virtual_work(kind, arithmetic, seed=0, depth=None):
    """Q·δq against the work that the force does along δq; of contacts also at a depth, in widths of the rounding."""
    here = state(kind, arithmetic, seed)
    direction = here.direction("q", seed)
    if kind in definitions.ROTATIONAL:
        here = PREPARED.get(kind, lambda state: state)(on_sphere(here))
        for first in range(3, 7 * kind.bodies, 7):
            p = here.operands["q"][first : first + 4]
            direction[first : first + 4] -= (direction[first : first + 4] @ p) * p
    here = here if depth is None else at_depth(here, depth)
    assert_exact(here("Q"), arithmetic)
    work = definitions.FORCES[kind](here.element, here)
    expected = here.difference(lambda s: work(s.operands["q"]), "q", direction)
    assert np.all(here.same(here("Q") @ direction, expected))


def potential_energy(kind, arithmetic, seed=0):
    """The potential against the work of the force at rest, without actuators and with symmetric stiffness."""
    here = PREPARED.get(kind, lambda state: state)(on_sphere(state(kind, arithmetic, seed)))
    here = _conservative(replace(here, operands={**here.operands, "v": 0 * here.operands["v"]}))
    direction = here.direction("q", seed)
    for first in range(3, 7 * kind.bodies, 7):
        p = here.operands["q"][first : first + 4]
        direction[first : first + 4] -= (direction[first : first + 4] @ p) * p
    with patch.object(StoredCurve, "moment", definitions.moment):  # kernels only record it
        gain = here.difference(
            lambda s: s.element.potential(partition(kind, s.operands["q"]))[0], "q", direction
        )
    assert np.all(here.same(here("Q") @ direction, -gain))


def _conservative(here):
    """The numbers of a force with its actuator at zero and its matrix of stiffness symmetric."""
    numbers, start = here.numbers.copy(), 0
    for field, width in zip(here.kind.fields, here.kind.widths(), strict=True):
        at = slice(start, start + width)
        if field in ("force", "torque"):
            numbers[at] *= 0
        if field == "K":
            K = numbers[at].reshape(6, 6)
            numbers[at] = (K + K.T).reshape(-1)
        start += width
    return replace(here, numbers=numbers)


def _satisfying(here):
    """An angle on a revolute joint that is satisfied, its axes orthonormal, the reference some turns away."""
    q, frame = here.operands["q"], paper.A(unit(50))
    A_i, A_j = paper.A(q[3:7]), paper.A(q[10:])
    f, g, h = (converted(frame[:, n], here.arithmetic) for n in range(3))
    three, four = converted(np.array([Fraction(3, 5), Fraction(4, 5)]), here.arithmetic)
    f_j = A_j.T @ A_i @ (three * f + four * g)
    numbers = np.concatenate([f, g, h, f_j, A_j.T @ A_i @ h, here.numbers[15:]])
    numbers[-1] = 22.5 * here.operands["t"] ** 0  # near which the turns counted are not those of 22.5 / 2π
    return replace(here, numbers=numbers)


def _unit_normal(here):
    """A plane whose normal is a unit vector."""
    at = slice(6, 9)  # n_j
    numbers = here.numbers.copy()
    numbers[at] = converted(paper.A(unit(51))[:, 2], here.arithmetic)
    return replace(here, numbers=numbers)


def _turned(here):
    """A bushing that is turned by 0.2 rad, for which its series has 36 digits."""
    p_i, p_j = here.operands["q"][3:7], here.operands["q"][10:]
    back = converted(np.array([Fraction(n, 1203) for n in (1197, -40, -80, -80)]), here.arithmetic)
    e = product(product(p_i * [1, -1, -1, -1], p_j), back)
    e = e / mpmath.sqrt(e @ e)
    return replace(here, numbers=np.concatenate([here.numbers[:15], e, here.numbers[19:]]))


PREPARED = {
    **dict.fromkeys(definitions.ON_A_HINGE, _satisfying),
    SphereContact: _unit_normal,
    Bushing: _turned,
}


# ------------------------------------------------------------------------------------------- Euler parameters


def euler_functions(seed=0):
    """Every function of `sarrus.euler` and the vectors of `sarrus.algebra` against the definitions."""
    p, b, a, x = (rational(seed + n, size) for n, size in enumerate((4, 4, 3, 3)))
    assert equal(algebra.skew(a) @ x, algebra.cross(a, x), np.cross(a, x))
    assert equal(algebra.outer(a, x), np.outer(a, x))
    assert equal(euler.A(p), paper.A(p))
    assert equal(euler.rotate(p, a), paper.A(p) @ a)
    assert equal(euler.B(p, a), derivative(lambda p: paper.A(p) @ a, p))
    assert equal(euler.D(a, x), derivative(lambda p: euler.B(p, a).T @ x, p))
    assert equal(euler.C(p, b), derivative(lambda a: euler.B(p, a) @ b, a))
    assert equal(euler.K(p, x), derivative(lambda a: euler.B(p, a).T @ x, a))
    assert equal(euler.bar(x), derivative(lambda p: euler.G(p).T @ x, p))
    assert equal(euler.bar_E(x), derivative(lambda p: euler.E(p).T @ x, p))


def angular_velocities(seed=0):
    """2 G ṗ and 2 E ṗ are the angular velocities that AᵀȦ and ȦAᵀ give, on unit p for tangent ṗ."""
    p = unit(seed)
    v = tangent(seed + 1, p)
    A_dot = along(paper.A, p, v)
    assert equal(algebra.skew(2 * euler.G(p) @ v), paper.A(p).T @ A_dot)
    assert equal(algebra.skew(2 * euler.E(p) @ v), A_dot @ paper.A(p).T)
    assert equal(euler.G(p) @ p, euler.E(p) @ p, np.zeros(3, dtype=int))


# -------------------------------------------------------------------------------------------------- the list


def exact_checks(kind, arithmetic) -> Iterator[Check]:
    """All checks of an element in an arithmetic."""
    for operator in kind.family:
        nested = operator.name == "gamma" and arithmetic == COMPLEX  # a difference within a difference
        run = partial(operator_that_follows, kind, operator.name, DIGITS if nested else arithmetic)
        if operator.origin == "follows":
            yield Check(kind, operator.name, run)
        elif operator.name in DERIVATIVES:
            yield Check(
                kind, operator.name, partial(derivative_of_an_operator, kind, operator.name, arithmetic)
            )
        if operator.origin == "follows" and operator.name in DERIVATIVES:
            differences = partial(derivative_of_an_operator, kind, operator.name, arithmetic)
            yield Check(kind, f"{operator.name}, differences", differences)


def definition_checks(kind, arithmetic) -> Iterator[Check]:
    """The checks of an element's first operators (Φ, M, S or Q) against what they are by definition."""
    family = kind.family[0].family
    if family == "constraint":
        yield Check(kind, "Phi", partial(constraint, kind, arithmetic))
    elif family == "inertia":
        yield Check(kind, "M", partial(mass_matrix, kind, arithmetic))
        if kind in definitions.INERTIAS:
            yield Check(kind, "M without G", partial(mass_matrix_without_G, kind))
        yield Check(kind, "S", partial(lagrange, kind, arithmetic))
    else:
        whole = arithmetic == WHOLE and kind in definitions.ROTATIONAL
        yield Check(kind, "Q", partial(virtual_work, kind, FRACTIONS if whole else arithmetic))
        if hasattr(kind, "potential"):
            yield Check(
                kind, "potential", partial(potential_energy, kind, FRACTIONS if whole else arithmetic)
            )
        for depth in (-0.3, 0.2, 1.5) if kind in definitions.DEPTHS else ():
            yield Check(kind, f"Q at {depth} widths", partial(virtual_work, kind, arithmetic, depth=depth))


def all_checks(quick: bool) -> list[Check]:
    """Every check; `quick` in whole numbers and by complex step, else in fractions and 70 digits."""
    exact, digits = (WHOLE, COMPLEX) if quick else (FRACTIONS, DIGITS)
    checks = [Check(None, "euler", euler_functions), Check(None, "angular velocities", angular_velocities)]
    for kind in BUILT_IN:
        polynomial = is_polynomial(kind)
        checks += definition_checks(kind, exact if polynomial else DIGITS)
        checks += exact_checks(kind, exact if polynomial else digits)
    for kind in OWN:
        checks += exact_checks(kind, exact if is_polynomial(kind) else digits)
    return checks
