"""The equations of candidate curves: their exact derivatives, scaling, what is refused, what is traced."""

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.workspace.problem.formulation import formulate
from sarrus.analyses.workspace.problem.random_positions import Samples
from sarrus.analyses.workspace.problem.rows import Problem
from sarrus.analyses.workspace.tracing.stratum import Stratum

from .mechanisms import Case, arm_2r, arm_3r, five_bar, platform_haug

WEIGHTS = np.array([1, -8, 0, 8, -1]) / 12  # of a five-point difference


def problem_of(case: Case) -> Problem:
    system, output, limits = case
    return formulate(system, output, limits=limits)


def differenced(f: object, x: np.ndarray, along: np.ndarray, h: float = 1e-3) -> np.ndarray:
    return sum(w * f(x + k * h * along) for w, k in zip(WEIGHTS, range(-2, 3), strict=True)) / h


@pytest.mark.parametrize("case", [arm_3r, five_bar, platform_haug])
def test_derivatives(case: object) -> None:
    """G_x and G_xx beside differences of G and G_x, at no solution."""
    problem, random = problem_of(case()), np.random.default_rng(0)
    active = frozenset({(0, 1)}) if len(problem.limited) else frozenset()
    stratum = Stratum(problem, active)
    x, s, t = random.normal(size=(3, stratum.size))
    x[: problem.n] = next(Samples(problem)) + 0.02 * x[: problem.n]
    assert stratum.linear(x).G_x @ s == pytest.approx(differenced(stratum.residual, x, s), abs=1e-7)
    turned = differenced(lambda y: stratum.linear(y).G_x @ t, x, s)
    assert stratum.second(x, s, t) == pytest.approx(turned, abs=1e-6)


def test_redundant_equations_are_left_out() -> None:
    problem = problem_of(five_bar())
    assert problem.system.m - len(problem.independent) == 3
    assert problem.freedoms == 2


@pytest.mark.slow
def test_a_rod_that_spins_idly_is_locked() -> None:
    """A five-bar with ball joints at both ends of one rod has the workspace of one with hinges."""
    system, output, _ = five_bar(balls=True)
    map_ = sr.WorkspaceMap(system, output)
    assert len(map_.problem.locked) == 1
    assert map_.problem.freedoms == 2
    found = map_.run().result()
    assert found.success, found.message
    assert found.area == pytest.approx(11.788984798867766, rel=3e-7)


def test_random_positions_can_be_built() -> None:
    """The hinges' equations allow their axes to be reversed; the samples do not."""
    problem = problem_of(arm_3r())
    for _, q in zip(range(40), Samples(problem, seed=3), strict=False):
        z = 1 - 2 * ((q.reshape(-1, 7)[:, 4:6]) ** 2).sum(axis=1)  # of each body's z axis along the ground's
        assert z == pytest.approx(1)


@pytest.mark.slow
def test_the_scale_of_the_model_does_not_matter() -> None:
    areas = []
    for scale in (1e-3, 1.0, 1e3):
        body = sr.Body("b", mass=1, inertia=(1, 1, 1))
        tip = sr.Body("c", mass=1, inertia=(1, 1, 1), position=(scale, 0, 0))
        joints = [
            sr.Revolute("q1", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1)),
            sr.Revolute("q2", body, tip, point=(scale, 0, 0), axis=(0, 0, 1)),
        ]
        system = sr.System(sr.Model("arm", bodies=[body, tip], joints=joints))
        found = sr.workspace(system, tip.point(0.6 * scale, 0, 0)["x", "y"], verify=False)
        areas.append(found.area / scale**2)
    assert areas == pytest.approx([np.pi * (1.6**2 - 0.4**2)] * 3, rel=3e-7)


def test_a_map_can_be_left_and_taken_up_again() -> None:
    system, output, limits = arm_2r()
    whole = sr.WorkspaceMap(system, output, limits=limits, seed=4).run()
    map_ = sr.WorkspaceMap(system, output, limits=limits, seed=4)
    first = next(iter(map_))
    assert len(first.points) > 1
    assert map_.result().status == "incomplete"
    assert map_.run().result().area == whole.result().area
    assert len(map_.branches) == len(whole.branches)


@pytest.mark.parametrize(
    ("output", "options", "told"),
    [
        (("link_9.x", "link_2.y"), {}, "link_2.x"),
        (("link_2.x", "link_2.y", "q1", "q2"), {}, "one to three outputs"),
        (("link_2.x",), {}, "output: a map has two outputs, got 1"),
        (("link_2(0.7, 0, 0).x", "link_2.y"), {"fixed": {"q1": 0.0}}, ": 1 degree of freedom"),
        (("link_2.x", "link_2.y"), {"fixed": {"q1": 2.0}, "limits": {"q1": (0, 1)}}, "beyond its limits"),
        (("link_2.x", "link_2.y"), {"limits": {"q1": (1.0, 0.0)}}, "Give the lower one first"),
        (("link_2.x", "link_2.y"), {"limits": {"q1": (0.5, None)}}, "Give both"),
        (("link_2.x", "link_2.y"), {"fixed": {"link_2.z": 1.0}}, "could not be assembled"),
        (("link_2(0, 1).x", "link_2.y"), {}, "Give three numbers"),
        ((3, "link_2.y"), {}, "Give a name"),
    ],
)
def test_misuse(output: tuple[object, ...], options: dict[str, object], told: str) -> None:
    system, _, _ = arm_2r()
    with pytest.raises(sr.SarrusError, match=told):
        sr.workspace(system, output, **options)
