"""Arrays of results cannot be written: what is read from a result never changes it."""

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms


@cache
def system() -> sr.System:
    return sr.System(sr.load(mechanisms.path("slider_crank")))


@cache
def run() -> sr.Trajectory:
    return sr.simulate(system(), until=0.1, store="steps")


def arrays(folder: Any) -> Iterator[tuple[str, np.ndarray]]:
    motion, rest = run(), sr.equilibrium(system())
    for name in (
        "t",
        "q",
        "v",
        "a",
        "lam",
        "kinetic_energy",
        "total_energy",
        "violation",
        "revolutions",
        "history",
    ):
        yield name, getattr(motion, name)
    for name in ("position", "velocity", "acceleration", "euler", "angular_velocity_body"):
        yield name, getattr(motion["crank"], name)
    yield "output", motion["slider.x"]
    yield "vector", motion["pin.force"]
    fall = sr.System(sr.Model("fall", [sr.Body("ball", 1.0, (1, 1, 1))], gravity=(0, 0, -9.81)))
    stopped = sr.simulate(
        fall, until=1.0, store="steps", events=sr.Event("ball.z + 0.1", reset=lambda t, q, v: -v)
    )
    assert isinstance(stopped.steps, sr.results.Segments)
    for n, steps in enumerate((motion.steps, *stopped.steps.segments)):
        for name in ("t", "h", "q", "b", "stages"):
            yield f"steps {n} {name}", getattr(steps, name)
    yield "event", stopped.steps.event_steps[0].after
    yield "joint", motion.joint("pin").angle
    yield "reaction", motion.reaction("pin").force
    assert motion.final is not None
    yield "final", motion.final.q
    yield "state", motion.state(motion.t[3]).v
    yield "assembly", sr.assemble(system()).q
    yield "equilibrium", rest.squares
    yield "linearization", sr.linearize(system(), rest).A
    yield "modes", sr.modes(system(), rest).shapes
    yield "gradient", sr.sensitivity(motion, "slider.x", ["crank.mass"]).matrix
    motion.save(folder / "run")
    loaded = sr.load_run(folder / "run")
    yield "loaded", loaded.kinetic_energy
    yield "loaded body", loaded["crank"].velocity


@pytest.mark.filterwarnings("ignore::sarrus.SarrusWarning")
def test_arrays_of_results_cannot_be_written(tmp_path: Any) -> None:
    for name, array in arrays(tmp_path):
        assert array.size, name
        with pytest.raises(ValueError, match="read-only"):
            array *= 1000
        assert not array.flags.writeable, name


@pytest.mark.filterwarnings("ignore::sarrus.SarrusWarning")
def test_results_that_cannot_be_written_are_starts(tmp_path: Any) -> None:
    assert run().final is not None
    for start in (run().final, run().state(run().t[5]), sr.assemble(system()), sr.equilibrium(system())):
        for method in (sr.Radau(), sr.HHT(), sr.ODE()):
            again = sr.simulate(system(), start, until=0.2, t_eval=[0.2], method=method)
            assert again.success
            assert np.isfinite(again.q).all()
