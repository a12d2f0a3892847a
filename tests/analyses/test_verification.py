"""`sarrus.verify`: an analysis is repeated with finer settings; what cannot be believed shows, what can does not."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr

# the runs of some tests are wrong on purpose
pytestmark = pytest.mark.filterwarnings("ignore::sarrus.SarrusWarning")
X, Z, O = (1, 0, 0), (0, 0, 1), (0, 0, 0)


def block(name: str = "block", mass: float = 1.0, x: float = 0.0) -> sr.Body:
    return sr.Body(name, mass, (0.01 * mass,) * 3, position=(x, 0, 0))


def sliding(*forces: Any, bodies: list[sr.Body], name: str = "slide") -> sr.System:
    joints = [sr.Translational(f"{one.name}_slide", sr.ground, one, point=O, axis=X) for one in bodies]
    return sr.System(sr.Model(name, bodies, joints, forces, gravity=O))


def oscillator(x: float = 1.5, **law: Any) -> sr.System:
    one = block(x=x)
    return sliding(sr.TSDA("spring", sr.ground.point(*O), one.point(*O), length=1.0, **law), bodies=[one])


def pendulums(speed: float = 0.0) -> sr.System:
    """Two rods one below the other."""
    rods = [
        sr.Body("upper", 1.0, (0.1, 0.1, 0.01), position=(0, 0, -0.5)),
        sr.Body("lower", 1.0, (0.1, 0.1, 0.01), position=(0, 0, -1.5)),
    ]
    joints = [
        sr.Revolute("pin", sr.ground, rods[0], point=O, axis=X),
        sr.Revolute("elbow", rods[0], rods[1], point=(0, 0, -1), axis=X),
    ]
    return sr.System(sr.Model("pendulums", rods, joints, gravity=(0, 0, -9.81)))


def test_a_calm_run_agrees_with_closed_forms() -> None:
    """m ẍ = -k (x - 1): the compared numbers are those of the cosine, and of its derivative by k."""
    run = sr.simulate(oscillator(k=9.0), until=1.0)
    found = sr.verify(run, "block.x", wrt=["spring.k"])
    assert found.agree, found
    (value,), (slope,) = found.values, found.derivatives
    assert value.value == pytest.approx(1 + 0.5 * np.cos(3.0), abs=1e-8)
    assert slope.finer == pytest.approx(-0.5 * np.sin(3.0) / 6, abs=1e-8)
    assert min(value.digits, slope.digits) > 7
    assert value.digits == pytest.approx(-np.log10(abs(value.difference)), abs=1)
    assert "block.x by spring.k" in str(found)
    assert sr.verify(run).agree
    assert found.finer.nsteps > run.nsteps


def test_a_chaotic_run_does_not_agree() -> None:
    system = pendulums()
    start = sr.assemble(system, rates={"pin": 9.0, "elbow": -3.0})
    calm, wild = (sr.verify(sr.simulate(system, start, until=until)) for until in (1.0, 30.0))
    assert calm.agree, calm
    assert not wild.agree
    assert min(one.digits for one in wild.values) < 1


def test_a_vibration_that_steps_do_not_resolve_shows() -> None:
    run = sr.simulate(oscillator(k=1e6), until=0.2, method=sr.HHT(step=0.01))
    assert not sr.verify(run).agree
    assert sr.verify(sr.simulate(oscillator(k=1e6), until=0.05)).agree


def test_a_pulse_over_which_one_of_two_runs_steps_shows() -> None:
    """A force over 1 cm of a motion of 5 cm in each step; steps that find it agree."""
    one = block()
    pulse = "-40*exp(-((length - 1.3234)/0.01)^2)"
    push = sr.Force("pulse", sr.ground.point(-1, 0, 0), one.point(*O), value=pulse)
    system = sliding(push, bodies=[one])
    start = sr.assemble(system, rates={"block_slide": 1.0})
    assert not sr.verify(sr.simulate(system, start, until=1.0, method=sr.HHT(step=0.05))).agree
    found = sr.verify(sr.simulate(system, start, until=1.0))
    assert found.agree, found


def test_a_stiff_law_shows_where_steps_are_too_long() -> None:
    """A stop of 1e8 N/m that is met at 1 m/s: its contact takes 0.3 ms, and the rebound depends on the step."""
    one = block()
    stop = sr.Force("stop", joint="block_slide", value="-1e8*max(x - 0.5, 0)")
    system = sliding(stop, bodies=[one])
    start = sr.assemble(system, rates={"block_slide": 1.0})
    assert not sr.verify(sr.simulate(system, start, until=1.0, method=sr.HHT(step=0.01))).agree
    found = sr.verify(sr.simulate(system, start, until=1.0), "block.velocity.x")
    assert found.agree, found
    assert found.values[0].finer == pytest.approx(-1.0, abs=1e-5)


@pytest.mark.parametrize("atol", [1e-2, {"position": 0.1, "orientation": 0.1}])
def test_tolerances_that_are_too_large_show(atol: Any) -> None:
    system = oscillator(k=400.0)
    assert not sr.verify(sr.simulate(system, until=3.0, method=sr.Radau(rtol=1e-9, atol=atol))).agree
    assert sr.verify(sr.simulate(system, until=3.0)).agree


def bouncing() -> tuple[sr.System, sr.Event]:
    ball = sr.Body("ball", 1.0, (0.1,) * 3, position=(0, 0, 1.0))
    guide = sr.Translational("guide", sr.ground, ball, point=O, axis=Z)
    system = sr.System(sr.Model("ball", [ball], [guide], gravity=(0, 0, -9.81)))
    return system, sr.Event("ball.z", -1, reset=sr.Impact(restitution=0.8), name="bounce")


def test_runs_with_events_are_verified() -> None:
    """v = 0.8 sqrt(2 g h) after the impact; the coarse run of fixed steps has it, too, as events are located."""
    system, bounce = bouncing()
    run = sr.simulate(system, until=0.8, events=bounce)
    found = sr.verify(run, "ball.z", wrt=["bounce.restitution"])
    assert found.agree, found
    assert len(found.finer.events) == len(run.events) == 1
    t, speed = 0.8 - run.events[0].t, float(run.events[0].v[2])
    assert found.derivatives[0].value == pytest.approx(-speed * t, rel=1e-7)
    assert sr.verify(run).values[0].name == "time of the last event"


def test_a_run_with_an_error_goal_is_verified_from_its_last_tolerances() -> None:
    run = sr.simulate(
        oscillator(k=9.0), until=1.0, method=sr.Radau(rtol=1e-3), limits=sr.Limits(errors={"block.x": 1e-7})
    )
    found = sr.verify(run, "block.x")
    assert found.agree
    assert abs(found.values[0].difference) < 1e-7


def test_another_number_of_events_does_not_agree() -> None:
    """Near the top of its way the block touches a plane, or does not: with the error of the run."""
    system = oscillator(k=400.0)
    touch = sr.Event("block.x - 1.4999", name="touch")
    run = sr.simulate(system, until=3.0, events=touch, method=sr.HHT(alpha=-0.3, step=0.01))
    found = sr.verify(run)
    assert len(found.finer.events) != len(run.events)
    assert not found.agree
    assert "events" in found.message


def servo(t: float, o: Any) -> dict[str, Any]:
    return {"u": -4.0 * (o["block.x"] - 1.0) - 2.0 * o["block.velocity.x"]}


def test_runs_with_controllers_are_verified() -> None:
    one = block(x=1.5)
    motor = sr.Force("motor", joint="block_slide", value="u")
    system = sliding(sr.Input("u", unit="N"), motor, bodies=[one])
    run = sr.simulate(system, until=1.0, controllers=sr.Controller(servo, period=0.05))
    found = sr.verify(run, "block.x", wrt=["block.mass"])
    assert found.agree, found
    assert sr.verify(run).agree


def test_saved_runs_are_verified(tmp_path: Path) -> None:
    """By the model and the options in their folder."""
    system, bounce = bouncing()
    folder = tmp_path / "bounces.sarrus"
    run = sr.simulate(system, until=0.8, events=bounce, method=sr.Radau(rtol=1e-4), save=folder)
    for saved in (
        run,
        sr.load_run(folder),
        sr.load_run(folder, system),
        sr.resume(folder),
        sr.repeat(folder),
    ):
        found = sr.verify(saved)
        assert found.agree, found
        assert len(found.finer.events) == 1
    assert sr.verify(saved, "ball.z", wrt=["ball.mass"]).agree
    other = tmp_path / "afterwards.sarrus"
    run.save(other)
    with pytest.raises(sr.SarrusError, match="without its options"):
        sr.verify(sr.load_run(other))


def test_the_tolerances_of_a_saved_run_are_its_own(tmp_path: Path) -> None:
    folder = tmp_path / "coarse.sarrus"
    sr.simulate(oscillator(k=400.0), until=3.0, method=sr.Radau(atol=1e-2), save=folder)
    assert not sr.verify(sr.load_run(folder)).agree


def test_other_methods_are_refined() -> None:
    """SciPy's by their tolerances; a given step is shorter by the root of the factor, so that the error is a tenth."""
    system = oscillator(k=9.0)
    for method in (sr.ODE(), sr.ODE("RK45"), sr.GeneralizedAlpha(step=2e-4)):
        found = sr.verify(sr.simulate(system, until=1.0, method=method))
        assert found.agree, found
    run = sr.simulate(system, until=1.0, method=sr.GeneralizedAlpha(step=0.01))
    errors = [one["block.x"][-1] - (1 + 0.5 * np.cos(3.0)) for one in (run, sr.verify(run).finer)]
    assert errors[1] / errors[0] == pytest.approx(0.1, rel=0.05)


def test_equilibria_and_prescribed_motions_are_verified() -> None:
    system = oscillator(x=1.2, k=9.0)
    rest = sr.verify(sr.equilibrium(system), "block.x", wrt=["spring.length"])
    assert rest.agree, rest
    assert rest.derivatives[0].finer == pytest.approx(1.0, abs=1e-9)
    one = block()
    joint = sr.Translational("slide", sr.ground, one, point=O, axis=X)
    driver = sr.DisplacementDriver("motor", "slide", "0.1*sin(t)")
    driven = sr.System(sr.Model("driven", [one], [joint], drivers=[driver]))
    motion = sr.verify(sr.kinematics(driven, until=1.0, steps=100), "motor.force.x", wrt=["block.mass"])
    assert motion.agree, motion
    assert motion.derivatives[0].finer == pytest.approx(-0.1 * np.sin(1.0), rel=1e-9)
    assert len(motion.finer.t) == 201
    assert sr.verify(sr.kinematics(driven, until=1.0, steps=10)).agree


def test_what_cannot_be_repeated_is_refused() -> None:
    run = sr.simulate(oscillator(k=9.0), until=0.1)
    with pytest.raises(TypeError, match="where it was computed, got a Trajectory"):
        sr.verify(pickle.loads(pickle.dumps(run)))
    with pytest.raises(ValueError, match="wrt needs responses"):
        sr.verify(run, wrt=["spring.k"])
    with pytest.raises(ValueError, match="factor must be less than 1"):
        sr.verify(run, factor=10.0)
    stopped = sr.simulate(oscillator(k=9.0), until=10.0, limits=sr.Limits(steps=2))
    with pytest.raises(ValueError, match="this analysis failed"):
        sr.verify(stopped)
