"""The rig: a suspension whose chassis is fixed, whose wheels stand on pads, and whose steering is driven."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..analyses.driven.kinematics import kinematics
from ..model import (
    PID,
    TSDA,
    AngleDriver,
    Bushing,
    DisplacementDriver,
    Distance,
    FirstOrderLag,
    Fixed,
    Model,
    PathFollower,
    PointDriver,
    SarrusError,
    StateSpaceBlock,
    TransferFunction,
    ground,
)
from ..model.drivers import Driver
from ..model.expression import parse
from ..model.expression.tree import lift
from ..model.forces.force import Force
from ..model.forces.tyre import RoadTyre, Tyre
from ..model.mirror_image import other_side
from ..model.show import quote, suggest
from ..model.states.driveline import Driveline
from ..model.tyres.rolling_tyre import RollingTyre
from ..model.written import following_numbers, written_numbers
from ..results import Trajectory
from ..system import System
from .characteristics import SweepName
from .corner import PlacedCorner, Side, of_rig
from .elastic import elastic_motion

TYRES = Tyre | RoadTyre | RollingTyre
CONTROLLERS = PID | FirstOrderLag | PathFollower | StateSpaceBlock | TransferFunction  # they load no part
REMEDY = (
    "Name the bodies that stand still with fixed={}, the joint that steers with steering=, and joints in which wheels "
    "spin as bearing of the corners; give bushings stiffness along and about all axes"
)
# The right wheel is in bump where the chassis rolls to the right
ROLL: dict[Side, float] = {"left": -1.0, "right": 1.0}


class Sweep(NamedTuple):
    """The motion of a sweep, whose time is the displacement, and why it ends early, if it does.

    With bushings it consists of equilibria, and velocities are their derivatives along the sweep.
    """

    run: Trajectory
    stopped: str


@dataclass(frozen=True)
class Rig:
    """A suspension on the rig.

    Attributes
    ----------
    system : the suspension
    corners : its wheels by side
    steering : the coordinate that steers, as the drivers name it; empty without one
    fixed : names of bodies that are fixed to the ground
    """

    system: System
    corners: Mapping[Side, PlacedCorner]
    steering: str
    fixed: tuple[str, ...]

    def loaded(self, sweep: SweepName, sign: float = 1.0) -> Model:
        """The model on the rig, whose time is the displacement of a sweep, times a sign.

        The rig's drivers replace those of the model, and its pads the tyres, with the drivelines on their spins and all
        controllers.
        """
        steering = self.steered(sign if sweep == "steer" else 0.0)
        return self.mounted([*steering, *(self._pad(side, sweep, sign) for side in self.corners)])

    def mounted(self, drivers: Sequence[Driver], loads: Sequence[Force] = ()) -> Model:
        """The model with the fixed bodies, the points of the corners, drivers and loads."""
        model, without = self.system.model, not_on_rig(self.system.model.forces)
        bodies = [one for one in model.bodies if one.name in self.fixed]
        fixed = [Fixed(of_rig("fixed", one.name), ground, one, point=one.position) for one in bodies]
        forces = [one for one in model.forces if one.name not in without]
        markers = [one for placed in self.corners.values() for one in placed.markers()]
        joints, drivers = [*model.joints, *fixed], [*self._bearings(), *drivers]
        return replace(model, joints=joints, drivers=drivers, forces=[*forces, *markers, *loads])

    def refuse_forces_of_tyres(self) -> None:
        """Refuse a model whose parts use outputs of what the rig removes."""
        names = sorted(not_on_rig(self.system.model.forces))
        try:
            System(self.mounted([])) if names else None
        except SarrusError as wrong:
            # With them, other errors remain
            System(self.mounted([], [one for one in self.system.model.forces if one.name in names]))
            raise SarrusError(
                f"{wrong} The rig has no tyres, drivelines of wheels and controllers ({', '.join(names)}): leave out "
                "what depends on them."
            ) from None

    def parameters(self) -> list[str]:
        """The names of the parameters of the suspension, without those of the rig.

        Hardpoints and parameters of the file are first; the numbers of parts that follow from them are left out, and
        those that move a joint in which a wheel centre or a spindle is, see `refuse_moved_joints`.
        """
        model, formulas = self.system.model, self.system.model.formulas
        own, free = written_numbers(model), formulas.free()
        following = following_numbers(model, {name: formulas.parameters[name] for name in free})
        numbers = [one for one in written_numbers(self.mounted([])) if one in own and one not in following]
        return [one for one in (*free, *numbers) if not self._moves_joint(one)]

    def refuse_moved_joints(self, names: Sequence[str]) -> None:
        """Refuse parameters that move a joint in which a wheel centre or a spindle is.

        Pads and loads are at global points, which follow hardpoints, but no joints.
        """
        for name in names:
            if moved := self._moves_joint(name):
                raise SarrusError(
                    f"{self.system.name}: {name} moves the joint {quote(moved)}, where a corner has its wheel centre "
                    "or spindle, and the rig does not follow joints. Give this point of the corner as a hardpoint."
                )

    def _moves_joint(self, name: str) -> str:
        """The joint with a wheel centre or a spindle that a parameter moves; empty if none."""
        formulas = self.system.model.formulas
        given = {name: formulas.parameters[name]} if name in formulas.parameters else {}
        moved = (name, *following_numbers(self.system.model, given))
        for placed in self.corners.values():
            carrier = placed.corner.carrier
            for point in (placed.points["centre"], placed.points["spindle"]):
                own = f"{point.part}.", f"{carrier}.position", f"{carrier}.orientation"
                if point.end and any(one.startswith(own) for one in moved):
                    return point.part
        return ""

    def _pad(self, side: Side, sweep: SweepName, sign: float) -> Driver:
        placed = self.corners[side]
        rate = sign * {"bump": 1.0, "roll": ROLL[side]}.get(sweep, 0.0)
        x, y, z = placed.coordinates("centre")
        height = lift(z) + parse(f"{rate!r}*t")
        return PointDriver(of_rig("pad", side), placed.body.global_point(x, y, z), z=height)

    def _bearings(self) -> list[Driver]:
        every = sorted(map(str, {placed.corner.bearing for placed in self.corners.values()} - {None}))
        return [self._coordinate(of_rig("brake", name), name, 0.0, "bearing") for name in every]

    def steered(self, rate: float) -> list[Driver]:
        """The driver of the steering, if there is one, from the design position."""
        return [self._coordinate(of_rig("steering"), self.steering, rate)] if self.steering else []

    def _coordinate(self, driver: str, joint: str, rate: float, word: str = "steering") -> Driver:
        """The driver of an angle or a displacement, from its value in the design position."""
        kind, name = coordinate(self.system, joint, word)
        joints = self.system.joint_coordinates
        value = float(joints.Phi(self.system.q0)[joints.index(name)])
        return kind(driver, joint, f"{value!r} + {rate!r}*t")

    def sweep(self, name: SweepName, limits: Sequence[float], steps: int) -> Sweep:
        """The motion of a sweep, as much of it as can be reached.

        Raises
        ------
        SarrusError
            If the rig does not determine the position of all parts.
        """
        low, high = limits
        system = System(self.loaded(name))
        falling = kinematics(System(self.loaded(name, -1.0)), np.linspace(0.0, -low, steps + 1 if low else 1))
        if falling.status == "not fully driven" and self._has_bushings and not system.states:
            return self._elastic(name, system, limits, steps, falling.message)
        if not len(falling.t):
            raise SarrusError(f"{name}: {falling.message}. {self._remedy}.")
        rising = np.linspace(0.0, high, steps + 1 if high else 1)
        grid = np.concatenate([-falling.t[:0:-1], rising])
        run = kinematics(system, grid, falling.q[-1])
        stopped = [(-falling.t[-1], falling), (run.t[-1], run)]
        messages = [f"{name} ends at {t:+.6g}: {one.message}." for t, one in stopped if not one.success]
        if not run.success:  # only a complete motion has derivatives
            run = kinematics(system, run.t, falling.q[-1])
        return Sweep(run, " ".join(messages))

    def _elastic(
        self, name: SweepName, system: System, limits: Sequence[float], steps: int, free: str
    ) -> Sweep:
        """The equilibria of a sweep, if forces keep the parts in place that constraints leave free."""
        below, above = (np.linspace(0.0, end, steps + 1 if end else 1) for end in limits)
        try:
            run, ends = elastic_motion(system, np.concatenate([below[:0:-1], above]))
        except SarrusError:
            raise SarrusError(f"{name}: {free}. {self._remedy}.") from None
        reached = zip((run.t[0], run.t[-1]), ends, strict=True)
        messages = [f"{name} ends at {t:+.6g}: {message}." for t, message in reached if message]
        return Sweep(run, " ".join(messages))

    @property
    def _remedy(self) -> str:
        """What to do about parts that are free: to fix the carrier of a side without a wheel, for example."""
        carriers = [placed.corner.carrier for placed in self.corners.values()]
        still = {other_side(one) for one in carriers} & {*self.system.bodies} - {*carriers, *self.fixed}
        return REMEDY.format(f"[{', '.join(map(quote, still))}]" if still else "")

    @property
    def _has_bushings(self) -> bool:
        return any(isinstance(one, Bushing) for one in self.system.model.forces)

    @property
    def has_virtual_kingpins(self) -> bool:
        """Whether steering axes can be found: a joint steers, and springs have two ends."""
        return bool(self.steering) and all(self._locked(placed) for placed in self.corners.values())

    def virtual_kingpins(self) -> Sweep | None:
        """The design position with unit velocity of the steering, while the lengths of the springs are constant.

        The knuckle then turns about its steering axis, which need not have joints: that of a multi-link suspension.
        With bushings, whose positions depend on loads, there is none.
        """
        locks = [lock for placed in self.corners.values() for lock in self._locked(placed)]
        model = self.mounted(self.steered(1.0))
        run = kinematics(System(replace(model, joints=[*model.joints, *locks])), [0.0])
        if run.status == "not fully driven" and self._has_bushings:
            return None
        if not run.success:
            raise SarrusError(f"kingpin: {run.message}. {self._remedy}.")
        return Sweep(run, "")

    def _locked(self, placed: PlacedCorner) -> list[Distance]:
        """The constraint that keeps the length of the spring of a corner; none if it has no two ends."""
        springs = [one for one in self.system.model.forces if one.name == placed.corner.spring]
        ends = [(one.point_i, one.point_j) for one in springs if isinstance(one, TSDA)]
        return [Distance(of_rig("lock", placed.side), *pair) for pair in ends]


def in_design_position(system: System) -> System:
    """Return the system whose bodies start in the design position: the same one if they do."""
    given = system.model.bodies
    if all(one.initial_position is None and one.initial_orientation is None for one in given):
        return system
    bodies = [replace(one, initial_position=None, initial_orientation=None) for one in given]
    return System(replace(system.model, bodies=bodies))


def not_on_rig(forces: Sequence[Force]) -> set[str]:
    """The names of tyres, of the parts of drivelines whose shafts are these or one another, and of controllers."""
    found, more = set[str](), {one.name for one in forces if isinstance(one, TYRES)}
    while more:
        found |= more
        drivelines = [one for one in forces if isinstance(one, Driveline) and one.name not in found]
        more = {one.name for one in drivelines if found & {getattr(one, field) for field in one.shafts}}
    return found | {one.name for one in forces if isinstance(one, CONTROLLERS)}


def coordinate(
    system: System, joint: str, word: str = "steering"
) -> tuple[type[AngleDriver | DisplacementDriver], str]:
    """The kind of driver of a joint's coordinate, and the full name of the coordinate; `word` names it in errors.

    Raises
    ------
    SarrusError
        If there is none.
    """
    known = system.joint_coordinates
    for kind, suffix in ((DisplacementDriver, "displacement"), (AngleDriver, "angle")):
        for name in (joint, f"{joint}.{suffix}"):
            if name in known.names and f".{suffix}" in name:
                return kind, name
    message = f"there is no joint coordinate {quote(joint)}. {suggest(joint, [*known.names])}"
    raise SarrusError(f"{word}: {message}")
