"""Forces of a fluid on bodies: drag at a point, and drag, lift and added mass of boxes and ellipsoids."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import Annotated, Any, ClassVar

import numpy as np

from ... import elements
from ...algebra import Array, Row, cross
from ...elements import output
from ...elements.element import Scalar, Single, Vec3
from ...euler import B, G, rotate
from ...functions import sqrt
from ..errors import ModelError
from ..geometry.points import Frame, LocalPoint, Point
from ..geometry.pose import Poses
from ..laws.law import Law, scaled, varies
from ..laws.recorded import Recording
from ..measure import In, Offset, Ratio, Velocity
from ..parity import declared
from ..primitive import Primitive
from ..quantity import LARGEST, Vector, not_negative, number, positive, regularization, vector
from ..signals import Measure, Signal, Signals
from .force import Force, refuse_ground
from .formula_element import FormulaLoad, Target, load_primitive


class FluidShape:
    """Base of shapes in a fluid. The fluid does work by its wind only; the rest is dissipated."""

    s: Vec3  # [m] centre of the shape in the body
    f: Vec3  # [-] axes of the shape in the body
    g: Vec3  # [-]
    h: Vec3  # [-]
    wind: Vec3  # [m/s] velocity of the fluid in global axes

    def load(self, u: Array, w: Array) -> tuple[Array, Array]:
        """Force and torque about the centre along the axes of the shape.

        u is the velocity relative to the fluid and w the angular velocity, along the same axes.
        """
        raise NotImplementedError

    def dissipated_power(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """-F·u - T·w."""
        u, w = self._velocities(x, v)
        F, T = self.load(u, w)
        return -(F @ u) - T @ w

    def supplied_power(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """Power that the wind supplies, F·wind."""
        F, _ = self.load(*self._velocities(x, v))
        return F @ self._global_axes(x) @ self.wind

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        along, about = self.load(*self._velocities(x, v))
        F, T = along @ self._global_axes(x), about @ self._axes()
        return F, F @ B(x.p, self.s) + 2 * (T @ G(x.p))

    def _axes(self) -> Array:
        return np.array([self.f, self.g, self.h])

    def _global_axes(self, x: Single) -> Array:
        return np.array([rotate(x.p, axis) for axis in (self.f, self.g, self.h)])

    def _velocities(self, x: Single, v: Single) -> tuple[Array, Array]:
        """Velocity of the centre relative to the fluid, and angular velocity, along the axes of the shape."""
        u = self._global_axes(x) @ (v.r + B(x.p, self.s) @ v.p - self.wind)
        return u, self._axes() @ (2 * (G(x.p) @ v.p))


def checked_fluid(part: Any) -> tuple[Any, ...]:
    """Wind, density, viscosity, creep and angular creep of a shape's drag, checked."""
    density = not_negative(part.density, "density", "Give it in kg/m³.")
    viscosity = not_negative(part.viscosity, "viscosity", "Give it in Pa s.")
    creep = regularization(part.creep)
    angular = (
        creep if part.angular_creep is None else regularization(part.angular_creep, "angular_creep", "rad/s")
    )
    return vector(part.wind, "wind"), density, viscosity, creep, angular


SPEED = "speed"


class DragLoad(FormulaLoad, abstract=True):
    """Base of the classes of drags by laws: their power is dissipated, but for that of the wind."""

    def _drag(self, x: Any, v: Any, t: Scalar) -> tuple[elements.Drag, Any, Any]:
        last = len(self.structure.parts) - 1
        drag = self._measures()[-1].drag(self.values(x, v, t)[0])
        return drag, self._local(last, x), self._local(last, v)

    @output("m/s")
    def speed(self, x: Any, v: Any) -> Scalar:
        """sqrt(u·u + creep²)."""
        last = len(self.structure.parts) - 1
        return self._measures()[-1].speed(self._local(last, x), self._local(last, v))

    def dissipated_power(self, x: Any, v: Any, t: Scalar) -> Scalar:
        """-F·u."""
        drag, own, rates = self._drag(x, v, t)
        return drag.dissipated_power(own, rates, t)

    def supplied_power(self, x: Any, v: Any, t: Scalar) -> Scalar:
        """Of the wind, F·wind."""
        drag, own, rates = self._drag(x, v, t)
        return drag.supplied_power(own, rates, t)


@dataclass(frozen=True)
class DraggedPoint:
    """A point of a body that moves through a wind."""

    fields: ClassVar[dict[str, str]] = {"s": "Vec3", "wind": "Vec3", "creep": "Scalar"}
    bodies: ClassVar[int] = 1
    load: ClassVar[type[FormulaLoad]] = DragLoad

    s: Vec3  # [m] in the body
    wind: Vec3  # [m/s] in global axes
    creep: Scalar  # [m/s]

    def drag(self, c: Scalar) -> elements.Drag:
        """The drag with a coefficient."""
        return elements.Drag(self.s, c, self.wind, self.creep)

    def speed(self, x: Single, v: Single) -> Scalar:
        """sqrt(u·u + creep²)."""
        return self.drag(0).speed(x, v)


def resistance(of: DraggedPoint, values: Any, x: Single, v: Single, t: Scalar) -> Row:
    """Q of the drag with the coefficient that a law gives."""
    return of.drag(values[0]).Q(x, v, t)


@dataclass(frozen=True, eq=False)
class Drag(Force):
    """Quadratic drag: force −c |u| u at ``point``, with u its velocity through the air.

    Parameters
    ----------
    point
        The centre of pressure.
    c
        Half of density, area and drag coefficient [N s²/m²], or a law over the speed |u| [m/s], as of a sphere whose
        drag coefficient falls: a formula of ``x``, a table, or a Python function.
    wind
        Velocity of the air in global axes [m/s].
    creep
        [m/s] |u| is √(u² + creep²), so that the law has all its derivatives at rest.
    """

    parity = declared(wind="polar")

    point: Point
    c: Annotated[Law, In("N s^2/m^2", over="m/s")]
    wind: Velocity = (0.0, 0.0, 0.0)
    creep: Annotated[float, In("m/s")] = 1e-3

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the drag with a constant coefficient."""
        point, wind, creep = self._checked(poses)
        if not varies(self.c):
            c = not_negative(scaled(self.c, "c").factor, "c", "Give it in N s²/m².")
            yield Primitive(elements.Drag, (point.body,), (point.s, c, wind, creep), "drag")

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the drag whose coefficient is a law of the speed."""
        if varies(self.c):
            point, wind, creep = self._checked(signals.poses)
            measure = Measure(DraggedPoint, (point.body,), (point.s, wind, creep))
            scaled(self.c, "c")  # refuses what is no function of one variable
            recording = Recording("c", {"x": SPEED}, {})
            c = recording.law(self.c, "x")
            speed = [Signal(measure, SPEED, 2, 0, "m/s")] * len(recording.signals)
            yield load_primitive(Target(measure, resistance), [c], recording, speed)

    def _checked(self, poses: Poses) -> tuple[LocalPoint, Any, float]:
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        creep = regularization(self.creep)
        return point, vector(self.wind, "wind"), creep


@dataclass(frozen=True, eq=False)
class ViscousDrag(Force):
    """A force −c v at ``point``, v its velocity, and a torque −c_turn ω, as in a thick fluid.

    Parameters
    ----------
    point
        Where the force acts.
    c
        [N s/m]
    c_turn
        [N m s/rad]
    """

    point: Point
    c: Annotated[float, In("N s/m")] = 0.0
    c_turn: Annotated[float, In("N m s/rad")] = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        c, c_turn = (
            not_negative(self.c, "c", "Give it in N s/m."),
            not_negative(self.c_turn, "c_turn", "Give N m s/rad."),
        )
        yield Primitive(elements.ViscousDrag, (point.body,), (point.s, c, c_turn), "drag")


class BoxInFluid(FluidShape, elements.Force, bodies=1, derivatives="automatic", rare=True):
    """Resistance of a fluid to a box: drag and viscous forces along its axes, and torques about them.

    With the velocity u of the box's centre relative to the fluid and its angular velocity w, both along the box's
    axes, the sides b, the density ρ, the viscosity β and d = (b₁ + b₂ + b₃)/3:

        F₁ = -3π β d u₁ - ½ ρ b₂ b₃ |u₁| u₁,    T₁ = -π β d³ w₁ - ρ/64 b₁ (b₂⁴ + b₃⁴) |w₁| w₁,

    and likewise for the other axes. This is MuJoCo's model of a body in a fluid. |u| is sqrt(u² + creep²), and so is
    |w| with its own creep.
    """

    s: Vec3  # [m] centre of the box in the body
    f: Vec3  # [-] axes of the box in the body
    g: Vec3  # [-]
    h: Vec3  # [-]
    box: Vec3  # [m] its sides
    wind: Vec3  # [m/s] velocity of the fluid in global axes
    density: Scalar  # [kg/m³]
    viscosity: Scalar  # [Pa s]
    creep: Scalar  # [m/s]
    angular_creep: Scalar  # [rad/s]

    def load(self, u: Array, w: Array) -> tuple[Array, Array]:
        """F and T, see the class."""
        b, d, force, torque = self.box, sum(self.box) / 3, [], []
        for n in range(3):
            area, arms = b[n - 1] * b[n - 2], b[n - 1] ** 4 + b[n - 2] ** 4
            resistance = 3 * pi * self.viscosity * d + self.density * area / 2 * self._size(u[n], self.creep)
            spin = self._size(w[n], self.angular_creep)
            turning = pi * self.viscosity * d**3 + self.density * b[n] * arms / 64 * spin
            force.append(-resistance * u[n])
            torque.append(-turning * w[n])
        return np.array(force), np.array(torque)

    def _size(self, speed: Scalar, creep: Scalar) -> Scalar:
        return sqrt(speed * speed + creep * creep)


@dataclass(frozen=True, eq=False)
class BoxDrag(Force):
    """Resistance of a fluid to a body like a box: drag by the ``density``, and viscous forces.

    The forces along the three axes of the box, and the torques about them, are independent; there is no lift. Models of
    swimmers and flyers in MJCF use it, with the box that has the mass and the moments of inertia of the body.

    Parameters
    ----------
    frame
        Centre and axes of the box.
    box
        Its three sides [m].
    density
        Of the fluid [kg/m³].
    viscosity
        Of the fluid [Pa s].
    wind
        Velocity of the fluid [m/s], in global axes.
    creep, angular_creep
        Small speeds [m/s], [rad/s], below which drag is linear, so that it has derivatives at rest. By default the
        second one has the number of the first.
    """

    parity = declared(frame="polar", box="even", wind="polar")

    frame: Frame
    box: Offset
    density: Annotated[float, In("kg/m^3")] = 0.0
    viscosity: Annotated[float, In("N s/m^2")] = 0.0
    wind: Velocity = (0.0, 0.0, 0.0)
    creep: Annotated[float, In("m/s")] = 1e-5
    angular_creep: Annotated[float, In("rad/s")] | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        body, *place = self.frame.resolve(poses, "frame")
        refuse_ground(body, "frame")
        box = vector(self.box, "box", "Give the three sides in m.")
        for side in box:
            not_negative(side, "box", "Give the three sides in m.")
        yield Primitive(BoxInFluid, (body,), (*place, box, *checked_fluid(self)), "drag")


ROUNDS = np.finfo(float).nmant // 2  # each makes the rest of the integral four times smaller


def added_masses(semiaxes: Vector, density: float) -> tuple[Vector, Vector]:
    """Return masses [kg] along the axes of an ellipsoid in an ideal fluid and moments of inertia [kg m²] about them.

    H. Lamb, Hydrodynamics, 6th ed., §§ 114, 115. With semi-axes a, b, c, the volume V and α = abc ∫₀^∞ dl / ((a² +
    l)^(3/2) (b² + l)^(1/2) (c² + l)^(1/2)),

        m₁ = ρ V α / (2 - α),    I₁ = ρ V / 5 (b² - c²)² (γ - β) / (2 (b² - c²) + (b² + c²) (β - γ)),

    and likewise for the other axes, with β and γ for b and c in the place of a.
    """
    a, b, c = semiaxes
    mass = density * 4 / 3 * pi * a * b * c
    alpha, beta, gamma = _factor(a, b, c), _factor(b, c, a), _factor(c, a, b)
    masses = tuple(mass * one / (2 - one) for one in (alpha, beta, gamma))
    pairs = (b, c, beta, gamma), (c, a, gamma, alpha), (a, b, alpha, beta)
    return masses, tuple(mass / 5 * _square_of_radius(*pair) for pair in pairs)


def _factor(a: Any, b: Any, c: Any) -> Any:
    """α, which is 2/3 abc R_D(b², c², a²); R_D by duplication, B. C. Carlson, Numer. Algorithms 10 (1995) 13-26."""
    x, y, z, total = b * b, c * c, a * a, 0.0
    for n in range(ROUNDS):
        roots = np.sqrt(x), np.sqrt(y), np.sqrt(z)
        step = roots[0] * roots[1] + roots[1] * roots[2] + roots[2] * roots[0]
        total = total + 3 * 0.25**n / (roots[2] * (z + step))
        x, y, z = (x + step) / 4, (y + step) / 4, (z + step) / 4
    return 2 / 3 * a * b * c * (total + 0.25**ROUNDS * ((x + y + 3 * z) / 5) ** -1.5)


def _square_of_radius(b: Any, c: Any, beta: Any, gamma: Any) -> Any:
    """5 I₁ / (ρ V); it and its gradient vanish where b = c."""
    difference = b * b - c * c
    if difference == 0:
        return 0.0
    return difference**2 * (gamma - beta) / (2 * difference + (b * b + c * c) * (beta - gamma))


SMALLEST = 1e-250  # m⁵, of I₀: what is computed from smaller ones is not a number
LEAST = 1e-3  # of I₀ and creep: what is added to |k|, whose coefficients may be zero


class EllipsoidInFluid(FluidShape, elements.Force, bodies=1, derivatives="automatic", rare=True):
    """Forces of a fluid on an ellipsoid: drag, viscous resistance, lift, and the moments of its added mass.

    The velocity u of the centre relative to the fluid and the angular velocity w are along the axes of the ellipsoid,
    with semi-axes a, b, c and volume V; ρ is the density and β the viscosity of the fluid. With m = (bc, ca, ab), the
    projected area A = π √(Σ mᵢ⁴uᵢ² / Σ mᵢ²uᵢ²) along u, its largest value A₀, nᵢ = mᵢ²uᵢ, D = 2/3 (a + b + c), the
    moments Iᵢ = 8/15 π aᵢ max(aⱼ, aₖ)⁴, I₀ = 8/15 π (middle axis) (longest axis)⁴, the added masses μ and moments of
    inertia J:

        drag         F = -(3π β D + ρ |u| (C_blunt A + C_slender (A₀ - A))) u
                     T = -(π β D³ + ρ |k|) w,    kᵢ = (C_angular Iᵢ + C_slender (I₀ - Iᵢ)) wᵢ
        Magnus lift  F = C_magnus ρ V w × u
        Kutta lift   F = C_kutta ρ A (Σ mᵢ²uᵢ² / (|u| Σ mᵢ⁴uᵢ²)) (n × u) × u
        added mass   F = (μ u) × w,    T = (μ u) × u + (J w) × w

    This is MuJoCo's ellipsoid model, in which the inertia of the added mass, -μ u̇ and -J ẇ, does not act. In |u|, A
    and |k|, uᵢ² and wᵢ² are uᵢ² + creep²/3 and wᵢ² + angular_creep²/3, so that all derivatives exist at rest. |k| is
    k²/√(k² + 1e-6 angular_creep² I₀²), so that they exist without drag of rotations, too.
    """

    s: Vec3  # [m] centre of the ellipsoid in the body
    f: Vec3  # [-] its axes in the body
    g: Vec3  # [-]
    h: Vec3  # [-]
    semiaxes: Vec3  # [m]
    wind: Vec3  # [m/s] velocity of the fluid in global axes
    density: Scalar  # [kg/m³]
    viscosity: Scalar  # [Pa s]
    blunt_drag: Scalar  # [-]
    slender_drag: Scalar  # [-]
    kutta_lift: Scalar  # [-]
    magnus_lift: Scalar  # [-]
    area: Scalar  # [m²] largest projected area
    moment: Scalar  # [m⁵] I₀
    turning: Vec3  # [m⁵] kᵢ / wᵢ
    added_mass: Vec3  # [kg]
    added_inertia: Vec3  # [kg m²]
    creep: Scalar  # [m/s]
    angular_creep: Scalar  # [rad/s]

    def load(self, u: Array, w: Array) -> tuple[Array, Array]:
        """F and T, see the class."""
        a, b, c = self.semiaxes
        m = np.array([b * c, c * a, a * b]) * (pi / self.area)  # over their largest, as powers underflow
        m2 = m * m
        u2, w2 = u * u + self.creep * self.creep / 3, w * w + self.angular_creep * self.angular_creep / 3
        speed, N, D = sqrt(u2 @ np.array([1, 1, 1])), m2 @ u2, (m2 * m2) @ u2
        area, diameter = self.area * sqrt(D / N), 2 * (a + b + c) / 3
        drag = self.density * speed * (self.blunt_drag * area + self.slender_drag * (self.area - area))
        k = self.turning / self.moment
        k2 = (k * k) @ w2
        turning = self.density * self.moment * k2 / sqrt(k2 + (LEAST * self.angular_creep) ** 2)
        kutta = self.kutta_lift * self.density * area * N / (speed * D)
        magnus = self.magnus_lift * self.density * 4 / 3 * pi * a * b * c
        momentum = self.added_mass * u
        force = magnus * cross(w, u) + kutta * cross(cross(m2 * u, u), u) + cross(momentum, w)
        torque = cross(momentum, u) + cross(self.added_inertia * w, w)
        viscous = pi * self.viscosity * diameter
        return force - (3 * viscous + drag) * u, torque - (viscous * diameter**2 + turning) * w


@dataclass(frozen=True, eq=False)
class EllipsoidDrag(Force):
    """Drag, lift and moments of the added mass of a fluid on a body like an ellipsoid, such as a leaf or a fish.

    Lift by circulation (Kutta) and by rotation (Magnus) and the added mass do no work. As in MuJoCo, the inertia of the
    added mass is left out: it does not act on accelerations. The largest area and moments depend on which semi-axis is
    the longest: where two are equal, derivatives by one of them alone are those of one side.

    Parameters
    ----------
    frame
        Centre and axes of the ellipsoid.
    semiaxes
        Its three semi-axes [m].
    density
        Of the fluid [kg/m³].
    viscosity
        Of the fluid [Pa s].
    wind
        Velocity of the fluid [m/s], in global axes.
    blunt_drag
        Coefficient of drag of the projected area.
    slender_drag
        Coefficient of drag of the largest projected area, less the projected area.
    angular_drag
        Coefficient of drag of rotations.
    kutta_lift
        Coefficient of lift by circulation.
    magnus_lift
        Coefficient of lift by rotation.
    added_mass
        Masses of the fluid that moves along each axis [kg], by default those of an ellipsoid in an ideal fluid.
    added_inertia
        Moments of inertia of the fluid about each axis [kg m²], by default as for the masses.
    creep, angular_creep
        Small speeds [m/s], [rad/s], below which drag is linear, so that it has derivatives at rest. By default the
        second one has the number of the first.
    """

    parity = declared(frame="polar", wind="polar", semiaxes="even", added_mass="even", added_inertia="even")

    frame: Frame
    semiaxes: Offset
    density: Annotated[float, In("kg/m^3")] = 0.0
    viscosity: Annotated[float, In("N s/m^2")] = 0.0
    wind: Velocity = (0.0, 0.0, 0.0)
    blunt_drag: Ratio = 0.5
    slender_drag: Ratio = 0.25
    angular_drag: Ratio = 1.5
    kutta_lift: Ratio = 1.0
    magnus_lift: Ratio = 1.0
    added_mass: Annotated[Vector, In("kg")] | None = None
    added_inertia: Annotated[Vector, In("kg m^2")] | None = None
    creep: Annotated[float, In("m/s")] = 1e-5
    angular_creep: Annotated[float, In("rad/s")] | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        body, *place = self.frame.resolve(poses, "frame")
        refuse_ground(body, "frame")
        remedy = "Give the three semi-axes in m."
        a, b, c = (positive(one, "semiaxes", remedy) for one in vector(self.semiaxes, "semiaxes", remedy))
        _, middle, longest = sorted((a, b, c))
        if not SMALLEST < middle * longest**4 < LARGEST:
            size = "small" if longest < 1 else "large"
            message = f"semiaxes are too {size}, they are {a:.3g}, {b:.3g}, {c:.3g} m. {remedy}"
            raise ModelError(message, field="semiaxes")
        wind, density, viscosity, *creep = checked_fluid(self)
        drags = "blunt_drag", "slender_drag", "angular_drag"
        remedy = "Give a coefficient without a unit."
        blunt, slender, angular = (not_negative(getattr(self, one), one, remedy) for one in drags)
        lift = (number(getattr(self, one), one, remedy) for one in ("kutta_lift", "magnus_lift"))
        masses, inertias = added_masses((a, b, c), density)
        if self.added_mass is not None:
            remedy = "Give three masses in kg."
            masses = _three(self.added_mass, "added_mass", remedy)
        if self.added_inertia is not None:
            remedy = "Give three moments of inertia in kg m²."
            inertias = _three(self.added_inertia, "added_inertia", remedy)
        moments = [8 / 15 * pi * x * max(y, z) ** 4 for x, y, z in ((a, b, c), (b, c, a), (c, a, b))]
        most = 8 / 15 * pi * middle * longest**4
        turning = [angular * one + slender * (most - one) for one in moments]
        values = (
            *place, (a, b, c), wind, density, viscosity, blunt, slender, *lift,
            pi * middle * longest, most, turning, masses, inertias, *creep,
        )  # fmt: skip
        yield Primitive(EllipsoidInFluid, (body,), values, "drag")


def _three(values: Vector, field: str, remedy: str) -> tuple[float, float, float]:
    x, y, z = (not_negative(one, field, remedy) for one in vector(values, field, remedy))
    return x, y, z
