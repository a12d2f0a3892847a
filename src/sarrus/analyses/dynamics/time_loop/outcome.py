"""The states of a run at the times wanted, and from them its trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from threading import RLock
from typing import Any

import numpy as np

from ....algebra import Array
from ....model.announcement import announce
from ....results import Trajectory
from ....results.motion.trajectory import LATE, LATER
from ....system import System
from ..dense_output.sample_loop import Samples
from ..dense_output.sampler import Sampler
from ..dense_output.winding import Winding
from ..stepping.nodes import Nodes
from .nearness import Nearness

SUCCESS = ("finished", "event")


class OutputStates:
    """The states of a run at the times wanted, in the order of time.

    They are computed from the steps when somebody looks at them: first positions and velocities, then, if they are
    wanted, accelerations, multipliers and energies, with the same bits as if all were computed together.

    Parameters
    ----------
    system : System
    sampler : for them alone, so that they do not depend on what else is computed

    Attributes
    ----------
    nearness : of the states computed so far
    winding : at the last of them
    waiting : steps, with the states wanted within them that are not computed yet
    status, message : of the run
    """

    status, message = "", ""

    def __init__(self, system: System, sampler: Sampler) -> None:
        self.system, self.sampler, self.winding = system, sampler, Winding(system)
        self.nearness = Nearness(system, sampler.independence)
        self.waiting = list[tuple[Nodes, Samples]]()
        self._known = list[Samples]()
        self._placed, self._begin, self._lock = False, dict[str, Array](), RLock()

    def take(self, nodes: Nodes, times: Array) -> None:
        """Take steps, and the times wanted within them."""
        self.waiting.append((nodes, self.sampler.capacity(times)))

    @property
    def too_large(self) -> bool:
        """Whether the steps that wait need more memory than the states."""
        return sum(len(nodes.t) - len(states.t) for nodes, states in self.waiting) > 0

    def computed(self) -> list[Samples]:
        """The states computed since the last time, which are forgotten."""
        found, self._known = self._known, []
        return found

    def complete(self, progress: Callable[[float], None] | None = None) -> None:
        """Compute all states; `progress` is called with their times now and then."""
        with self._lock:
            placed = self._placed
            self._start()
            for nodes, states in self.waiting:
                for done in self.sampler.fill(states, nodes, placed=placed):
                    if progress and done < len(states.t):
                        progress(float(states.t[done]))
                if not placed:
                    self._wind(nodes, states)
            for _, states in self.waiting:
                states.energy[:] = self.sampler.energies(states)[:, :2]
                self.nearness.look(states)
                self._known.append(states)
            self.waiting.clear()
            self._begin.clear()
            self._placed = False

    def _place(self) -> None:
        """Compute positions and velocities."""
        with self._lock:
            if not self._placed:
                self._start()
                for nodes, states in self.waiting:
                    for _ in self.sampler.fill(states, nodes, rounds=0):
                        pass
                    self._wind(nodes, states)
                self._placed = True

    def _start(self) -> None:
        """Begin with the states that wait, each time with the same choices."""
        if self._begin:
            self.resume(self._begin)
        else:
            self._begin = {name: np.array(array) for name, array in self.state().items()}

    def _wind(self, nodes: Nodes, states: Samples) -> None:
        states.revolutions[:] = self.winding.take(nodes, states.t, states.q, states.v)

    def state(self) -> dict[str, Array]:
        """Return the data on which further states depend."""
        return {f"output_{name}": x for name, x in (self.sampler.choices() | self.winding.state()).items()}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state; older ones have the choices of all states together."""
        own = {name.removeprefix("output_"): x for name, x in state.items() if name.startswith("output_")}
        self.sampler.resume(own or state)
        self.winding.resume(own or state)

    def remarks(self) -> tuple[str, tuple[str, ...]]:
        """The message of the run with what its states add, and the warnings about them, which are issued."""
        if self.status not in SUCCESS:
            return self.message, ()
        message, undefined = self.message + self.nearness.message(), self.nearness.undefined_message()
        return message, announce([undefined] if undefined else [])

    @property
    def times(self) -> Array:
        """The times of all states (nt,)."""
        return self._every("t")

    def look(self, name: str) -> dict[str, Any]:
        """The field of a trajectory, and what is known with it."""
        late = name in LATE
        if late:
            self.complete()
        else:
            self._place()
        found: dict[str, Any] = {field: self._every(field) for field in ("q", "v", "memory", "revolutions")}
        found["violation"], found["velocity_violation"] = self._every("violation").T
        if late:
            found |= {
                "a": self._every("a"),
                "lam": self._every("lam"),
                "singular": tuple(self.nearness.times),
            }
            found["kinetic_energy"], found["potential_energy"] = self._every("energy").T
            found["message"], found["warnings"] = self.remarks()
        return found

    def _every(self, field: str) -> Array:
        states = [*self._known, *(states for _, states in self.waiting)]
        parts = [getattr(one, field) for one in states or [self.sampler.capacity(np.zeros(0))]]
        return np.concatenate(parts)


def trajectory_of(system: System, states: OutputStates, **fields: Any) -> Trajectory:
    """The trajectory of a run; what waits is computed when it is looked at."""
    known = {} if states.waiting else states.look("a")
    run = Trajectory(**_of(system, states.status), t=states.times, **(dict.fromkeys(LATER) | known), **fields)
    if states.waiting:
        run.wait_for(states)
    return run


def nothing(system: System, status: str, message: str) -> Trajectory:
    """A trajectory without states: it failed at the start."""
    q, lam = np.zeros((0, system.nq)), np.zeros((0, system.m))
    remembered = {"memory": np.zeros((0, len(system.memory_places)))}
    remembered["revolutions"] = np.zeros((0, system.joint_coordinates.m))
    states: dict[str, Any] = {
        "t": np.zeros(0),
        "q": q,
        "v": q,
        "a": q,
        "lam": lam,
        "violation": np.zeros(0),
        **remembered,
    }
    return Trajectory(**_of(system, status), **states, message=message)


def _of(system: System, status: str) -> dict[str, Any]:
    """The fields of a trajectory that are no states."""
    names = {
        "name": system.name,
        "bodies": tuple(system.bodies),
        "coordinate_names": tuple(system.coordinate_names),
    }
    verdict = {"success": status in SUCCESS, "status": status}
    return {**names, **verdict, "joints": system.joint_coordinates, "system": system}
