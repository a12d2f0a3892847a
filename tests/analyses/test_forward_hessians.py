"""Contracted second derivatives of forward dynamics: against differences of first ones, and a closed form."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import njit
from numba.core.runtime import rtsys
from numba.core.runtime._nrt_python import memsys_disable_stats, memsys_enable_stats
from tests.analyses.test_linearization import cart_pole, four_bar

import sarrus as sr
from sarrus.analyses.equations.states_at_rest import places
from sarrus.analyses.position.coordinate_set import of_names
from sarrus.model.written import with_numbers, written_numbers

FOURTH_ORDER = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}


def differences(gradient: Callable[[np.ndarray], np.ndarray], size: int, h: float) -> np.ndarray:
    """The derivative of a gradient, by differences of fourth order."""
    return np.array([sum(w * gradient(n * h * e) for n, w in FOURTH_ORDER.items()) / h for e in np.eye(size)])


def servo(**values: float) -> sr.System:
    """A slider-crank whose crank a motor turns; the voltage acts through a nonlinear law, too."""
    model = sr.load("slider_crank")
    motor = sr.DCMotor("motor", "pin", voltage="u", resistance=0.5, inductance=0.02, constant=0.4, gear=3.0)
    brake = sr.Torque("brake", "pin", value="-0.3*v*v*v + u*u*sin(x)")
    u = sr.Input("u", 1.5, unit="V")
    whole = sr.Model("servo", model.bodies, model.joints, [*model.forces, u, motor, brake])
    return sr.System(with_numbers(whole, values))


# of forces, a motor, inertia, a joint's place, and axes, on which b does not depend linearly
PARAMETERS = ["spring.k", "motor.inductance", "rod.mass", "ball.point.z", "guide.axis.z", "pin.axis.z"]


def by_each(make: Callable[..., sr.System], gradient: Callable[[sr.System], np.ndarray]) -> np.ndarray:
    """The derivatives of a gradient by parameters, by differences of fourth order of mechanisms with others."""
    own, found = written_numbers(make().model), []
    for name in PARAMETERS:
        h = 1e-3 * (own[name] or 1.0)
        near = [w * gradient(make(**{name: own[name] + n * h})) for n, w in FOURTH_ORDER.items()]
        found.append(sum(near) / h)
    return np.array(found)


@pytest.mark.parametrize("make", [cart_pole, servo])
def test_by_all_coordinates(make: Callable[[], sr.System]) -> None:
    system = make()
    f, nq, (u,) = system.forward_dynamics, system.nq, system.inputs
    q, v = system.q0 + 0.02 * np.cos(np.arange(nq)), np.sin(np.arange(nq))  # off the constraints, too
    weights = np.cos(np.arange(nq + system.m))

    def gradient(change: np.ndarray) -> np.ndarray:
        d = f.derivatives(q + change[:nq], v + change[nq : 2 * nq], u={u: 1.5 + change[-1]})
        of_a, of_lam = np.hstack([d.a_q, d.a_v, d.a_u]), np.hstack([d.lam_q, d.lam_v, d.lam_u])
        return weights[:nq] @ of_a + weights[nq:] @ of_lam

    found = f.hessian(q, v, weights, u={u: 1.5})
    size = abs(found).max()
    assert found == pytest.approx(found.T, abs=1e-12 * size)
    assert found == pytest.approx(differences(gradient, 2 * nq + 1, 1e-3), abs=1e-8 * size)
    of_a = f.hessian(q, v, weights[:nq], u={u: 1.5})
    assert abs(of_a - found).max() > 0.01 * size
    assert of_a == pytest.approx(f.hessian(q, v, np.append(weights[:nq], np.zeros(system.m)), u={u: 1.5}))


def test_by_parameters_at_constant_coordinates() -> None:
    """Against differences of first derivatives by q, v, u and b of mechanisms with other parameters."""
    system = servo()
    nq, f = system.nq, system.forward_dynamics
    q, v = system.q0 + 0.02 * np.cos(np.arange(nq)), np.sin(np.arange(nq))
    weights, hessian = np.cos(np.arange(nq + system.m)), f.differentiated(PARAMETERS).hessian

    def gradient(other: sr.System) -> np.ndarray:
        return weights @ other.forward_dynamics.derivatives(q, v, wrt=PARAMETERS).every[:, 1:]

    found = hessian(q, v, weights)
    rows = found[2 * nq + 1 :]
    sizes = np.maximum(abs(rows).max(axis=1, keepdims=True), 1e-3)
    assert hessian.parameters == tuple(PARAMETERS)
    assert found[: 2 * nq + 1, : 2 * nq + 1] == pytest.approx(f.hessian(q, v, weights), rel=1e-12)
    assert found == pytest.approx(found.T, abs=1e-12 * abs(found).max())
    assert (rows - by_each(servo, gradient)) / sizes == pytest.approx(0.0, abs=2e-8)
    assert abs(rows[:, -len(PARAMETERS) :].diagonal())[-2:].min() > 0.1  # by axes, also at constant b
    place = system.parameter_names[0]
    again = f.differentiated(place).hessian(q, v, weights, b=system.b)
    assert np.array_equal(again, f.differentiated(place).hessian(q, v, weights))
    with pytest.raises(sr.SarrusError, match=r"is no parameter of an element. Leave out b"):
        hessian(q, v, weights, b=system.b)


class Moved:
    """States of a system by independent coordinates, their rates and first-order states.

    start : values of the coordinates and rates from which changes count; by default those of q and v
    """

    def __init__(
        self, system: sr.System, names: list[str], q: np.ndarray, v: np.ndarray, start: Any = None
    ) -> None:
        self._system, self._of, self._q, self._v = system, of_names(system, tuple(names)), q, v
        self._own, self.start = np.eye(system.nq)[places(system)], start or self._of.values(q, v)

    def __call__(self, c: np.ndarray, rates: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The state whose coordinates, rates and states have changed, by Newton's method."""
        system, of, q = self._system, self._of, self._q
        start, rate = self.start
        for _ in range(8):
            gap = np.concatenate(
                [system.Phi(q), of.values(q, self._v)[0] - start - c, self._own @ (q - self._q)]
            )
            q = q - np.linalg.lstsq(self._rows(q), gap, rcond=1e-9)[0]
        right = np.concatenate([np.zeros(system.m), rate + rates, self._own @ self._v + states])
        return q, np.linalg.lstsq(self._rows(q), right, rcond=1e-9)[0]

    def _rows(self, q: np.ndarray) -> np.ndarray:
        return np.vstack([self._system.Phi_q(q).toarray(), self._of.gradients(q), self._own])


def check(system: sr.System, names: list[str], q: np.ndarray, v: np.ndarray, accuracy: float = 1e-8) -> None:
    """Rates and multipliers; the latter as functions of q and v along the coordinates."""
    dynamics, (u,) = system.forward_dynamics, system.inputs
    matrices, n, ns = dynamics.in_coordinates(names), len(names), len(system.states)
    moved, nx, redundant = (
        Moved(system, names, q, v),
        2 * n + ns,
        np.linalg.matrix_rank(system.Phi_q(q).toarray()),
    )
    weights = np.cos(np.arange(nx + system.m))
    weights[nx:] *= float(redundant == system.m)

    def gradient(change: np.ndarray) -> np.ndarray:
        state, value = moved(change[:n], change[n : 2 * n], change[2 * n : nx]), {u: 0.7 + change[nx]}
        found = weights[:nx] @ matrices(*state, u=value).every
        if not weights[nx:].any():
            return found
        plant = sr.linearize(system.with_inputs(value), *state, coordinates=names)
        d = dynamics.derivatives(*state, u=value)
        by_x = d.lam_q @ plant.q_x + d.lam_v @ plant.v_x
        return found + weights[nx:] @ np.hstack([by_x, d.lam_u])

    found = matrices.hessian(q, v, weights, u={u: 0.7})
    size = abs(found).max()
    assert found == pytest.approx(found.T, abs=1e-11 * size)
    assert found == pytest.approx(differences(gradient, nx + 1, 1e-3), abs=accuracy * size)


def test_in_independent_coordinates_of_a_loop_with_a_motor() -> None:
    system = servo()
    start = sr.assemble(system, rates={"pin": 2.0})
    v = start.v.copy()
    v[system.states["motor.current"].place] = 0.4
    check(system, ["pin.angle"], start.q, v)
    check(system, ["slider.x"], start.q, v)  # a coordinate of a body, in which all is more curved


@pytest.mark.parametrize("coordinate", ["pin.angle", pytest.param("slider.x", marks=pytest.mark.slow)])
def test_by_parameters_in_independent_coordinates(coordinate: str) -> None:
    """At constant coordinates, rates and states, against differences of first derivatives of other mechanisms."""
    system, names = servo(), [coordinate]
    start = sr.assemble(system, rates={"pin": 2.0})
    v = start.v.copy()
    v[system.states["motor.current"].place] = 0.4
    matrices, here = system.forward_dynamics.in_coordinates(names, PARAMETERS), of_names(system, tuple(names))
    values, weights = here.values(start.q, v), np.cos(np.arange(3))

    def gradient(other: sr.System) -> np.ndarray:
        state = Moved(other, names, start.q, v, values)(np.zeros(1), np.zeros(1), np.zeros(1))
        return weights @ other.forward_dynamics.in_coordinates(names, PARAMETERS)(*state).every

    found = matrices.hessian(start.q, v, weights)
    rows = found[4:]
    sizes = np.maximum(abs(rows).max(axis=1, keepdims=True), 1e-3)
    alone = system.forward_dynamics.in_coordinates(names).hessian(start.q, v, weights)
    assert found[:4, :4] == pytest.approx(alone, abs=1e-11 * abs(alone).max())
    assert found == pytest.approx(found.T, abs=1e-11 * abs(found).max())
    assert (rows - by_each(servo, gradient)) / sizes == pytest.approx(0.0, abs=1e-7)
    with pytest.raises(sr.SarrusError, match=r"is no parameter of an element. Leave out b"):
        matrices.hessian(start.q, v, weights, b=system.b)


def test_in_a_loop_with_redundant_constraints() -> None:
    system = four_bar()
    start = sr.assemble(system, rates={"a": 2.0})
    check(system, ["a.angle"], start.q, start.v)
    hessian = system.forward_dynamics.in_coordinates(["a.angle"]).hessian
    with pytest.raises(sr.SarrusError, match="second derivatives of multipliers are not unique"):
        hessian(start.q, start.v, np.ones(2 + system.m))
    with pytest.raises(sr.SarrusError, match=r"second derivatives by all coordinates .* Use in_coordinates"):
        system.forward_dynamics.hessian(start.q, start.v, np.ones(system.nq))


def test_a_pendulum_in_closed_form() -> None:
    """J θ̈ = -m g r sin θ - c θ̇² + u cos θ."""
    m, r, J, g, c = 2.0, 0.5, 0.2 + 2.0 * 0.25, 9.81, 0.3
    arm = sr.Body("arm", mass=m, inertia=(0.1, 0.15, 0.2), position=(0, -r, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 0, 1))
    law = sr.Torque("law", "pin", value=f"u*cos(pin.angle) - {c}*pin.rate**2")
    system = sr.System(sr.Model("arm", [arm], [pin], [sr.Input("u"), law], gravity=(0, -g, 0)))
    hessian, u = system.forward_dynamics.in_coordinates(["pin.angle"]).hessian, 0.7
    for theta, rate in ((0.6, 1.5), (-1.2, 0.4)):
        sin, cos = np.sin(theta), np.cos(theta)
        at = [r * sin, -r * cos, 0, np.cos(theta / 2), 0, 0, np.sin(theta / 2)]
        start = sr.assemble(system.with_inputs({"u": u}), at, rates={"pin": rate})
        exact = np.array([[m * g * r * sin - u * cos, 0, -sin], [0, -2 * c, 0], [-sin, 0, 0]])
        found = hessian(start.q, start.v, [5.0, J], u={"u": u})
        assert found == pytest.approx(exact, abs=1e-11)
        plant = sr.linearize(system.with_inputs({"u": u}), start)
        assert sr.state_hessian(plant, {"pin.angle.rate": J}) == pytest.approx(exact, abs=1e-11)


def test_a_pendulum_by_its_parameters_in_closed_form() -> None:
    """θ̈ = γ sin θ m L/(I + m L²), with the gravity γ = -g."""
    m, L, inertia, gravity, theta = 2.0, 0.5, 0.2, -9.81, 0.6
    arm = sr.Body("arm", mass=m, inertia=(0.1, 0.15, inertia), position=(0, -L, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 0, 1))
    system = sr.System(sr.Model("arm", [arm], [pin], [], gravity=(0, gravity, 0)))
    names = ["arm.mass", "pin.point.y", "gravity.y"]  # the second is a change of L
    sin, cos, J = np.sin(theta), np.cos(theta), inertia + m * L**2
    start = sr.assemble(system, [L * sin, -L * cos, 0, np.cos(theta / 2), 0, 0, np.sin(theta / 2)])
    F, by_m, by_L = m * L / J, L * inertia / J**2, m * (inertia - m * L**2) / J**2
    by_mL = inertia * (inertia - 3 * m * L**2) / J**3
    by_mm, by_LL = -2 * inertia * L**3 / J**3, -2 * m**2 * L * (3 * inertia - m * L**2) / J**3
    exact = [
        [-gravity * sin * F, 0, gravity * cos * by_m, gravity * cos * by_L, cos * F],
        [0, 0, 0, 0, 0],
        [gravity * cos * by_m, 0, gravity * sin * by_mm, gravity * sin * by_mL, sin * by_m],
        [gravity * cos * by_L, 0, gravity * sin * by_mL, gravity * sin * by_LL, sin * by_L],
        [cos * F, 0, sin * by_m, sin * by_L, 0],
    ]
    found = system.forward_dynamics.in_coordinates(["pin.angle"], names).hessian(start.q, start.v, [0.0, 1.0])
    assert found == pytest.approx(np.array(exact), abs=1e-11)


SPRUNG = """
name: sprung
parameters: {p: 0}
bodies: {arm: {mass: 1, inertia: [1, 1, 1], position: [0.5, 0, 0]}}
joints: {pin: {type: revolute, bodies: [ground, arm], point: [0, 0, 0], axis: [0, 0, 1]}}
forces: {coil: {type: rsda, bodies: [ground, arm], point: [0, 0, 0], axis: [0, 0, 1], k: p*sqrt(p)}}
"""


def test_a_parameter_without_a_second_derivative_is_refused(tmp_path: Path) -> None:
    (tmp_path / "sprung.yaml").write_text(SPRUNG)
    dynamics = sr.System(sr.load(tmp_path / "sprung.yaml")).forward_dynamics
    with pytest.raises(sr.SarrusError, match="sprung: p has no second derivative at its value"):
        _ = dynamics.differentiated("p").hessian


@pytest.mark.parametrize("independent", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_numba_code_calls_them(independent: bool) -> None:
    """With the same results, and without allocations."""
    system = servo()
    start = sr.assemble(system, rates={"pin": 2.0})
    f, q, v, b = system.forward_dynamics, start.q.copy(), start.v.copy(), system.b.copy()
    of = f.in_coordinates(["pin.angle"], PARAMETERS) if independent else f.differentiated(PARAMETERS)
    hessian: Any = of.hessian
    with pytest.raises(sr.SarrusError, match="call the function with a state first"):
        _ = system.forward_dynamics.in_coordinates(["pin.angle"]).hessian.data
    weights = np.ones((3 if independent else system.nq) + system.m)
    wanted, function, data = hessian(q, v, weights), hessian.function, hessian.data

    @njit
    def call(count: int, data: Any, b: Any, q: Any, v: Any, weights: Any, H: Any) -> Any:
        for _ in range(count):
            found = function(data, 1e-9, b, 0.0, q, v, weights, H)
        return found

    H = np.zeros(wanted.shape)
    found = call(1, data, b, q, v, weights, H)
    trust, dependent = found if independent else (found, -1)
    assert trust > 1e-9
    assert dependent == -1
    assert np.array_equal(H, wanted)
    memsys_enable_stats()
    try:
        before = rtsys.get_allocation_stats().alloc
        call(500, data, b, q, v, weights, H)
        assert rtsys.get_allocation_stats().alloc - before < 50  # those of the entry of the loop
    finally:
        memsys_disable_stats()


def test_wrong_weights_are_refused() -> None:
    system = cart_pole()
    q, v = system.q0, np.zeros(14)
    with pytest.raises(ValueError, match=r"weights must have shape \(14,\) or \(26,\), got \(3,\)"):
        system.forward_dynamics.hessian(q, v, np.ones(3))
    with pytest.raises(ValueError, match=r"weights must have shape \(4,\) or \(16,\), got \(\)"):
        system.forward_dynamics.in_coordinates(["slide.displacement", "pin.angle"]).hessian(q, v, 1.0)
