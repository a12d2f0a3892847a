"""Derivatives by initial rates of joints, which are parameters as other numbers of a model are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

CRANK, ROD, W0 = 0.3, 0.8, 2.0
FILE = f"""name: crank
parameters: {{w0: {W0}, radius: {CRANK}}}
bodies:
  crank: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
  rod: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [radius, 0, 0]}}
  slider: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: ["radius + {ROD}", 0, 0]}}
joints:
  pin: {{type: revolute, bodies: [ground, crank], point: [0, 0, 0], axis: [0, 0, 1]}}
  knee: {{type: revolute, bodies: [crank, rod], point: [radius, 0, 0], axis: [0, 0, 1]}}
  wrist: {{type: spherical, bodies: [rod, slider], point: ["radius + {ROD}", 0, 0]}}
  rail: {{type: translational, bodies: [ground, slider], point: [0, 0, 0], axis: [1, 0, 0]}}
rates: {{pin: 2*w0}}
"""


def spun(w0: float) -> sr.Trajectory:
    """A rotor with drag: ω' = -ω²/J, ω = w0/(1 + w0 t/J), φ = J ln(1 + w0 t/J), until the angle of 1 rad."""
    rotor = sr.Body("rotor", 1.0, (0.5, 0.5, 0.5))
    pin = sr.Revolute("pin", sr.ground, rotor, point=(0, 0, 0), axis=(0, 0, 1))
    drag = sr.Torque("drag", "pin", value="-pin.rate*abs(pin.rate)")
    system = sr.System(sr.Model("rotor", [rotor], [pin], [drag], rates={"pin": w0}))
    return sr.simulate(system, until=0.4, method=sr.Radau(rtol=1e-10), store="steps")


def test_gradients_and_hessians_by_a_rate_are_those_of_the_closed_form() -> None:
    w0, J, t = 1.7, 0.5, 0.4
    run = spun(w0)
    assert run["pin.angle"][-1] == pytest.approx(J * np.log(1 + w0 * t / J), rel=1e-9)
    slope = t / (1 + w0 * t / J)
    for method in ("adjoint", "direct"):
        gradient = sr.sensitivity(run, "pin.angle", ["rates.pin"], method=method)
        assert gradient.matrix[0, 0] == pytest.approx(slope, rel=1e-8)
        assert gradient.units == ("rad/s",)
    hessian = sr.hessian(run, "pin.angle", ["rates.pin"])
    assert hessian.matrix[0, 0] == pytest.approx(-(slope**2) / J, rel=1e-7)


def angle(w0: complex, radius: complex, t: float = 0.1, steps: int = 4000) -> complex:
    """The slider's place by an independent route: Lagrange's equation of the crank's angle, by complex arithmetic."""
    m, J = 1.0, 0.1

    def sides(phi: complex) -> tuple[complex, ...]:
        s, c = np.sin(phi), np.cos(phi)
        sin_psi = -radius * s / ROD  # of the rod's angle ψ
        cos_psi = np.sqrt(1 - sin_psi**2)
        p1 = -radius * c / (ROD * cos_psi)  # ψ' by φ
        p2 = (radius * s / ROD + sin_psi * p1**2) / cos_psi
        x1 = -radius * s - ROD * sin_psi * p1
        x2 = -radius * c - ROD * (cos_psi * p1**2 + sin_psi * p2)
        x = radius * c + ROD * cos_psi
        inertia = J + m * radius**2 + J * p1**2 + m * x1**2
        return inertia, 2 * (J * p1 * p2 + m * x1 * x2), x

    def f(y: np.ndarray) -> np.ndarray:
        inertia, slope, _ = sides(y[0])
        return np.array([y[1], -0.5 * slope * y[1] ** 2 / inertia])

    y, h = np.array([0.0 + 0j, 2 * w0]), t / steps
    for _ in range(steps):
        k1 = f(y)
        k2 = f(y + h / 2 * k1)
        k3 = f(y + h / 2 * k2)
        y = y + h * f(y + h * k3) / 6 + h * (k1 + 2 * k2 + 2 * k3) / 6
    return sides(y[0])[2]


GIVEN = ("rates: {pin: 2*w0}", "angular_velocity: [0, 0, 2*w0]", "velocity: [0, 2*w0*radius, 0]")


@pytest.mark.parametrize("given", GIVEN)
def test_what_a_file_gives_has_derivatives_in_linkages(tmp_path: Path, given: str) -> None:
    """First derivatives by complex step, second ones by central differences of these."""
    file = tmp_path / "crank.yaml"
    body = "[radius, 0, 0]" if given == GIVEN[2] else "[0, 0, 0]"  # the rod's origin is on the knee
    text = FILE.replace(GIVEN[0], "").replace(f"position: {body}", f"position: {body}, {given}")
    text = FILE if given == GIVEN[0] else text
    file.write_text(text)
    run = sr.simulate(sr.System(sr.load(file)), until=0.1, method=sr.Radau(rtol=1e-10), store="steps")

    def slopes(w0: float, radius: float) -> list[float]:
        return [
            (angle(w0 + dw, radius + dr, steps=400) / 1e-30).imag for dw, dr in ((1e-30j, 0), (0, 1e-30j))
        ]

    wrt = ["w0", "radius"]
    gradient = sr.sensitivity(run, "slider.x", wrt)
    assert gradient.matrix[0] == pytest.approx(slopes(W0, CRANK), rel=1e-7)
    h = 1e-5
    expected = [
        (np.array(slopes(W0 + dw, CRANK + dr)) - slopes(W0 - dw, CRANK - dr)) / (2 * h)
        for dw, dr in ((h, 0.0), (0.0, h))
    ]
    assert sr.hessian(run, "slider.x", wrt).matrix == pytest.approx(np.array(expected), rel=1e-5, abs=1e-7)
