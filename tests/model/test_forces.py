"""Forces: their elements and values, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sarrus.model import (
    RSDA,
    TSDA,
    Body,
    Curve,
    Force,
    Model,
    ModelError,
    Placed,
    PointForce,
    Torque,
    Tyre,
    blueprint,
    ground,
)

BODY = Body("body", 1.0, (1, 1, 1), position=(0, 0, 2))
OTHER = Body(
    "other", 1.0, (1, 1, 1), position=(1, 0, 2), orientation=Rotation.from_rotvec([0, 0, 0.7]).as_matrix()
)
TOP, FOOT = BODY.point(0, 0, 1), ground.point(0, 0, 0)


def placed(force: Force) -> Placed:
    """Return what a single force becomes."""
    return blueprint(Model("m", [BODY, OTHER], forces=[force])).placed[-1]


def test_a_linear_tsda() -> None:
    one = placed(TSDA("spring", TOP, FOOT, k=10, length=5, c=1, force=3))
    assert one.element.__name__ == "TSDA"
    assert one[1:] == ((1, 0), ((0, 0, 1), (0, 0, 0), 10, 1, 5, 3), "spring", "tsda")


@pytest.mark.parametrize("field", ["k", "c", "force"])
def test_a_curve_in_any_place_makes_the_tsda_nonlinear(field: str) -> None:
    table = Curve.table([(0, 1), (1, 3), (2, 4)])
    laws: dict[str, object] = {"k": 10.0, "c": 2.0, "force": 3.0} | {field: table}
    one = placed(TSDA("spring", TOP, FOOT, length=5, **laws))  # type: ignore[arg-type]
    assert one.element.__name__ == "NonlinearTSDA"
    factors = dict(zip(("k", "c", "length", "force"), one.values[2:6]))
    curves = dict(zip(("k", "c", "force"), one.values[6:]))
    assert curves.pop(field) is table
    assert factors == {"k": 10.0, "c": 2.0, "length": 5.0, "force": 3.0} | {field: 1.0}
    assert all(curve(0.3) == 1.0 for curve in curves.values())
    assert list(one.element.fields.values())[6:] == ["Curve"] * 3


def test_an_rsda_about_a_global_axis_starts_at_zero() -> None:
    one = placed(RSDA("coil", BODY, OTHER, point=(0, 0, 0), axis=(0, 0, 2), k=7, c=1, angle=0.2, torque=3))
    f_i, g_i, h_i, f_j, h_j, *rest = one.values
    assert rest == pytest.approx([7, 1, 0.2, 3, 0], abs=1e-15)
    assert one.bodies == (1, 2)
    assert len(one.values) == len(one.element.fields)
    np.testing.assert_allclose(np.cross(f_i, g_i), h_i)
    np.testing.assert_allclose([h_i, h_j], [(0, 0, 1)] * 2, atol=1e-15)
    np.testing.assert_allclose(Rotation.from_rotvec([0, 0, 0.7]).apply(f_j), f_i, atol=1e-15)


def test_an_rsda_between_frames_starts_at_the_angle_between_them() -> None:
    coil = RSDA("coil", k=1.0, frame_i=BODY.frame((0, 0, 0)), frame_j=OTHER.frame((0, 0, 0)))
    assert abs(placed(coil).values[-1] - 0.7) < 1e-15


def test_forces_and_torques_in_global_and_in_body_axes() -> None:
    made = [
        placed(PointForce("load", TOP, (1, 2, 3))),
        placed(PointForce("load", TOP, (1, 2, 3), axes="body")),
        placed(Torque("load", BODY, (1, 2, 3))),
        placed(Torque("load", OTHER, (1, 2, 3), axes="body")),
    ]
    assert [(one.element.__name__, one.bodies, one.values) for one in made] == [
        ("PointForce", (1,), ((0, 0, 1), (1, 2, 3))),
        ("FollowerForce", (1,), ((0, 0, 1), (1, 2, 3))),
        ("Torque", (1,), ((1, 2, 3),)),
        ("BodyTorque", (2,), ((1, 2, 3),)),
    ]


def test_a_tyre() -> None:
    one = placed(Tyre("tyre", TOP, k=1e5, c=100, radius=0.5, road=0.1))
    assert one.element.__name__ == "Tyre"
    assert one.values == ((0, 0, 1), 1e5, 100, 0.5, 0.1)
    assert list(one.element.fields) == ["s", "k", "c", "radius", "road"]


WRONG: list[tuple[Force, str]] = [
    (TSDA("f", TOP, ground.point(0, 0, 3), k=1, length=1), "has zero length, its two points coincide"),
    (TSDA("f", TOP, BODY.point(0, 0, 3), k=1, length=1), 'connects "body" to itself'),
    (TSDA("f", TOP, FOOT, k=1, length=-1), "length must not be negative"),
    (TSDA("f", TOP, FOOT, k=np.nan, length=1), "k must be a finite number, but is nan"),
    (TSDA("f", TOP, FOOT, k="1", length=1), 'k must be a number, but is "1"'),  # type: ignore[arg-type]
    (TSDA("f", TOP, FOOT, k=1, length=1, c=np.inf), "c must be a finite number, but is inf"),
    (RSDA("f", BODY, OTHER, point=(0, 0, 0), axis=(0, 0, 0), k=1), "axis has zero length"),
    (RSDA("f", BODY, OTHER, point=(0, 0, 0), k=1), "axis is missing"),
    (
        RSDA("f", BODY, OTHER, point=(0, 0, 0), axis=(0, 0, 1), k=1, angle=np.nan),
        "angle must be a finite number",
    ),
    (PointForce("f", FOOT, (0, 0, 1)), "acts on the ground, which does not move; name a body"),
    (PointForce("f", TOP, (0, 1)), "force must have 3 numbers, but has 2"),
    (PointForce("f", TOP, (0, 0, 1), axes="local"), 'axes must be "global" or "body"'),  # type: ignore[arg-type]
    (Torque("f", ground, (0, 0, 1)), "acts on the ground"),
    (Torque("f", Body("bodi", 1, (1, 1, 1)), (0, 0, 1)), 'no body "bodi"; did you mean "body"?'),
    (Tyre("f", TOP, k=1, c=1, radius=-1), "radius must be greater than 0"),
    (Tyre("f", FOOT, k=1, c=1, radius=1), "acts on the ground"),
]


@pytest.mark.parametrize(("force", "phrase"), WRONG, ids=range(len(WRONG)))
def test_a_wrong_force_is_refused_by_name(force: Force, phrase: str) -> None:
    with pytest.raises(ModelError) as caught:
        placed(force)
    assert str(caught.value).startswith('force "f": ')
    assert phrase in str(caught.value)
