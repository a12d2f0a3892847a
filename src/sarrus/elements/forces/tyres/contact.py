"""The contact of a rolling tyre with a road: its axes, slips and deflections, and the force on the wheel.

With the wheel's centre C, its spin axis s (unit, to the left), its angular velocity ω, and the road's normal n at a
point P of it, the axes of the contact (TYDEX-W, ISO) and the point A are

    e_x = s × n/|s × n|,  e_y = n × e_x,  sin γ = s·n,  e_r = -(n - (n·s) s)/|n - (n·s) s|,  A = C + R_l e_r
    R_l = (C - P)·n/cos γ,   ρ̇ = -(v_A·n)/cos γ
    ψ̇ = (ω - (ω·s) s)·n/cos² γ,   Ω = ω·s - ψ̇ sin γ,   v_A = v_C + (ω - Ω s) × R_l e_r
    V_x = v_A·e_x,  V_sy = v_A·e_y,  V_sx = V_x - R_e Ω

The contact has no mass: its deflections u and v to the front and to the left [m] are first-order states of the tyre,

    u̇ = -V_sx - |V_x| u/σ_x,   v̇ = V_sy - |V_x| v/σ_y

[P12 7.1], and the law has the slips κ = u/σ_x and tan α = v/σ_y. There is no division by V_x: at standstill, the tyre
is a spring of the stiffness K/σ, which holds a vehicle on a slope without creep. Below the speed `low_speed` the
slips are damped, κ = (u + τ w u̇)/σ_x, and are bounded, so that a wheel that slides at V_x = 0 does not wind up: in
place of |V_x|, both rates have the greater one of |V_x| and

    V_m = w √((V_sx/κ_mx)² + (V_sy/κ_my)²),   w = w(V_x/low_speed)

with the slips κ_m at which the friction is that of full sliding. Friction is then against the sliding velocity, as V_sx
and V_sy have the same factor, and a wheel that rolls has the same slips at all speeds. The greater one is |V_x| where
V_m is less, and V_m - creep where V_m is greater by 3/2 `creep`; near rest it is exactly |V_x|. |V_x| is
V_x tanh(V_x/creep). Off the road, `low_speed` is added to it, and deflections vanish. Where the wheel leans
by more than 60°, the load fades; beyond 70° there is none.

Bodies are the block of the states, and the wheel. All derivatives are made by differentiating Q.
"""

from __future__ import annotations

import copyreg
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ...._jit.formulas.functions import asin, atan, sqrt, tanh
from ....algebra import Array, Row, cross
from ....euler import E, rotate
from ...element import Curve, Force, Pair, Scalar, Surface, Validity, Vec3
from ...output import output
from ..laws import soft_ramp, soft_step
from .law import Slip, TyreLaw, Wrench
from .rounding import SMALLEST, at_least, fading, limited, rounded_absolute

STATES = ("deflection_x", "deflection_y")
MASS = 1.0  # [kg] of the block of the states, a scale alone
LEANING = (0.25, 0.1170)  # cos² of 60° and of 70°
LARGEST = 70.0  # [deg]
LEAST = 1.0  # [N] load by which the use of friction is divided at least
ROADS: dict[str, dict[str, str]] = {
    "flat": {},
    "profile": {"profile": "Curve"},  # [m] height over the global x [m]
    "surface": {"surface": "Surface"},  # [m] height over the global x and y [m]
}


class Contact(NamedTuple):
    """The contact at a state of the wheel."""

    e_x: Array
    e_y: Array
    n: Array
    place: Array  # A [m]
    sin_gamma: Any
    upright: Any  # cos² γ
    loaded: Any  # R_l [m]
    spin: Any  # Ω [rad/s]
    yaw: Any  # ψ̇ [rad/s]
    velocity: Array  # v_A [m/s]

    @property
    def gamma(self) -> Any:
        """The inclination [rad]; near 90° it is limited."""
        return asin(limited(self.sin_gamma, -0.9, 0.9))


class Sliding(NamedTuple):
    """What moves in a contact."""

    load: Any  # F_z [N]
    V_x: Any  # [m/s]
    V_sx: Any  # [m/s]
    rates: tuple[Any, Any]  # u̇, v̇ [m/s]
    slip: Slip


class TyreType(type):
    """Type of the classes of tyres, which are pickled by law, coefficients and road."""


class RollingTyre(Force, abstract=True, metaclass=TyreType):
    """Base of the classes of rolling tyres: one for each law, names of its coefficients, and kind of road."""

    law: ClassVar[type[TyreLaw]]
    coefficients: ClassVar[tuple[str, ...]]
    kind_of_road: ClassVar[str]  # of `ROADS`
    prefix: ClassVar[str] = ""  # of the names of its classes
    validity: ClassVar[Validity | None] = Validity(
        "lean", -LARGEST, LARGEST, "its contact ends where the wheel leans by [deg]",
        "where the wheel passes through the road. Hold it by contacts of its body, such as sr.SphereContact, or end "
        "the run there by an event."
    )  # fmt: skip

    s: Vec3  # [m] wheel centre in the wheel
    axis: Vec3  # [-] spin axis in the wheel, to the left
    rounding: Scalar  # [m] of the rounding of the load
    creep: Scalar  # [m/s] of the rounding of |V_x|
    low_speed: Scalar  # [m/s] below which deflections are damped and bounded
    damping_time: Scalar  # [s] τ
    shortest: Scalar  # [m] the least relaxation length
    road: Scalar  # [m] height that is added to the profile or the surface

    if TYPE_CHECKING:  # those of `ROADS`
        profile: Curve
        surface: Surface

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        hidden = ("force_i", "torque_i", "force_i_body", "torque_i_body")  # of the block of the states
        cls.outputs = {word: one for word, one in cls.outputs.items() if word not in hidden}

    def _law(self) -> TyreLaw:
        return self.law({name: getattr(self, name) for name in self.coefficients})

    def _contact(self, x: Pair, v: Pair) -> Contact:
        C, s, omega = x.r_j + rotate(x.p_j, self.s), rotate(x.p_j, self.axis), 2 * (E(x.p_j) @ v.p_j)
        v_C, at = v.r_j + cross(omega, C - x.r_j), C
        P, n = self._plane(at)
        if self.kind_of_road != "flat":  # the plane below the contact of the plane below the centre
            _, _, _, at = _place(C, s, P, n)
            P, n = self._plane(at)
        sin_gamma, upright, loaded, place = _place(C, s, P, n)
        e_x = cross(s, n) / sqrt(upright)
        across = omega - (omega @ s) * s
        yaw = across @ n / upright
        spin = omega @ s - yaw * sin_gamma
        velocity = v_C + cross(omega - spin * s, place - C)
        return Contact(e_x, cross(n, e_x), n, place, sin_gamma, upright, loaded, spin, yaw, velocity)

    def lean(self, x: Pair, v: Pair) -> Any:
        """The inclination as far as 90° [deg]."""
        c = self._contact(x, v)
        return 180 / np.pi * atan(c.sin_gamma / sqrt(c.upright))

    def _plane(self, at: Array) -> tuple[Array, Array]:
        """A point of the road below a place, and the normal there."""
        if self.kind_of_road == "flat":
            return np.array([at[0], at[1], self.road]), np.array([0, 0, 1])
        if self.kind_of_road == "profile":
            height, z_x, z_y = self.profile(at[0]), self.profile.slope(at[0]), 0
        else:
            height, z_x, z_y = (self.surface.derivative(at[0], at[1], *n) for n in ((0, 0), (1, 0), (0, 1)))
        long = sqrt(1 + z_x * z_x + z_y * z_y)
        return np.array([at[0], at[1], self.road + height]), np.array([-z_x / long, -z_y / long, 1 / long])

    def _sliding(self, c: Contact, x: Pair, v: Pair) -> Sliding:
        law = self._law()
        depth, rate = self._depth(c), -(c.velocity @ c.n) / sqrt(c.upright)
        fades = soft_step(c.upright - sum(LEANING) / 2, LEANING[0] - LEANING[1])
        load = fades * law.vertical_force(depth, rate, c.spin, self.rounding)
        lifted = 1 - fades * soft_step(depth, self.rounding)
        V_x, V_sy = c.velocity @ c.e_x, c.velocity @ c.e_y
        V_sx = V_x - law.rolling_radius(c.loaded, load, c.spin) * c.spin
        direction, standing = tanh(V_x / self.creep), fading(V_x, self.low_speed)
        still = Slip(0, 0, c.gamma, load, V_x, direction)
        if law.turns:
            passed = at_least(sqrt(V_x * V_x + V_sy * V_sy + SMALLEST * SMALLEST), self.creep)
            still = still._replace(turn=c.yaw / passed, roll=c.spin / passed)
        slip = law.in_range(still)
        sigma_x, sigma_y = (at_least(length, self.shortest) for length in law.relaxation_lengths(slip))
        passing = self._passing(slip, standing, V_sx, V_sy) + lifted * self.low_speed
        u, deflected = v.r_i[0], v.r_i[1]
        rates = -V_sx - passing / sigma_x * u, V_sy - passing / sigma_y * deflected
        damped = self.damping_time * standing
        kappa, tan_alpha = (u + damped * rates[0]) / sigma_x, (deflected + damped * rates[1]) / sigma_y
        return Sliding(load, V_x, V_sx, rates, law.in_range(still._replace(kappa=kappa, tan_alpha=tan_alpha)))

    def _depth(self, c: Contact) -> Any:
        return self._law().depth(c.loaded, c.spin, c.gamma)

    def _passing(self, slip: Slip, standing: Any, V_sx: Any, V_sy: Any) -> Any:
        """The greater one of |V_x| and V_m [m/s]; the load of κ_m is at least that at the compression `rounding`."""
        law, rolled = self._law(), rounded_absolute(slip.speed, self.creep)
        least = law.vertical_force(self.rounding, 0, 0, self.rounding)
        x, y = law.sliding_slips(at_least(slip.load, least))
        slides = standing * sqrt(V_sx * V_sx / (x * x) + V_sy * V_sy / (y * y) + SMALLEST * SMALLEST)
        return rolled + soft_ramp(slides - rolled - self.creep, self.creep)

    def _at(self, x: Pair, v: Pair) -> tuple[Contact, Sliding, Wrench]:
        c = self._contact(x, v)
        moving = self._sliding(c, x, v)
        return c, moving, self._law().wrench(moving.slip)

    def Q(self, x: Pair, v: Pair, t: Any) -> Row:
        c, moving, w = self._at(x, v)
        F = w.F_x * c.e_x + w.F_y * c.e_y + moving.load * c.n
        M = w.M_x * c.e_x + w.M_y * c.e_y + w.M_z * c.n + cross(c.place - x.r_j, F)
        u_dot, v_dot = moving.rates
        return np.array([MASS * u_dot, MASS * v_dot, 0]), None, F, 2 * (M @ E(x.p_j))

    def power(self, x: Pair, v: Pair, t: Any) -> Any:
        """The power on the wheel."""
        _, _, F, torque = self.Q(x, v, t)
        return F @ v.r_j + torque @ v.p_j

    def stored_energy(self, x: Pair, v: Pair, t: Any) -> Any:
        """The energy of the vertical spring."""
        c = self._contact(x, v)
        return self._law().stored_energy(self._depth(c), self.rounding)

    def dissipated_power(self, x: Pair, v: Pair, t: Any) -> Any:
        """All power that the vertical spring does not store; the energy of u and v is counted as dissipated."""
        c = self._contact(x, v)
        law, rate = self._law(), -(c.velocity @ c.n) / sqrt(c.upright)
        elastic = law.vertical_force(self._depth(c), 0, 0, self.rounding)
        return -self.power(x, v, t) - elastic * rate

    def supplied_power(self, x: Pair, v: Pair, t: Any) -> Any:
        """Zero."""
        return 0

    @output("m")
    def compression(self, x: Pair, v: Pair) -> Any:
        """ρ; negative where the tyre is off the road."""
        return self._depth(self._contact(x, v))

    @output("N")
    def load(self, x: Pair, v: Pair) -> Any:
        """F_z."""
        return self._sliding(self._contact(x, v), x, v).load

    @output("1", "slip")
    def longitudinal_slip(self, x: Pair, v: Pair) -> Any:
        """κ, of the deflection."""
        return self._sliding(self._contact(x, v), x, v).slip.kappa

    @output("rad")
    def slip_angle(self, x: Pair, v: Pair) -> Any:
        """α, of the deflection."""
        return self._sliding(self._contact(x, v), x, v).slip.alpha

    @output("rad")
    def inclination(self, x: Pair, v: Pair) -> Any:
        """γ, positive where the top of the wheel is to the right."""
        return self._contact(x, v).gamma

    @output("m/s")
    def slip_velocity(self, x: Pair, v: Pair) -> Any:
        """V_sx, the forward velocity of the rolling contact."""
        return self._sliding(self._contact(x, v), x, v).V_sx

    @output("N")
    def longitudinal_force(self, x: Pair, v: Pair) -> Any:
        """F_x, forwards."""
        return self._at(x, v)[2].F_x

    @output("N")
    def lateral_force(self, x: Pair, v: Pair) -> Any:
        """F_y, to the left."""
        return self._at(x, v)[2].F_y

    @output("N m")
    def overturning_moment(self, x: Pair, v: Pair) -> Any:
        """M_x."""
        return self._at(x, v)[2].M_x

    @output("N m")
    def rolling_moment(self, x: Pair, v: Pair) -> Any:
        """M_y."""
        return self._at(x, v)[2].M_y

    @output("N m")
    def aligning_moment(self, x: Pair, v: Pair) -> Any:
        """M_z."""
        return self._at(x, v)[2].M_z

    @output("1")
    def friction_use(self, x: Pair, v: Pair) -> Any:
        """√(F_x² + F_y²)/F_z; zero without load."""
        _, moving, w = self._at(x, v)
        return sqrt(w.F_x * w.F_x + w.F_y * w.F_y + SMALLEST * SMALLEST) / at_least(moving.load, LEAST)


def _place(C: Array, s: Array, P: Array, n: Array) -> tuple[Any, Any, Any, Array]:
    """sin γ, cos² γ, R_l and A. A wheel that lies on its side has no direction down: cos² γ is at least 1e-6."""
    sin_gamma = s @ n
    upright = at_least(1 - sin_gamma * sin_gamma, 1e-6)
    down = (sin_gamma * s - n) / sqrt(upright)
    loaded = (C - P) @ n / sqrt(upright)
    return sin_gamma, upright, loaded, C + loaded * down


@lru_cache(1000)
def tyre_element(
    base: type[RollingTyre], law: type[TyreLaw], coefficients: tuple[str, ...], road: str
) -> type[RollingTyre]:
    """The element's class for a law, the names of its coefficients, and a kind of road, see `ROADS`."""
    fields = ROADS[road] | dict.fromkeys(coefficients, "Scalar")
    body: dict[str, Any] = {"__annotations__": fields, "__module__": __name__, "__doc__": law.__doc__}
    body |= {"law": law, "coefficients": coefficients, "kind_of_road": road}
    options: dict[str, Any] = {"derivatives": "automatic", "rare": True, "registered": False}
    made: Any = TyreType(f"{base.prefix}{law.__name__}Tyre", (base,), body, bodies=2, **options)
    found: type[RollingTyre] = made
    return found


def _reduced(kind: Any) -> Any:
    if "law" not in vars(kind):  # a base
        return kind.__qualname__
    return tyre_element, (kind.__base__, kind.law, kind.coefficients, kind.kind_of_road)


copyreg.pickle(TyreType, _reduced)
