"""A robot that someone else described: three of Panda's joints as a planar arm, and the command line."""

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.cli import main

PANDA = Path(__file__).parent.parent / "io" / "data" / "panda.urdf"
LIMITS = {2: (-1.7628, 1.7628), 4: (-3.0718, -0.0698), 6: (-0.0175, 3.7525)}  # of the description
HELD = {f"panda_joint{n}": 0.0 for n in (1, 3, 5, 7)} | {f"panda_finger_joint{n}": 0.0 for n in (1, 2)}


def flange(q2: float, q4: float, q6: float) -> np.ndarray:
    """The wrist's flange in the plane y = 0, from the dimensions of the arm's data sheet."""
    p, turn = np.array([0.0, 0.333]), q2

    def along(x: float, z: float) -> np.ndarray:
        return np.array([np.cos(turn) * x + np.sin(turn) * z, -np.sin(turn) * x + np.cos(turn) * z])

    p = p + along(0.0825, 0.316)
    turn -= q4
    p = p + along(-0.0825, 0.384)
    turn -= q6
    return p + along(0.088, 0.0)


@pytest.fixture(scope="module")
def panda() -> sr.Workspace:
    system = sr.System(sr.load_urdf(PANDA, mimic="free"))
    return sr.workspace(
        system, ("panda_link7.x", "panda_link7.z"), limits="model", fixed=HELD, samples=200, rays=6
    )


@pytest.mark.slow
def test_every_point_is_where_the_data_sheet_says(panda: sr.Workspace) -> None:
    """By the angles of the three joints at every point of every curve."""
    assert panda.success, panda.message
    system = panda.map.problem.system
    for curve in panda.curves:
        for q, u in zip(curve.q, curve.u_of_q, strict=True):
            angles = [system.joint(f"panda_joint{n}").angle(q) for n in (2, 4, 6)]
            assert flange(*angles) == pytest.approx(u, abs=1e-9)


@pytest.mark.slow
def test_random_joint_angles_lie_inside(panda: sr.Workspace) -> None:
    random = np.random.default_rng(0)
    angles = np.array([random.uniform(*LIMITS[n], size=4000) for n in (2, 4, 6)]).T
    inside = panda.contains([flange(*q) for q in angles])
    assert np.count_nonzero(~inside) <= 2  # nearer to the boundary than its polyline


@pytest.mark.slow
def test_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    held = [f"{name}={value}" for name, value in HELD.items()]
    files = [tmp_path / name for name in ("map.png", "map.csv", "map.txt")]
    arguments = [
        "workspace",
        str(PANDA),
        "--mimic",
        "free",
        "--output",
        "panda_link7.x",
        "panda_link7(0, 0, 0).z",
    ]
    arguments += [
        "--limit",
        "panda_joint2=-30deg,30deg",
        "panda_joint4=-2,-1",
        "panda_joint6=0.5,1.5",
        "--fix",
        *held,
    ]
    arguments += [
        "--samples",
        "50",
        "--figure",
        str(files[0]),
        "--csv",
        str(files[1]),
        "--report",
        str(files[2]),
    ]
    assert main(arguments) == 0
    told = capsys.readouterr()
    assert "random admissible positions are outside" in told.out
    assert told.out.strip() == files[2].read_text(encoding="utf-8").strip()
    assert files[0].stat().st_size > 10_000
    assert files[1].read_text(encoding="utf-8").startswith("curve,kind,cause,panda_link7.x")


@pytest.mark.parametrize("wrong", [["--limit", "q1"], ["--fix", "q1="], ["--limit", "q1=1 lightyears,2"]])
def test_command_line_misuse(wrong: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["workspace", str(PANDA), "--output", "a", "b", *wrong]) == 2
    assert "must be" in capsys.readouterr().err or wrong[1].startswith("q1=1")
