"""Parts of a run list their variables: their state as arrays by name, from which they go on."""

from typing import Any, NamedTuple

import numpy as np
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.stepping.stepper import RunPart
from sarrus.analyses.dynamics.time_loop.recording import RunState


class Pair(NamedTuple):
    one: np.ndarray
    other: np.ndarray


class Inner(RunPart):
    VARIABLES = ("count", "last")

    def __init__(self) -> None:
        self.count, self.last = 0, -np.inf


class Outer(RunPart):
    VARIABLES = "x", "pair", "_work.one", "names", "inner", "all", "nothing", "_ready"

    def __init__(self) -> None:
        self.x, self.pair, self._work = np.zeros(3), Pair(np.zeros(2), np.zeros(0)), Pair(*np.zeros((2, 2)))
        self.names, self.inner, self.all = list[str](), Inner(), [Inner(), Inner()]
        self.nothing, self.made = None, 0

    @property
    def _ready(self) -> bool:
        return self.made > 0

    @_ready.setter
    def _ready(self, ready: bool) -> None:
        self.made += ready


def test_a_part_goes_on_from_the_state_of_another() -> None:
    """Arrays of the same shape stay where they are, as compiled code knows them; properties are set."""
    one, other = Outer(), Outer()
    one.x[:], one.pair, one.names, one.made = (1, 2, 3), Pair(np.ones(2), np.full(4, 7.0)), ["rod", "pin"], 1
    one._work.one[:], one.all[1].count, one.inner.last = 5.0, 3, 0.25
    x, work, state = other.x, other._work.one, one.state()
    one.x[:] = 0.0  # the state is a copy
    other.resume(state)
    assert other.x is x
    assert x.tolist() == [1, 2, 3]
    assert other._work.one is work
    assert work.tolist() == [5, 5]
    assert other.pair.one.tolist() == [1, 1]
    assert other.pair.other.tolist() == [7] * 4
    assert other.names == ["rod", "pin"]
    assert other.nothing is None
    assert other.made == 1
    counts: Any = [other.inner.last, *(part.count for part in other.all)]
    assert counts == [0.25, 0, 3]
    assert type(other.all[1].count) is int


def test_a_checkpoint_holds_the_fields_of_the_state(tmp_path: Any) -> None:
    """One record for each part of the run, and what results are read from."""
    from sarrus.results.saving.saved import checkpoint

    sr.simulate(slider_crank(), until=0.1, save=tmp_path / "run", store="steps")
    found = {name.split(".")[0] for name in checkpoint(tmp_path / "run") if "." in name}
    assert found <= set(RunState._fields)
    assert {"method", "sampler", "outputs", "winding", "record"} <= found
