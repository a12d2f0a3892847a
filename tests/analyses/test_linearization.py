"""State spaces against closed forms, and against differences of the forward dynamics in independent coordinates."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import signal
from tests.analyses.driven import planar_body

import sarrus as sr

M_CART, M_POLE, LENGTH, INERTIA, G = 2.0, 0.5, 0.6, 0.04, 9.81


def cart_pole() -> sr.System:
    """A cart on a slide along x with the force u, and a pole on a pin about z; angle 0 is upright."""
    cart = sr.Body("cart", mass=M_CART, inertia=(1, 1, 1))
    pole = sr.Body("pole", mass=M_POLE, inertia=(INERTIA,) * 3, position=(0, LENGTH, 0))
    slide = sr.Translational("slide", sr.ground, cart, point=(0, 0, 0), axis=(1, 0, 0))
    pin = sr.Revolute("pin", cart, pole, point=(0, 0, 0), axis=(0, 0, 1))
    push = sr.Force("push", "slide", value="u")
    u = sr.Input("u", 0.0, unit="N")
    return sr.System(sr.Model("cart-pole", [cart, pole], [slide, pin], [u, push], gravity=(0, -G, 0)))


def upright() -> tuple[np.ndarray, np.ndarray]:
    """A and B of the cart-pole about its upright position, by hand."""
    total, arm, turning = M_CART + M_POLE, M_POLE * LENGTH, INERTIA + M_POLE * LENGTH**2
    mass = np.linalg.inv([[total, -arm], [-arm, turning]])  # the angle is positive to the left
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [mass @ [[0, 0], [0, arm * G]], np.zeros((2, 2))]])
    return A, np.concatenate([[[0], [0]], mass @ [[1], [0]]])


def test_cart_pole() -> None:
    system, (A, B) = cart_pole(), upright()
    found = sr.linearize(
        system, system.q0, np.zeros(14), outputs=["pin.angle", "pole.x", "cart.velocity.x", "u"]
    )
    assert found.states == ("slide.displacement", "pin.angle", "slide.displacement.rate", "pin.angle.rate")
    assert found.state_units == ("m", "rad", "m/s", "rad/s")
    assert (found.inputs, found.input_units) == (("u",), ("N",))
    assert found.output_units == ("rad", "m", "m/s", "N")
    assert found.A == pytest.approx(A, abs=1e-12)
    assert found.B == pytest.approx(B, abs=1e-12)
    C = [[0, 1, 0, 0], [1, -LENGTH, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0]]
    assert found.C == pytest.approx(np.array(C), abs=1e-12)
    assert found.D == pytest.approx(np.array([[0], [0], [0], [1]]), abs=1e-12)
    assert found.unsteady == pytest.approx(0.0, abs=1e-12)


def test_named_coordinates_and_accelerations_and_reactions_as_outputs() -> None:
    """With the place of the pole's centre and the angle as coordinates; the force of the pin follows from Newton."""
    system, (A, B) = cart_pole(), upright()
    names = ["pole.acceleration.x", "pin.force.x"]
    found = sr.linearize(system, system.q0, np.zeros(14), coordinates=["pole.x", "pin.angle"], outputs=names)
    T = np.kron(np.eye(2), [[1, -LENGTH], [0, 1]])  # from the displacement of the cart
    assert found.states[2:] == ("d(pole.x)/dt", "pin.angle.rate")
    assert found.A == pytest.approx(T @ A @ np.linalg.inv(T), abs=1e-11)
    assert found.B == pytest.approx(T @ B, abs=1e-12)
    assert found.C[0] == pytest.approx(found.A[2], abs=1e-11)
    assert found.D[0] == pytest.approx(found.B[2], abs=1e-12)
    assert found.C[1] == pytest.approx(M_POLE * found.C[0], abs=1e-11)
    assert found.D[1] == pytest.approx(M_POLE * found.D[0], abs=1e-11)


def test_a_mass_on_a_spring_with_a_motor() -> None:
    """A DC motor with inductance turns a wheel on a torsional spring: three states, by hand."""
    k, c, J = 8.0, 0.1, 0.3
    wheel = sr.Body("wheel", mass=1.0, inertia=(0.2, 0.2, J))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    motor = sr.DCMotor("motor", "pin", voltage="u", resistance=0.5, inductance=0.02, constant=0.4, gear=3.0)
    spring = sr.Torque("spring", "pin", value=f"-{k}*x - {c}*v")
    u = sr.Input("u", "2 + 3*t", unit="V")
    system = sr.System(sr.Model("servo", [wheel], [pin], [u, motor, spring]))
    found = sr.linearize(system, system.q0, np.zeros(system.nq), t=1.0)
    A = np.array([[0, 1, 0], [-k / J, -c / J, 1.2 / J], [0, -1.2 / 0.02, -0.5 / 0.02]])
    assert found.states == ("pin.angle", "pin.angle.rate", "motor.current")
    assert found.state_units == ("rad", "rad/s", "A")
    assert found.A == pytest.approx(A, abs=1e-11)
    assert found.B == pytest.approx(np.array([[0], [0], [50.0]]), abs=1e-11)
    assert found.u0 == pytest.approx([5.0])
    s = 2j * np.pi * 1.7
    response = found.frequency_response([1.7])
    exact = 50 * 1.2 / J / ((s * s + c / J * s + k / J) * (s + 25) + 60 * 1.2 / J * s)
    assert response.of("pin.angle", "u") == pytest.approx(exact, rel=1e-11)


def four_bar() -> sr.System:
    """A planar four-bar with three redundant equations, a spring on its rocker, and a torque u on its crank."""
    A, B, C, D = (0.0, 0.0), (0.1, 0.3), (0.9, 0.8), (1.0, 0.0)
    pairs = {"crank": (A, B), "coupler": (B, C), "rocker": (D, C)}
    bodies = {name: planar_body(name, tuple(np.mean(ends, axis=0))) for name, ends in pairs.items()}
    crank, coupler, rocker = bodies.values()
    hinges = {"a": (sr.ground, crank, A), "b": (crank, coupler, B), "c": (coupler, rocker, C)}
    hinges["d"] = (sr.ground, rocker, D)
    joints = [
        sr.Revolute(name, one, other, point=(*at, 0), axis=(0, 0, 1))
        for name, (one, other, at) in hinges.items()
    ]
    forces = [sr.Input("u", 0.7, unit="N m"), sr.Torque("motor", "a", value="u*(1 + 0.2*x) - 0.3*v")]
    forces.append(sr.Torque("spring", "d", value="-5*x - 0.2*v*v*v"))
    return sr.System(sr.Model("four-bar", list(bodies.values()), joints, forces, gravity=(0, -G, 0)))


class Reduced:
    """Forward dynamics in independent coordinates: x' = f(x, u), by assembly and the equations of motion."""

    def __init__(self, system: sr.System, found: sr.StateSpace) -> None:
        self.system, self.found, self.names = system, found, found.states[: len(found.states) // 2]
        self.c = [system.joint(name.split(".")[0])[name.split(".")[1]] for name in self.names]

    def state(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """q and v, by Newton's method from those of the linearization."""
        system, n, q = self.system, len(self.c), self.found.q
        for _ in range(8):
            gap = [c.value(q, near) - value for c, value, near in zip(self.c, x, self.found.x0, strict=False)]
            q = q - self._solve(q, np.concatenate([system.Phi(q), gap]))
        return q, self._solve(q, np.concatenate([-system.Phi_t(q), x[n:]]))

    def _solve(self, q: np.ndarray, right: np.ndarray) -> np.ndarray:
        J = np.vstack([self.system.Phi_q(q).toarray(), *(c.gradient(q).toarray() for c in self.c)])
        return np.linalg.lstsq(J, right, rcond=1e-10)[0]

    def rates(self, x: np.ndarray, u: float) -> np.ndarray:
        """x'."""
        q, v = self.state(x)
        system = self.system.with_inputs({"u": u}) if "u" in self.system.inputs else self.system
        J, M = system.Phi_q(q).toarray(), system.M(q).toarray()
        force = system.Q(q, v, 0.0) + system.S(q, v)
        K = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
        a = np.linalg.lstsq(K, np.concatenate([force, system.gamma(q, v)]), rcond=1e-13)[0][: len(q)]
        return np.array([*x[len(self.c) :], *(c.acceleration(q, v, a) for c in self.c)])


def differences(reduced: Reduced, u: float, h: float = 2e-3) -> tuple[np.ndarray, np.ndarray]:
    """A and B by central differences of order six."""
    weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    x = reduced.found.x0

    def along(dx: np.ndarray, du: float) -> np.ndarray:
        parts = [w * (reduced.rates(x + k * h * dx, u + k * h * du) - reduced.rates(x - k * h * dx, u - k * h * du))
                 for k, w in weights.items()]  # fmt: skip
        return np.sum(parts, axis=0) / h

    return np.array([along(e, 0.0) for e in np.eye(len(x))]).T, along(0 * x, 1.0)[:, None]


def test_a_moving_loop_with_redundant_constraints() -> None:
    system = four_bar()
    start = sr.assemble(system, rates={"a": 3.0})
    found = sr.linearize(system, start, outputs=["rocker.velocity.x", "spring.value"])
    assert len(found.states) == 2
    A, B = differences(Reduced(system, found), 0.7)
    assert found.A == pytest.approx(A, abs=1e-8 * abs(A).max())
    assert found.B == pytest.approx(B, abs=1e-8 * abs(B).max())
    h, reduced, d = 1e-3, Reduced(system, found), system.joint("d")["angle"]

    def values(x: np.ndarray) -> np.ndarray:
        q, v = reduced.state(x)
        return np.array([v[14], -5 * d.value(q) - 0.2 * d.rate(q, v) ** 3])

    slopes = [(values(found.x0 + h * e) - values(found.x0 - h * e)) / (2 * h) for e in np.eye(2)]
    assert found.C == pytest.approx(np.array(slopes).T, rel=1e-4)
    assert found.y0 == pytest.approx(values(found.x0), rel=1e-12)


def test_a_moving_double_pendulum_in_space() -> None:
    """Crossed axes and a free state: all gyroscopic terms."""
    bodies, joints, last = [], [], sr.ground
    for n, axis in enumerate([(0, 0, 1), (0, 1, 0), (1, 0, 1)]):
        body = sr.Body(
            f"link{n}", mass=1.0 + n, inertia=(0.03, 0.05, 0.04), position=(0.4 * n + 0.2, 0.1 * n, 0)
        )
        joints.append(sr.Revolute(f"j{n}", last, body, point=(0.4 * n, 0.1 * n, 0), axis=axis))
        bodies.append(body)
        last = body
    forces = [sr.Input("u", 0.4), sr.Torque("motor", "j1", value="u - 0.5*v")]
    system = sr.System(sr.Model("arm", bodies, joints, forces, gravity=(0, -G, 1)))
    start = sr.assemble(system, rates={"j0": 2.0, "j1": -1.5, "j2": 0.7})
    found = sr.linearize(system, start)
    A, B = differences(Reduced(system, found), 0.4)
    assert found.A == pytest.approx(A, abs=1e-9 * abs(A).max())
    assert found.B == pytest.approx(B, abs=1e-9 * abs(B).max())
    again = sr.linearize(system, start, coordinates=["j2.angle", "j0.angle", "j1.angle"])
    order = [2, 0, 1, 5, 3, 4]
    assert again.A == pytest.approx(found.A[np.ix_(order, order)], abs=1e-10 * abs(A).max())


def test_of_scipy_and_frequency_responses_of_a_loop() -> None:
    """The response of the closed loop is that of its transfer function, with resonances where modes are."""
    system = four_bar()
    rest = sr.equilibrium(system)
    found = sr.linearize(system, rest, outputs=["d.angle", "rocker.x"])
    scipy, w = found.to_scipy(), np.array([0.3, 2.0, 11.0])
    response = found.frequency_response(w / (2 * np.pi))
    for row, name in enumerate(found.outputs):
        numerator, denominator = signal.ss2tf(scipy.A, scipy.B, scipy.C, scipy.D)
        exact = np.polyval(numerator[row], 1j * w) / np.polyval(denominator, 1j * w)
        assert response.of(name, "u") == pytest.approx(exact, rel=1e-9)
    modes = sr.modes(system, rest)
    assert np.sort_complex(found.poles)[-1] == pytest.approx(modes.eigenvalues[0], rel=1e-9)
    usual = found.frequency_response()
    assert usual.frequencies[[0, -1]] == pytest.approx(
        np.array([0.1, 10]) * abs(found.poles[0]) / (2 * np.pi)
    )
    magnitude, phase = usual.plot("d.angle")
    assert magnitude.get_ylabel() == "magnitude [rad/(N m)]"
    assert phase.get_xlabel() == "frequency [Hz]"
    degrees = phase.lines[0].get_ydata()
    assert degrees[0] - degrees[-1] == pytest.approx(180, abs=10)


@pytest.mark.parametrize("second", [0.3, 2.0, 2.7])
@pytest.mark.parametrize("k", [0.0, 3.3, 77.0, 1234.5])
@pytest.mark.parametrize("law", ["", "50*x"])
def test_poles_are_numbered_as_modes(second: float, k: float, law: str) -> None:
    """Two carts with a spring move freely: a double zero, which eigenvalue solvers find as ±1e-8 or ±1e-8 i.

    A force that pushes the first one away makes a pole unstable.
    """
    carts = [
        sr.Body(name, mass=mass, inertia=(1, 1, 1), position=(x, 0, 0))
        for name, mass, x in (("a", 1.0, 0.0), ("b", second, 1.0))
    ]
    slides = [
        sr.Translational(f"{one.name}x", sr.ground, one, point=one.position, axis=(1, 0, 0)) for one in carts
    ]
    spring = sr.TSDA("spring", carts[0].point(0, 0, 0), carts[1].point(0, 0, 0), k=k, c=0.3, length=1.0)
    away = [sr.Force("away", "ax", value=law)] if law else []
    system = sr.System(sr.Model("carts", carts, slides, [spring, *away]))
    plant, values = (
        sr.linearize(system, system.q0, system.v0),
        sr.modes(system, system.q0, system.v0).eigenvalues,
    )
    found = [plant.pole(number) for number in range(1, len(values) + 1)]
    assert [one.value for one in found] == pytest.approx(values.tolist(), rel=1e-6)
    with pytest.raises(sr.SarrusError, match=f"Choose a number from 1 to {len(values)}"):
        plant.pole(len(values) + 1)
    for one in found:
        assert one.left @ plant.A == pytest.approx(one.value * one.left, abs=1e-5)
        assert plant.A @ one.right == pytest.approx(one.value * one.right, abs=1e-5)
    if k and not law:
        damping = 0.15 * (1 + 1 / second)
        exact = -damping + 1j * np.sqrt(k * (1 + 1 / second) - damping**2)
        assert [one.value for one in found] == [0.0, pytest.approx(exact, rel=1e-9)]
        assert plant._usual()[[0, -1]] == pytest.approx(np.array([0.1, 10]) * abs(exact) / (2 * np.pi))


@pytest.mark.filterwarnings("error")
def test_entries_that_are_tiny_but_not_zero() -> None:
    """An equilibrium leaves 1e-81 in A beside entries of 16."""
    plant = sr.linearize(cart_pole(), cart_pole().q0, np.zeros(14))
    A = plant.A.copy()
    A[2:, 0] = 4.6e-81, -6.8e-80
    found = replace(plant, A=A)
    assert [found.pole(n).value for n in (1, 2)] == pytest.approx([0.0, np.sqrt(A[3, 1])], rel=1e-9)


def test_stiffness_that_cancels_is_a_free_motion() -> None:
    """What round-off leaves of 1e4 N/m is compared with the terms, not with their sum."""
    cart = sr.Body("cart", mass=3.0, inertia=(1, 1, 1))
    slide = sr.Translational("slide", sr.ground, cart, point=(0, 0, 0), axis=(1, 0, 0))
    forces = [sr.Force(f"f{n}", "slide", value=f"{c}*x") for n, c in enumerate((-10000.1, 0.3, 9999.8))]
    system = sr.System(sr.Model("cart", [cart], [slide], forces))
    plant = sr.linearize(system, system.q0, system.v0)
    assert 0 < abs(plant.A[1, 0]) < 1e-11
    assert plant.pole(1).value == 0.0
    assert list(sr.modes(system, system.q0, system.v0).eigenvalues) == [0.0]


def test_coordinates_that_are_chosen() -> None:
    """Of joints as far as they are independent, then of the first body of those that no joint ties to the ground."""
    assert sr.linearize(four_bar(), sr.equilibrium(four_bar())).states[0] in {
        f"{one}.angle" for one in "abcd"
    }
    wheel = sr.Body("wheel", mass=1.0, inertia=(0.1, 0.2, 0.3))
    arm = sr.Body("arm", mass=1.0, inertia=(0.1, 0.2, 0.3))
    pin = sr.Revolute("pin", wheel, arm, point=(0, 0, 0), axis=(0, 0, 1))
    system = sr.System(sr.Model("free", [wheel, arm], [pin]))
    found = sr.linearize(system, system.q0, np.zeros(14))
    assert found.states[:7] == ("pin.angle", *(f"wheel.{x}" for x in ("x", "y", "z", "e1", "e2", "e3")))
    assert abs(found.A[7:]).max() < 1e-12


@pytest.mark.needs("control")
def test_of_python_control() -> None:
    control = pytest.importorskip("control")
    found = sr.linearize(cart_pole(), cart_pole().q0, np.zeros(14))
    same = found.to_control()
    assert isinstance(same, control.StateSpace)
    assert np.array_equal(same.A, found.A)
    assert same.input_labels == ["u"]
    assert same.state_labels[1] == "pin_angle"


def test_wrong_names_are_refused() -> None:
    system = cart_pole()
    at = system.q0, np.zeros(14)
    for names, message in (
        (["pin.angle"], "2 degrees of freedom need as many coordinates, got pin.angle"),
        (["slide.displacement", "cart.x"], "cart.x is not independent of the coordinates before it"),
    ):
        with pytest.raises(sr.SarrusError, match=message):
            sr.linearize(system, *at, coordinates=names)
    with pytest.raises(sr.SarrusError, match='has no input "w"'):
        sr.linearize(system, *at, inputs=["w"])
    with pytest.raises(sr.SarrusError, match=r'inputs contains "u" more than once\. Name each'):
        sr.linearize(system, *at, inputs=["u", "u"])
    with pytest.raises(sr.SarrusError, match="motion since the start"):
        sr.linearize(system, *at, outputs=["energy.supplied"])
    with pytest.raises(sr.SarrusError, match="reactions as outputs are not supported"):
        sr.linearize(four_bar(), sr.equilibrium(four_bar()), outputs=["b.force.x"])
    with pytest.raises(sr.SarrusError, match="needs inputs"):
        sr.linearize(system, *at, inputs=[]).frequency_response()
    plant = sr.linearize(system, *at, outputs=["cart.x"])
    with pytest.raises(sr.SarrusError, match="0 Hz is a pole of the linearization"):
        plant[f"magnitude[cart.x, {plant.inputs[0]}, 0]"]


@pytest.mark.parametrize("analysis", [sr.linearize, sr.modes])
def test_states_off_the_constraints_are_refused(analysis: Any) -> None:
    cart = sr.Body("cart", 1.0, (1, 1, 1), position=(0.1, 0, 0))
    rail = sr.Prismatic("rail", sr.ground, cart, point=(0.1, 0, 0), axis=(1, 0, 0))
    system = sr.System(sr.Model("cart", [cart], [rail]))
    q, v = system.q0 + np.array([0, 0, 1e-3, 0, 0, 0, 0]), np.array([0, 0, 1.0, 0, 0, 0, 0])
    for state in ({"q": q}, {"q": system.q0, "v": v}):
        with pytest.raises(
            sr.ModelError, match=r"at t = 0 s the given state violates the constraints rail: .* Pass"
        ):
            analysis(system, **state)
