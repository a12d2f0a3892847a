"""Every message on the page "Troubleshooting" is provoked and compared word by word."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.cli.values import refuse_unwritable
from sarrus.views import film
from sarrus.views.figures import style as plots

PAGE = (Path(__file__).parents[1] / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
NOT_MESSAGES = ("The first run is slow", "Where compiled kernels are cached")
HEADINGS = [line for line in re.findall(r"^### (.*)$", PAGE, re.MULTILINE) if line not in NOT_MESSAGES]
Z = (0, 0, 1)
CRANK = """name: crank
bodies:
  crank: {{mass: {mass}, inertia: {inertia}, position: [0.5, 0, 0]}}
joints:
  other: {{type: revolute, bodies: [ground, crank], point: [0, 0, 0], axis: [0, 0, 1]}}
  pin: {{type: revolute, bodies: [ground, {body}], point: [0, 0, 0], axis: [0, 0, 1]}}
"""
ARM = """<robot name="arm"><link name="base"/><link name="tip"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><mesh filename="package://none/box.stl"/></geometry></visual></link>
<joint name="pin" type="continuous"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/></joint></robot>"""


def in_a_file(folder: Path, mass: str = "1", inertia: str = "[1, 1, 1]", body: str = "crank") -> str:
    file = folder / "crank.yaml"
    file.write_text(CRANK.format(mass=mass, inertia=inertia, body=body))
    return refused(lambda: sr.System(sr.load(file)))


def refused(what: Callable[[], object]) -> str:
    try:
        what()
    except (sr.SarrusError, ValueError, KeyError) as error:
        return str(error.args[0]) if isinstance(error, KeyError) else str(error)
    raise AssertionError("nothing was refused")


def box(name: str = "box", x: float = 1.0) -> sr.Body:
    return sr.Body(name, mass=1.0, inertia=(1, 1, 1), position=(x, 0, 0))


def chain(points: list[tuple[float, float]], *drivers: sr.AngleDriver) -> sr.System:
    """Rods between points, hinges A, B, ... in the points, the first and the last in the ground."""
    middles = [((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, 0) for a, b in pairwise(points)]
    rods = [sr.Body(f"rod_{n}", mass=1, inertia=(1, 1, 1), position=place) for n, place in enumerate(middles)]
    sides = [sr.ground, *rods, sr.ground]
    hinges = [
        sr.Revolute(name, *sides[n : n + 2], point=(*points[n], 0), axis=Z)
        for n, name in enumerate("ABCD"[: len(points)])
    ]
    return sr.System(sr.Model("four-bar", rods, hinges, drivers=drivers))


def four_bar(*drivers: sr.AngleDriver) -> sr.System:
    return chain([(0, 0), (0.2, 0), (0.8, 0.5), (0.9, 0)], *drivers)


def mobility(system: sr.System) -> str:
    return str(sr.mobility(system, system.q0))


def in_degrees() -> str:
    with pytest.warns(sr.SarrusWarning, match="Give radians") as seen:
        chain([(0, 0), (1, 0), (1, 1)], sr.AngleDriver("motor", "A", motion="360*t"))
    return str(seen[0].message)


def not_assembled() -> str:
    far = box()
    rope = sr.Distance("C", sr.ground.point(5, 0, 0), far.point(0, 0, 0), length=2.0)
    hinge = sr.Spherical("S", sr.ground, far, point=(0, 0, 0))
    return sr.assemble(sr.System(sr.Model("far", [far], [hinge, rope]))).message


def tilted() -> str:
    door = box("door")
    hinges = [
        sr.Revolute(n, sr.ground, door, point=(0, 0, z), axis=(z, 0, 1)) for n, z in (("A", 0), ("B", 1e-7))
    ]
    with pytest.warns(sr.SarrusWarning) as seen:
        sr.simulate(sr.System(sr.Model("door", [door], hinges)), until=0.01)
    return str(seen[0].message)


def rounded() -> str:
    door = box("door")
    balls = [
        sr.Spherical(n, point_i=sr.ground.point(0, 0, z), point_j=door.point(-1, 0, 1.000001 * z))
        for n, z in (("top", 1), ("bottom", 0))
    ]
    with pytest.warns(sr.SarrusWarning) as seen:
        sr.System(sr.Model("door", [door], balls))
    return str(seen[0].message)


def stuck() -> str:
    door = box("door")
    hinges = [
        sr.Revolute(n, sr.ground, door, point=(0, 0, z), axis=(z, 0, 1))
        for n, z in (("low", 0), ("high", 1e-3))
    ]
    return sr.assemble(sr.System(sr.Model("door", [door], hinges)), rates={"low": 1.0}).message


def locked() -> str:
    driven = four_bar(sr.AngleDriver("motor", "D", "t"))
    return sr.kinematics(driven, np.linspace(0, 3, 50)).message


def falling() -> str:
    return sr.equilibrium(sr.System(sr.Model("ball", [box()], gravity=(0, 0, -9.81)))).message


def ever_smaller() -> str:
    ball = box()
    ends = sr.ground.point(0, 0, 0), ball.point(0, 0, 0)
    pull = sr.TSDA("pull", *ends, k=lambda l: 10 / (l * l * l * l * l), length=0.0)
    return sr.simulate(
        sr.System(sr.Model("falling in", [ball], forces=[pull])),
        until=2.0,
        method=sr.Radau(rtol=1e-9, atol=1e-11),
    ).message


def no_steps() -> str:
    run = sr.simulate(four_bar(), until=0.01)
    return refused(lambda: sr.sensitivity(run, sr.Final("rod_0.x"), wrt=["rod_0.mass"]))


def no_length() -> str:
    one = box()
    spring = sr.TSDA("spring", sr.ground.point(1, 0, 0), one.point(0, 0, 0), k=1, length=1)
    return refused(lambda: sr.System(sr.Model("one", [one], forces=[spring])))


def no_such_coordinate() -> str:
    run = sr.simulate(four_bar(), until=0.01)
    return refused(lambda: run.plot("A.angel"))


def saved_run(folder: Path) -> str:
    (folder / "run.sarrus").mkdir()
    (folder / "run.sarrus" / "zarr.json").write_text("{}")
    return refused(lambda: sr.load(folder / "run.sarrus"))


def finished_run(folder: Path) -> str:
    run = {"until": 0.01, "save": folder / "run.sarrus"}
    sr.simulate(four_bar(), **run)
    return refused(lambda: sr.simulate(four_bar(), **run))


def no_mesh(folder: Path) -> str:
    (folder / "arm.urdf").write_text(ARM)
    page = sr.load_urdf(folder / "arm.urdf").view(folder / "page.html")
    return Path(str(page)).read_text(encoding="utf-8")


SAID: list[Callable[[Path], str]] = [
    lambda folder: in_a_file(folder, body="crnak"),
    lambda folder: in_a_file(folder, mass="1 mm"),
    lambda folder: in_a_file(folder, inertia="[1, 1, 5]"),
    lambda folder: no_length(),
    lambda folder: in_degrees(),
    lambda folder: not_assembled(),
    lambda folder: mobility(four_bar()),
    lambda folder: tilted(),
    lambda folder: rounded(),
    lambda folder: stuck(),
    lambda folder: mobility(chain([(0, 0), (1, 0), (2, 0)])),
    lambda folder: locked(),
    lambda folder: falling(),
    lambda folder: ever_smaller(),
    lambda folder: no_steps(),
    lambda folder: no_such_coordinate(),
    saved_run,
    finished_run,
    lambda folder: refused(lambda: refuse_unwritable([folder / "none" / "a.csv"])),
    lambda folder: plots.MISSING,
    lambda folder: film.NO_FFMPEG,
    no_mesh,
]


def like(heading: str) -> re.Pattern[str]:
    """A sentence with any numbers and folders in the place of its own; ``...`` stands for anything."""
    words = heading.removesuffix(" (in the title of a page)")
    pieces = re.split(rf"({NUMBER}|\.\.\.|FOLDER)", words)
    return re.compile(
        "".join(
            re.escape(piece) if n % 2 == 0 else (".*" if piece in ("...", "FOLDER") else NUMBER)
            for n, piece in enumerate(pieces)
        ),
        re.DOTALL,
    )


def test_every_sentence_is_provoked() -> None:
    assert len(HEADINGS) == len(SAID)


@pytest.mark.parametrize(
    ("heading", "said"), [*zip(HEADINGS, SAID, strict=False)], ids=[one[:40] for one in HEADINGS]
)
def test_it_is_said(heading: str, said: Callable[[Path], str], tmp_path: Path) -> None:
    found = said(tmp_path)
    assert like(heading).search(found), found[:2000]


@pytest.mark.parametrize(
    ("call", "kind"),
    [
        (lambda s: sr.simulate(s, until=1, method=sr.Radau(rtol=-1)), ValueError),
        (lambda s: sr.simulate("crank", until=1), TypeError),
        (lambda s: sr.simulate(s, untill=1), TypeError),
        (lambda s: sr.Body("b"), TypeError),
        (lambda s: sr.assemble(s, np.zeros(3)), ValueError),
        (lambda s: sr.simulate(s, until=0.01)["nope"], KeyError),
        (lambda s: sr.assemble(s, rates={"nope": 1.0}), sr.SarrusError),
        (lambda s: sr.Body("b", mass=-1, inertia=(1, 1, 1)), sr.SarrusError),
        (lambda s: sr.load("nope.yaml"), sr.SarrusError),
    ],
)
def test_kinds_of_errors(call: Callable[[sr.System], object], kind: type[Exception]) -> None:
    """As the page says: errors of Sarrus for models, files and names, those of Python for arguments."""
    system = sr.System(sr.load("slider_crank"))
    with pytest.raises(kind) as raised:
        call(system)
    assert len(str(raised.value)) > 20
