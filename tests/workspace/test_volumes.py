"""Volumes and surfaces of spatial mechanisms, beside closed forms and independent quadratures."""

import json
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.workspace.problem.formulation import formulate
from sarrus.analyses.workspace.regions.mapping import WorkspaceMap
from sarrus.analyses.workspace.volumes.quadrature import FIRST, Integral
from sarrus.analyses.workspace.volumes.slicing import _height_of, _on_curve
from sarrus.analyses.workspace.volumes.volume import positions_outside
from sarrus.results.maps.workspace_volume import Slice

from .mechanisms import Case, about, delta, elbow_arm, gough, orthogonal_arm, puma, tilted, translated

GOUGH = 0.1449207748152  # spheres cut by planes to arcs, these by Gauss-Kronrod quadrature between critical heights


OUT = 0.4318 + float(np.hypot(0.0203, 0.4331))  # m, a PUMA's arm stretched


def shell() -> Case:
    return translated({((0, 0, 0), (0, 0, 0)): (0.5, 1.0)})


def tip_of(case: tuple[sr.System, sr.Point]) -> Case:
    system, tip = case
    return system, tip["x", "y", "z"], {}


def limited_delta() -> Case:
    system, output, _ = tip_of(delta())
    return system, output, {f"q{n}.angle": (-np.pi / 6, np.pi / 2) for n in range(3)}


@pytest.fixture(scope="module")
def ball() -> sr.WorkspaceVolume:
    system, output, limits = shell()
    return sr.workspace_volume(system, output, limits=limits, rtol=1e-4, derivatives=True)


@pytest.mark.slow
def test_volume_of_a_shell(ball: sr.WorkspaceVolume) -> None:
    """Slices are annuli and discs; where one kind follows the other, the area has a kink."""
    exact = 4 / 3 * np.pi * (1 - 0.125)
    assert ball.success
    assert ball.ranges == (pytest.approx((-1.0, 1.0)),)
    assert ball.critical == pytest.approx([-0.5, 0.5], abs=1e-9)
    assert abs(ball.volume - exact) < ball.volume_error < 1e-4 * exact
    for one in ball.slices:
        area = np.pi * (1 - one.height**2 - max(0.25 - one.height**2, 0))
        assert one.area == pytest.approx(area, rel=1e-6)
        assert abs(one.area - area) < 3 * one.area_error + 1e-9
    assert "volume" in str(ball)


@pytest.mark.slow
def test_surface_of_a_shell(ball: sr.WorkspaceVolume, tmp_path: Path) -> None:
    """Closed, seen from outside everywhere, on two spheres, each with its cause."""
    assert open_edges(ball) == 0
    assert ball.enclosed() == pytest.approx(ball.volume, rel=0.01)
    radius = np.linalg.norm(ball.vertices, axis=1)
    on = np.min(abs(radius[:, None] - (0.5, 1.0)), axis=1)
    assert np.quantile(on, 0.95) < 4e-3
    for name, expected in (("leg 1 lowest", 0.5), ("leg 1 highest", 1.0)):
        mine = ball.triangles[ball.cause_of == ball.causes.index(name)]
        assert abs(radius[mine] - expected).max() < 8e-3
    ball.to_obj(tmp_path / "shell.obj")
    assert (tmp_path / "shell.obj").read_text().count("\nv ") == len(ball.vertices)
    assert len(ball.plot().collections) >= 1


@pytest.mark.slow
def test_page_of_a_shell(ball: sr.WorkspaceVolume, tmp_path: Path) -> None:
    """Each cause is a part of the surface in its own colour, seen through; the page needs no network."""
    page = ball.view(tmp_path / "shell.html").read_text(encoding="utf-8")
    told = json.loads(page.split('id="scene">')[1].split("</script>")[0])
    parts = {part["name"]: part for part in told["sketches"][0]["parts"] if part["opacity"] < 1}
    assert {"leg 1 lowest", "leg 1 highest"} <= parts.keys()
    assert len({part["color"] for part in parts.values()}) == len(parts)
    assert "tool" in told["sketches"][0]["bodies"]
    angles = replace(ball, outputs=("a.angle", "b.angle", "c.angle"))
    with pytest.raises(sr.SarrusError, match="no coordinates"):
        angles.view(tmp_path / "angles.html")


def open_edges(found: sr.WorkspaceVolume) -> int:
    """Edges that have not as many triangles on one side as on the other."""
    edges: Counter[tuple[int, int]] = Counter()
    for a, b, c in found.triangles.tolist():
        for one, other in ((a, b), (b, c), (c, a)):
            edges[one, other] += 1
            edges[other, one] -= 1
    return sum(map(abs, edges.values()))


@pytest.mark.slow
@pytest.mark.parametrize("pool", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_numbers_do_not_depend_on_the_executor(pool: type) -> None:
    system, output, limits = shell()
    options = {"between": (0.6, 1.0), "rtol": 0.05, "samples": 20}
    here = sr.workspace_volume(system, output, limits=limits, **options)
    with pool(2) as executor:
        there = sr.workspace_volume(system, output, limits=limits, executor=executor, **options)
    assert there.volume == here.volume
    assert np.array_equal(there.vertices, here.vertices)


@pytest.mark.slow
def test_a_range_that_is_cut() -> None:
    """Half of a shell is closed by an annulus."""
    system, output, limits = shell()
    found = sr.workspace_volume(system, output, limits=limits, between=(0.0, 2.0), rtol=1e-3)
    exact = 2 / 3 * np.pi * (1 - 0.125)
    assert found.volume == pytest.approx(exact, rel=1e-3)
    assert open_edges(found) == 0
    assert found.enclosed() == pytest.approx(exact, rel=0.01)


@pytest.mark.parametrize(
    ("output", "options", "told"),
    [
        (("tool.x", "tool.y"), {}, "a volume has three outputs"),
        (("tool.x",) * 3, {"rtol": 0.0}, "rtol: must be"),
        (
            ("tool.x",) * 3,
            {"between": (1.0, 0.0)},
            r"between: must be two values that rise, got \(1\.0, 0\.0\)",
        ),
    ],
)
def test_misuse(output: tuple[str, ...], options: dict[str, Any], told: str) -> None:
    system, _, limits = shell()
    with pytest.raises(sr.SarrusError, match=told):
        sr.workspace_volume(system, output, limits=limits, **options)


def test_heights_out_of_reach() -> None:
    system, output, limits = shell()
    found = sr.workspace_volume(
        system, output, limits=limits, between=(2.0, 3.0), samples=20, derivatives=True
    )
    assert (found.volume, found.rates) == (0.0, None)
    assert "Nothing can be reached between these heights" in str(found)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "between", "exact"),
    [
        (gough, (0, 2), GOUGH),
        (lambda: gough(tilted()), (0, 2), 0.0413666269387125),
        (lambda: gough(about(2, 30)), (0, 2), 0.0087290447061201),
        (elbow_arm, None, 1.1964247358662679),
        (lambda: tip_of(orthogonal_arm()), None, 350.751924309),
        (limited_delta, (-1, 0), 0.23112556),
    ],
    ids=["gough", "tilted gough", "turned gough", "elbow arm", "orthogonal arm", "delta"],
)
def test_volumes_by_refinement(
    case: Callable[[], Case], between: tuple[float, float] | None, exact: float
) -> None:
    """Known from spheres and from Pappus' theorem."""
    system, output, limits = case()
    found = sr.workspace_volume(system, output, limits=limits, between=between, rtol=1e-6)
    assert found.success, found.message
    assert found.volume == pytest.approx(exact, rel=1e-6)
    assert abs(found.volume - exact) < found.volume_error + 1e-7 * exact
    assert open_edges(found) == 0


def test_an_interrupted_volume_has_a_coarse_value() -> None:
    """The error of the slices so far contains the exact volume."""
    system, output, limits = gough(tilted())
    exact, slices = 0.0413666269387125, 30

    def interrupt(reached: float) -> None:
        if reached >= slices:
            raise KeyboardInterrupt

    with pytest.warns(sr.SarrusWarning, match="its volume is a coarse one"):
        found = sr.workspace_volume(
            system, output, limits=limits, between=(0, 2), samples=20, progress=interrupt
        )
    assert found.status == "stopped"
    assert len(found.slices) >= slices
    assert abs(found.volume - exact) < found.volume_error < 0.4 * exact
    assert f"some {found.volume:.3g}" in str(found)


@pytest.mark.slow
def test_derivatives_of_a_cap() -> None:
    """The cap of a ball above a height, by its radius; the hole does not matter. Derivatives have to be asked for."""
    system, output, limits = shell()
    options = {"between": (0.6, 2.0), "rtol": 1e-2, "samples": 20}
    found = sr.workspace_volume(system, output, limits=limits, derivatives=True, **options)
    by = sr.volume_gradient(
        found, ["leg 1 highest", "leg 1 lowest", "leg 1[length].s_i.x", "tool.z[z].s_j.z"]
    )
    assert by.value == found.volume == pytest.approx(np.pi * (2 / 3 - 0.6 + 0.6**3 / 3), abs=1e-7)
    exact = 2 * np.pi * 0.4
    cut = np.pi * (1 - 0.6**2)  # m², the middle rises past it
    assert list(by.by.values()) == pytest.approx([exact, 0, 0, cut], abs=1e-7)
    assert abs(by["leg 1 highest"] - exact) < by.error["leg 1 highest"]
    with pytest.raises(sr.SarrusError, match="derivatives=True"):
        sr.volume_gradient(replace(found, rates=None), ["leg 1 highest"])
    with pytest.raises(sr.SarrusError, match="leg 1 highest"):
        sr.volume_gradient(found, ["leg 1 high"])


@pytest.mark.slow
def test_derivatives_of_a_shell(ball: sr.WorkspaceVolume) -> None:
    """By its radii; it is moved by its middle as a whole."""
    by = sr.volume_gradient(ball, ["leg 1 highest", "leg 1 lowest", "leg 1[length].s_i.x", "tool.z[z].s_j.z"])
    assert by.value == ball.volume
    for name, exact in (("leg 1 highest", 4 * np.pi), ("leg 1 lowest", -4 * np.pi / 4)):
        assert by[name] == pytest.approx(exact, rel=1e-7)
        assert abs(by[name] - exact) < by.error[name]
    assert [by["leg 1[length].s_i.x"], by["tool.z[z].s_j.z"]] == pytest.approx([0, 0], abs=1e-6)


@pytest.mark.slow
def test_derivatives_of_a_shell_between_levels() -> None:
    """A limit of the height itself makes level parts of the boundary; they move with that limit alone."""
    system, output, limits = shell()
    levels = {**limits, output[2]: (-0.2, 0.6)}
    found = sr.workspace_volume(system, output, limits=levels, rtol=1e-4, samples=40, derivatives=True)
    names = [*(f"{of} {end}" for of in ("leg 1", "tool.z") for end in ("lowest", "highest"))]
    by = sr.volume_gradient(found, [*names, "leg 1[length].s_i.z", "tool.z[z].s_j.z"])
    radii, ends = [-2 * np.pi * 0.5 * 0.7, 2 * np.pi * 0.8], [-np.pi * 0.75, np.pi * 0.64]
    assert list(by.by.values()) == pytest.approx([*radii, *ends, 0.11 * np.pi, 0.11 * np.pi], rel=3e-6)


@pytest.mark.slow
def test_derivatives_of_an_elbow_arm() -> None:
    """By Pappus' theorem, over two angles; lengths times derivatives make three times the volume."""
    system, output, limits = elbow_arm()
    found = sr.workspace_volume(system, output, limits=limits, rtol=1e-6, derivatives=True)
    lengths = {
        "q2[point].s_i.x": 0.1,
        "q3[point].s_i.x": 0.45,
        **{f"link_3.{a}[{a}].s_j.x": 0.4 for a in "xyz"},
    }
    angles = [
        "q1.angle highest",
        "q2.angle lowest",
        "q2.angle highest",
        "q3.angle lowest",
        "q3.angle highest",
    ]
    by = sr.volume_gradient(found, [*lengths, *angles])
    by_angles = [0.21421902486, -1.09003697221, 0.65672633543, -0.53298458109, 0.12965813407]
    # rtol is that of the volume: derivatives have jumps where the area has kinks, and errors of their own
    for name, wanted in zip(angles, by_angles, strict=True):
        assert abs(by[name] - wanted) < 2 * by.error[name] < 3e-3
    off = sum(length * by[name] for name, length in lengths.items()) - 3 * found.volume
    assert abs(off) < 2 * sum(length * by.error[name] for name, length in lengths.items()) < 5e-3


@pytest.mark.slow
def test_derivatives_of_a_gough_platform() -> None:
    """Beside differences of volumes that were made of circles' arcs and Gauss' rule between critical heights."""
    system, output, limits = gough()
    found = sr.workspace_volume(system, output, limits=limits, between=(0, 2), rtol=1e-5, derivatives=True)
    names = [
        "leg 1 lowest",
        "leg 1 highest",
        "leg 1[length].s_i.x",
        "leg 2[length].s_i.x",
        "leg 1[length].s_i.z",
    ]
    by = sr.volume_gradient(found, names)
    exact = [-0.130951736143, 0.162502976184, -0.050131182441, 0.051500804807, 0.0]
    assert [by[name] for name in names] == pytest.approx(exact, abs=1e-5)
    assert all(abs(by[name] - wanted) < by.error[name] for name, wanted in zip(names, exact, strict=True))


def test_rates_where_slices_are_empty() -> None:
    """Rates of a piece of which no slice has a curve are zero; without any there are none."""

    def integral(whole: bool) -> Integral:
        known: dict[float, Slice] = {}

        def at(heights: Any) -> list[Slice]:
            found = list(heights)
            rates = {z: np.ones(3) if whole and z < 1.5 else None for z in found}
            known.update({z: Slice(z, 0.0, 0.0, (), (), True, (), one) for z, one in rates.items()})
            return [known[z] for z in found]

        slicer: Any = SimpleNamespace(known=known, problem=None, at=at, reconcile=lambda: False)
        made = Integral(slicer, [(0.0, 1.0), (2.0, 3.0)], [], 1e-4, 100, 4 * FIRST)
        made.run()
        return made

    assert len(integral(False).rates) == 0
    assert integral(True).rates == pytest.approx(np.ones(3))


def test_positions_at_heights_that_were_missed_are_outside() -> None:
    u = np.array([(0.0, 0.0, z) for z in (0.5, 1.0005, 1.5, 2.5)])
    slicer: Any = SimpleNamespace(around=lambda z: [SimpleNamespace(holds=lambda u: True)], at=list)
    ranges = [(0, 1), (2, 3)]
    assert [positions_outside(u, slicer, ranges, between) for between in ((-1, 4), (0, 1.2))] == [1, 0]
    assert positions_outside(u, slicer, [], (1, 2)) == 2


@pytest.mark.slow
def test_curves_are_carried_to_slices_far_away() -> None:
    """The hole of a PUMA's slices, where its elbow is nearly folded: the arm turns much between these heights."""
    system, output, _ = puma()
    above = formulate(system, output[:2], fixed={output[2]: 0.0996555})
    below = above.held_at(_height_of(above), 0.0133286)
    radii = set()
    for branch in WorkspaceMap.of(above).run().branches:
        found = _on_curve(below, branch.stratum.key, branch.points[0].x)
        if found is not None:
            u = below.values(found.x[: below.n])[below.m + below.outputs] * below.units[below.outputs]
            radii.add(round(float(np.linalg.norm(u)), 9))
    assert radii == {0.1497, round(float(np.hypot(0.1497, np.sqrt(OUT**2 - 0.0133286**2))), 9)}
