"""Whole laws are twice continuously differentiable: exact derivatives on both sides of a place."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.tyres.test_laws import CAR, LAWS
from tests.tyres.test_magic_formula_options import CAMBER, SPINS

from sarrus._jit.formulas.differentiate import jacobian
from sarrus._jit.formulas.expression import Graph
from sarrus._jit.formulas.replay import replay
from sarrus.elements.forces.tyres import LargeAngles61, MagicFormula52, Slip, TurnSlip, TyreLaw, rounding

AT = Slip(0.03, 0.05, 0.02, 3700.0, 12.0, 0.9, 0.05, 3.0)
BESIDE = 1e-10
WIDTH = 1e-3
ELLIPSE = {name: value for name, value in CAR.items() if not name.startswith("RC")}
EVERY: dict[str, TyreLaw] = LAWS | {
    "turn slip": TurnSlip(CAR | SPINS),
    "large angles": LargeAngles61(CAR),
    "ellipse": MagicFormula52(ELLIPSE),
}


def derivatives(law: TyreLaw, path: Any, place: float) -> np.ndarray:
    """Forces and moments along a path of slips, with first and second derivatives (3, 5)."""
    graph = Graph()
    x = graph.input("x")
    values = graph.expressions(law.wrench(path(law, x)))
    first = [row[0] for row in jacobian(graph, values, [x])]
    second = [row[0] for row in jacobian(graph, graph.expressions(first), [x])]
    return np.array(replay(graph, [*values, *first, *second], {("x",): place}), dtype=float).reshape(3, 5)


def jump(law: TyreLaw, path: Any, place: float, apart: float = 1.0, order: int = 2) -> float:
    """The largest difference of the derivatives on both sides over their size near the place."""
    left, right = (derivatives(law, path, place + side * BESIDE * apart) for side in (-1, 1))
    wide = [derivatives(law, path, place + side * apart / 10) for side in (-1, 1)]
    size = np.max([abs(part).max(axis=1) for part in (left, right, *wide)], axis=0)
    floor = np.array([1e-6, *size[:2] / apart]) * 1e-6 + 1e-9
    return float((abs(left - right) / np.maximum(size, floor)[:, None])[: order + 1].max())


def slip(field: str, sign: float = 1.0) -> Any:
    return lambda law, x: AT._replace(**{field: sign * x})


def pure(field: str) -> Any:
    """A slip with the other one zero."""
    return lambda law, x: AT._replace(kappa=0, tan_alpha=0)._replace(**{field: x})


def lifting(law: Any, x: Any) -> Slip:
    """A compression that falls to zero."""
    return AT._replace(load=law.vertical_force(x, 0.1, 0.0, WIDTH))


def limits(field: str) -> Any:
    return lambda law, x: law.in_range(AT._replace(**{field: x}))


PLACES: dict[str, tuple[Any, float, float]] = {
    "no slip angle": (pure("tan_alpha"), 0.0, 1.0),
    "no longitudinal slip": (pure("kappa"), 0.0, 1.0),
    "no slip angle in combined slip": (slip("tan_alpha"), 0.0, 1.0),
    "no longitudinal slip in combined slip": (slip("kappa"), 0.0, 1.0),
    "no inclination": (slip("gamma"), 0.0, 1.0),
    "no yaw rate": (slip("turn"), 0.0, 1.0),
    "standstill": (slip("direction"), 0.0, 1.0),
    "lift-off": (lifting, -WIDTH / 2, WIDTH),
    "landing": (lifting, 0.0, WIDTH),
    "contact": (lifting, WIDTH / 2, WIDTH),
}


# Where laws are once continuously differentiable: the brush has the forces x - x|x|/l without slip
ONCE = {("brush", "no slip angle"), ("brush", "no longitudinal slip")}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("name", EVERY)
def test_second_derivatives_are_continuous(name: str, place: str) -> None:
    path, where, apart = PLACES[place]
    order = 1 if (name, place) in ONCE or place == "contact" else 2
    assert jump(EVERY[name], path, where, apart, order) < 0.02


SHIFTED = ("magic formula 6.1", "large angles", "turn slip")


@pytest.mark.parametrize("name", SHIFTED)
def test_signs_of_shifted_slips_are_rounded(name: str) -> None:
    """E has the sign of κ + S_Hx and of α + S_Hy, which change beside zero slip."""
    law: Any = EVERY[name]
    for field, of in (("kappa", law.longitudinal), ("tan_alpha", lambda at: law.lateral(at, 0.0))):
        shift = of(AT._replace(gamma=0.0, roll=0.0, turn=0.0)).S_H
        path = lambda law, x, field=field: AT._replace(gamma=0.0, roll=0.0, turn=0.0)._replace(**{field: x})  # noqa: E731
        assert jump(law, path, float(np.tan(-shift))) < 0.02


@pytest.mark.parametrize("name", ["magic formula 6.1", "magic formula 5.2"])
@pytest.mark.parametrize("field", ["kappa", "tan_alpha", "gamma", "load"])
def test_limits_of_files_are_smooth(name: str, field: str) -> None:
    law: Any = EVERY[name]
    low, high, _ = law.ranges()["alpha" if field == "tan_alpha" else field]
    for place in (high, high + (high - low) / 10):
        where = float(np.tan(place)) if field == "tan_alpha" else place
        if where > 0:
            assert jump(law, limits(field), where, high - low) < 0.02


def test_the_compression_of_an_inclined_tread_is_smooth() -> None:
    law = EVERY["magic formula 6.1"].__class__(CAR | CAMBER)

    def along(law: Any, x: Any) -> Slip:
        return AT._replace(load=law.vertical_force(law.depth(0.31, 0.0, x), 0.0, 0.0, WIDTH), gamma=x)

    assert jump(law, along, 0.0) < 0.02


def test_the_measure_finds_a_kink(monkeypatch: pytest.MonkeyPatch) -> None:
    """With |γ| in place of its rounding, the measure is large."""
    from sarrus._jit.formulas.functions import absolute
    from sarrus.elements.forces.tyres import magic_formula

    monkeypatch.setattr(magic_formula, "rounded_absolute", lambda x, width: absolute(x))
    assert jump(EVERY["magic formula 6.1"], slip("gamma"), 0.0) > 0.1
    assert rounding.rounded_absolute(0.5, 0.01) == 0.5
