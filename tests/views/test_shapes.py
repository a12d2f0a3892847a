"""Meshes are closed, look outwards, and have the size that was asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.views.looks import sketch
from sarrus.views.meshes import mesh as meshes
from sarrus.views.meshes import solids

Z = np.array([0.0, 0.0, 1.0])
EXAMPLES = [
    *(
        file
        for file in (Path(__file__).parents[2] / "examples").glob("*.yaml")
        if "\nname:" in file.read_text()
    ),
    mechanisms.path("hmmwv"),
]


def volume(mesh: meshes.Mesh) -> float:
    """By Gauss: positive if the triangles look outwards, and independent of the origin if it is closed."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (solids.ball(0.5), 4 / 3 * np.pi * 0.125),
        (solids.rod(0 * Z, np.array([1.0, 2.0, 2.0]), 0.1), np.pi * 0.01 * 3),
        (solids.box((1, 2, 3)), 6.0),
        (solids.bar(2.0, 0.1, 0.05), (0.4 + np.pi * 0.01) * 0.05),
        (solids.ring(1.0, 0.1), 2 * np.pi**2 * 0.01),
        (solids.cone(0.3, 0.0, 0.0, 1.0), np.pi * 0.03),
        (solids.plate(np.array([(0, 0), (1, 0), (0, 1)]), 0.0, 0.5), 0.25),
        (solids.hull(np.array(np.meshgrid([0, 1], [0, 2], [0, 3])).reshape(3, -1).T.astype(float)), 6.0),
    ],
    ids=["ball", "rod", "box", "bar", "ring", "cone", "plate", "hull"],
)
def test_volumes(mesh: meshes.Mesh, expected: float) -> None:
    assert volume(mesh) == pytest.approx(expected, rel=0.12)
    assert volume(mesh.moved(np.array([3.0, -2.0, 5.0]))) == pytest.approx(volume(mesh), rel=1e-6)


@pytest.mark.parametrize("make", [lambda: solids.coil(1.0, 0.2, 0.02), lambda: solids.spiral(0.1, 0.4, 0.02)])
def test_springs_look_outwards(make: object) -> None:
    assert callable(make)
    assert volume(make()) > 0


def test_normals_point_away_from_a_ball() -> None:
    mesh = solids.ball(2.0)
    assert np.einsum("ij,ij->i", meshes.normals(mesh), mesh.vertices) == pytest.approx(2.0, rel=0.03)


def test_a_mirrored_mesh_still_looks_outwards() -> None:
    assert volume(solids.box((1, 2, 3)).stretched((1, -1, 2))) == pytest.approx(12.0)


def test_points_of_a_plane_have_no_hull() -> None:
    assert solids.hull(np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0.0)])) is None


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_every_example_can_be_drawn(file: Path) -> None:
    model = sr.load(file)
    drawn = sketch(model)
    names = {part.name for part in drawn.parts} | {span.name for span in drawn.spans}
    assert {body.name for body in model.bodies} <= names
    assert all(np.isfinite(part.mesh.vertices).all() for part in (*drawn.parts, *drawn.spans))
    reach = max(abs(part.mesh.vertices).max() for part in drawn.parts if part.kind == "body")
    assert reach < 3 * drawn.size
