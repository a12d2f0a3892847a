"""Two published suspensions, and their kinematics by Newton's method on the distances of their points, in 30 digits.

The points are those of public reports of Lotus suspension analyses: "4x4V23.shk" (v4.03) and "bat.shk" (v5.01, Scribd
821673379). Axes: x rearward, y outboard, z up, with the origin in the wheel centre of the design position.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from mpmath.ctx_mp import MPContext

import sarrus as sr

mp = MPContext()  # of its own: the digits of others stay
mp.dps = 30
STEP = mp.mpf(10) ** -6  # [mm] of central differences
MM = 1e-3
V23 = {
    "lower_front": (-105.88, 240.00, 65.40),
    "lower_rear": (116.32, 240.00, 25.57),
    "lower_ball": (-12.46, 562.18, -60.00),
    "upper_front": (-184.08, 240.00, 206.34),
    "upper_rear": (167.42, 240.00, 135.02),
    "upper_ball": (28.28, 538.13, 80.00),
    "tie_outer": (58.00, 526.75, 11.78),
    "tie_inner": (75.00, 230.23, 108.91),
    "damper_arm": (-7.78, 431.24, 29.98),
    "damper_body": (52.33, 262.89, 362.10),
    "spindle": (0.0, 551.87, 0.0),
    "centre": (0.0, 650.00, 0.0),
}
_BAT = {
    "lower_front": (3911.29, -175.37, 427.98),
    "lower_rear": (4234.54, -208.31, 305.45),
    "lower_ball": (4066.34, -688.22, 215.95),
    "upper_front": (3889.76, -252.86, 643.10),
    "upper_rear": (4332.88, -269.15, 506.27),
    "upper_ball": (4128.01, -618.94, 435.27),
    "tie_outer": (4024.33, -673.44, 340.23),
    "tie_inner": (3929.26, -287.85, 509.76),
    "damper_arm": (4108.06, -532.43, 492.61),
    "damper_body": (4155.98, -318.65, 802.41),
    "spindle": (4092.50, -655.70, 313.10),
    "centre": (4092.50, -750.00, 313.10),
}
BAT = {name: (x - 4092.50, -y, z - 313.10) for name, (x, y, z) in _BAT.items()}
RADIUS = {"V23": 279.40, "BAT": 225.00}
SUSPENSIONS = {"V23": V23, "BAT": BAT}


def metres(points: Mapping[str, tuple[float, ...]]) -> dict[str, tuple[float, ...]]:
    """The points in m."""
    return {name: tuple(MM * x for x in place) for name, place in points.items()}


def model(
    points: Mapping[str, tuple[float, ...]], *, rack: bool = False, damper_on: str = "lower_arm"
) -> sr.Model:
    """The right corner of a double wishbone suspension; with a rack, or with the inner tie rod on the ground."""
    p = metres(points)
    names = {
        "lower_arm": ("lower_front", "lower_rear", "lower_ball"),
        "upper_arm": ("upper_front", "upper_rear"),
    }
    arms = {
        name: sr.Body(
            name, 5.0, (0.1, 0.1, 0.1), position=tuple(np.mean([p[n] for n in own], axis=0).tolist())
        )
        for name, own in names.items()
    }
    knuckle = sr.Body("knuckle", 20.0, (0.5, 0.5, 0.5), position=p["centre"])
    bodies, joints, ground = [*arms.values(), knuckle], [], sr.ground
    for arm, ends in (("lower_arm", "lower"), ("upper_arm", "upper")):
        joints += [
            sr.Spherical(f"{ends}_front", ground, arms[arm], point=p[f"{ends}_front"]),
            sr.Spherical(f"{ends}_rear", ground, arms[arm], point=p[f"{ends}_rear"]),
            sr.Spherical(f"{ends}_ball", arms[arm], knuckle, point=p[f"{ends}_ball"]),
        ]
    inner = ground
    if rack:
        inner = sr.Body("rack_bar", 2.0, (0.1, 0.1, 0.1), position=p["tie_inner"])
        bodies.append(inner)
        joints.append(sr.Translational("rack", ground, inner, point=p["tie_inner"], axis=(0, 1, 0)))
    joints.append(
        sr.Distance("tie_rod", inner.global_point(*p["tie_inner"]), knuckle.global_point(*p["tie_outer"]))
    )
    ends = ground.global_point(*p["damper_body"]), arms[damper_on].global_point(*p["damper_arm"])
    return sr.Model("corner", bodies, joints, [sr.TSDA("spring", *ends, k=30e3, length=0.4, c=2e3)])


def corner(points: Mapping[str, tuple[float, ...]], radius: float, **other: object) -> sr.Corner:
    """Its wheel."""
    p = metres(points)
    given = {"kingpin": ("lower_ball", "upper_ball"), "spring": "spring"} | other
    return sr.Corner("knuckle", p["centre"], p["spindle"], MM * radius, **given)


Distances = (
    ("lower_front", "lower_ball"), ("lower_rear", "lower_ball"), ("upper_front", "upper_ball"),
    ("upper_rear", "upper_ball"), ("tie_inner", "tie_outer"),
)  # fmt: skip


@dataclass
class Reference:
    """The knuckle on five rods of constant length, its centre at a height; all values in mm and degrees."""

    points: Mapping[str, tuple[float, ...]]
    radius: float
    rack: float = 0.0
    starts: dict[int, list[mp.mpf]] = field(default_factory=dict)  # solutions near heights in mm
    known: dict[mp.mpf, dict[str, mp.mpf]] = field(default_factory=dict)
    exact: dict[str, mp.matrix] = field(init=False)

    def __post_init__(self) -> None:
        self.exact = {
            name: mp.matrix([mp.mpf(repr(float(x))) for x in place]) for name, place in self.points.items()
        }

    def pose(self, z: mp.mpf) -> Callable[[str], mp.matrix]:
        """Where the points of the knuckle are, with the wheel centre at a height z."""
        p, centre = self.exact, self.exact["centre"]
        lengths = [mp.norm(p[a] - p[b]) for a, b in Distances]

        def moved(x: list[mp.mpf], name: str) -> mp.matrix:
            return centre + mp.matrix(x[:3]) + rotation(x[3:]) * (p[name] - centre)

        def residual(*x: mp.mpf) -> list[mp.mpf]:
            inner = p["tie_inner"] + mp.matrix([0, self.rack, 0])
            ends = [inner if a == "tie_inner" else p[a] for a, _ in Distances]
            gaps = [
                mp.norm(a - moved(x, b)) - n for a, (_, b), n in zip(ends, Distances, lengths, strict=True)
            ]
            return [*gaps, x[2] - z]

        x = root(residual, self.starts.get(int(mp.nint(z)), [mp.mpf(0)] * 6))
        self.starts.setdefault(int(mp.nint(z)), x)
        return lambda name: moved(x, name)

    def values(self, z: mp.mpf) -> dict[str, mp.mpf]:
        """The characteristics with the names of the package."""
        if z not in self.known:
            self.known[z] = self._values(z)
        return self.known[z]

    def _values(self, z: mp.mpf) -> dict[str, mp.mpf]:
        at = self.pose(z)
        lower, upper, c, s = (at(name) for name in ("lower_ball", "upper_ball", "centre", "spindle"))
        s = (c - s) / mp.norm(c - s)
        k, down = upper - lower, s[2] * s - mp.matrix([0, 0, 1])
        a = c + self.radius * down / mp.norm(down)
        g, h = (lower + k * ((height - lower[2]) / k[2]) for height in (a[2], c[2]))
        caster = mp.degrees(mp.atan2(k[0], k[2]))
        return {
            "toe": -mp.degrees(mp.atan2(s[0], s[1])),
            "camber": -mp.degrees(mp.asin(s[2])),
            "caster": caster,
            "kingpin_inclination": mp.degrees(mp.atan2(-k[1], k[2])),
            "scrub_radius": a[1] - g[1],
            "caster_trail": a[0] - g[0],
            "mechanical_trail": (a[0] - g[0]) * mp.cos(mp.radians(caster)),
            "spindle_offset": c[1] - h[1],
            "hub_trail": c[0] - h[0],
            "wheel_recession": c[0] - self.exact["centre"][0],
            "contact_y": a[1],
            "contact_z": a[2],
        }  # fmt: skip

    def slope(self, name: str, z: float = 0.0) -> mp.mpf:
        """The derivative by z, with an error of 1e-18."""
        h, z = mp.mpf(10) ** -9, mp.mpf(z)
        return (self.values(z + h)[name] - self.values(z - h)[name]) / (2 * h)

    def roll_centre(self) -> mp.mpf:
        """The height above the road, with the wheel vertical: A_y dA_y/dA_z."""
        return self.values(mp.mpf(0))["contact_y"] * self.slope("contact_y") / self.slope("contact_z")

    def changed(self, point: str, axis: str, sign: int) -> "Reference":
        """The same with a coordinate of a point changed by a step."""
        other = Reference(self.points, self.radius, self.rack, self.starts)
        other.exact[point] = other.exact[point].copy()
        other.exact[point]["xyz".index(axis)] += sign * STEP
        return other

    def gradients(self, of: Sequence[Callable[["Reference"], mp.mpf]], point: str, axis: str) -> list[float]:
        """The derivatives of values by a coordinate of a point, with an error of 1e-12."""
        above, below = self.changed(point, axis, 1), self.changed(point, axis, -1)
        return [float((value(above) - value(below)) / (2 * STEP)) for value in of]


def root(f: Callable[..., list[mp.mpf]], x: list[mp.mpf]) -> list[mp.mpf]:
    """Newton's method with differences of 1e-12; the matrix of the third step is that of the later ones."""
    h = mp.mpf(10) ** -12
    for n in range(50):
        value = mp.matrix(f(*x))
        if n < 3:
            columns = [mp.matrix(f(*[y + h * (i == k) for i, y in enumerate(x)])) - value for k in range(6)]
            J = mp.matrix(6, 6)
            for k, column in enumerate(columns):
                J[:, k] = column / h
        step = mp.lu_solve(J, -value)
        x = [y + d for y, d in zip(x, step, strict=True)]
        if mp.norm(step) < mp.mpf(10) ** -25:
            return x
    raise ArithmeticError("Newton's method does not converge.")


def rotation(w: list[mp.mpf]) -> mp.matrix:
    """The rotation matrix of a rotation vector, by Cayley's formula for half of it."""
    a, b, c = (x / 2 for x in w)
    K = mp.matrix([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    return mp.eye(3) + (2 / (1 + a * a + b * b + c * c)) * (K + K * K)
