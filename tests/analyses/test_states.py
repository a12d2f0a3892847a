"""A state that is handed on has its time, its revolutions and what elements remember; starts of every kind."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints

import sarrus as sr

RATE, ROOT = 10.0, 0.1  # rad/s at the start; sqrt(k / J)
RADAU: dict[str, Any] = {"method": sr.Radau(rtol=1e-9, atol=1e-11)}
METHODS = (sr.HHT(), sr.GeneralizedAlpha(), sr.HHT(stabilized=True), sr.Radau(), sr.ODE())


def wheel(k: float = ROOT**2) -> sr.System:
    """A wheel of unit inertia on a weak coil: θ = (rate / ω) sin ω t, some 16 revolutions each way."""
    body = sr.Body("wheel", 1.0, (1.0, 1.0, 1.0))
    pin = sr.Revolute("pin", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    coil = sr.RSDA("coil", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1), k=k)
    return sr.System(sr.Model("wheel", [body], [pin], [coil]))


def turning(system: sr.System) -> sr.Assembly:
    """The wheel's start."""
    return sr.assemble(system, rates={"pin": RATE})


def exact(t: Any) -> Any:
    """Its angle."""
    return RATE / ROOT * np.sin(ROOT * np.asarray(t))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", METHODS, ids=repr)
def test_angles_have_their_revolutions_for_two_times_only(method: Any) -> None:
    system = wheel()
    run = sr.simulate(
        system, turning(system), until=7.0, t_eval=[0.0, 7.0], method=replace(method, rtol=1e-7, atol=1e-9)
    )
    assert run.joint("pin").angle[-1] == pytest.approx(exact(7.0), abs=1e-2)
    assert exact(7.0) > 10 * 2 * np.pi
    dense = sr.simulate(system, turning(system), until=7.0, method=replace(method, rtol=1e-7, atol=1e-9))
    assert dense.joint("pin").angle == pytest.approx(exact(dense.t), abs=1e-2)


@pytest.mark.parametrize("method", METHODS, ids=repr)
def test_a_run_goes_on_from_the_end_of_another_at_its_time(method: Any) -> None:
    system = wheel()
    fine = {"method": replace(method, rtol=1e-7, atol=1e-9)}
    first = sr.simulate(system, turning(system), until=6.5, t_eval=[1.0], **fine)
    assert first.final is not None
    assert first.final.t == 6.5
    second = sr.simulate(system, first.final, until=20.0, t_eval=[6.5, 13.0, 20.0], **fine)
    assert second.joint("pin").angle == pytest.approx(exact(second.t), abs=2e-2)
    assert second.joint("pin").rate == pytest.approx(RATE * np.cos(ROOT * second.t), abs=2e-3)
    assert second.state(20.0).memory == pytest.approx(exact(20.0), abs=0.5)


def test_any_time_of_a_dense_motion_and_any_output_is_a_start() -> None:
    system = wheel()
    run = sr.simulate(system, turning(system), until=9.0, t_eval=[4.0, 9.0], store="dense", **RADAU)
    assert run.sol
    for t in (0.0, 3.3, 4.0, 8.9999):
        state = run.state(t)
        on = sr.simulate(system, state, until=12.0, t_eval=[t, 12.0], **RADAU)
        assert on.joint("pin").angle == pytest.approx(exact([t, 12.0]), abs=1e-5)
    several = run.sol([8.0, 2.0, 5.0])
    assert several.revolutions[:, 0] == pytest.approx([run.state(t).revolutions[0] for t in (8.0, 2.0, 5.0)])
    sparse = replace(run, sol=None)
    assert sparse.state(4.0).revolutions == pytest.approx(run.state(4.0).revolutions)
    with pytest.raises(ValueError, match=r"no state was stored at t = 3.3 s. Choose one of `t`"):
        sparse.state(3.3)


def test_events_and_responses_see_the_revolutions_of_the_start() -> None:
    system = wheel()
    start = sr.simulate(system, turning(system), until=5.0, **RADAU).final
    event = sr.Event("pin.angle - 80", terminal=True)
    run = sr.simulate(system, start, until=20.0, events=event, **RADAU)
    assert [one.t for one in run.events] == pytest.approx([np.arcsin(0.8) / ROOT], abs=1e-6)
    assert run.final is not None
    assert run.final.t == run.events[0].t
    kept = sr.simulate(system, start, until=10.0, store="steps", **RADAU)
    response = [sr.Final("pin.angle"), sr.Final("coil.angle")]
    found = sr.sensitivity(kept, response, ["coil.k"])
    assert found.values == pytest.approx(exact([10.0, 10.0]), abs=1e-4)
    e = 1e-6
    ends = [
        sr.simulate(wheel(ROOT**2 + d), start, until=10.0, method=sr.Radau(rtol=1e-11, atol=1e-13))
        for d in (e, -e)
    ]  # fmt: skip
    angles = [end.joint("pin").angle[-1] for end in ends]
    assert found.matrix[0, 0] == pytest.approx((angles[0] - angles[1]) / (2 * e), rel=1e-5)
    long = by_checkpoints(system, response, ["coil.k"], until=10.0, start=start, **RADAU)
    assert long.values == pytest.approx(found.values, abs=1e-9)
    assert long.matrix == pytest.approx(found.matrix, rel=1e-9)


def sparse(system: sr.System) -> sr.Trajectory:
    """An analysis of a study with two outputs, many revolutions apart."""
    return sr.simulate(system, turning(system), until=7.0, t_eval=[0.0, 7.0], **RADAU)


def test_studies_see_revolutions_between_sparse_outputs() -> None:
    responses = {"turned": "final(pin.angle)", "coil": "final(coil.angle)"}
    table = sr.study(wheel().model, {"coil.k": [ROOT**2]}, responses, analysis=sparse, workers=1)
    assert table.found[0] == pytest.approx(exact([7.0, 7.0]), abs=1e-4)


def test_a_saved_run_keeps_revolutions_and_its_end(tmp_path: Path) -> None:
    system, folder = wheel(), tmp_path / "run.sarrus"
    start = sr.simulate(system, turning(system), until=5.0, **RADAU).final
    run = sr.simulate(system, start, until=9.0, t_eval=[6.0, 8.0], save=folder, **RADAU)
    loaded = sr.load_run(folder, system)
    for one in (run, loaded, sr.resume(folder), sr.repeat(folder)):
        assert one.joint("pin").angle == pytest.approx(exact([6.0, 8.0]), abs=1e-5)
        assert one.final is not None
        assert one.final.t == 9.0
        on = sr.simulate(system, one.final, until=10.0, **RADAU)
        assert on.joint("pin").angle[-1] == pytest.approx(exact(10.0), abs=1e-5)


def test_a_run_stopped_in_its_midst_goes_on_with_its_revolutions(tmp_path: Path) -> None:
    system, folder = wheel(), tmp_path / "run.sarrus"

    def stop(t: float) -> None:
        if t > 4.0:
            raise KeyboardInterrupt

    times = np.linspace(0.0, 9.0, 4)
    start = turning(system)
    cut = sr.simulate(
        system, start, until=9.0, t_eval=times, save=folder, progress=stop, method=sr.Radau(max_step=1e-3)
    )
    assert cut.status == "stopped"
    assert cut.final is None or cut.final.t > 4.0
    whole = sr.resume(folder)
    once = sr.simulate(system, start, until=9.0, t_eval=times, method=sr.Radau(max_step=1e-3))
    assert np.array_equal(np.asarray(whole.q), once.q)
    joints = replace(whole, joints=system.joint_coordinates).joint("pin")
    assert joints.angle == pytest.approx(once.joint("pin").angle, abs=0)
    assert joints.angle == pytest.approx(exact(times), abs=1e-2)


def driven() -> sr.System:
    """A crank that a driver turns by t², and a load that is given over time."""
    crank = sr.Body("crank", 1.0, (0.1, 0.1, 0.1), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, crank, point=(0, 0, 0), axis=(0, 0, 1))
    slider = sr.Body("slider", 2.0, (0.1, 0.1, 0.1))
    guide = sr.Translational("guide", sr.ground, slider, point=(0, 0, 0), axis=(1, 0, 0))
    push = sr.PointForce("push", slider.point(0, 0, 0), (lambda t: 6 * t, 0, 0))
    drive = sr.AngleDriver("drive", "pin", "t**2")
    return sr.System(sr.Model("driven", [crank, slider], [pin, guide], [push], drivers=[drive]))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", METHODS, ids=repr)
def test_drivers_and_loads_see_the_time_of_the_start(method: Any) -> None:
    """x'' = 3 t: x = t³ / 2 with x(0) = x'(0) = 0; the run is interrupted at t = 1."""
    system = driven()
    first = sr.simulate(system, until=1.0, method=replace(method, rtol=1e-7, atol=1e-9))
    run = sr.simulate(system, first.final, until=3.0, method=replace(method, rtol=1e-7, atol=1e-9))
    assert run.t[0] == 1.0
    assert run.coordinate("slider.x") == pytest.approx(run.t**3 / 2, abs=1e-4)
    assert run.joint("pin").angle == pytest.approx(run.t**2, abs=1e-9)


def test_a_run_from_an_assembly_at_another_time_starts_there() -> None:
    system = driven()
    start = sr.assemble(system, t=1.5)
    run = sr.simulate(system, start, until=2.0, **RADAU)
    assert run.t[0] == 1.5
    assert run.joint("pin").angle == pytest.approx(run.t**2, abs=1e-8)
    with pytest.raises(ValueError, match=r"until must be a time in s after the start at 1.5, but is 1"):
        sr.simulate(system, start, until=1.0)
    with pytest.raises(
        ValueError, match=r"t_eval must be rising times between the start at 1.5 s and until = 2 s"
    ):
        sr.simulate(system, start, until=2.0, t_eval=[1.0, 2.0])


def test_a_driven_motion_keeps_its_revolutions_between_two_times() -> None:
    system = driven_wheel("9*t + 2*sin(5*t)")
    times = np.array([0.0, 3.0, 11.0])
    run = sr.kinematics(system, times)
    assert run.success, run.message
    assert run.joint("pin").angle == pytest.approx(9 * times + 2 * np.sin(5 * times), abs=1e-9)
    on = sr.kinematics(system, [11.0, 13.0], run.final)
    assert on.joint("pin").angle[-1] == pytest.approx(9 * 13 + 2 * np.sin(65.0), abs=1e-9)
    assert on.state(13.0).memory == pytest.approx(on.joint("pin").angle[-1])


def driven_wheel(motion: str) -> sr.System:
    """The wheel without a freedom."""
    model = wheel().model
    return sr.System(replace(model, drivers=[sr.AngleDriver("drive", "pin", motion)]))
