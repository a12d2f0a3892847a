"""A model that was imported from a robot description: links by name, limits, visuals."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from ...model.bodies.shape import Look
from ...model.errors import ModelError
from ...model.expansion.tree import TreeModel
from ...model.forces.contact import SphereContact
from ...model.geometry.motion import Turn
from ...model.geometry.points import Frame, Point
from ...model.quantity import Array, Vector
from ...model.show import counted, quote, suggest
from .description import Limit, Mimic, Sensor, Visual, legal
from .interaction import TOUCH, Ends, acted
from .tree.carried import LinkPlace, look_of

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


Named = TypeVar("Named")


@dataclass(frozen=True, eq=False, kw_only=True)
class Robot(TreeModel):
    """A model that was read from a robot description, with its names.

    Attributes
    ----------
    links
        Every link by name, also those that were merged into another body.
    limits, mimics
        By joint name, as in the description.
    visuals, search
        The shapes of the links, and folders in which their meshes are searched.
    sensors
        Sensors by name, whose values are outputs, ``run["imu.x"]``, ``run["encoder"]``.
    keyframes
        States of the description by name, see `start`.
    notes
        Messages about content of the description that the model leaves out.
    """

    links: Mapping[str, LinkPlace] = field(default_factory=dict, repr=False)
    limits: Mapping[str, Limit] = field(default_factory=dict, repr=False)
    mimics: Mapping[str, Mimic] = field(default_factory=dict, repr=False)
    visuals: tuple[Visual, ...] = field(default=(), repr=False)
    search: tuple[str, ...] = field(default=(), repr=False)
    notes: tuple[str, ...] = field(default=(), repr=False)
    sensors: Mapping[str, Sensor] = field(default_factory=dict, repr=False)
    keyframes: Mapping[str, Keyframe] = field(default_factory=dict, repr=False)

    def start(self, keyframe: str) -> Callable[[System], Assembly]:
        """Return a keyframe as the start of a motion, ``sr.simulate(system, robot.start("home"), until=1.0)``.

        It has the positions, velocities and activations of the keyframe. Its controls are
        ``robot.keyframes["home"].controls``, for the option ``controls`` of the import.

        Raises
        ------
        ModelError
            If there is no such keyframe.
        """
        return start_at(keyframe, self._found("keyframe", self.keyframes, keyframe))

    def link(self, name: str) -> LinkPlace:
        """Return a link, which has points and frames in its own axes.

        Raises
        ------
        ModelError
            If there is no such link.
        """
        return self._found("link", self.links, name)

    def _found(self, kind: str, among: Mapping[str, Named], name: str) -> Named:
        if name not in among:
            message = f"there is no {kind} {quote(name)}. {suggest(name, among)}"
            raise ModelError(message, part=f"model {quote(self.name)}")
        return among[name]

    def point(self, link: str, coordinates: Vector = (0.0, 0.0, 0.0)) -> Point:
        """Return the point with these coordinates in the axes of a link [m]; its origin if left out."""
        x, y, z = coordinates
        return self.link(link).point(x, y, z)

    def frame(
        self, link: str, point: Vector = (0.0, 0.0, 0.0), *, x: Vector | None = None, z: Vector | None = None
    ) -> Frame:
        """Return a frame fixed to a link; point [m] and directions in the link's axes, by default the link's own."""
        return self.link(link).frame(point, x=x, z=z)

    def free_names(self, names: Iterable[str], ending: str) -> list[str]:
        """Return a name for each new part that no other part has; one that is taken gets the ending."""
        taken = {part.name for parts in self.sections().values() for part in parts}
        return list(legal(names, taken, ending).values())

    def looks(self) -> list[Look]:
        """The shapes of links in the description, on the bodies that the links belong to.

        A link without mass between two joints that became one has no place, and is not drawn.
        """
        seen = (visual for visual in self.visuals if visual.link in self.links)
        return [*super().looks(), *(look_of(visual, self.links, self.origin, self.search) for visual in seen)]

    def unwritten(self) -> tuple[str, ...]:
        """Return the kinds of data that only the description has."""
        named = {
            "shapes of links": self.visuals,
            "limits of joints": self.limits,
            "names of merged links": self.links.keys() - {body.name for body in self.bodies},
        }
        return tuple(name for name, found in named.items() if found)

    def loaded_by(self, ends: Mapping[str, Ends]) -> Robot:
        """Return the robot whose sensors of forces account for contacts and loops between these links."""
        contacts = {one.name: ends[one.name] for one in self.forces if isinstance(one, SphereContact)}
        sensors = {
            name: acted(one, contacts if one.kind == TOUCH else ends) for name, one in self.sensors.items()
        }
        idle = {name for name, one in sensors.items() if one.kind == TOUCH and not one.acting}
        text = "{n} touch [sensor of a body|sensors of bodies] without contacts: left out"
        notes = [counted(text, len(idle))] if idle else []
        left = {name: one for name, one in sensors.items() if name not in idle}
        return replace(self, sensors=left, notes=(*self.notes, *notes))
