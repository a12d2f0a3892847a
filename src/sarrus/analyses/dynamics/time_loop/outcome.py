"""The states of a run at the output times, and from them its trajectory."""

from __future__ import annotations

from collections.abc import Callable
from itertools import repeat
from threading import RLock
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....linalg.threads import one_thread_if_small
from ....model.announcement import announce, warn_now
from ....model.read_only import read_only
from ....results import State, Trajectory
from ....results.motion.trajectory import COMPUTED, LAST
from ....system import System
from ..dense_output.sample_loop import REFINEMENTS, Samples
from ..dense_output.sampler import PORTION, Sampler, samples_at
from ..dense_output.winding import revolutions_between
from ..stepping.nodes import Nodes
from ..stepping.stepper import RunPart
from .nearness import Nearness

COUNTED, FINAL = "revolutions", "final"  # the fields
CROWDED = 10  # outputs within a step, above which its points take less time than they save
SUCCESS = ("finished", "event")


class Waiting(NamedTuple):
    """Steps, the output times within them, and the revolutions of the joints at their nodes, see `Winding`."""

    nodes: Nodes
    times: Array
    revolutions: Array


class OutputStates(RunPart):
    """The states of a run at the output times, computed from its steps when somebody looks at them.

    Where only positions and velocities are wanted, accelerations, multipliers and energies are not computed. If they
    are wanted later, all is computed from the same choice of pivots on, so that the bits are the same.

    Parameters
    ----------
    system : System
    sampler : for these states alone, so that they do not depend on what else is computed

    Attributes
    ----------
    waiting : what is not computed yet, in the order of time
    nearness : of the states computed with accelerations
    """

    VARIABLES = "sampler", "nearness"

    def __init__(self, system: System, sampler: Sampler) -> None:
        self.system, self.sampler = system, sampler
        self.waiting, self._projected, self._computed = list[Waiting](), list[Samples](), list[Samples]()
        self.nearness = Nearness(system, sampler.independence)
        self._excess, self.lock = 0, RLock()
        self._status, self._message = "", ""
        self._reached: Callable[[], State | None] = lambda: None
        self._fields: dict[str, Any] = {}

    def take(self, nodes: Nodes, times: Array, revolutions: Array) -> None:
        """Take steps, see `Waiting`."""
        self.waiting.append(Waiting(nodes, times, revolutions))
        self._excess += len(nodes.t) - len(times)

    def end(self, status: str, message: str, reached: Callable[[], State | None]) -> None:
        """Take the status and the message of the run, and what computes the state that it has reached."""
        self._status, self._message, self._reached = status, message, reached

    @property
    def too_large(self) -> bool:
        """Whether the steps that wait need much more memory than their states."""
        return self._excess > PORTION

    def released(self) -> list[Samples]:
        """The states computed since the last call, which are not stored here any longer."""
        states, self._computed = self._computed, []
        return states

    def compute(self, progress: Callable[[float], None] | None = None) -> None:
        """Compute all that waits; `progress` is called with the time now and then, and may interrupt it."""
        with self.lock:
            if not self.waiting:
                return
            states = self._states(REFINEMENTS, progress)
            self._computed += [out for out in states if len(out.t)]
            self.waiting, self._projected, self._excess = [], [], 0

    def _states(self, rounds: int, progress: Callable[[float], None] | None = None) -> list[Samples]:
        """The states that wait; after an interruption, or without rounds for accelerations, again from the start."""
        begin = self.state()
        states, again = [self.sampler.capacity(one.times) for one in self.waiting], True
        try:
            for (nodes, _, turns), out, known in zip(self.waiting, states, self._projected or repeat(None)):
                crowded = CROWDED if known is None else None
                for done in self.sampler.fill(out, nodes, known=known, crowded=crowded, rounds=rounds):
                    if progress and done < len(out.t):
                        progress(float(out.t[done]))
                if rounds:
                    out.revolutions[:] = revolutions_between(self.system, nodes, turns, out.t, out.q, out.v)
                    out.energy[:] = self.sampler.energies(out)[:, :2]
                    self.nearness.look(out)
            again = not rounds
        finally:
            if again:
                self.resume(begin)
        return states

    def remarks(self) -> tuple[str, list[str]]:
        """The message of the run with what its states add, and warnings about them."""
        if self._status not in SUCCESS:
            return self._message, []
        undefined = self.nearness.undefined_message()
        return self._message + self.nearness.message(), [undefined] if undefined else []

    @one_thread_if_small
    def fields(self, name: str) -> dict[str, Any]:
        """The field of a trajectory, and all that are computed so far: those of its copies, too."""
        with self.lock:
            if name == FINAL and name not in self._fields:
                self._fields |= {FINAL: read_only(self._reached())}
                return self._fields
            if name not in LAST and self._fields.keys() <= {FINAL}:
                self._project()
            if name == COUNTED and name not in self._fields and "q" in self._fields:
                self._count()
            if (
                name not in self._fields
            ):  # also positions, where a state could not be projected: there are warnings
                self._fields, self._computed = read_only(self._complete()), []
                warn_now(self._fields["warnings"])
            return self._fields

    def _complete(self) -> dict[str, Any]:
        """All fields."""
        self.compute()
        message, warnings = self.remarks()
        rest = {"singular": tuple(self.nearness.times), "message": message, "warnings": tuple(warnings)}
        final = {} if FINAL in self._fields else {FINAL: self._reached()}
        return _columns(self._computed, self.system) | self._fields | rest | final

    def _project(self) -> None:
        """Compute positions and velocities, if all are on the constraints."""
        states = self._states(rounds=0)
        if not any(np.isinf(out.growth).any() for out in states):
            columns = _columns([*self._computed, *states], self.system)
            self._fields |= read_only(
                {name: array for name, array in columns.items() if name not in (*LAST, COUNTED)}
            )
        unfilled = "a", "lam", "energy"
        empty = [{name: getattr(out, name)[:, :0].copy() for name in unfilled} for out in states]
        self._projected = [out._replace(**own) for out, own in zip(states, empty, strict=True)]

    def _count(self) -> None:
        """Compute the revolutions at the projected states."""
        counted = [out.revolutions for out in self._computed]
        for (nodes, _, turns), out in zip(self.waiting, self._projected, strict=True):
            counted.append(revolutions_between(self.system, nodes, turns, out.t, out.q, out.v))
        self._fields |= read_only({COUNTED: np.concatenate(counted)})

    def trajectory(self, **fields: Any) -> Trajectory:
        """The trajectory of the run; states that wait are computed when somebody looks at them."""
        times = [out.t for out in self._computed] + [one.times for one in self.waiting]
        if self.waiting:
            states: dict[str, Any] = dict.fromkeys(COMPUTED) | {"_later": self}
        else:
            states = self._complete()
            announce(states["warnings"])
        t = np.concatenate([np.zeros(0), *times])
        return Trajectory(t=t, **_about(self.system, self._status), **states, **fields)


def nothing(system: System, status: str, message: str) -> Trajectory:
    """A trajectory without states: it failed at the start."""
    return Trajectory(t=np.zeros(0), **_about(system, status), **_columns([], system), message=message)


def _columns(states: list[Samples], system: System) -> dict[str, Any]:
    """The fields of a trajectory with an entry for each of its times."""
    every = Samples._make(
        np.concatenate(x) for x in zip(samples_at(system, np.zeros(0)), *states, strict=True)
    )
    columns = {name: getattr(every, name) for name in ("q", "v", "a", "lam", "memory", "revolutions")}
    columns["violation"], columns["velocity_violation"] = every.violation.T
    columns["kinetic_energy"], columns["potential_energy"] = every.energy.T
    return columns


def _about(system: System, status: str) -> dict[str, Any]:
    """The fields of a trajectory that do not depend on its states."""
    return {
        "name": system.name,
        "bodies": tuple(system.bodies),
        "coordinate_names": tuple(system.coordinate_names),
        "success": status in SUCCESS,
        "status": status,
        "joints": system.joint_coordinates,
        "system": system,
    }
