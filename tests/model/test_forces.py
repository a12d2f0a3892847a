"""Forces: their elements and values, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import sarrus as sr
from sarrus.functions import sin
from sarrus.model import (
    RSDA,
    TSDA,
    Body,
    Bushing,
    Curve,
    Force,
    LengthStop,
    Model,
    ModelError,
    PointForce,
    Torque,
    Tyre,
    ground,
)
from sarrus.model.expansion.blueprint import Placement, blueprint

BODY = Body("body", 1.0, (1, 1, 1), position=(0, 0, 2))
OTHER = Body(
    "other", 1.0, (1, 1, 1), position=(1, 0, 2), orientation=Rotation.from_rotvec([0, 0, 0.7]).as_matrix()
)
TOP, FOOT = BODY.point(0, 0, 1), ground.point(0, 0, 0)


def placed(force: Force) -> Placement:
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
    (TSDA("f", TOP, FOOT, k="stiff", length=1), 'k has the unknown name "stiff"'),  # type: ignore[arg-type]
    (TSDA("f", TOP, FOOT, k=1, length=1, c=np.inf), "c must be a finite number, but is inf"),
    (RSDA("f", BODY, OTHER, point=(0, 0, 0), axis=(0, 0, 0), k=1), "axis has zero length"),
    (RSDA("f", BODY, OTHER, point=(0, 0, 0), k=1), "axis is missing"),
    (
        RSDA("f", BODY, OTHER, point=(0, 0, 0), axis=(0, 0, 1), k=1, angle=np.nan),
        "angle must be a finite number",
    ),
    (PointForce("f", FOOT, (0, 0, 1)), "acts on the ground, which does not move. Name a body"),
    (PointForce("f", TOP, (0, 1)), "force must have 3 numbers, but has 2"),
    (PointForce("f", TOP, (0, 0, 1), axes="local"), 'axes must be "global" or "body"'),  # type: ignore[arg-type]
    (Torque("f", ground, (0, 0, 1)), "acts on the ground"),
    (Torque("f", Body("bodi", 1, (1, 1, 1)), (0, 0, 1)), 'no body "bodi". Did you mean "body"?'),
    (Tyre("f", TOP, k=1, c=1, radius=-1), "radius must be greater than 0"),
    (Tyre("f", FOOT, k=1, c=1, radius=1), "acts on the ground"),
    (PointForce("f", TOP, (0, [[0, 0], [0, 1]], 1)), "force must have rising x, but 0.0 follows 0.0"),
    (PointForce("f", TOP, (0, 0, 1), factor="2*x"), 'factor has the unknown name "x"'),  # type: ignore[arg-type]
    (Bushing("f", BODY, OTHER, (0, 0, 0), stiffness=(1, 2)), "stiffness must have 6 numbers, but has 2"),
]


@pytest.mark.parametrize(("force", "phrase"), WRONG, ids=range(len(WRONG)))
def test_a_wrong_force_is_refused_by_name(force: Force, phrase: str) -> None:
    with pytest.raises(ModelError) as caught:
        placed(force)
    assert str(caught.value).startswith('force "f": ')
    assert phrase in str(caught.value)


def test_laws_by_table_or_function_make_the_rsda_nonlinear() -> None:
    about = {"body_i": BODY, "body_j": OTHER, "point": (0, 0, 0), "axis": (0, 0, 2)}
    one = placed(RSDA("coil", **about, k=lambda angle: 3 + angle * angle, c=2.0, torque=[[0, 0], [1, 5]]))  # type: ignore[arg-type]
    assert one.element.__name__ == "NonlinearRSDA"
    assert one.values[5:9] == (1.0, 2.0, 0.0, 1.0)
    assert [curve(0.5) for curve in one.values[9:12]] == pytest.approx([3.25, 1.0, 2.5])
    assert len(one.values) == len(one.element.fields)


def test_loads_that_vary() -> None:
    made = [
        placed(PointForce("load", TOP, (1, [[0, 0], [1, 2]], 3), factor=2.0)),
        placed(PointForce("load", TOP, (1, 2, 3), factor=lambda t: t * t, axes="body")),
        placed(Torque("load", BODY, (1, 2, 3), factor=3)),
        placed(Torque("load", BODY, (1, 2, 3), factor=[[0, 0], [1, 2]])),
        placed(Torque("load", BODY, (1, 2, lambda t: t), axes="body")),
    ]
    assert [(one.element.__name__, one.values[-1 if len(one.values) == 1 else -4]) for one in made] == [
        ("VaryingForce", (2.0, 2.0, 6.0)),
        ("VaryingFollowerForce", (1, 2, 3)),
        ("Torque", (3, 6, 9)),
        ("VaryingTorque", (1, 2, 3)),
        ("VaryingBodyTorque", (1, 2, 1)),
    ]
    assert [[curve(0.5) for curve in made[n].values[-3:]] for n in (0, 1, 3, 4)] == [
        [1.0, 1.0, 1.0], [0.25] * 3, [1.0] * 3, [1.0, 1.0, 0.5],
    ]  # fmt: skip


def test_a_bushing_takes_a_diagonal_or_rows() -> None:
    rows = np.arange(36.0).reshape(6, 6) + 100 * np.eye(6)
    one = placed(Bushing("mount", BODY, OTHER, (0, 0, 0), stiffness=rows, damping=range(6)))
    assert one.values[7] == tuple(rows.flat)
    assert np.array_equal(np.reshape(one.values[8], (6, 6)), np.diag(range(6)))
    assert one.values[9] == (0.0,) * 6
    assert one.values[1:4] == ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def test_stops_are_one_element_for_each_limit() -> None:
    stop = LengthStop("rope", TOP, FOOT, lower=1, upper=2, stiffness=9)
    plan = blueprint(Model("m", [BODY, OTHER], forces=[stop])).placed[-2:]
    assert [(one.label, one.values[2:]) for one in plan] == [
        ("lower", (1, -1, 9, 1, 0, 1e-4)),
        ("upper", (2, 1, 9, 1, 0, 1e-4)),
    ]


@pytest.mark.parametrize(
    "given",
    [{"k": 0, "force": "10*length - rate"}, {"k": "length"}, {"k": 1, "c": lambda length, rate, t: rate}],
)
def test_a_law_of_several_variables_is_refused_with_the_force_that_takes_it(given: dict[str, Any]) -> None:
    with pytest.raises(ModelError, match=r"or use sr\.Force for a formula of length, rate and t\."):
        placed(TSDA("f", TOP, FOOT, length=1, **given))


def test_a_formula_that_branches_is_refused() -> None:
    spring = TSDA("f", TOP, FOOT, k=lambda l: 1.0 if l > 2 else 2.0, length=1)
    with pytest.raises(
        ModelError, match='force "f": k cannot be used as a formula: a formula must not branch'
    ):
        placed(spring)


AIR = "0.01 + 0.002*tanh((x - 12)/3)"


def in_the_air(c: Any) -> sr.System:
    """A ball in the wind."""
    ball = sr.Body("ball", mass=0.5, inertia=(1, 1, 1), velocity=(20, 0, 0))
    air = sr.Drag("air", ball.point(0, 0, 0), c=c, wind=(1, 0, 0))
    return sr.System(sr.Model("ball", [ball], forces=[air], gravity=(0, 0, -9.81)))


def test_drag_whose_coefficient_depends_on_the_speed() -> None:
    def rates(t: float, y: Any) -> Any:
        u = y[2:] - (1, 0)
        speed = np.sqrt(u @ u + 1e-6)
        return *y[2:], *(-(0.01 + 0.002 * np.tanh((speed - 12) / 3)) * speed * u / 0.5 + (0, -9.81))

    run = sr.simulate(in_the_air(AIR), until=1.0, store="steps")
    exact = solve_ivp(rates, (0, 1), (0, 0, 20, 0), rtol=1e-11, atol=1e-12).y[:2, -1]
    assert run["ball"].position[-1, [0, 2]] == pytest.approx(exact, abs=1e-8)
    balance = run.energy_balance()
    assert abs(balance.total - balance.total[0]).max() < 1e-6
    assert balance.dissipated["air"][-1] > 50
    assert run.system.check_derivatives()
    slope = sr.sensitivity(run, "ball.x", ["air.c.1"])["air.c.1"]
    low, high = (
        sr.simulate(in_the_air(f"{c} + 0.002*tanh((x - 12)/3)"), until=1.0)["ball.x"][-1]
        for c in (0.00999, 0.01001)
    )
    assert slope == pytest.approx((high - low) / 2e-5, rel=1e-6)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("c", ["10 g/m", lambda v: 0.01 + 0 * v, [[0, 0.01], [10, 0.01], [30, 0.01]]])
def test_a_law_that_is_constant_is_the_constant(c: Any) -> None:
    given, constant = (sr.simulate(in_the_air(one), until=0.2) for one in (c, 0.01))
    for name in ("ball.x", "air.speed", "air.dissipated_power", "air.supplied_power", "air.force.x"):
        assert given[name] == pytest.approx(constant[name], rel=1e-12), name


def test_one_function_returns_all_components() -> None:
    body = sr.Body("body", mass=2, inertia=(1, 1, 1))

    def end(load: Any, turn: Any = (0, 0, 0)) -> Any:
        loads = [sr.PointForce("push", body.point(0, 0, 0), load), sr.Torque("turn", body, turn)]
        run = sr.simulate(sr.System(sr.Model("body", [body], forces=loads)), until=0.5)
        return run["body.y"][-1], run["body.angular_velocity.z"][-1]

    assert end(lambda t: (0, 5 * sin(t), 1), lambda t: (0, 0, t)) == end((0, "5*sin(t)", 1), (0, 0, "t"))
    assert end(lambda o: (0, 1 - 2 * o["body.y"], 0)) == pytest.approx(end((0, "1 - 2*body.y", 0)), rel=1e-14)
    with pytest.raises(sr.ModelError, match=r'"push": force .* returns 1 of three components\. Return all'):
        end(lambda t: 5 * sin(t))
