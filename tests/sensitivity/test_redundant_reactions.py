"""Derivatives of reactions where constraints are redundant: those of the minimum-norm forces that runs report.

What they are compared with is made without them: central differences of `run.reaction` over whole simulations.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from tests.analyses.least_reactions import least
from tests.analyses.linkages import door, hinge, rod
from tests.sensitivity.checkpoints import by_checkpoints
from tests.sensitivity.frozen import differenced, solved

import sarrus as sr
from sarrus.analyses.sensitivity import long_run
from sarrus.model.written import with_numbers

EXAMPLES = Path(__file__).parents[2] / "examples"
PRECISE = {"method": sr.Radau(rtol=1e-11, atol=1e-12)}
UNTIL, BETWEEN = 0.4, 0.173


class Subject(NamedTuple):
    """A redundant mechanism, the joints asked for, and what is changed: variables, and what follows from them."""

    system: sr.System
    joints: tuple[str, ...]
    design: Mapping[str, float]
    formula: Callable[[Mapping[str, float]], Mapping[str, object]]


def hung_door() -> Subject:
    def numbers(d):
        return {
            "panel.mass": d["mass"],
            "panel.inertia.zz": d["moment"],
            "gravity.y": d["pull"],
            "hinge_1.point.z": d["low"],
        }

    design = {"mass": 20.0, "moment": 2.5, "pull": 1.0, "low": 0.2}
    return Subject(door(), ("hinge_1", "hinge_2"), design, numbers)


def doubled_joints() -> Subject:
    """A double pendulum, all of whose joints are there twice."""
    ends = np.array([0.0, 0, 0]), np.array([1.0, -0.2, 0.1]), np.array([1.6, 0.5, 0.2])
    one, two = rod("one", *ends[:2]), rod("two", *ends[1:])
    axis = np.array([0.1, 0.0, 1.0])
    joints = [
        hinge(f"{name}{k}", i, j, at, axis)
        for name, i, j, at in (("pin", sr.ground, one, ends[0]), ("elbow", one, two, ends[1]))
        for k in (1, 2)
    ]
    model = sr.Model("doubled", [one, two], joints, gravity=(0, -9.81, 0.5))
    design = {"mass": 1.0, "other": 1.5, "weight": -9.81}

    def numbers(d):
        return {"two.mass": d["mass"], "one.mass": d["other"], "gravity.y": d["weight"]}

    return Subject(sr.System(model), ("pin1", "elbow2"), design, numbers)


def bricard() -> Subject:
    design = {"mass": 1.0, "weight": -9.81}

    def numbers(d):
        return {"rod_2.mass": d["mass"], "gravity.y": d["weight"]}

    return Subject(sr.System(sr.load(EXAMPLES / "bricard.yaml")), ("hinge_1", "hinge_4"), design, numbers)


def parallel_cranks() -> Subject:
    """A coupler on three equal cranks, one more than it needs, and a spring."""
    turned = np.array([np.sin(0.7), np.cos(0.7), 0.0])
    feet = [np.array([x, 0.0, 0.0]) for x in (0.0, 1.0, 2.5)]
    cranks = [rod(f"crank_{n}", foot, foot + turned) for n, foot in enumerate(feet)]
    coupler = rod("coupler", feet[0] + turned, feet[2] + turned, mass=2.0)
    axis = np.array([0.0, 0.0, 1.0])
    joints = [hinge(f"foot_{n}", sr.ground, c, feet[n], axis) for n, c in enumerate(cranks)]
    joints += [hinge(f"head_{n}", c, coupler, feet[n] + turned, axis) for n, c in enumerate(cranks)]
    spring = sr.TSDA(
        "spring", sr.ground.point(3, 1, 0.2), coupler.point(0.3, 0, 0), k=30.0, c=1.0, length=0.5
    )
    model = sr.Model("parallel cranks", [*cranks, coupler], joints, [spring], gravity=(0, -9.81, 0))
    design = {"mass": 2.0, "k": 30.0, "middle": 1.0}

    def numbers(d):
        return {"coupler.mass": d["mass"], "spring.k": d["k"], "crank_1.mass": d["middle"]}

    return Subject(sr.System(model), ("foot_1", "head_2"), design, numbers)


SUBJECTS = {f.__name__: f for f in (hung_door, doubled_joints, bricard, parallel_cranks)}


@cache
def subject(name: str) -> Subject:
    one = SUBJECTS[name]()
    return one._replace(system=sr.System(with_numbers(one.system.model, one.formula(one.design))))


def responses(joints: tuple[str, ...]) -> list[object]:
    finals = [sr.Final(f"{j}.{kind}.{x}") for j in joints for kind in ("force", "torque") for x in "xyz"]
    between = [sr.At(f"{j}.{kind}.y", time=BETWEEN) for j in joints for kind in ("force", "torque")]
    return [*finals, *between, *(sr.Final(f"{j}.multiplier.2") for j in joints)]


def reported(run: sr.Trajectory, joints: tuple[str, ...]) -> np.ndarray:
    """What the run says of the same."""
    found = {joint: run.reaction(joint) for joint in joints}
    finals = [getattr(found[j], kind)[-1] for j in joints for kind in ("force", "torque")]
    between = [getattr(found[j], kind)[1, 1] for j in joints for kind in ("force", "torque")]
    return np.concatenate([*finals, between, [run.lam[-1, run.system.rows[j][1]] for j in joints]])


def forces(one: Subject, change: Mapping[str, float]) -> np.ndarray:
    """The reported forces of a simulation with other values of the design."""
    design = {name: x + change.get(name, 0.0) for name, x in one.design.items()}
    system = sr.System(with_numbers(one.system.model, one.formula(design)))
    return reported(sr.simulate(system, until=UNTIL, t_eval=[0.0, BETWEEN, UNTIL], **PRECISE), one.joints)


def kept(one: Subject, **settings: object) -> sr.Trajectory:
    run = sr.simulate(
        one.system, until=UNTIL, t_eval=[0.0, BETWEEN, UNTIL], store="steps", **PRECISE | settings
    )
    assert run.steps.left_out.any()
    return run


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", SUBJECTS)
def test_values_and_derivatives_are_those_of_reported_forces(name: str) -> None:
    one = subject(name)
    run, told = kept(one), responses(one.joints)
    design = {"design": one.design, "formula": one.formula}
    found = sr.sensitivity(run, told, **design)
    scale = abs(found.values).max()
    assert abs(found.values - reported(run, one.joints)).max() < 1e-7 * scale
    direct = sr.sensitivity(run, told, method="direct", **design)
    assert abs(direct.matrix - found.matrix).max() < 1e-9 * abs(found.matrix).max()
    for column, (variable, at) in enumerate(one.design.items()):
        e = 2e-3 * max(abs(at), 0.1)
        coarse, fine = (
            (forces(one, {variable: d}) - forces(one, {variable: -d})) / (2 * d) for d in (e, e / 2)
        )
        wanted = (4 * fine - coarse) / 3
        assert abs(found.matrix[:, column] - wanted).max() < 1e-6 * abs(wanted).max(), variable


def test_reported_multipliers_have_the_least_norm() -> None:
    one = subject("parallel_cranks")
    run = kept(one)
    for t, q, lam in zip(run.t, run.q, run.lam, strict=True):
        assert least(one.system, q, one.system.Phi_qT_lam(q, lam, t), t) == pytest.approx(lam, abs=1e-8)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*its derivatives")  # of reactions by methods of order two
@pytest.mark.parametrize("method", [sr.HHT(), sr.GeneralizedAlpha(), sr.Radau()])
def test_every_method_by_its_own_steps(method: object, monkeypatch: pytest.MonkeyPatch) -> None:
    """Frozen steps with other numbers, the adjoint, the direct way and checkpoints agree; integrals, peaks, misfits."""
    monkeypatch.setattr(long_run, "FIRST", 9)
    one = subject("parallel_cranks")
    settings = {"method": replace(method, rtol=1e-5, atol=1e-7)}
    run = kept(one, **settings)
    told = [
        sr.Final("foot_1.force.y"),
        sr.Integral(lambda o: o("foot_1.force.x") ** 2, name="squared"),
        sr.Maximum("head_2.force.y"),
        sr.Misfit("foot_1.force.y", at=(0.1, 0.25), data=(1.0, 2.0)),
        sr.Final("coupler.x"),
    ]
    names = ["coupler.mass", "spring.k"]
    found = sr.sensitivity(run, told, names)
    scale = abs(found.matrix).max(axis=1)
    direct = sr.sensitivity(run, told, names, method="direct")
    assert np.all(abs(direct.matrix - found.matrix).T < 1e-8 * scale)
    some = by_checkpoints(one.system, told, names, until=UNTIL, **settings)
    assert np.all(abs(some.matrix - found.matrix).T < 1e-8 * scale)
    exact = sr.sensitivity(solved(run, method), told, names)
    for name, size in (("coupler.mass", 3e-2), ("spring.k", 0.3)):
        wanted = differenced(run, told, name, size, method)
        assert np.all(abs(exact[name] - wanted) < 1e-6 * scale), name


def test_derivatives_of_all_states_have_those_of_reported_multipliers() -> None:
    one = subject("doubled_joints")
    run = kept(one)
    found = sr.state_derivatives(run, ["mass"], design=one.design, formula=one.formula).lam_b[-1, :, 0]

    def lam(change: float) -> np.ndarray:
        system = sr.System(
            with_numbers(one.system.model, one.formula(dict(one.design) | {"mass": 1 + change}))
        )
        return sr.simulate(system, until=UNTIL, t_eval=[UNTIL], **PRECISE).lam[-1]

    wanted = (lam(1e-3) - lam(-1e-3)) / 2e-3
    assert abs(found - wanted).max() < 1e-6 * abs(wanted).max()


def test_reactions_after_an_impact() -> None:
    """An event moves the nodes behind it."""
    one = subject("hung_door")
    stop = sr.Event("hinge_1.angle - 0.05", direction=1, reset=sr.Impact(0.6), name="stop")
    settings = PRECISE | {"until": 0.5, "t_eval": [0.5], "events": stop}
    run = sr.simulate(one.system, store="steps", **settings)
    assert len(run.events) == 1
    told, names = [sr.Final(f"hinge_2.force.{x}") for x in "xyz"], ["gravity.y", "panel.mass"]
    found = sr.sensitivity(run, told, names)
    direct = sr.sensitivity(run, told, names, method="direct")
    assert direct.matrix == pytest.approx(found.matrix, abs=1e-9 * abs(found.matrix).max())

    def at_end(name: str, value: float) -> np.ndarray:
        system = sr.System(with_numbers(one.system.model, {name: value}))
        return sr.simulate(system, **settings).reaction("hinge_2").force[-1]

    for name, at, e in (("gravity.y", 1.0, 1e-3), ("panel.mass", 20.0, 1e-2)):
        wanted = (at_end(name, at + e) - at_end(name, at - e)) / (2 * e)
        assert found[name] == pytest.approx(wanted, abs=2e-6 * abs(found.matrix).max())


def test_hessians_of_reactions_are_refused() -> None:
    """Others are not, beside the same constraints."""
    one = subject("hung_door")
    run = kept(one)
    for response in ("hinge_2.force.x", sr.Integral(lambda o: o("hinge_1.force.y") ** 2)):
        with pytest.raises(sr.SarrusError, match="redundant constraints have no second derivatives"):
            sr.hessian(run, response, ["panel.mass", "gravity.y"])
    found = sr.hessian(run, "hinge_1.angle", ["panel.mass", "gravity.y"])
    assert found.asymmetry < 1e-9


def test_the_search_of_a_fit_has_the_same_derivatives() -> None:
    """Signals and their derivatives by one sweep forwards, at times between the nodes."""
    one = subject("hung_door")
    misfit = sr.Misfit("hinge_1.force.x", at=(0.1, 0.3), data=(0.0, 0.0))
    wrt = ["panel.mass", "gravity.y"]
    problem = sr.Problem(one.system, misfit, wrt, until=UNTIL, method=sr.Radau(rtol=1e-8, atol=1e-10))
    point = problem.at(problem.x0)
    (signal,), (slopes,) = point.signals()
    assert slopes.T @ signal == pytest.approx(point.slopes[0], rel=1e-9)


def test_studies_uncertainties_and_problems_have_the_same_value() -> None:
    """The force on a hinge of a door, from every analysis of a simulation."""
    one = subject("hung_door")
    name, until = "hinge_1.force.z", 0.2
    wanted = sr.simulate(one.system, until=until, t_eval=[until]).reaction("hinge_1").force[-1, 2]
    table = sr.study(
        one.system.model, {"panel.mass": [20.0]}, {"f": name}, analysis=sr.Simulation(until), workers=1
    )
    assert table["f"] == pytest.approx([wanted], rel=1e-9)
    spread = sr.uncertainty(
        one.system.model, {"panel.mass": [19.6, 20.4]}, {"f": name}, analysis=sr.Simulation(until)
    )
    problem = sr.Problem(one.system, sr.Final(name), ["panel.mass"], until=until)
    by_mass = problem.gradient(problem.x0).matrix[0, 0]
    assert problem.values(problem.x0) == pytest.approx([wanted], rel=1e-4)
    assert spread.values[0] == pytest.approx(wanted, rel=1e-4)
    assert spread.std[0] == pytest.approx(0.4 * abs(by_mass), rel=1e-9)
