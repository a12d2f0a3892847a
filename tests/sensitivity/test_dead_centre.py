"""Derivatives through an assembly near a dead centre of the held crank: exact as far as they exist, else undefined."""

from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

import sarrus as sr

NAMES = ["L0", "L1", "L2", "L3", "th0"]
LINK = """  {name}: {{mass: 1, inertia: [1, 1, 1], position: {at},
    orientation: {{axis: [0, 0, 1], angle: {angle}}}}}
"""
HINGE = """  {name}:
    type: revolute
    frames: [{{body: {i}, at: [{at_i}, 0, 0], z: [0, 0, 1]}}, {{body: {j}, at: [{at_j}, 0, 0], z: [0, 0, 1]}}]
"""
HINGES = [
    ("A", "ground", "0", "crank", "-L1/2"),
    ("C", "crank", "L1/2", "coupler", "-L2/2"),
    ("D", "coupler", "L2/2", "rocker", "L3/2"),
    ("B", "ground", "L0", "rocker", "-L3/2"),
]


def model(L2: float, coupler: tuple[list[float], float], rocker: tuple[list[float], float]) -> str:
    """The model file; coupler and rocker by position and angle."""
    lines = f"name: four-bar\nparameters: {{L0: 2.5, L1: 1.0, L2: {L2!r}, L3: 1.8, th0: 1.2}}\nbodies:\n"
    lines += LINK.format(name="crank", at="[L1/2*cos(th0), L1/2*sin(th0), 0]", angle="th0")
    for name, (at, angle) in (("coupler", coupler), ("rocker", rocker)):
        lines += LINK.format(name=name, at=at, angle=repr(angle))
    lines += "joints:\n"
    for name, i, at_i, j, at_j in HINGES:
        lines += HINGE.format(name=name, i=i, at_i=at_i, j=j, at_j=at_j)
    return lines


def pin(L0: mp.mpf, L1: mp.mpf, L2: mp.mpf, L3: mp.mpf, th: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """The pin between coupler and rocker: where two circles meet."""
    x, y = L1 * mp.cos(th), L1 * mp.sin(th)
    dx, dy = L0 - x, -y
    a = (L2**2 - L3**2 + dx**2 + dy**2) / (2 * (dx**2 + dy**2))
    h = mp.sqrt(max(L2**2 / (dx**2 + dy**2) - a * a, mp.mpf(0)))
    return x + a * dx - h * dy, y + a * dy + h * dx


def run_of(folder: Path, open_by: float, off: float = 0.0) -> tuple[sr.Trajectory, list[mp.mpf]]:
    """A run, with coupler and rocker this much longer than the distance to span, and guessed off by an angle."""
    crank = np.array([np.cos(1.2), np.sin(1.2)])
    values = [mp.mpf(x) for x in (2.5, 1.0, float(np.hypot(*(crank - (2.5, 0)))) - 1.8 + open_by, 1.8, 1.2)]
    D = np.array([float(x) for x in pin(*values)])
    poses = [
        ([*(0.5 * (D + end)).tolist(), 0.0], float(np.arctan2(*(D - end)[::-1])) + turn)
        for end, turn in ((crank, off), (np.array([2.5, 0.0]), -off))
    ]
    file = folder / "four_bar.yaml"
    file.write_text(model(float(values[2]), *poses))
    system = sr.System(sr.load(file))
    start = sr.assemble(system, fixed=["crank"])
    return sr.simulate(system, start, until=1e-4, method=sr.Radau(), store="steps"), values


HEIGHT = sr.At(lambda o: o.position("coupler", (o.parameter("L2") / 2, 0, 0))[1], time=0.0)


def error_of(found: sr.Gradient, values: list[mp.mpf]) -> float:
    """The largest error over the largest derivative of the pin's height."""
    directions = (tuple(int(n == k) for n in range(5)) for k in range(5))
    want = np.array([float(mp.diff(lambda *x: pin(*x)[1], values, n)) for n in directions])
    return float(abs(found.matrix[0] - want).max() / abs(want).max())


@pytest.mark.parametrize("open_by", [1e-1, 1e-3, 1e-5, 1e-7, 1e-9, 1e-11])
@mp.workdps(40)
def test_near_the_dead_centre(tmp_path: Path, open_by: float) -> None:
    run, values = run_of(tmp_path, open_by)
    found = sr.sensitivity(run, HEIGHT, NAMES)
    assert not found.undefined
    assert error_of(found, values) < 1e-8


@pytest.mark.filterwarnings("ignore:.*dead centre")
def test_in_line(tmp_path: Path) -> None:
    """The derivatives are infinite there: the rocker's pin would leave at the root of the change."""
    run, _ = run_of(tmp_path, 0.0)
    assert sr.sensitivity(run, HEIGHT, NAMES).undefined == tuple(NAMES)
    with pytest.raises(sr.NoDerivative, match="as in a dead centre"):
        sr.hessian(run, HEIGHT, NAMES)


@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_a_start_that_is_not_the_nearest_is_refused(tmp_path: Path) -> None:
    run, _ = run_of(tmp_path, 1e-8, 1e-2)
    with pytest.raises(ValueError, match=r"four-bar: derivatives need a start .* farther from a dead centre"):
        sr.sensitivity(run, HEIGHT, NAMES)
