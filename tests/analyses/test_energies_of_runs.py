"""Energies that trajectories record are the same from every analysis and every method."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erf, spence
from tests.analyses.driven import pushed
from tests.patience import within

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.dynamics.stepping.nodes import Nodes
from sarrus.analyses.dynamics.time_loop.energy_check import EnergyCheck
from sarrus.functions import exp, sin, tanh
from sarrus.system.curves.curve_potentials import curve_potentials

T = np.linspace(0.0, 1.0, 11)
PRECISE = {"method": sr.Radau(rtol=1e-10, atol=1e-12)}


def driven() -> sr.System:
    """A slider-crank that turns twice in a second, with a coil on its pin that counts revolutions."""
    model = sr.load(mechanisms.path("slider_crank"))
    motor = sr.AngleDriver("motor", "pin", "12.6*t")
    pin = next(joint for joint in model.joints if joint.name == "pin")
    coil = sr.RSDA("coil", sr.ground, pin.body_j, point=pin.point, axis=pin.axis, k=3.0, c=0.0)
    return sr.System(replace(model, drivers=[motor], forces=[*model.forces, coil]))


def test_a_driven_motion_has_the_energies_of_its_simulation() -> None:
    system = driven()
    run = sr.kinematics(system, T)
    simulated = sr.simulate(system, until=1.0, t_eval=T, **PRECISE)
    scale = simulated.kinetic_energy.max()
    for name in ("kinetic_energy", "potential_energy", "total_energy"):
        assert getattr(run, name) == pytest.approx(getattr(simulated, name), abs=1e-7 * scale), name
    assert np.all(run.velocity_violation < 1e-9)
    assert len(run.plot_energies().lines) == 3


def test_a_motion_that_locks_has_those_up_to_its_end() -> None:
    run = sr.kinematics(pushed(0.5), np.linspace(0.0, 4.0, 41))
    assert run.status == "lock-up"
    assert (
        run.kinetic_energy.shape == run.potential_energy.shape == run.velocity_violation.shape == run.t.shape
    )


def test_inverse_dynamics_has_those_of_its_own_bodies() -> None:
    system = driven()
    run = sr.kinematics(system, T)
    bodies = [replace(body, mass=2 * body.mass) for body in system.model.bodies]
    heavy = sr.System(replace(system.model, bodies=bodies))
    found, wanted = sr.inverse_dynamics(heavy, run), sr.kinematics(heavy, T)
    assert np.allclose(found.kinetic_energy, wanted.kinetic_energy, rtol=1e-12)
    assert np.allclose(found.potential_energy, wanted.potential_energy, rtol=1e-12)


@pytest.mark.parametrize("method", [sr.HHT(), sr.GeneralizedAlpha(), sr.Radau(), sr.ODE()])
def test_every_method_records_them(method: object, tmp_path: Path) -> None:
    """A mass on a spring and its weight; also read from a folder."""
    body = sr.Body("mass", mass=2.0, inertia=(1, 1, 1), position=(0, 0, -1.2))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=50.0, length=1.0)
    system = sr.System(sr.Model("hung", [body], forces=[spring], gravity=(0, 0, -9.81)))
    run = sr.simulate(
        system, until=1.0, t_eval=T, method=replace(method, rtol=1e-8, atol=1e-10), save=tmp_path / "run"
    )
    for one in (run, sr.load_run(tmp_path / "run", system)):
        z, rate = one["mass"].position[:, 2], one["mass"].velocity[:, 2]
        assert one.kinetic_energy == pytest.approx(rate**2, rel=1e-12, abs=1e-14)
        assert one.potential_energy == pytest.approx(2 * 9.81 * z + 25.0 * (-z - 1) ** 2, rel=1e-12)


OF_RUNS: dict[str, dict[str, object]] = {
    "plain": {}, "stored": {"store": "steps"}, "dense": {"store": "dense"},
}  # fmt: skip
LAWS = {  # a stiffness over the length or angle
    "table": [[-8.0, 40.0], [-4.0, 45.0], [0.0, 48.0], [1.0, 50.0], [1.5, 56.0], [4.0, 60.0], [8.0, 70.0]],
    "formula": lambda x: 50 + 20 * x * x,
}


def law(name: str) -> object:
    """The law as a function of plain numbers, from the definition of a table by SciPy."""
    return sr.Curve.table(LAWS[name]) if name == "table" else LAWS[name]


def work(name: str, free: float, at: float) -> float:
    """∫ k(s) (s - free) ds by SciPy."""
    curve, knots = law(name), [x for x, _ in LAWS["table"]]
    inside = [x for x in knots if min(free, at) < x < max(free, at)]
    return quad(lambda s: curve(float(s)) * (s - free), free, at, points=inside or None, epsabs=1e-12)[0]


def sprung(name: str, mass: float = 2.0, free: float = 1.0) -> sr.System:
    """A mass on a spring with a law, and a flywheel on a coil with the same law that is wound for a revolution."""
    body = sr.Body("mass", mass=mass, inertia=(1, 1, 1), position=(0.3, 0, -1.2))
    wheel = sr.Body("wheel", mass=1.0, inertia=(1, 1, 1), angular_velocity=(0, 0, 40.0))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    forces = [
        sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=LAWS[name], length=free),
        sr.RSDA("coil", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1), k=LAWS[name], angle=0.3),
    ]
    return sr.System(sr.Model("sprung", [body, wheel], [pin], forces, gravity=(0, 0, -9.81)))


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_springs_with_laws_keep_energy(name: str) -> None:
    run = sr.simulate(sprung(name), until=1.0, store="steps", **PRECISE)
    angle = run.joint("pin").angle
    assert abs(angle).max() > (2.5 if name == "formula" else 5.0)
    assert run.total_energy == pytest.approx(run.total_energy[0], abs=1e-7 * run.kinetic_energy.max())
    r = run["mass"].position
    wanted = [
        2 * 9.81 * z + work(name, 1.0, float(l)) + work(name, 0.3, float(x))
        for z, l, x in zip(r[:, 2], np.linalg.norm(r, axis=1), angle, strict=True)
    ]
    assert run.potential_energy == pytest.approx(wanted, rel=1e-9)
    values = sr.sensitivity(run, ["energy.potential", "energy.total"]).values
    assert values == pytest.approx([run.potential_energy[-1], run.total_energy[-1]], rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_derivatives_of_the_energy_of_springs_with_laws(name: str) -> None:
    """The energy is conserved: its derivatives are those of the initial one, the second as well."""
    system = sprung(name)
    run = sr.simulate(system, until=0.5, store="steps", **PRECISE)
    names = ["spring.length", "mass.position.z", "coil.angle"]
    found = sr.sensitivity(run, "energy.total", names).matrix[0]

    def energy(change: np.ndarray) -> float:
        l = np.hypot(0.3, -1.2 + change[1])
        return 2 * 9.81 * change[1] + work(name, 1.0 + change[0], l) + work(name, 0.3 + change[2], 0.0)

    e = 1e-4 * np.eye(3)
    wanted = [(energy(d) - energy(-d)) / 2e-4 for d in e]
    assert found == pytest.approx(wanted, rel=2e-5)  # steps go over the knots of the table
    second = [
        [energy(c + d) - energy(c - d) - energy(d - c) + energy(-c - d) for c in 10 * e] for d in 10 * e
    ]
    at_once = sr.At("energy.total", time=0.0)  # later ones depend on where steps meet the knots of a table
    hessian = sr.hessian(run, at_once, names).matrix
    assert hessian == pytest.approx(np.array(second) / 4e-6, abs=1e-5 * abs(hessian).max())


NARROW = {  # stiffness over the length with features of a width, and ∫ k(s) (s - 1) ds from 1 on
    "peak": lambda w: (lambda x: 40 + 2e3 * exp(-(((x - PLACE) / w) ** 2)), lambda x: 2e3 * _peak(x, w)),
    "resonance": lambda w: (
        lambda x: 40 + 2e3 / (1 + ((x - PLACE) / w) ** 2),
        lambda x: 2e3 * _resonance(x, w),
    ),
    "stop": lambda w: (lambda x: 40 + 2e3 * tanh((x - PLACE) / w), lambda x: 2e3 * _stop(x, w)),
    "ripple": lambda w: (lambda x: 40 + 20 * sin(x / w), lambda x: 20 * _ripple(x, w)),
}
PLACE = 1.1234


def _peak(x: float, w: float) -> float:
    ends = [(-0.5 * w * w * np.exp(-(((s - PLACE) / w) ** 2)), erf((s - PLACE) / w)) for s in (1.0, x)]
    return ends[1][0] - ends[0][0] + (PLACE - 1) * w * np.sqrt(np.pi) / 2 * (ends[1][1] - ends[0][1])


def _resonance(x: float, w: float) -> float:
    ends = [(np.log1p(((s - PLACE) / w) ** 2) * w * w / 2, np.arctan((s - PLACE) / w)) for s in (1.0, x)]
    return ends[1][0] - ends[0][0] + (PLACE - 1) * w * (ends[1][1] - ends[0][1])


def _stop(x: float, w: float) -> float:
    """With log cosh z = |z| + log((1 + exp(-2 |z|)) / 2), whose integral has the dilogarithm."""

    def log_cosh(s: float) -> float:
        z = abs(s - PLACE) / w
        return z + np.log1p(np.exp(-2 * z)) - np.log(2)

    def integral(s: float) -> float:  # of log cosh ((s - PLACE) / w) from PLACE on
        z = abs(s - PLACE) / w
        rest = 0.5 * (np.pi**2 / 12 + spence(1 + np.exp(-2 * z)))
        return np.sign(s - PLACE) * w * (z * z / 2 - z * np.log(2) + rest)

    return w * ((x - 1) * log_cosh(x) - integral(x) + integral(1.0))


def _ripple(x: float, w: float) -> float:
    return w * (-(x - 1) * np.cos(x / w) + w * (np.sin(x / w) - np.sin(1 / w)))


@pytest.mark.parametrize("width", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("name", NARROW)
def test_energy_of_laws_with_narrow_features(name: str, width: float) -> None:
    """Of one state, of a motion over the feature, and on the tape; a fixed rule passes over what is this narrow."""
    stiffness, extra = NARROW[name](max(width, 1e-4) if name == "ripple" else width)
    body = sr.Body("mass", mass=2.0, inertia=(1, 1, 1), position=(1.3, 0, 0))
    slide = sr.Translational("slide", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=stiffness, length=1.0)
    system = sr.System(sr.Model("narrow", [body], [slide], [spring]))
    q, places = np.tile(system.q0, (1001, 1)), np.linspace(0.8, 1.4, 1001)
    q[:, 0] = places
    wanted = np.array([20 * (x - 1) ** 2 + extra(x) for x in places])
    scale = abs(wanted).max()
    at_once = curve_potentials(system.populations, system.b, {}, np.zeros(1001), q)
    assert at_once == pytest.approx(wanted, rel=1e-9, abs=1e-13 * scale)
    assert [system.potential_energy(x) for x in q[::100]] == pytest.approx(
        wanted[::100], rel=1e-9, abs=1e-13 * scale
    )


def test_energies_of_many_times_cost_little() -> None:
    system = sprung("formula")
    q = np.tile(system.q0, (20_000, 1))
    q[:, 2] = np.linspace(-3.0, -0.5, len(q))
    curve_potentials(system.populations, system.b, {}, np.zeros(len(q)), q)
    with within(2):
        curve_potentials(system.populations, system.b, {}, np.zeros(len(q)), q)


def test_a_detent_that_is_passed_in_an_instant_keeps_the_energy(tmp_path: Path) -> None:
    """There is no warning that the energy grew; also read from a folder, and differentiated."""
    body = sr.Body("mass", mass=2.0, inertia=(1, 1, 1), position=(1.3, 0, 0))
    slide = sr.Translational("slide", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    x = np.concatenate([[0.02, 0.9], PLACE + np.linspace(-6e-4, 6e-4, 61), [1.3, 2.0]])
    law = np.array([x, 40 + 2e6 * np.exp(-(((x - PLACE) / 1e-4) ** 2))]).T.tolist()
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=law, length=1.0)
    system = sr.System(sr.Model("detent", [body], [slide], [spring]))
    whole = sr.simulate(system, until=0.4, store="steps")
    run = sr.simulate(system, until=0.4, save=tmp_path / "run")
    for one in (whole, run, sr.load_run(tmp_path / "run", system)):
        assert one.warnings == ()
        assert one["mass"].position[-1, 0] < 1.1
        assert one.total_energy == pytest.approx(one.total_energy[0], abs=1e-6 * one.kinetic_energy.max())
        assert one.output("energy.potential").values == pytest.approx(one.potential_energy, rel=1e-12)
    gradient = sr.sensitivity(whole, ["energy.potential", "energy.total"], ["spring.length"])
    assert gradient.values == pytest.approx([whole.potential_energy[-1], whole.total_energy[-1]], rel=1e-10)


ALONG = {"point": (0, 0, 0), "axis": (1, 0, 0)}
DRIVES = ("nothing", "motor", "spring", "controller")


def coasting(drive: str = "nothing", damping: float = 0.0) -> tuple[sr.System, dict[str, object]]:
    """A mass that coasts against a stop, beside a flywheel that something drives or brakes; and options of its run."""
    body = sr.Body("b", 1.0, (1, 1, 1), velocity=(2, 0, 0))
    wheel = sr.Body("wheel", 0.1, (0.1, 0.1, 0.1), position=(0, 3, 0))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 3, 0), axis=(0, 0, 1))
    stop = sr.DisplacementStop(
        "stop", sr.ground, body, **ALONG, stiffness=1e6, rounding=1e-6, upper=5.0, damping=damping
    )
    coil = sr.RSDA(
        "coil", sr.ground, wheel, point=(0, 3, 0), axis=(0, 0, 1), k=0.1, c=0.05, torque="0.3*sin(3*t)"
    )
    moves = {"spring": [coil], "controller": [sr.Input("u", 0.0), sr.Torque("servo", "pin", value="u")]}
    model = sr.Model(
        "coast", [body, wheel], [sr.Translational("guide", sr.ground, body, **ALONG), pin],
        drivers=[sr.AngleDriver("motor", "pin", "sin(3*t)")] if drive == "motor" else [],
        forces=[stop, *moves.get(drive, [])],
    )  # fmt: skip
    hold = sr.Controller(lambda t, o: {"u": 0.2 - o["pin.angle"]}, period=0.05)
    return sr.System(model), {"controllers": [hold]} if drive == "controller" else {}


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("kind", OF_RUNS)
@pytest.mark.parametrize(("factor", "how"), [(3.0, "grew .* supply"), (0.2, "fell .* dissipate")])
def test_energy_that_a_contact_makes_or_swallows_is_a_warning(
    kind: str, factor: float, how: str, drive: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mass comes back from a stop with another speed, as by a wrong step, whatever drives or brakes another part."""
    system, more = coasting(drive)
    assert sr.simulate(system, until=4.0, **more, **OF_RUNS[kind]).warnings == ()
    take = EnergyCheck.take

    def wrong(self: EnergyCheck, nodes: Nodes) -> None:
        v = nodes.v.copy()
        v[nodes.t > 2.62, 0] *= factor
        take(self, nodes._replace(v=v))

    monkeypatch.setattr(EnergyCheck, "take", wrong)
    with pytest.warns(sr.SarrusWarning, match=f"coast: the total energy {how}.* near t = [23][.]"):
        sr.simulate(system, until=4.0, **more, **OF_RUNS[kind])


@pytest.mark.parametrize("drive", DRIVES[:3])
@pytest.mark.parametrize("kind", ["plain", "stored", "dense"])
def test_long_steps_through_a_stiff_stop_are_a_warning(kind: str, drive: str) -> None:
    """Steps of HHT of 10 ms make 11 J of 2 J."""
    system, more = coasting(drive)
    with pytest.warns(sr.SarrusWarning) as told:
        run = sr.simulate(system, until=4.0, method=sr.HHT(step=0.01), **more, **OF_RUNS[kind])
    assert any("total energy grew by 1" in str(one.message) for one in told)
    assert run["b"].velocity[-1, 0] < -4.0


@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()])
def test_what_is_supplied_and_dissipated_within_a_contact_is_no_warning(method: object) -> None:
    """A driven hammer gives a ball more than four times its energy within a millisecond; a damped stop takes most."""
    body = sr.Body("b", 1.0, (1, 1, 1), velocity=(-1, 0, 0))
    hammer = sr.Body("hammer", 1.0, (1, 1, 1), position=(-2, 0, 0))
    guides = [sr.Translational(f"guide_{one.name}", sr.ground, one, **ALONG) for one in (body, hammer)]
    driver = sr.DisplacementDriver("motor", "guide_hammer", "t")
    stops = [
        sr.DisplacementStop("face", hammer, body, **ALONG, stiffness=1e6, lower=-1.0),
        sr.DisplacementStop("end", sr.ground, body, **ALONG, stiffness=1e6, upper=2.0, damping=2.0),
    ]
    system = sr.System(sr.Model("hit", [body, hammer], guides, drivers=[driver], forces=stops))
    run = sr.simulate(system, until=2.8, method=method)
    assert run["b"].velocity[:, 0].max() == pytest.approx(3.0, rel=1e-2)
    assert run.kinetic_energy[-1] < 0.4 * run.kinetic_energy.max()
    assert run.warnings == ()


def test_a_continued_run_adds_to_what_was_made_before_it_was_saved(tmp_path: Path) -> None:
    """The first part ends behind the stop that made the energy, the second has no stop near."""
    system, _ = coasting("motor")
    options = {"until": 4.0, "method": sr.HHT(step=0.01), "save": tmp_path / "run"}

    def interrupt(t: float) -> None:
        if t > 3.0:
            raise KeyboardInterrupt

    stopped = sr.simulate(system, progress=interrupt, **options)
    assert not stopped.success
    assert "energy" not in "".join(stopped.warnings)
    with pytest.warns(sr.SarrusWarning):
        assert "coast: the total energy grew" in "".join(sr.resume(tmp_path / "run").warnings)
