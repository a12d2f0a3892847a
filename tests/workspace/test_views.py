"""Pictures and tables of workspaces."""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.io import netcdf_file

import sarrus as sr
from sarrus.cli import main
from sarrus.results.maps.workspace import inside
from sarrus.results.maps.workspace_volume import CriticalValue, Loop, Slice, WorkspaceRange, WorkspaceVolume
from sarrus.views.workspace_volume import barrier_sheets, surface_parts

from .mechanisms import arm_3r, platform_haug


@pytest.fixture(scope="module")
def arm() -> sr.Workspace:
    system, output, limits = arm_3r()
    return sr.workspace(system, output, limits=limits, verify=False)


def test_picture(arm: sr.Workspace) -> None:
    """All curves, each kind once in the legend, arrows on barriers, the mechanism in the number of positions wanted."""
    axes = arm.plot(ghosts=2)
    ghosts = [line for line in axes.get_lines() if line.get_marker() == "o"]
    assert len(ghosts) == 2 * (3 + 1)  # three links and the tip
    assert len(axes.get_lines()) - len(ghosts) == len([curve for curve in arm.curves if not curve.again])
    assert len(axes.get_legend().get_texts()) == 3
    assert len(axes.texts) > len(arm.of_kind("barrier"))


def test_the_mechanism_is_drawn_where_it_is_wanted(arm: sr.Workspace) -> None:
    """Its links have their lengths, and the last one ends there."""
    axes = arm.plot(at=[(5.0, 2.5), (2.0, 6.0)])
    marked = [np.array(line.get_xydata()) for line in axes.get_lines() if line.get_marker() == "o"]
    tips = [line for line in marked if len(line) == 1]
    assert np.concatenate(tips) == pytest.approx(np.array([(5.0, 2.5), (2.0, 6.0)]), abs=1e-9)
    lengths = sorted(float(np.linalg.norm(line[1] - line[0])) for line in marked if len(line) == 2)
    assert lengths == pytest.approx([1, 1, 2, 2, 4, 4])
    with pytest.raises(sr.SarrusError, match="no position was found with the outputs at 0, 0"):
        arm.plot(at=[(0.0, 0.0)])


def test_kinds_of_curves_are_chosen(arm: sr.Workspace) -> None:
    axes = arm.plot(kinds=["barrier"], ghosts=0)
    assert len(axes.get_lines()) == len([curve for curve in arm.of_kind("barrier") if not curve.again])
    assert len(axes.get_legend().get_texts()) == 1
    with pytest.raises(sr.SarrusError, match=r'no curves of kind "barriers". Did you mean'):
        arm.plot(kinds=["barriers"])


def test_parts_are_told_and_numbered() -> None:
    """Four parts in two mirrored pairs; each has its number, and the report tells in which the model stands."""
    system, output, limits = platform_haug()
    found = sr.workspace(system, output, limits=limits, verify=False)
    told = str(found)
    assert "The region has 4 components; no motion leads from one to another" in told
    assert f"  1: {found.components[0].area:.6g} m², platform.x from 0.185" in told
    where = "none of them" if found.drawn is None else f"part {found.drawn + 1}"
    assert f"is in {where}." in told
    axes = found.plot(ghosts=0)
    numbers = [text for text in axes.texts if text.get_text()]
    assert [text.get_text() for text in numbers] == ["1", "2", "3", "4"]
    for text, part in zip(numbers, found.components, strict=True):
        assert inside(list(part.loops), np.array([text.get_position()]))[0]
        assert np.linalg.norm(np.concatenate(part.loops) - text.get_position(), axis=1).min() > 0.2


def cone(height: float) -> Slice:
    """A slice with a barrier: a circle, as wide as it is high."""
    angle = np.linspace(0, 2 * np.pi, 181)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    loop = Loop(0, False, 3 * circle, (), ("singularity",))
    return Slice(height, 9 * np.pi, 0.0, (loop,), (height * circle,), True)


def test_barriers_inside_of_a_volume_are_sheets() -> None:
    """Circles of 1, 1.1 ... 2 m at heights of as much: a truncated cone, seen from both sides."""
    vertices, triangles = barrier_sheets([cone(1 + k / 10) for k in range(11)])
    radius = np.linalg.norm(vertices[:, :2], axis=1)
    assert radius == pytest.approx(vertices[:, 2], abs=1e-3)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    area = 0.5 * np.linalg.norm(normals, axis=1).sum()
    assert area == pytest.approx(2 * np.pi * np.sqrt(2) * (2**2 - 1), rel=1e-3)  # both sides
    assert normals.sum(axis=0) == pytest.approx(0, abs=1e-9)
    alone, _ = barrier_sheets([cone(1), cone(2)])
    assert len(alone) == 0  # too far from each other


def test_barriers_are_a_part_of_their_own_in_space() -> None:
    """Not seen through, beside the surface, which is; outputs in another order are turned back."""
    slices = tuple(cone(1 + k / 10) for k in range(11))
    corners, faces = np.eye(3), np.array([[0, 1, 2]])
    ends = (((1.0, 2.0),), (), slices, 1.0, 0.0, corners, faces, ("limit",), np.array([0]))
    found = WorkspaceVolume("cone", ("tip.y", "tip.z", "tip.x"), *ends, "mapped", "All slices are complete")
    surface, barrier = surface_parts(found, 0.3)
    assert (surface.name, surface.opacity) == ("limit", 0.3)
    assert (barrier.name, barrier.opacity) == ("barrier", 1.0)
    x, y, z = barrier.mesh.vertices.T
    assert np.hypot(y, z) == pytest.approx(x, abs=1e-3)


def test_table(arm: sr.Workspace, tmp_path: Path) -> None:
    arm.to_csv(tmp_path / "arm.csv")
    with (tmp_path / "arm.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(curve.u) for curve in arm.curves)
    x = np.array([[float(row[name]) for name in arm.outputs] for row in rows])
    assert np.array_equal(x, np.concatenate([curve.u for curve in arm.curves]))


def test_report(arm: sr.Workspace) -> None:
    told = str(arm)
    for words in (
        "31.4975",
        "The region is connected",
        "Barriers inside",
        "singularity",
        "q2.angle lowest",
        "not tested",
    ):
        assert words in told


def test_arrays(arm: sr.Workspace, tmp_path: Path) -> None:
    """NetCDF as another program reads it: every point, kind and cause."""
    arm.to_netcdf(tmp_path / "arm.nc")
    with netcdf_file(str(tmp_path / "arm.nc"), mmap=False) as file:
        u = np.stack([file.variables[name][:] for name in ("output_1", "output_2")], axis=1)
        kinds = file.variables["kind"].flag_meanings.decode().split()
        found = [kinds[n] for n in file.variables["kind"][:]]
        curve, area = file.variables["curve"][:], file.area
        assert file.variables["output_1"].units == b"m"
        assert file.variables["output_1"].long_name == arm.outputs[0].encode()
    assert np.array_equal(u, np.concatenate([curve.u for curve in arm.curves]))
    assert found == [curve.kind for curve in arm.curves]
    assert np.array_equal(np.bincount(curve), [len(curve.u) for curve in arm.curves])
    assert area == arm.area


def test_an_end_that_many_positions_have_is_told_once() -> None:
    ends = [CriticalValue(value, 1, (), True, np.zeros(7)) for value in (1.0, 2.0, 2.0)]
    found = WorkspaceRange("arm", "tip.x", "m", ((1.0, 2.0),), tuple(ends), "mapped", "Nothing is new")
    assert "Ends: 1 by singularity; 2 by singularity. Nothing is new." in str(found)


TABLE = """
name: table
bodies:
  x: {mass: 1, inertia: [1, 1, 1]}
  y: {mass: 1, inertia: [1, 1, 1]}
  tool: {mass: 1, inertia: [1, 1, 1]}
joints:
  one: {type: translational, bodies: [ground, x], point: [0, 0, 0], axis: [1, 0, 0]}
  two: {type: translational, bodies: [x, y], point: [0, 0, 0], axis: [0, 1, 0]}
  three: {type: translational, bodies: [y, tool], point: [0, 0, 0], axis: [0, 0, 1]}
"""
ENDS = ("lowest", "highest")
LIMITS = ["--limit", "one=0.5,2.5", "two=0,1", "three=-1,1", "--samples", "20"]


@pytest.mark.slow
def test_one_and_three_outputs_in_the_shell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Three slides reach a box, whose volume is exact; its picture, page, table and arrays are written."""
    (tmp_path / "table.yaml").write_text(TABLE)
    words = ["workspace", str(tmp_path / "table.yaml"), *LIMITS, "--output"]
    assert main([*words, "tool.x"]) == 0
    assert "tool.x can be from 0.5 to 2.5 m" in capsys.readouterr().out
    names = ("figure", "view", "csv", "netcdf", "report")
    files = [tmp_path / f"box.{ending}" for ending in ("png", "html", "csv", "nc", "txt")]
    options = [word for name, file in zip(names, files, strict=True) for word in (f"--{name}", str(file))]
    assert main([*words, "tool.x", "tool.y", "tool.z", *options]) == 0
    assert "can reach a volume of 4 " in capsys.readouterr().out
    assert all(file.stat().st_size > 100 for file in files)
    with netcdf_file(str(files[3]), mmap=False) as file:
        assert file.volume == pytest.approx(4, rel=1e-9)
        assert file.variables["vertices"][:].max(axis=0) == pytest.approx([2.5, 1, 1], abs=1e-3)
    with files[2].open(encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    assert {row["cause"] for row in rows} == {
        f"{name}.displacement {end}" for name in ("one", "two") for end in ENDS
    }
    assert main([*words, "tool.x", "--netcdf", str(files[3])]) == 2
    assert "for more than one output" in capsys.readouterr().err


ARM = """
name: arm
bodies:
  upper: {mass: 1, inertia: [1, 1, 1]}
  lower: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  q1: {type: revolute, bodies: [ground, upper], point: [0, 0, 0], axis: [0, 0, 1]}
  q2: {type: revolute, bodies: [upper, lower], point: [1, 0, 0], axis: [0, 0, 1]}
"""


@pytest.mark.slow
def test_fields_and_singular_positions_in_the_shell(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "arm.yaml").write_text(ARM)
    files = [tmp_path / name for name in ("field.png", "lost.png", "field.csv", "field.nc", "told.txt")]
    options = zip(("--figure", "--singular", "--csv", "--netcdf", "--report"), map(str, files), strict=True)
    words = ["workspace", str(tmp_path / "arm.yaml"), "--samples", "50", "--limit", "q1=-1,1", "q2=-1,2"]
    words += ["--output", "lower(1, 0, 0).x", "lower(1, 0, 0).y"]
    asked = ["--inputs", "q1", "q2", "--field", "manipulability"]
    assert main([*words, *asked, *(word for pair in options for word in pair)]) == 0
    assert all(file.stat().st_size > 100 for file in files)
    with files[2].open(encoding="utf-8") as table:
        assert max(float(row["manipulability"]) for row in csv.DictReader(table)) == pytest.approx(
            1, abs=0.01
        )
    assert files[4].read_text() == capsys.readouterr().out
    places = ["--at", "1.5,0.5", "--at=1.5,-0.5", "--curves", "outer", "--figure", str(files[0])]
    assert main([*words, *places]) == 0


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--field", "conditioning"], "--field conditioning needs to know what drives it. Add --inputs NAME"),
        (["--field", "turn"], "Add --turn NAME"),
        (["--turn", "x.rotation_z"], "--turn is for --field turn. Add it"),
        (["--singular", "x.png"], "Add --inputs NAME"),
        (["--output", "tool.x", "--at=1,1"], "--at is for two outputs, not 1. Leave it out"),
        (["--output", "tool.x", "--curves", "outer"], "--curves is for two outputs, not 1"),
        (["--output", "tool.x", "--netcdf", "x.nc"], "--netcdf is for more than one output"),
        (["--field", "solutions", "--at=1,1"], "--at is for a picture without --field"),
        (["--inputs", "one"], "--inputs is for --field and --singular"),
        (["--view", "x.html"], "--view is for three outputs, not 2"),
    ],
)
def test_options_that_do_not_fit(
    options: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "table.yaml").write_text(TABLE)
    both = [] if "--output" in options else ["--output", "tool.x", "tool.y"]
    assert main(["workspace", str(tmp_path / "table.yaml"), *both, *options]) == 2
    assert told in capsys.readouterr().err
