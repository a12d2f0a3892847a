"""A user's element over three bodies: from its potential, in runs, both sweeps, Hessians and saved runs."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.registries import kinds_of_forces_here

import sarrus as sr
from sarrus import elements
from sarrus.elements.element import Scalar
from sarrus.model.primitive import Primitive


class Bending(elements.Force, bodies=3, derivatives="automatic", registered=False):
    """V = k/2 |r₁ - 2 r₂ + r₃|²."""

    k: Scalar

    def potential(self, x: Any) -> Any:
        r_1, _, r_2, _, r_3, _ = x
        bent = r_1 - 2 * r_2 + r_3
        return self.k * (bent @ bent) / 2


@dataclass(frozen=True, eq=False)
class Line(sr.Force):
    """Keeps three bodies in a line."""

    bodies: tuple[sr.Body, ...]
    k: float = 3.0

    def primitives(self, poses: Any) -> Iterator[Primitive]:
        yield Primitive(Bending, tuple(body.name for body in self.bodies), (self.k,), "bending")


_kinds = kinds_of_forces_here("line")


K, MASS, BENT, END = 3.0, 2.0, 0.3, 0.9


def beam() -> sr.System:
    """Free bodies, the first of which is beside the line."""
    places = (0.0, 0.0, BENT), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)
    bodies = [sr.Body(f"b{n}", mass=MASS, inertia=(1, 1, 1), position=r) for n, r in enumerate(places, 1)]
    return sr.System(sr.Model("beam", bodies, [], [Line("beam", tuple(bodies), K)]))


def test_in_all_analyses(tmp_path: Path) -> None:
    """The bend s'' = -6 k/m s, and z₁ = s₀ + (s - s₀)/6, with its derivatives by k."""
    system, omega = beam(), np.sqrt(6 * K / MASS)
    assert system.check_derivatives()
    run = sr.simulate(system, until=END, method=sr.Radau(rtol=1e-11), store="steps")
    assert run["b1"].position[-1, 2] == pytest.approx(BENT + BENT * (np.cos(omega * END) - 1) / 6, abs=1e-9)
    response, angle = sr.Final("b1.z"), omega * END
    slope = -BENT / 6 * np.sin(angle) * angle / (2 * K)
    for way in ("adjoint", "direct"):
        assert sr.sensitivity(run, response, wrt=["beam.k"], method=way).matrix == pytest.approx(
            slope, rel=1e-7
        )
    curvature = -BENT / 6 * (np.cos(angle) * angle**2 - np.sin(angle) * angle) / (4 * K**2)
    assert np.squeeze(sr.hessian(run, response, wrt=["beam.k"]).matrix) == pytest.approx(curvature, rel=1e-6)
    run.save(tmp_path / "run.sarrus")
    again = sr.load_run(tmp_path / "run.sarrus", system)
    assert np.array_equal(again.q, run.q)
