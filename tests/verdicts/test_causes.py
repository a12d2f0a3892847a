"""Short runs, far positions, missing inertia, huge masses: they work, or the message names the true cause."""

import numpy as np
import pytest
from tests.analyses import linkages
from tests.verdicts.random_mechanisms import KINDS, mechanism

import sarrus as sr
from sarrus.io.robot.tree.merge import UncheckedBody

METHODS = [sr.HHT(), sr.HHT(stabilized=True), sr.Radau(), sr.ODE()]


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("until", [1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4])
def test_very_short_runs(kind: str, until: float) -> None:
    """In a short step the round-off of constraints is no acceleration: q and v follow their derivatives."""
    for seed in range(6):
        system = mechanism(seed, kind, c=1.0).system()
        motions = sr.mobility(system).motions
        v = motions @ np.random.default_rng(seed).normal(size=motions.shape[1])
        start = sr.assemble(system, system.q0, v)
        for method in METHODS[:3]:
            run = sr.simulate(system, start, until=until, method=method, t_eval=[0.0, until])
            assert run.success, (seed, method, run.message)
            allowed = 1e-6 + 1e3 * until  # accelerations are of order 100, 1000 where springs are stiff
            assert abs(run.q[-1] - run.q[0] - until * run.v[0]).max() < 1e-14 + 1e-6 * until + allowed * until
            assert abs(run.v[-1] - run.v[0]).max() < allowed, (seed, method)


def pendulum(
    kind: type[sr.Body] = sr.Body, where: tuple[float, ...] = (0, 0, 0), **inertial: object
) -> sr.System:
    """Two links, hinge and ball."""
    at = np.array(where, dtype=float)
    link, tip = (
        kind(n, position=tuple(at + (x, 0, 0)), **inertial) for n, x in (("link", 0.5), ("tip", 1.5))
    )
    hinge = sr.Revolute("hinge", sr.ground, link, point=tuple(at), axis=(0, 0, 1))
    ball = sr.Spherical("ball", link, tip, point=tuple(at + (1, 0, 0)))
    return sr.System(sr.Model("pendulum", [link, tip], [hinge, ball], gravity=(0, -9.81, 0)))


@pytest.mark.parametrize("mass", [1e-21, 1e-9, 1e9, 1e21])
@pytest.mark.parametrize("method", METHODS, ids=repr)
def test_the_unit_of_mass_does_not_matter(mass: float, method: sr.HHT) -> None:
    runs = [
        sr.simulate(pendulum(mass=m, inertia=(0.1 * m,) * 3), until=0.3, t_eval=[0.3], method=method)
        for m in (1, mass)
    ]
    assert runs[1].success, runs[1].message
    assert runs[1].q == pytest.approx(runs[0].q, abs=1e-5)


def test_far_from_the_origin() -> None:
    near = sr.simulate(pendulum(mass=1.0, inertia=(0.1,) * 3), until=0.5, method=sr.Radau())
    far = sr.simulate(
        pendulum(where=(1e8, -1e8, 1e7), mass=1.0, inertia=(0.1,) * 3), until=0.5, method=sr.Radau()
    )
    assert far.q[-1, 1] + 1e8 == pytest.approx(near.q[-1, 1], abs=1e-6)
    refused = sr.simulate(pendulum(where=(1e8, -1e8, 1e7), mass=1.0, inertia=(0.1,) * 3), until=0.5)
    assert refused.success or "m from the origin" in refused.message


@pytest.mark.parametrize("inertia", [0.0, 1e-30])
def test_missing_inertia_is_named(inertia: float) -> None:
    system = pendulum(UncheckedBody, mass=1.0, inertia=inertia * np.eye(3))
    for analysis in (lambda: sr.modes(system, system.q0), lambda: sr.equilibrium(system)):
        with pytest.raises(sr.ModelError, match="body tip: it has no inertia"):
            analysis()
    run = sr.simulate(system, until=0.1)
    if inertia and run.success:  # the motion does not depend on it
        light = sr.simulate(pendulum(mass=1.0, inertia=1e-12 * np.eye(3)), until=0.1)
        assert run.q[-1] == pytest.approx(light.q[-1], abs=1e-9)
    else:
        assert "body tip: it has no inertia" in run.message


@pytest.mark.parametrize("moments", [(-1.0, -1.0, -1.0), (-0.1, 0.1, 0.1), (np.nan, 1.0, 1.0)])
def test_a_negative_inertia_is_refused(moments: tuple[float, ...]) -> None:
    with pytest.raises(sr.ModelError, match='body "link": inertia has the principal moments'):
        pendulum(UncheckedBody, mass=1.0, inertia=np.diag(moments))


def flat_parallelogram(length: float, mass: float) -> sr.System:
    """All four hinges in one line, where the parallelogram and its antiparallel twin meet."""

    def rod(name: str, x: float, long: float) -> sr.Body:
        inertia = (mass * (long * length) ** 2 / 12,) * 3
        return sr.Body(name, mass=mass, inertia=inertia, position=(x * length, 0, 0))

    a, b, c = rod("a", 0.5, 1), rod("b", 2.0, 2), rod("c", 2.5, 1)
    z = (0, 0, 1)
    joints = [
        sr.Revolute("o", sr.ground, a, point=(0, 0, 0), axis=z),
        sr.Revolute("p", a, b, point=(length, 0, 0), axis=z),
        sr.Revolute("q", sr.ground, c, point=(2 * length, 0, 0), axis=z),
        sr.PointOnLine("r", b, c, point=(3 * length, 0, 0), axis=z),
    ]
    return sr.System(sr.Model("flat", [a, b, c], joints, gravity=(0, -9.81 * length, 0)))


@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()], ids=repr)
@pytest.mark.parametrize(("length", "mass"), [(1.0, 1.0), (1e-6, 1e-9), (1e4, 1e6)])
def test_a_start_on_a_branching_is_said(length: float, mass: float, method: sr.HHT) -> None:
    system = flat_parallelogram(length, mass)
    assert sr.mobility(system).kind == "branching"
    with pytest.warns(sr.SarrusWarning, match="lose rank in the initial configuration"):
        run = sr.simulate(system, until=1e-3, method=method)
    assert any("2 degrees of freedom there and fewer nearby" in warning for warning in run.warnings)


def test_nothing_can_move() -> None:
    box = sr.Body("box", mass=1.0, inertia=(1, 1, 1))
    welded = sr.System(sr.Model("welded", [box], [sr.Fixed("weld", sr.ground, box, point=(0, 0, 0))]))
    with pytest.warns(sr.SarrusWarning, match="nothing can move"):
        run = sr.simulate(welded, until=1.0)
    assert len(run.warnings) == 1
    hinge = sr.Revolute("hinge", sr.ground, box, point=(0, 0, 0), axis=(0, 0, 1))
    motor = sr.AngleDriver("motor", "hinge", lambda t: 2 * t)
    assert not sr.simulate(sr.System(sr.Model("driven", [box], [hinge], drivers=[motor])), until=0.1).warnings


@pytest.mark.parametrize(
    "make",
    [
        linkages.door,
        linkages.bennett,
        linkages.bricard,
        linkages.parallelogram,
        linkages.slider_crank_in_line,
    ],
)
def test_redundant_mechanisms_start_without_a_warning(make: object) -> None:
    assert not sr.simulate(make(), until=0.01).warnings  # type: ignore[operator]
