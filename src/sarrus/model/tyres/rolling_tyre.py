"""What rolling tyres share: the wheel, the road, and the treatment of standstill."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from ...elements.forces.tyres import TyreLaw, tyre_element
from ...elements.forces.tyres.contact import STATES
from ...elements.forces.tyres.contact import RollingTyre as RolledTyre
from ...elements.forces.tyres.rotor import Rotor
from ...elements.forces.tyres.spinning import SpinningTyre
from ..errors import ModelError
from ..forces.force import refuse_ground
from ..geometry.points import Point
from ..geometry.pose import Poses
from ..laws.curve import Curve, Formula
from ..laws.law import Law, scaled, varies
from ..laws.surface import Surface
from ..measure import Direction, In, Length, Ratio
from ..parity import Parities, declared
from ..primitive import Primitive
from ..quantity import direction, not_negative, number, positive, regularization, triple
from ..signals import Signals
from ..states.block import StateValue

SPIN = "spin"
LARGEST_DEFLECTION = 1e-2  # [m] the usual size of deflections, for tolerances
LARGEST_SPIN = 100.0  # [rad/s] likewise of spins


@dataclass(frozen=True, eq=False)
class RollingTyre:
    """A tyre of a wheel that rolls, slips and stands, with the forces and moments of a law of tyres.

    The states ``name.deflection_x`` and ``name.deflection_y`` [m] are the deflections of the contact, from which the
    slips follow. Outputs are ``name.load``, ``name.slip``, ``name.slip_angle`` and further ones of the contact.

    Parameters
    ----------
    point
        The wheel's centre.
    axis
        The spin axis, to the left of the direction of travel: global, in the design position.
    road
        Height of the road [m]: a number, a law over the global x [m], or a `Surface`.
    rounding
        Compression [m] over which the load sets in smoothly, as for `RoadTyre`.
    creep
        [m/s] Below this speed |V_x| is rounded, and the sign of V_x is tanh(V_x/creep).
    low_speed
        [m/s] Below this speed deflections are damped and bounded, which vanishes towards it.
    damping_time
        [s] Damping over stiffness of the deflections at standstill.
    shortest_relaxation
        [m] The least relaxation length: it replaces shorter ones, as those without load.
    spin_inertia
        [kg m²] Of all that spins, about the axis. With it, the wheel is no body: ``point`` and ``axis`` are of its
        carrier, whose mass and inertia include those of the wheel but that about the axis, and the spin is a state.
        Its outputs are ``name.spin``, absolute, ``name.rate``, relative to the carrier [rad/s], and
        ``name.spin_energy`` [J]. Parts of a driveline take the name of the tyre for a shaft.
    initial_spin
        [rad/s] Absolute spin about the axis at the start, positive forwards; only with ``spin_inertia``.
    """

    parity: ClassVar[Parities] = declared(axis="axial")  # to the left of the travel on both sides

    point: Point
    axis: Direction = field(default=(0.0, 1.0, 0.0), kw_only=True)
    road: Annotated[Law | Surface, In("m", over="m")] = field(default=0.0, kw_only=True)
    rounding: Length = field(default=1e-3, kw_only=True)
    creep: Annotated[float, In("m/s")] = field(default=0.1, kw_only=True)
    low_speed: Annotated[float, In("m/s")] = field(default=2.5, kw_only=True)
    damping_time: Annotated[float, In("s")] = field(default=5e-3, kw_only=True)
    shortest_relaxation: Length = field(default=0.02, kw_only=True)
    spin_inertia: Annotated[float | None, In("kg m^2")] = field(default=None, kw_only=True)
    initial_spin: Annotated[float, In("rad/s")] = field(default=0.0, kw_only=True)

    if TYPE_CHECKING:
        name: str

    @property
    def absent_numbers(self) -> Collection[tuple[str, ...]]:
        """The initial spin where it is no state."""
        return [("initial_spin",)] if self.spin_inertia is None else []

    @abstractmethod
    def tyre_law(self) -> tuple[type[TyreLaw], Mapping[str, Any]]:
        """Return the law, and its checked coefficients by name."""

    def law(self) -> TyreLaw:
        """Return the law with its coefficients, for its forces in given slips, as in diagrams."""
        kind, coefficients = self.tyre_law()
        return kind(coefficients)

    def states(self) -> Iterator[StateValue]:
        """Yield the two deflections, and the spin if it is a state."""
        for word in STATES:
            yield StateValue(f"{self.name}.{word}", 0.0, "m", LARGEST_DEFLECTION, self._block)
        initial = number(self.initial_spin, "initial_spin")
        if self.spin_inertia is not None:
            yield StateValue(f"{self.name}.{SPIN}", initial, "rad/s", LARGEST_SPIN, self._block)
        elif initial != 0:
            message = "initial_spin needs a spin that is a state. Give spin_inertia, or the wheel a velocity."
            raise ModelError(message, field="initial_spin")

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        axis = triple(poses[point.body].local_vector(direction(self.axis, "axis")))
        kind, coefficients = self.tyre_law()
        height, road = self._road()
        values = [
            point.s,
            axis,
            positive(self.rounding, "rounding", "Give a small length in m."),
            regularization(self.creep),
            positive(self.low_speed, "low_speed", "Give it in m/s, such as 2.5."),
            not_negative(self.damping_time, "damping_time", "Give it in s, or 0."),
            positive(self.shortest_relaxation, "shortest_relaxation", "Give a small length in m."),
            height,
        ]
        inertia = self.spin_inertia
        spins = [] if inertia is None else [positive(inertia, "spin_inertia", "Give it in kg m².")]
        values += [*spins, *([] if road is None else [road]), *coefficients.values()]
        of_road = "flat" if road is None else "surface" if isinstance(road, Surface) else "profile"
        element = tyre_element(SpinningTyre if spins else RolledTyre, kind, tuple(coefficients), of_road)
        bodies = self._block, point.body
        yield Primitive(element, bodies, tuple(values), "tyre")
        if spins:
            yield Primitive(Rotor, bodies, (*spins, axis), "rotor")

    def _road(self) -> tuple[Any, Curve | Formula | Surface | None]:
        """Return a constant height, and what is added to it if the road is not flat."""
        if isinstance(self.road, Surface):
            return 0.0, self.road
        size, curve = scaled(self.road, "road")
        return (0.0, curve) if varies(self.road) else (size, None)

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Refuse drivers that follow the states."""
        for name in [state.name for state in self.states()]:
            signals.used[name] = ()
            if name in signals.followed:
                message = (
                    f"the driver {signals.followed[name]} follows {name}, whose rate depends on velocities"
                )
                raise ModelError(f"{message}. Replace the driver by a force with a stiff controller.")
        yield from ()

    @property
    def _block(self) -> str:
        return f"states of {self.name}"


@dataclass(frozen=True, eq=False, kw_only=True)
class SimpleTyre(RollingTyre):
    """A tyre with a linear vertical spring and damper.

    Parameters
    ----------
    radius
        Of the unloaded wheel [m].
    k, c
        Vertical stiffness [N/m] and damping [N s/m].
    relaxation_x, relaxation_y
        Relaxation lengths [m] of the longitudinal and of the lateral deflection.
    rolling_resistance
        Rolling resistance moment over load and radius [-].
    """

    radius: Length
    k: Annotated[float, In("N/m")]
    c: Annotated[float, In("N s/m")] = 0.0
    relaxation_x: Length = 0.2
    relaxation_y: Length = 0.4
    rolling_resistance: Ratio = 0.0

    def wheel(self) -> dict[str, Any]:
        """Return the checked coefficients of the wheel."""
        return {
            "radius": positive(self.radius, "radius", "Give the unloaded radius in m."),
            "k": positive(self.k, "k", "Give the stiffness in N/m."),
            "c": not_negative(self.c, "c", "Give the damping in N s/m."),
            "sigma_x": positive(self.relaxation_x, "relaxation_x", "Give a length in m."),
            "sigma_y": positive(self.relaxation_y, "relaxation_y", "Give a length in m."),
            "rolling_resistance": not_negative(
                self.rolling_resistance, "rolling_resistance", "Give 0 or more."
            ),
        }
