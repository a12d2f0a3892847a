"""Mass and inertia of uniform solids, against integrals over their volume and against meshes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

import sarrus as sr
from sarrus.model.bodies.inertia import inertia_entries

DENSITY = 2700.0


def points(
    inner: float, outer: float, half: float, round_ends: bool = False
) -> Iterator[tuple[float, np.ndarray]]:
    """Volumes and places in a cylinder about z, or in a ball: Gauss in r and z, even angles."""
    nodes, weights = leggauss(12)
    for x, w in zip(nodes, weights, strict=True):
        z = half * x
        far = np.sqrt(outer**2 - z**2) if round_ends else outer
        for y, u in zip(nodes, weights, strict=True):
            r = inner + (far - inner) * (y + 1) / 2
            for angle in np.linspace(0, 2 * np.pi, 8, endpoint=False):
                volume = w * half * u * (far - inner) / 2 * r * np.pi / 4
                yield volume, np.array([r * np.cos(angle), r * np.sin(angle), z])


def integrated(parts: Iterator[tuple[float, np.ndarray]]) -> tuple[float, np.ndarray]:
    mass, tensor = 0.0, np.zeros((3, 3))
    for volume, s in parts:
        mass += DENSITY * volume
        tensor += DENSITY * volume * (s @ s * np.eye(3) - np.outer(s, s))
    return mass, tensor


def tensor_of(body: sr.Body) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = inertia_entries(body.inertia)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def check(body: sr.Body, wanted: tuple[float, np.ndarray], rel: float = 1e-10) -> None:
    assert body.mass == pytest.approx(wanted[0], rel=rel)
    assert tensor_of(body) == pytest.approx(wanted[1], rel=rel, abs=rel * abs(wanted[1]).max())


@pytest.mark.parametrize("inner", [0.0, 0.15])
def test_cylinders_and_tubes(inner: float) -> None:
    mass, tensor = integrated(points(inner, 0.2, 0.35))
    check(sr.Body.cylinder("c", 0.2, 0.7, inner_radius=inner, density=DENSITY), (mass, tensor))
    along_x = tensor[np.ix_([2, 0, 1], [2, 0, 1])]
    check(sr.Body.cylinder("c", 0.2, 0.7, axis="x", inner_radius=inner, density=DENSITY), (mass, along_x))


def test_spheres_and_boxes() -> None:
    check(sr.Body.sphere("s", 0.3, density=DENSITY), integrated(points(0.0, 0.3, 0.3, round_ends=True)), 1e-9)
    x, y, z = 0.1, 0.2, 0.4
    m = DENSITY * x * y * z
    wanted = np.diag([m / 12 * (y**2 + z**2), m / 12 * (x**2 + z**2), m / 12 * (x**2 + y**2)])
    check(sr.Body.box("b", (x, y, z), density=DENSITY), (m, wanted))
    check(sr.Body.box("b", (x, y, z), mass=m), (m, wanted))


def test_a_rod_is_a_cylinder_that_is_turned() -> None:
    start, end, radius = np.array([0.1, -0.2, 0.3]), np.array([0.7, 0.4, 0.1]), 0.02
    body = sr.Body.rod("r", start, end, radius=radius, density=DENSITY)
    length = np.linalg.norm(end - start)
    along = sr.Body.cylinder("c", radius, length, density=DENSITY)
    u = (end - start) / length
    turn = np.linalg.svd(u[None])[2].T[:, [1, 2, 0]]  # its last column is along the rod
    check(body, (along.mass, turn @ tensor_of(along) @ turn.T))
    assert body.position == pytest.approx((start + end) / 2)
    thin = sr.Body.rod("r", (0, 0, 0), (2, 0, 0), mass=3.0)
    assert tensor_of(thin)[1, 1] == pytest.approx(3.0 * 4 / 12, rel=1e-2)


def test_a_pendulum_of_a_rod_swings_as_it_should() -> None:
    """Small swings of a thin rod about its end: ω² = 3 g / (2 l)."""
    rod = sr.Body.rod("rod", (0, 0, 0), (np.sin(0.001), 0, -np.cos(0.001)), radius=1e-3, mass=2.0)
    pin = sr.Hinge("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 1, 0))
    system = sr.System(sr.Model("pendulum", [rod], [pin], gravity=(0, 0, -9.81)))
    period = 2 * np.pi / np.sqrt(1.5 * 9.81)
    run = sr.simulate(system, until=period, t_eval=[0.5 * period, period])
    assert run["rod"].position[:, 0] == pytest.approx([-0.0005, 0.0005], rel=1e-5)


def test_a_mesh(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    made = trimesh.creation.box((100, 200, 400))
    made.apply_translation((10, 0, 0))
    made.export(tmp_path / "box.stl")
    body = sr.Body.from_mesh("b", tmp_path / "box.stl", scale=1e-3, density=DENSITY)
    check(
        body,
        (lambda box: (box.mass, tensor_of(box)))(sr.Body.box("b", (0.1, 0.2, 0.4), density=DENSITY)),
        1e-6,
    )
    assert body.center_of_mass == pytest.approx((0.01, 0, 0), abs=1e-9)
    assert sr.System(sr.Model("one", [body])).nq == 7
    open_one = trimesh.creation.box((1, 1, 1))
    open_one.update_faces(np.arange(len(open_one.faces)) > 1)
    open_one.export(tmp_path / "open.stl")
    with pytest.raises(sr.ModelError, match="no closed mesh"):
        sr.Body.from_mesh("b", tmp_path / "open.stl", density=DENSITY)
    with pytest.raises(sr.ModelError, match=r"none\.stl: does not exist"):
        sr.Body.from_mesh("b", tmp_path / "none.stl", density=DENSITY)


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        (lambda: sr.Body.box("b", (1, 1, 1)), "mass or density must be given"),
        (lambda: sr.Body.box("b", (1, 1, 1), mass=1, density=1), "only one of them"),
        (lambda: sr.Body.box("b", (1, -1, 1), mass=1), "size must be greater than 0"),
        (lambda: sr.Body.cylinder("b", 1, 1, axis="u", mass=1), "axis must be x, y or z"),
        (lambda: sr.Body.cylinder("b", 1, 1, inner_radius=2, mass=1), "less than the radius"),
        (lambda: sr.Body.rod("b", (0, 0, 0), (0, 0, 0), mass=1), "end"),
        (lambda: sr.Body.sphere("b", 0.1, density=0), "density must be greater than 0"),
    ],
)
def test_what_no_solid_has(wrong, why: str) -> None:
    with pytest.raises(sr.ModelError, match=why):
        wrong()


def test_other_names_of_types(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(
        "name: m\nbodies: {a: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}}\n"
        "joints: {p: {type: hinge, bodies: [ground, a], point: [0, 0, 0], axis: [0, 0, 1]}}\n"
        "forces:\n  s: {type: spring, points: [{body: ground, at: [0, 0, 1]}, {body: a, at: [0, 0, 0]}], k: 5,\n"
        "    length: 1}\n"
        "  c: {type: spring, bodies: [ground, a], point: [0, 0, 0], axis: [0, 0, 1], k: 1}\n"
    )
    found = sr.load(tmp_path / "m.yaml")
    assert [type(part) for part in (*found.joints, *found.forces)] == [sr.Revolute, sr.TSDA, sr.RSDA]
    assert (sr.Hinge, sr.Prismatic, sr.Ball, sr.Spring) == (
        sr.Revolute,
        sr.Translational,
        sr.Spherical,
        sr.TSDA,
    )


def test_rods_from_point_to_point() -> None:
    a, b, c = np.array([(0.1, 0.2, 0), (0.5, 0.3, 0.1), (0.2, 0.8, 0.3)])
    rod = sr.Body.rod("rod", a, b, radius=0.01, density=DENSITY)
    one = sr.Body.from_points("one", [a, b], radius=0.01, density=DENSITY)
    assert one.mass == pytest.approx(rod.mass, rel=1e-14)
    assert np.allclose(one.inertia, rod.inertia, rtol=1e-14)
    assert one.position == pytest.approx(rod.position, rel=1e-14)
    arm = sr.Body.from_points("arm", [a, b, c], radius=0.01, closed=True, density=DENSITY)
    mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))  # thin segments of the rods, and their discs
    for start, end in ((a, b), (b, c), (c, a)):
        u, m = (
            (end - start) / np.linalg.norm(end - start),
            DENSITY * np.pi * 1e-4 * np.linalg.norm(end - start) / 400,
        )
        for x in (np.arange(400) + 0.5) / 400:
            s = start + x * (end - start)
            disc = m * 1e-4 / 4 * (np.eye(3) + np.outer(u, u))
            mass, first, second = (
                mass + m,
                first + m * s,
                second + disc + m * (s @ s * np.eye(3) - np.outer(s, s)),
            )
    center = first / mass
    about = second - mass * (center @ center * np.eye(3) - np.outer(center, center))
    assert arm.mass == pytest.approx(mass, rel=1e-12)
    assert arm.position == pytest.approx(center, rel=1e-12)
    assert np.allclose(arm.inertia, about, rtol=1e-4, atol=1e-6 * mass)
    for wrong, message in (([a], "two or more"), ([a, a], "twice in a row"), ([a, (0, 0)], "3 numbers")):
        with pytest.raises(sr.ModelError, match=rf'"bad": points .*{message}'):
            sr.Body.from_points("bad", wrong, mass=1)
