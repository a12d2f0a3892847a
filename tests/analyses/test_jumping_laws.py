"""Laws of springs and of users' elements that jump with the state: a mass is driven to and fro with constant forces."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.algebra import Array
from sarrus.analyses.dynamics.inputs.force_arguments import that_jump
from sarrus.elements import Element
from sarrus.elements import Force as ElementForce
from sarrus.elements.element import Scalar
from sarrus.functions import absolute, maximum, positive, sign, step
from sarrus.model import Force
from sarrus.model.primitive import Primitive

QUARTER = np.sqrt(2 * 0.1 / 10)  # s, from 1.0 to 0.9 m at 10 m/s²
WITHIN = 1e-6  # m; of errors that were up to 3e-2 m


def block() -> tuple[sr.Body, sr.Translational]:
    body = sr.Body("block", 1.0, (0.01,) * 3, position=(1, 0, 0))
    return body, sr.Translational("guide", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))


def on_a_spring(length: float = 0.5, **laws: Any) -> sr.System:
    body, guide = block()
    spring = sr.TSDA("bang", sr.ground.point(0, 0, 0), body.point(0, 0, 0), length=length, **laws)
    return sr.System(sr.Model("bang-bang", [body], [guide], [spring]))


def constant_forces() -> sr.System:
    """10 N towards 0.9 m: a stiffness of 10 / (x - 0.5) N/m, with its sign."""
    return on_a_spring(k=lambda x: 10 * sign(x - 0.9) / (x - 0.5))


def exact(t: Array) -> Array:
    p = t / QUARTER % 4
    turned = np.where(p < 2, p, 4 - p)
    return np.where(turned < 1, 0.9 + 0.1 * (1 - turned**2), 0.9 - 0.1 * (1 - (2 - turned) ** 2))


def error(system: sr.System, **settings: Any) -> float:
    run = sr.simulate(system, until=10.0, **settings)
    assert not run.warnings
    return float(abs(run["block.x"] - exact(run.t)).max())


@pytest.mark.parametrize(
    "settings", [{}, {"method": sr.Radau(rtol=1e-6, atol=1e-6)}, {"method": sr.HHT()}, {"store": "steps"}]
)
def test_steps_end_at_jumps(settings: Mapping[str, Any]) -> None:
    """18 jumps; where steps passed over them, positions were off by 5e-5, 7e-3 and 3e-2 m in silence."""
    assert error(constant_forces(), **settings) < WITHIN


def test_steps_of_a_given_length_pass_over_jumps_with_a_warning() -> None:
    with pytest.warns(
        sr.SarrusWarning, match=r'a law of "bang" jumps, .* Take a method without a given step'
    ):
        run = sr.simulate(constant_forces(), until=1.0, method=sr.HHT(step=0.01))
    assert abs(run["block.x"] - exact(run.t)).max() > 1e-3


@pytest.mark.parametrize("stored", [False, True])
def test_sliding_along_a_jump_ends_the_run(stored: bool) -> None:
    """Damping brings the mass to rest at the jump, whose force pushes it back from both sides."""
    system = on_a_spring(k=lambda x: 10 * sign(x - 0.9) / (x - 0.5), c=5.0)
    run = sr.simulate(system, until=4.0, method=sr.HHT(), store="steps" if stored else "samples")
    assert run.status == "switches crowd"
    assert re.match(r"bang: switches crowd at t = [23]\.\d* s, .* within a width, such as tanh", run.message)
    assert abs(run["block.x"][-1] - 0.9) < 1e-3


@pytest.mark.parametrize("direction", [-1, 0, 1])
@pytest.mark.parametrize("stored", [False, True])
def test_events_at_jumps(direction: int, stored: bool) -> None:
    """A reset that changes nothing: velocities within the gap of 1e-15 s at a jump were off by 4e-4 in silence."""
    event = sr.Event("block.x - 0.9", direction=direction, reset=lambda t, q, v: v, name="at the jump")
    assert error(constant_forces(), events=event, store="steps" if stored else "samples") < WITHIN


@pytest.fixture
def _no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Element, "registry", dict(Element.registry))
    monkeypatch.setattr(Force, "kinds", dict(Force.kinds))


@pytest.mark.usefixtures("_no_trace")
def test_an_element_of_ones_own() -> None:
    class Switched(ElementForce, bodies=1, derivatives="automatic"):
        middle: Scalar
        size: Scalar

        def Q(self, x, v, t):  # type: ignore[no-untyped-def]
            return np.array([self.size * (1 - 2 * positive(x.r[0] - self.middle)), 0, 0]), None

    @dataclass(frozen=True, eq=False)
    class Bang(Force):
        def primitives(self, poses: Any) -> Any:
            yield Primitive(Switched, ("block",), (0.9, 10.0), "switch")

    body, guide = block()
    system = sr.System(sr.Model("bang-bang", [body], [guide], [Bang("bang")]))
    assert that_jump(system) == ("bang",)
    assert error(system) < WITHIN


@pytest.mark.parametrize(
    ("law", "jumps"),
    [
        (lambda x: 1.5 + 0.5 * sign(x - 1.2), True),
        (lambda x: step(x - 1.1), True),
        (lambda x: maximum(0, x - 1) ** 1.5, False),
        (lambda x: absolute(x - 1.2), False),
        (lambda x: step(x, 1.0, 0.0, 1.2, 5.0), False),
    ],
)
def test_which_laws_jump(law: Callable[[Any], Any], jumps: bool) -> None:
    for laws in ({"k": law}, {"k": 1.0, "c": law}):
        assert that_jump(on_a_spring(**laws)) == (("bang",) if jumps else ())
