"""Records of every built-in element for sweeps, evaluated without compilation, against complex steps."""

from typing import Any

import numpy as np
import pytest
from tests.elements.states import COMPLEX, fields, fixed, state

from sarrus._jit.formulas.expression import Expression
from sarrus._jit.formulas.replay import replay
from sarrus._jit.kernels.emit import NUMBERS_DOT, Recording
from sarrus.analyses.sensitivity.lagrangians.by_parameters import _change, _gradient
from sarrus.analyses.sensitivity.lagrangians.changes import DOTS, _record
from sarrus.analyses.sensitivity.lagrangians.elements import STATES, Share
from sarrus.elements import BUILT_IN, Element
from sarrus.elements.evaluation import STORED
from sarrus.elements.recorder import Variant

STEP = 1e-200
KINDS = sorted(BUILT_IN, key=lambda kind: kind.__name__)
every = pytest.mark.parametrize("kind", KINDS, ids=[kind.__name__ for kind in KINDS])


class Inputs:
    """A random state of an element between moving bodies, with adjoint variables and two directions."""

    def __init__(self, kind: type[Element]) -> None:
        self.state, random = state(kind, COMPLEX), np.random.default_rng(3)
        sizes = {
            **dict.fromkeys((*STATES, "xi"), (kind.bodies, 7)),
            **dict.fromkeys(("lam", "nu"), kind.rows),
        }
        self.values = {name: random.normal(size=size) for name, size in sizes.items()}
        for name in ("q", "v"):
            self.values[name] = self.state.operands[name].reshape(-1, 7)
        self.directions = [
            {name: random.normal(size=x.shape) for name, x in self.values.items()} for _ in range(2)
        ]
        for one in self.directions:
            one["numbers"] = random.normal(size=kind.size())
            one["numbers"][fixed(kind)] = 0

    def moved(self, direction: dict[str, Any], step: complex = 0) -> dict[tuple[Any, ...], Any]:
        """Inputs of a record, moved in a direction."""
        found: dict[tuple[Any, ...], Any] = {("t",): self.state.operands["t"]}
        for name, x in {**self.values, "numbers": self.state.numbers}.items():
            for place in np.ndindex(*x.shape):
                found[name, *place] = (
                    x[place] + step * direction[name][place] if name in direction else x[place]
                )
        for n, field in enumerate(fields(self.state.kind)):
            if field in STORED:
                found["numbers", n] = STORED[field](self.state.store, self.state.numbers[n])
        return found


def outputs(record: Recording, inputs: dict[tuple[Any, ...], Any], kind: type = float) -> list[np.ndarray]:
    """Values of a record, an array for each output."""
    found = []
    for out in record.outputs:
        flat = [x for block in out.blocks for x in np.ravel(block)]
        values = iter(replay(record.graph, [x for x in flat if isinstance(x, Expression)], inputs))
        found.append(np.array([next(values) if isinstance(x, Expression) else x for x in flat], dtype=kind))
    return found


def slope(share: Share, inputs: Inputs, direction: dict[str, Any]) -> float:
    """The derivative of ℓ in a direction."""
    (value,) = replay(share.graph, [share.value], inputs.moved(direction, 1j * STEP))
    return float(complex(value).imag / STEP)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("operation", ["step", "motion"])
@every
def test_derivatives_by_parameters_forward_and_backward(kind: type[Element], operation: str) -> None:
    variant, inputs = Variant(kind, tuple(range(kind.bodies))), Inputs(kind)
    numbers = inputs.directions[0]["numbers"]
    (by_numbers,) = outputs(_gradient(variant, operation), inputs.moved({}))
    dots = {(NUMBERS_DOT, n): x for n, x in enumerate(numbers)}
    along, rows = outputs(_change(variant, operation), inputs.moved({}) | dots)
    wanted = slope(Share(variant, operation), inputs, {"numbers": numbers})
    scale = 1e-11 * (abs(by_numbers) @ abs(numbers) + abs(along) @ abs(inputs.values["xi"].ravel()))
    assert abs(by_numbers @ numbers - wanted) <= scale
    assert abs(along @ inputs.values["xi"].ravel() + rows @ inputs.values["nu"] - wanted) <= scale


@pytest.mark.one_in(4)
@every
def test_second_derivatives(kind: type[Element]) -> None:
    """The change of the gradient is symmetric in two directions; by parameters, it is that of a complex step."""
    variant, inputs = Variant(kind, tuple(range(kind.bodies))), Inputs(kind)
    record = _record(variant, "step")

    def change(along: dict[str, Any]) -> dict[str, np.ndarray]:
        names = dict(zip((*STATES, "lam", "numbers"), (*DOTS, "lam_dot", NUMBERS_DOT), strict=True))
        dots = {(dot, *at): along[x][at] for x, dot in names.items() for at in np.ndindex(*along[x].shape)}
        return dict(zip(names, outputs(record, inputs.moved({}) | dots), strict=True))

    one, two = ({name: d[name] for name in (*STATES, "lam", "numbers")} for d in inputs.directions)
    first, second = change(one), change(two)
    terms = [(first[name] * two[name].ravel(), second[name] * one[name].ravel()) for name in one]
    size = sum(abs(x).sum() for pair in terms for x in pair)
    assert abs(sum(x.sum() - y.sum() for x, y in terms)) <= 1e-11 * size
    (moved,) = outputs(_gradient(variant, "step"), inputs.moved(one, 1j * STEP), complex)
    np.testing.assert_allclose(
        first["numbers"], moved.imag / STEP, rtol=1e-9, atol=1e-11 * (1 + abs(moved).max(initial=0))
    )
