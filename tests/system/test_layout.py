"""The layout of coordinates, and that no other file knows how many a body has."""

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.states.motors import motor

import sarrus as sr
from sarrus.algebra import Array
from sarrus.elements import OPERATORS, Force
from sarrus.elements.element import POSITION, RIGID, ROTATION, Kind, Scalar, Vec3
from sarrus.model.expansion.blueprint import Placement
from sarrus.system.layout import STATES
from sarrus.system.structure.group import Group
from sarrus.system.structure.pattern import Axes
from sarrus.system.structure.population import populate

SOURCE = Path(sr.__file__).parent
OPERATIONS = (ast.Add, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod)
SIZED = {"reshape", "repeat", "tile", "zeros", "full", "empty", "inputs"}  # functions that take widths

DEFINED = {"model/coordinates.py", "system/layout.py"}  # what a rigid body is
OTHERS = {
    "analyses/equations/paired_matrix.py",
    "analyses/progress.py",
    "cli/progress.py",
    "io/mjcf/bodies.py",
}  # widths of other things
POLYNOMIALS = {
    "_jit/formulas/surfaces.py": 2,
    "analyses/workspace/tracing/point.py": 1,
    "elements/forces/tyres/magic_formula_wheel.py": 1,
    "model/forces/beam.py": 1,
    "model/laws/path.py": 3,
}  # whose sevens have nothing to do with bodies


def is_width(node: ast.AST) -> bool:
    """Whether an expression is the number of a body's coordinates."""
    return getattr(node, "id", "") == "WIDTH" or (
        isinstance(node, ast.Constant) and type(node.value) is int and node.value == 7
    )


def is_pair(node: ast.AST) -> bool:
    """Whether an expression is the pair of widths of r and p."""
    parts = node.elts if isinstance(node, ast.Tuple | ast.List) else []
    return [getattr(part, "value", None) for part in parts] == [3, 4]


def widths(tree: ast.AST) -> Iterator[ast.AST]:
    """Places in which the width of a body is used."""
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp) and isinstance(node.op, OPERATIONS):
            if is_width(node.left) or is_width(node.right):
                yield node
        elif isinstance(node, ast.Call):
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            sizes = [part for one in node.args for part in (one, *getattr(one, "elts", ()))]
            if (
                any(map(is_width, sizes))
                if name in SIZED
                else name == "range" and any(map(is_width, sizes[2:]))
            ):
                yield node
        elif is_pair(node) or (isinstance(node, ast.Slice) and node.upper and is_width(node.upper)):
            yield node


def found() -> Counter[str]:
    """How often each file computes with the width of a body."""
    counts = {
        path.relative_to(SOURCE).as_posix(): len([*widths(ast.parse(path.read_text(encoding="utf-8")))])
        for path in SOURCE.rglob("*.py")
    }
    return Counter({name: count for name, count in counts.items() if count and name not in DEFINED | OTHERS})


def test_the_layout_alone_knows_the_width_of_a_body() -> None:
    assert found() == Counter(POLYNOMIALS)


@pytest.mark.parametrize(
    "text",
    [
        "7 * n",
        "k // 7",
        "k % 7 < 3",
        "x.reshape(-1, 7)",
        "[3, 4] * n",
        "q[3:7]",
        "np.zeros((n, 7))",
        "n * WIDTH",
        "q[i + 3 : i + 7]",
        "range(first + 3, first + WIDTH)",
    ],
)
def test_what_is_a_width(text: str) -> None:
    assert [*widths(ast.parse(text))]


def test_what_is_none() -> None:
    assert not [*widths(ast.parse("x - 7; f(7); (3, 4, 5); 0.7 * y; seed(seed=7); x.reshape(-1, 3)"))]


def test_blocks_of_bodies_and_states() -> None:
    """The blocks cover all coordinates in their order, and their owners are those of the names."""
    system = sr.System(motor())
    layout = system.layout
    assert [(b.kind, b.owner, b.start) for b in layout.blocks] == [
        (POSITION, "arm", 0), (ROTATION, "arm", 3), (STATES, "states 1", 7), (ROTATION, "states 1", 10),
    ]  # fmt: skip
    assert [*layout.owners] == ["arm", "states 1"]
    assert layout.size == system.nq
    names = np.array(system.coordinate_names)
    for index, part in ((layout.positions, ".r."), (layout.rotations, ".p.")):
        assert all(part in name for name in names[index].ravel())
    owner = [layout.owners[n] for n in layout.owner_of]
    assert owner == [name.split(".")[0] for name in names]
    assert all((".r." in name) == is_length for name, is_length in zip(names, layout.is_length, strict=True))
    assert layout.bodies.size == system.moving == len(layout.owner_of) // 2


def test_units_of_all_coordinates() -> None:
    layout = sr.System(motor()).layout
    assert [*layout.scales(2.5)] == [b.kind.scale(2.5) for b in layout.blocks for _ in range(b.width)]
    norms = np.linalg.norm(sr.System(motor()).q0[layout.rotations], axis=1)
    assert norms == pytest.approx(1.0)


MODES = Kind("modes", tuple(f"q{n}" for n in range(5)), False)


def potential(q: Any, k: float, s: Any) -> Any:
    """k/2 (r_z + s · e)² (w · w)² + w_0 w_4 r_x, with the amplitudes w of five modes behind r and p."""
    r, e, w = q[:3], q[4:7], q[7:]
    return 0.5 * k * (r[2] + s @ e) ** 2 * (w @ w) ** 2 + w[0] * w[4] * r[0]


class Stiffening(Force, bodies=2, derivatives="automatic", registered=False):
    """The force of this potential, between a body and modes."""

    s: Vec3
    k: Scalar

    @classmethod
    def owners(cls) -> tuple[tuple[Kind, ...], ...]:
        return RIGID, (MODES,)

    def Q(self, x: Any, v: Any, t: Any) -> Any:
        r, p, w = x
        stretch, square = r[2] + self.s @ p[1:], w @ w
        force = -self.k * stretch * square**2
        by_r = np.array([-w[0] * w[4], 0, force])
        by_p = np.concatenate([[0], force * self.s])
        ends = np.array([w[4] * r[0], 0, 0, 0, w[0] * r[0]])
        return by_r, by_p, -2 * self.k * stretch**2 * square * w - ends


def test_an_element_touches_blocks_of_other_widths() -> None:
    """Q and Q_q between bodies and modes, against complex steps of the potential and of Q."""
    random, widths = np.random.default_rng(3), np.array([3, 4, 5, 3, 4, 5])
    values = [(random.normal(size=3), 1.7), (random.normal(size=3), 0.6)]
    placed = [
        Placement(Stiffening, bodies, own, "stiff", "")
        for bodies, own in zip([(1, 2), (3, 4)], values, strict=True)
    ]
    populations, numbers = populate(placed, np.array([0, 7, 12, 19]))
    axes = Axes(populations, widths, 0, len(numbers))
    q, v = random.normal(size=(2, widths.sum()))

    def called(name: str) -> tuple[Any, Array]:
        pattern = axes.pattern(OPERATORS[name])
        group, found = Group((name,), populations, [pattern]), np.zeros(pattern.size)
        operands = {"q": q, "v": v, "t": 0.0}
        group.run(numbers, *(operands[one] for one in group.operands), found)
        return pattern, found

    def force(q: Any) -> Any:
        steps = 1e-30j * np.eye(12)
        each = [[-potential(part + h, k, s).imag * 1e30 for h in steps] for part, (s, k) in parts(q)]
        return np.concatenate(each)

    def parts(q: Any) -> Iterator[Any]:
        return zip(np.split(q, 2), [(s, k) for s, k in values], strict=True)

    assert called("Q")[1] == pytest.approx(force(q), rel=1e-13, abs=1e-13)
    pattern, found = called("Q_q")
    dense = pattern.matrix(found).toarray()
    h = 1e-5
    differences = [(force(q + h * e) - force(q - h * e)) / (2 * h) for e in np.eye(24)]
    assert dense == pytest.approx(np.array(differences).T, rel=1e-7, abs=1e-7)
    assert dense == pytest.approx(dense.T, rel=1e-13)


if __name__ == "__main__":
    for name, count in sorted((found() - Counter(POLYNOMIALS)).items()):
        print(f'    "{name}": {count},')
