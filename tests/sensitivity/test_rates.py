"""Derivatives through given rates of joints: axes that move take their rates with them, to second order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.model.written import with_numbers, written_numbers

TIGHT: dict[str, Any] = {"method": sr.Radau(rtol=1e-9, atol=1e-11)}


def gimbal() -> sr.System:
    """A body on a universal joint at the ground, both of whose angles turn."""
    rod = sr.Body("rod", 2.0, (0.3, 0.2, 0.1), position=(0.1, 0.2, -0.4))
    hook = sr.Universal("hook", sr.ground, rod, point=(0, 0, 0), axis_i=(1, 0, 0), axis_j=(0, 1, 0))
    return sr.System(sr.Model("gimbal", [rod], [hook], gravity=(0, 0, -9.81)))


# The system, the given rates, an output, and what changes; the axes of a universal joint stay perpendicular
CASES: dict[str, tuple[Callable[[], sr.System], dict[str, float], str, list[str]]] = {
    "first axis": (
        gimbal, {"hook.angle_i": 1.0, "hook.angle_j": 2.0}, "rod.x", ["hook.axis_i.z", "hook.point.x", "rod.mass"]
    ),
    "second axis": (
        gimbal, {"hook.angle_i": 1.0, "hook.angle_j": 2.0}, "rod.z", ["hook.axis_j.z", "rod.position.x"]
    ),
    "one rate": (gimbal, {"hook.angle_j": 2.0}, "rod.y", ["hook.axis_i.z", "hook.point.z"]),
    "coordinate": (gimbal, {"rod.y": 0.5}, "rod.x", ["hook.axis_i.z", "hook.point.x"]),
    "crank": (
        slider_crank, {"pin": 1.5}, "slider.x",
        ["pin.axis.y", "pin.point.z", "ball.point.x", "rod.mass", "spring.k"],
    ),
}  # fmt: skip


def slope(value: Any, h: float) -> Any:
    """The derivative at 0 by differences of fourth order."""
    return (8 * (value(h) - value(-h)) - (value(2 * h) - value(-2 * h))) / (12 * h)


@pytest.mark.parametrize("case", CASES)
def test_velocities_follow_the_axes(case: str) -> None:
    """Against models with other numbers, assembled with the same rates; forwards and backwards."""
    build, rates, _, names = CASES[case]
    system = build()
    start = sr.assemble(system, rates=rates)
    run = sr.simulate(system, start, until=1e-3, store="steps", **TIGHT)
    found = sr.state_derivatives(run, names).v_b[0]
    body = system.bodies[-1]
    spin = sr.sensitivity(run, sr.At(f"{body}.velocity.x", time=0.0), names).matrix[0]
    assert spin == pytest.approx(found[7 * (len(system.bodies) - 1)], abs=1e-10)
    values = written_numbers(system.model)

    def velocity(name: str, change: float) -> np.ndarray:
        moved = sr.System(with_numbers(system.model, {name: values[name] + change}))
        return np.asarray(sr.assemble(moved, rates=rates).v)

    for n, name in enumerate(names):
        wanted = slope(lambda h, name=name: velocity(name, h), 1e-3)
        assert found[:, n] == pytest.approx(wanted, abs=1e-8), name


@pytest.mark.one_in(4)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("method", ["Radau", "HHT"])
def test_products_are_differences_of_gradients(case: str, method: str) -> None:
    """Each gradient is that of another model, assembled and simulated anew."""
    build, rates, output, names = CASES[case]
    system = build()
    how = TIGHT if method == "Radau" else {"method": sr.HHT(rtol=1e-9, atol=1e-11)}
    problem = sr.Problem(system, sr.Final(output), names, until=0.2, start={"rates": rates}, **how)
    direction = np.random.default_rng(1).normal(size=len(names))
    wanted = slope(lambda h: problem.gradient(problem.x0 + h * direction).matrix[0], 4e-3)
    found = problem.hvp(problem.x0, direction)
    assert found == pytest.approx(wanted, abs=(1e-6 if method == "Radau" else 1e-4) * abs(wanted).max())
