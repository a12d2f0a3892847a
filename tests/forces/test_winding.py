"""Paths around and through spheres and cylinders: lengths against MuJoCo's, directions against complex steps."""

from typing import Any

import numpy as np
import pytest

from sarrus.model.forces.paths.winding import Corner, Way

RADIUS = 0.3
WAYS = {"shorter": 0.0, "side": 2.0, "through": 0.5}  # distance of the side from the centre, over the radius


def path(p: Any, q: Any, side: Any, way: str, axis: Any = None) -> Way:
    corner = Corner.of(p, q, RADIUS, axis)
    return corner.through() if way == "through" else corner.around(side if way == "side" else None)


def ends(number: int, seed: int = 1) -> Any:
    """Points in all positions: in the circle, near it and far from it."""
    rng = np.random.default_rng(seed)
    for _ in range(number):
        side = rng.normal(size=3)
        yield *(rng.normal(size=3) * rng.choice([0.2, 0.4, 1]) for _ in range(2)), side / np.linalg.norm(side)


FILE = """<mujoco><worldbody><site name="s" pos="1 2 3" euler="1 2 3"/><geom name="g" type="{}" size="0.3 1"/>
<body><freejoint/><geom size="1"/><site name="a"/></body><body><freejoint/><geom size="1"/><site name="b"/></body>
</worldbody><tendon><spatial><site site="a"/><geom geom="g"{}/><site site="b"/></spatial></tendon></mujoco>"""


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_lengths_are_those_of_mujoco(shape: str, way: str) -> None:
    mujoco: Any = pytest.importorskip("mujoco", "4.0")  # before, sites at the side had another meaning
    model = mujoco.MjModel.from_xml_string(FILE.format(shape, ' sidesite="s"' if WAYS[way] else ""))
    data, touching, flat = mujoco.MjData(model), 0, np.array([1, 1, int(shape == "sphere")])
    for p, q, direction in ends(500):
        side = WAYS[way] * RADIUS * direction
        model.site("s").pos[:] = side
        data.qpos[:3], data.qpos[7:10] = p, q
        mujoco.mj_forward(model, data)
        rise = (q - p) * (1 - flat)
        for axis in [None] if shape == "sphere" else [None, np.eye(3)[2], -np.eye(3)[2]]:
            flat_length = path(p * flat, q * flat, side * flat, way, axis).length
            found = np.hypot(flat_length, np.linalg.norm(rise))
            assert found == pytest.approx(data.ten_length[0], abs=1e-11)
        touching += data.ten_wrapnum[0] > 2
    assert 50 < touching < 450


@pytest.mark.parametrize("way", WAYS)
def test_directions_are_derivatives_of_the_length(way: str) -> None:
    for p, q, side in ends(100):
        found = path(p, q, side, way)
        for n in range(3):
            step = 1e-200j * np.eye(3)[n]
            assert path(p + step, q, side, way).length.imag / 1e-200 == pytest.approx(
                -found.first[n], abs=1e-10
            )
            assert path(p, q + step, side, way).length.imag / 1e-200 == pytest.approx(
                found.last[n], abs=1e-10
            )


@pytest.mark.parametrize("sense", [1, -1])
def test_opposite_points_of_a_cylinder_have_a_path_in_its_plane(sense: int) -> None:
    """Both ways are equally long; the side chooses one, along which the length is smooth."""
    p, q, axis, side = 0.5 * np.eye(3)[0], -0.8 * np.eye(3)[0], sense * np.eye(3)[2], np.array([0, 1.0, 0])
    found = path(p, q, side, "side", axis)
    tangents = [np.sqrt(d * d - RADIUS**2) for d in (0.5, 0.8)]
    turn = np.pi - np.arccos(RADIUS / 0.5) - np.arccos(RADIUS / 0.8)
    assert found.length == pytest.approx(sum(tangents) + RADIUS * turn)
    np.testing.assert_allclose(found.first, [-tangents[0] / 0.5, RADIUS / 0.5, 0], atol=1e-12)
    np.testing.assert_allclose(found.last, [-tangents[1] / 0.8, -RADIUS / 0.8, 0], atol=1e-12)
    step = 1e-200j * np.eye(3)[1]
    assert path(p + step, q, side, "side", axis).length.imag / 1e-200 == pytest.approx(-found.first[1])
