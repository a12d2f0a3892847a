"""Events of accelerations and reactions end runs, and have no derivatives: the message says what to name instead."""

import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr


@pytest.mark.parametrize("name", ["rod.acceleration.y", "pin.force.x"])
def test_derivatives_past_events_of_reactions_are_refused(name: str) -> None:
    system = slider_crank()
    free = sr.simulate(system, until=0.1)
    event = sr.Event(f"{name} - {free[name][500]}", terminal=True, name="here")
    run = sr.simulate(system, until=0.1, events=event, store="steps")
    assert run.status == "event"
    with pytest.raises(
        ValueError, match=f"the event here depends on {name}, which follows from the equations"
    ):
        sr.sensitivity(run, "slider.x", ["rod.mass"])
