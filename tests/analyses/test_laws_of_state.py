"""Features of laws over a place, a length or an angle are not passed over in a calm motion."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus import model
from sarrus.analyses.dynamics.inputs.laws_of_state import StateLaws
from sarrus.analyses.dynamics.time_loop import feature_steps, time_loop
from sarrus.elements import Element, Force, Single
from sarrus.elements.element import Scalar
from sarrus.functions import exp
from sarrus.model.primitive import Primitive

METHODS = (sr.Radau(), sr.HHT(), sr.HHT(stabilized=True), sr.GeneralizedAlpha(), sr.ODE())
SPEED, RADIUS, K, M = 10.0, 0.3, 2e5, 20.0


def wheel(road: Any) -> sr.System:
    """A wheel that rolls at rest on its tyre, without a vibration, until the road changes."""
    height = RADIUS - M * 9.81 / K
    body = sr.Body("wheel", mass=M, inertia=(1, 1, 1), position=(0, 0, height), velocity=(SPEED, 0, 0))
    tyre = sr.RoadTyre("tyre", body.point(0, 0, 0), k=K, c=2e3, radius=RADIUS, road=road)
    return sr.System(sr.Model("wheel", [body], forces=[tyre], gravity=(0, 0, -9.81)))


def bell(width: float, height: float = 0.005) -> str:
    return f"{height}*exp(-((x - 30)/{width})^2)"


def points(width: float) -> dict[str, Any]:
    """A road of few points, the bump between two of them."""
    return {"table": [[0, 0], [29, 0], [30 - width, 0], [30, 0.005], [30 + width, 0], [31, 0], [60, 0]]}


def heights(system: sr.System, **given: Any) -> np.ndarray:
    run = sr.simulate(system, until=3.3, t_eval=np.linspace(2.7, 3.3, 601), **given)
    assert run.success, run.message
    return np.asarray(run["wheel"].position[:, 2])


@pytest.mark.filterwarnings("ignore:.*spline through the table")  # it overshoots between few points
@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", METHODS, ids=str)
@pytest.mark.parametrize("road", [bell(0.5), bell(0.05), points(0.5), points(0.05)], ids=str)
def test_a_bump_after_a_calm(road: Any, method: Any) -> None:
    given = {} if isinstance(method, sr.Radau) else {"rtol": 1e-8}
    system = wheel(road if isinstance(road, str) else road["table"])
    wanted = heights(system, max_step=1e-3)
    assert np.ptp(wanted) > 4e-3
    assert heights(system, method=method, **given) == pytest.approx(wanted, rel=0, abs=0.02 * np.ptp(wanted))


@pytest.mark.filterwarnings(
    "ignore:.*the total energy grew"
)  # the energy stored is a quadrature that sees no narrow law
def test_a_detent_of_a_hinge_and_a_catch_of_a_spring() -> None:
    """Laws κ over an angle and a length, forces κ x: in passing they take ∫ κ x dx from the motion."""
    narrow = "200*(x - 20)*exp(-((x - 20)/0.02)^2)"
    work = 200 * 0.02**3 * np.sqrt(np.pi) / 2
    disc = sr.Body("disc", mass=1, inertia=(1, 1, 1), angular_velocity=(0, 0, 5.0))
    pin = sr.Revolute("pin", sr.ground, disc, point=(0, 0, 0), axis=(0, 0, 1))
    detent = sr.RSDA("detent", sr.ground, disc, point=(0, 0, 0), axis=(0, 0, 1), k=narrow)
    turned = sr.simulate(sr.System(sr.Model("disc", [disc], [pin], [detent])), until=8.0)
    assert turned["disc"].angular_velocity_global[-1, 2] == pytest.approx(np.sqrt(25 - 2 * work), abs=1e-7)
    rod = sr.Body("rod", mass=1, inertia=(1, 1, 1), position=(1, 0, 0), velocity=(5.0, 0, 0))
    catch = sr.TSDA("catch", sr.ground.point(0, 0, 0), rod.point(0, 0, 0), k=narrow, c=0, length=0)
    pulled = sr.simulate(sr.System(sr.Model("rod", [rod], forces=[catch])), until=8.0)
    assert pulled["rod"].velocity[-1, 0] == pytest.approx(np.sqrt(25 - 2 * work), abs=1e-7)


def test_fields_in_the_formula_of_a_force() -> None:
    """A mass at 1 m/s passes a smooth field over its place, a detent over the displacement, and one over both."""
    field = "F*exp(-((mass.x - 3)/w)^2)"
    detent = "F*(step(x, 5, 0, 5 + w, 1) - step(x, 5 + w, 0, 5 + 2*w, 1))"
    both = "F*exp(-((mass.x - 8)/w)^2)*exp(-((x - mass.x)/w)^2)"
    mass = sr.Body("mass", mass=2.0, inertia=(0.01, 0.01, 0.01), velocity=(1, 0, 0))
    guide = sr.Translational("guide", sr.ground, mass, point=(0, 0, 0), axis=(1, 0, 0))
    given = {"F": 3.0, "w": 0.02}
    force = sr.Force("field", joint="guide", value=f"{field} + {detent} + {both}", parameters=given)
    run = sr.simulate(sr.System(sr.Model("fields", [mass], [guide], [force])), until=10.0)
    work = given["F"] * given["w"] * (2 * np.sqrt(np.pi) + 1)
    assert run["mass.velocity.x"][-1] == pytest.approx(np.sqrt(1 + work), abs=1e-6)
    assert run.nsteps < 500


@pytest.mark.parametrize("path", ["2-d", "length"])
def test_a_field_beside_the_path(path: str) -> None:
    """Its argument reverses within the step that passes it: a distance, or the exponent of a field in the plane."""
    field = "F*exp(-((mass.x - 5)^2 + mass.y^2)/w^2)" if path == "2-d" else "F*exp(-x^2/w^2)"
    mass = sr.Body("mass", mass=2.0, inertia=(0.01, 0.01, 0.01), position=(0, 0.02, 0), velocity=(1, 0, 0))
    guide = sr.Planar("guide", sr.ground, mass, point=(0, 0, 0), axis=(0, 0, 1))
    anchor, point, given = sr.ground.point(5, 0, 0), mass.point(0, 0, 0), {"F": 1.0, "w": 0.02}
    load = (
        sr.PointForce("load", point, force=(0, field, 0), parameters=given)
        if path == "2-d"
        else sr.Force("load", anchor, point, value=field, parameters=given)
    )
    system = sr.System(sr.Model("field", [mass], [guide], [load]))
    found, wanted = (
        sr.simulate(system, until=8.0, t_eval=[8.0], **more)["mass.y"][0] for more in ({}, {"max_step": 5e-3})
    )
    assert abs(wanted - 0.02) > 5e-3
    assert found == pytest.approx(wanted, abs=1e-6)


def test_two_corners_at_one_place() -> None:
    """A bump of two cubics, whose common end each of them has, with different round-off: no step ends between both."""
    bump = "0.005*(step(x, 20, 0, 20.02, 1) - step(x, 20.02, 0, 20.04, 1))"
    run = sr.simulate(wheel(bump), until=2.1, t_eval=[2.1])
    assert run.success, run.message
    assert run["wheel.z"][0] == pytest.approx(
        sr.simulate(wheel(bump), until=2.1, t_eval=[2.1], max_step=1e-3)["wheel.z"][0], abs=1e-7
    )


def test_a_road_that_varies_all_the_time() -> None:
    """A washboard after a plane: no step passes over a wave."""
    road = "1e-4*sin(30*x)*min(max(x - 20, 0), 1)"
    found, wanted = (heights(wheel(road), **given) for given in ({}, {"max_step": 1e-3}))
    assert np.ptp(wanted) > 2e-5
    assert found == pytest.approx(wanted, rel=0, abs=1e-8)


@pytest.mark.parametrize(("method", "near"), [(sr.Radau(), 1e-4), (sr.HHT(), 0.02)], ids=str)
def test_gradients_over_a_bump(method: Any, near: float) -> None:
    system = wheel(bell(0.2, 3e-4))
    run = sr.simulate(system, until=3.01, store_steps=True, method=method, rtol=1e-9)
    names = ["tyre.k", "tyre.c", "wheel.mass", "tyre.road.1"]
    direct, adjoint = (
        sr.sensitivity(run, sr.Final("wheel.z"), names, method=way).matrix for way in ("direct", "adjoint")
    )
    assert direct == pytest.approx(adjoint, rel=1e-9, abs=1e-12 * abs(adjoint).max())
    higher = [sr.simulate(wheel(bell(0.2, 3e-4 + d)), until=3.01, rtol=1e-10).q[-1, 2] for d in (1e-6, -1e-6)]
    assert adjoint[0, 3] == pytest.approx((higher[0] - higher[1]) / 2e-6, rel=near)


def test_steps_of_a_given_length_warn() -> None:
    system = wheel(bell(0.02))
    with pytest.warns(
        sr.SarrusWarning, match=r"tyre: its law varies near t = 2\.9\d* s within less than a step"
    ):
        sr.simulate(system, until=6.0, method=sr.HHT(step=0.1))


def test_what_is_kept_and_resumed_has_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Saved where the bump has been passed and where it has not."""
    monkeypatch.setattr(time_loop, "PAUSE", 0.0)
    monkeypatch.setattr(time_loop, "PATIENT", 0.0)
    monkeypatch.setattr(feature_steps, "MOST", 16)
    monkeypatch.setattr(time_loop, "CHUNK", 16)
    system, given = wheel(bell(0.2)), {"until": 6.0, "t_eval": np.linspace(0, 6, 61)}
    stretches = list[float]()
    plain = sr.simulate(system, progress=stretches.append, **given)
    for count in range(1, len(stretches), 4):
        calls = list[float]()

        def stop(t: float, calls: list[float] = calls, count: int = count) -> None:
            calls.append(t)
            if len(calls) > count:
                raise KeyboardInterrupt

        folder = tmp_path / f"run{count}"
        assert sr.simulate(system, save=folder, progress=stop, **given).status == "stopped"
        resumed = sr.resume(folder)
        assert np.array_equal(resumed.q, plain.q), count
        assert resumed.nsteps == plain.nsteps


def test_laws_that_are_examined() -> None:
    """A road over x, but neither a bump over the time nor a spring with a number."""
    assert len(StateLaws(wheel(bell(0.1))).all) == 1
    assert not StateLaws(wheel(0.0)).all


class Field(Force, bodies=1, derivatives="automatic"):
    """A field over the place, written as an element."""

    F: Scalar
    a: Scalar
    w: Scalar

    def Q(self, x: Single, v: Single, t: Any) -> Any:
        force = self.F * exp(-(((x.r[0] - self.a) / self.w) ** 2))
        return np.array([force, 0 * force, 0 * force]), None


@dataclass(frozen=True, eq=False)
class OwnField(model.Force):
    """Field on a point."""

    point: model.Point
    w: float

    def primitives(self, poses: Any) -> Any:
        point = self.point.resolve(poses, "point")
        yield Primitive(Field, (point.body,), (3.0, 3.0, self.w), "field")


# other tests see those of the package alone
del Element.registry["Field"], model.Force.kinds["own_field"]


def test_a_field_in_a_users_own_element() -> None:
    mass = sr.Body("mass", mass=2.0, inertia=(0.01, 0.01, 0.01), velocity=(1, 0, 0))
    field = OwnField("field", mass.point(0, 0, 0), 0.02)
    (law,) = StateLaws(sr.System(sr.Model("field", [mass], forces=[field]))).all
    x = np.array([2.98, 3.0, 4.0])
    assert law.law(x) == pytest.approx(3 * np.exp(-(((x - 3) / 0.02) ** 2)))


@pytest.mark.slow
def test_a_field_in_a_users_own_element_is_not_passed_over() -> None:
    mass = sr.Body("mass", mass=2.0, inertia=(0.01, 0.01, 0.01), velocity=(1, 0, 0))
    field = OwnField("field", mass.point(0, 0, 0), 0.02)
    run = sr.simulate(sr.System(sr.Model("field", [mass], forces=[field])), until=6.0)
    assert run["mass.velocity.x"][-1] == pytest.approx(np.sqrt(1 + 0.06 * np.sqrt(np.pi)), abs=1e-6)
