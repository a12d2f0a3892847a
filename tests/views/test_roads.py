"""Tyres are drawn on their roads; what is round-off of forces has no arrow, and a road hides what is below it."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.views.looks import Part, sketch
from sarrus.views.meshes.mesh import Mesh
from sarrus.views.motion import arrows, frames
from sarrus.views.raster import Canvas, camera

RADIUS = 0.33
LIFT = np.tile([0.0, 0, 1, 0, 0, 0, 0], 14)  # of all bodies of the vehicle


def volume(mesh: Mesh) -> float:
    """By the divergence theorem: positive if the surface is closed and looks outwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


@cache
def ride() -> sr.Trajectory:
    """Two wheels on a road in waves, and one on a flat road that a shaker lifts by 2 cm at the start."""
    bodies = [
        sr.Body(f"wheel_{n}", mass=20.0, inertia=(1, 1, 1), position=(0, n, 0.3), velocity=(4, 0, 0))
        for n in range(3)
    ]
    guides = [
        sr.PointOnPlane(f"guide_{body.name}", sr.ground, body, point=body.position, axis=(0, 1, 0))
        for body in bodies
    ]
    roads = [{"road": "0.03*sin(3*x)"}] * 2 + [{"road": 0.01, "bump": "0.02*cos(9*t)"}]
    tyres = [
        sr.RoadTyre(f"tyre_{n}", body.point(0, 0, 0), k=2e4, c=300.0, radius=RADIUS, **road)
        for n, (body, road) in enumerate(zip(bodies, roads, strict=True))
    ]
    system = sr.System(sr.Model("ride", bodies, guides, tyres, gravity=(0, 0, -9.81)))
    return sr.simulate(system, until=1.0, t_eval=np.linspace(0, 1, 41))


def roads() -> dict[str, Part]:
    drawn = sketch(ride().system.model, ride().q)
    found = {part.name: part for part in drawn.parts if part.kind == "ground" and part.name[:4] == "road"}
    assert drawn.floor == min(part.mesh.vertices[:, 2].min() for part in found.values())
    return found


def test_tyres_on_one_road_have_it_in_common() -> None:
    waves, flat = roads()["road of tyre_0, tyre_1"].mesh, roads()["road of tyre_2"].mesh
    for mesh, width in ((waves, 1 + 1.4 * RADIUS), (flat, 1.4 * RADIUS)):
        long, wide, _ = np.ptp(mesh.vertices, axis=0)
        assert wide == pytest.approx(width)
        assert volume(mesh) == pytest.approx(long * wide * 0.05 * RADIUS, rel=1e-9)


def test_the_surface_has_the_profile_of_the_road() -> None:
    waves, flat = roads()["road of tyre_0, tyre_1"].mesh.vertices, roads()["road of tyre_2"].mesh.vertices
    top = waves[waves[:, 2] > 0.03 * np.sin(3 * waves[:, 0]) - 1e-9]
    assert top[:, 2] == pytest.approx(0.03 * np.sin(3 * top[:, 0]), abs=1e-12)
    assert np.ptp(top[:, 0]) == pytest.approx(np.ptp(ride()["wheel_0"].position[:, 0]) + 5 * RADIUS, rel=1e-6)
    assert flat[:, 2].max() == pytest.approx(0.01)


def test_a_surface_is_drawn_as_far_as_its_grid_reaches() -> None:
    """From behind the path, which begins at x = 0, to the end of the grid; closed, and with the heights of the grid."""
    x, y = np.linspace(-5, 3, 33), np.linspace(-0.5, 9, 20)
    surface = sr.Surface(x, y, 0.05 * np.sin(2 * x[:, None]) * np.cos(y))
    body = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1), position=(0, 0, 0.35), velocity=(4, 0, 0))
    law = {"k": 2e4, "c_kappa": 2e4, "c_alpha": 2e4, "mu": 1.0, "radius": RADIUS}
    tyre = sr.BrushTyre("tyre", body.point(0, 0, 0), **law, spin_inertia=1.0, road=surface)
    model = sr.Model("grid", [body], [], [tyre], gravity=(0, 0, -9.81))
    positions = np.array([[at, 0.2, 0.35, 1, 0, 0, 0] for at in (0.0, 2.9)])
    (road,) = (part for part in sketch(model, positions).parts if part.description == "road")
    corners = road.mesh.vertices
    assert corners.min(axis=0)[:2] == pytest.approx([-2.5 * RADIUS, 0.2 - 0.7 * RADIUS])
    assert corners.max(axis=0)[:2] == pytest.approx([3.0, 0.2 + 0.7 * RADIUS])
    above = corners[:, 2] - surface.height(corners[:, 0], corners[:, 1])
    assert np.all((abs(above) < 1e-12) | (abs(above + 0.05 * RADIUS) < 1e-12))
    long, wide, _ = np.ptp(corners, axis=0)
    assert volume(road.mesh) == pytest.approx(long * wide * 0.05 * RADIUS, rel=1e-4)


def test_a_road_that_moves_is_drawn_where_it_is(tmp_path: Path) -> None:
    t = np.linspace(0, 1, 41)
    drawn = sketch(ride().system.model, ride().q, t)
    rises = drawn.coordinates(t, ride().q, ride().v)[:, 21:]
    assert rises[:, 2] == pytest.approx(0.02 * np.cos(9 * t), abs=1e-12)
    assert np.all(rises[:, [0, 1, 4, 5, 6]] == 0)
    assert np.all(rises[:, 3] == 1)
    assert [part.body for part in drawn.parts if part.name[:4] == "road"] == [0, 4]
    assert drawn.floor == pytest.approx(min(-0.03, 0.01 + rises[:, 2].min()) - 0.05 * RADIUS, abs=1e-5)
    data = sr.animate(ride(), tmp_path / "ride.glb", count=41).read_bytes()
    scene = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    (node,) = (n for n, one in enumerate(scene["nodes"]) if one["name"] == "road 1")
    channels, samplers = (scene["animations"][0][key] for key in ("channels", "samplers"))
    (path,) = (samplers[one["sampler"]]["output"] for one in channels if one["target"]["node"] == node)
    assert scene["accessors"][path]["max"] == pytest.approx([0, 0, 0.02])
    assert scene["accessors"][path]["min"] == pytest.approx([0, 0, rises[:, 2].min()])


def test_roads_are_numbered_without_the_wheels_whose_spins_are_states() -> None:
    """The tyre has the name of a road, and a frame as a road that moves has."""
    body = sr.Body("hub", mass=20.0, inertia=(1, 1, 1), position=(0, 0, 0.3))
    law = {"k": 2e4, "c_kappa": 2e4, "c_alpha": 2e4, "mu": 1.0, "radius": RADIUS}
    tyres = [
        sr.BrushTyre("roadster", body.point(0, 0, 0), **law, spin_inertia=1.0),
        sr.RoadTyre("shaken", body.point(0, 0, 0), k=2e4, c=300.0, radius=RADIUS, bump="0.02*cos(9*t)"),
    ]
    drawn = sketch(sr.Model("two", [body], [], tyres))
    assert [frame.name for frame in drawn.moving] == ["roadster", "road 1"]


def test_every_tyre_of_the_vehicle_is_on_one_flat_road() -> None:
    drawn = sketch(sr.load("hmmwv"))
    (road,) = (part for part in drawn.parts if part.description == "road")
    assert len(road.mesh.faces) == 12
    assert road.mesh.vertices[:, 2].max() == 0


def test_torques_that_are_round_off_of_forces_have_no_arrows() -> None:
    system = sr.System(sr.load("hmmwv"))
    run = sr.simulate(system, system.q0 + 0.02 * LIFT, until=0.05)
    found = arrows(run, frames(run, 5), [], True)
    assert {one.name for one in found} == {force.name for force in system.model.forces}
    assert not any(one.turning for one in found)


def test_a_large_triangle_hides_what_is_below_it() -> None:
    """Seen at a low angle, its depth on the page is not linear, but that of the plane."""
    corners = np.array([[[-1, -1, 0], [1, -1, 0], [0, 30, 0]]], dtype=float)
    lens = camera(corners.reshape(-1, 3), np.array([0.0, 0, 1]), "iso", 200, 150)
    below = np.array(
        [[[-0.05, y, -0.02], [0.05, y, -0.02], [0, y + 0.5, -0.02]] for y in np.linspace(0, 25, 60)]
    )
    canvas = Canvas(200, 150, np.ones(3))
    canvas.draw(lens.seen(corners), np.zeros((1, 3)))
    alone = canvas.copy()
    canvas.draw(lens.seen(below), np.tile([1.0, 0, 0], (len(below), 1)))
    assert np.array_equal(canvas.pixels, alone.pixels)
