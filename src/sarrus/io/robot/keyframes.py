"""Keyframes: named states of a description, as starts of a motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...model.errors import ModelError
from ...model.geometry.motion import Turn
from ...model.quantity import Array
from ...model.show import quote

if TYPE_CHECKING:
    from ...results.assembly import Assembly
    from ...system import System


class Keyframe(NamedTuple):
    """A state of a description: joint coordinates as in ``q0``, joint velocities, activations and controls by name."""

    values: Mapping[str, Array]
    rates: Mapping[str, Array]
    states: Mapping[str, float]
    controls: Mapping[str, float]
    time: float = 0.0


def start_at(name: str, keyframe: Keyframe) -> Callable[[System], Assembly]:
    """Return the start of a motion in a keyframe, as a function of the system."""

    def start(system: System) -> Assembly:
        from ...analyses.position.assembly import assemble  # reading a file needs no analysis
        from ...analyses.position.joint_space import JointSpace

        space = JointSpace(system)
        for motion in space.motions:
            if isinstance(motion, Turn) and abs(keyframe.values[motion.name][0]) > np.pi:
                message = (
                    f"rotates {quote(motion.name)} by more than half a revolution. Give q0 in its place."
                )
                raise ModelError(message, part=f"keyframe {quote(name)}")
        theta = space.pack({one.name: keyframe.values[one.name] for one in space.motions})
        rates = np.concatenate([keyframe.rates[one.name] for one in space.motions])
        v = space.T(theta) @ rates
        for state, (place, *_) in system.states.items():
            v[place] = keyframe.states.get(state, system.v0[place])
        return assemble(system, space.q(theta), v, t=keyframe.time)

    return start
