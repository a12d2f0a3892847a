"""A system in which every built-in element occurs: arms on joints of all kinds, couplings, drivers and forces."""

from functools import cache

import numpy as np

import sarrus as sr

AXIS = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
GRID = np.linspace(-60, 60, 121)
HILLS = sr.Surface(GRID, GRID[50:71], 0.1 * np.sin(GRID[:, None]) * np.cos(GRID[50:71] / 2))


class Builder:
    """Collects bodies at random poses, and what connects them."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.bodies, self.joints, self.drivers, self.forces = [], [], [], []

    def body(self, eccentric: bool = False) -> sr.Body:
        """A body at a new place, turned anyhow, moving a little."""
        n, draw = len(self.bodies), self.random.normal
        p = draw(size=4)
        body = sr.Body(
            f"body_{n}",
            mass=1.0 + self.random.uniform(),
            inertia=tuple(0.5 + 0.2 * self.random.uniform(size=3)),
            position=(3.0 * (n // 2), 0.6 * (n % 2), 0.3 * draw()),
            orientation=tuple(p / np.linalg.norm(p)),
            center_of_mass=tuple(0.1 * draw(size=3)) if eccentric else None,
            velocity=tuple(0.1 * draw(size=3)),
            angular_velocity=tuple(0.1 * draw(size=3)),
        )
        self.bodies.append(body)
        return body

    def pair(self, kind: type, name: str, **options: object) -> tuple[sr.Body, sr.Body]:
        """Two bodies, the first hinged to the ground, the second on the first by a joint of a kind."""
        one, two = self.body(), self.body(eccentric=True)
        self.joints.append(sr.Revolute(f"{name}_arm", sr.ground, one, point=self.near(one), axis=self.axis()))
        self.joints.append(
            kind(name, one, two, **(options or {"point": self.near(two), "axis": self.axis()}))
        )
        return one, two

    def near(self, body: sr.Body) -> tuple[float, ...]:
        return tuple(np.array(body.position) + 0.3 * self.random.normal(size=3))

    def axis(self) -> tuple[float, ...]:
        return tuple(self.random.normal(size=3))

    def spot(self, body: sr.Body) -> object:
        return body.point(*(0.2 * self.random.normal(size=3)))


def _joints(b: Builder) -> None:
    b.pair(sr.Revolute, "pin")
    b.pair(sr.Cylindrical, "sleeve")
    b.pair(sr.Translational, "slide")
    b.pair(sr.Planar, "table")
    b.pair(sr.PointOnLine, "bead")
    b.pair(sr.PointOnPlane, "plate")
    one, two = b.pair(sr.ParallelAxes, "parallel", axis=b.axis())
    b.forces.append(sr.TSDA("hold", one.point(0, 0, 0), two.point(0, 0, 0.1), k=50.0, c=2.0, length=0.5))
    one, two = b.pair(sr.ConstantAngle, "inclined", axis_i=(1, 0, 0.3), axis_j=(0.2, 1, 0))
    b.forces.append(sr.Bushing("mount", one, two, point=b.near(two), stiffness=(50,) * 6, damping=(2,) * 6))
    b.pair(sr.Universal, "cross", point=(21.0, 0.2, 0.1), axis_i=(1, 0, 0), axis_j=(0, 1, 0))
    b.pair(sr.Spherical, "ball", point=(24.0, 0.2, 0.1))
    b.pair(sr.Fixed, "weld", point=(27.0, 0.2, 0.1))
    b.pair(sr.Screw, "thread", point=(30.0, 0.2, 0.1), axis=b.axis(), pitch=0.1)
    one, two = b.body(), b.body()
    b.joints.append(sr.Spherical("hook", sr.ground, one, point=b.near(one)))
    b.joints.append(sr.Distance("rod", b.spot(one), b.spot(two)))
    one, two = b.body(), b.body()
    b.joints.append(sr.Spherical("eye", sr.ground, one, point=b.near(one)))
    b.joints.append(sr.RevoluteSpherical("link", b.spot(one), b.spot(two), axis=(0.3, 0.2, 1)))


def _couplings(b: Builder) -> None:
    names = []
    for n in range(2):
        for kind, name in ((sr.Revolute, "wheel"), (sr.Translational, "cart")):
            one = b.body()
            b.joints.append(kind(f"{name}_{n}", sr.ground, one, point=b.near(one), axis=b.axis()))
            names.append(one)
    b.joints.append(sr.Gear("gear", "wheel_0", "wheel_1", ratio=-1.5))
    b.joints.append(sr.Coupler("rope", "cart_0.displacement", "cart_1.displacement", ratio=0.7))
    b.joints.append(sr.RackAndPinion("rack", "cart_0", "wheel_0", radius=0.3))


def _drivers(b: Builder) -> None:
    def tossed(t: object) -> object:
        return 0.1 * np.sin(3 * t)

    b.pair(sr.Revolute, "motor")
    b.drivers.append(sr.AngleDriver("turn", "motor", tossed))
    b.pair(sr.Translational, "ram")
    b.drivers.append(sr.DisplacementDriver("push", "ram", tossed))
    one, two = b.body(), b.body()
    b.joints.append(sr.Spherical("socket", sr.ground, one, point=b.near(one)))
    ends = np.array(two.position) - np.array(one.position)
    far = float(np.linalg.norm(ends))
    b.drivers.append(
        sr.DistanceDriver(
            "jack", one.point(0, 0, 0), two.point(0, 0, 0), lambda t: far + 0.05 * np.sin(2 * t)
        )
    )
    one = b.body()
    z = one.position[2]
    b.drivers.append(sr.CoordinateDriver("lift", one, "z", lambda t: z + 0.05 * np.sin(2 * t)))


def _forces(b: Builder) -> None:
    one, two = b.bodies[0], b.bodies[1]
    table = [(-5.0, 20.0), (0.0, 30.0), (1.0, 35.0), (5.0, 60.0)]
    about = {"point": b.near(two), "axis": b.axis()}
    damping = {"stiffness": 80.0, "damping": 0.3, "rounding": 0.05}
    b.forces += [
        sr.TSDA("spring", b.spot(one), b.spot(two), k=20.0, c=1.0, length=0.5, force=0.3),
        sr.TSDA("rope_", b.spot(one), b.spot(b.bodies[3]), k=table, c=1.0, length=0.5),
        sr.RSDA("coil", one, two, k=3.0, c=0.2, angle=0.1, torque=0.2, **about),
        sr.RSDA("clock", one, two, k=table, c=0.2, **about),
        sr.Drag("wind", b.spot(one), c=0.2, wind=(1.0, 0.2, 0.1), creep=0.1),
        sr.ViscousDrag("oil", b.spot(two), c=0.2, c_turn=0.1),
        sr.PointForce("pull", b.spot(two), force=(0.3, 0.2, 0.1)),
        sr.PointForce("jet", b.spot(two), force=(0.3, 0.2, 0.1), axes="body"),
        sr.PointForce("wave", b.spot(two), force=(lambda t: np.sin(t), 0.2, 0.1)),
        sr.PointForce("fan", b.spot(two), force=(lambda t: np.sin(t), 0.2, 0.1), axes="body"),
        sr.Torque("twist", one, torque=(0.3, 0.2, 0.1)),
        sr.Torque("spin", two, torque=(0.3, 0.2, 0.1), axes="body"),
        sr.Torque("swing", two, torque=(lambda t: np.sin(t), 0.2, 0.1)),
        sr.Torque("rotor", two, torque=(lambda t: np.sin(t), 0.2, 0.1), axes="body"),
        sr.AngleFriction("rub", one, two, load=2.0, mu=0.2, creep=0.2, radius=0.1, **about),
        sr.AngleInertia("armature", one, two, inertia=0.3, **about),
        sr.DisplacementInertia("nut", b.bodies[4], b.bodies[5], inertia=0.2, **about),
        sr.DisplacementFriction("scrape", b.bodies[4], b.bodies[5], load=2.0, mu=0.2, creep=0.2, **about),
        sr.Tyre("tyre", b.spot(one), k=30.0, c=1.0, radius=0.5, road=-0.2),
        sr.RoadTyre("wheel", b.spot(two), k=30.0, c=1.0, radius=0.7, road=lambda x: 0.1 * np.sin(x), rounding=0.1),
        sr.SphereContact("bump", b.spot(one), sr.ground.frame((0, 0, -0.3)), radius=0.4, mu=0.2, creep=0.2, **damping),
        sr.LengthStop("stay", b.spot(one), b.spot(two), lower=0.9, upper=1.5, **damping),
        sr.DisplacementStop("end", b.bodies[4], b.bodies[5], lower=0.1, upper=0.5, **about, **damping),
        sr.AngleStop("limit", one, two, lower=0.05, upper=0.5, **about, **damping),
        sr.RoadTyre("climber", b.spot(one), k=20.0, c=1.0, radius=0.7, road=HILLS, rounding=0.1),
    ]  # fmt: skip


@cache
def zoo(seed: int = 0) -> sr.System:
    """All of them in one system."""
    builder = Builder(seed)
    for add in (_joints, _couplings, _drivers, _forces):
        add(builder)
    parts = {"joints": builder.joints, "drivers": builder.drivers, "forces": builder.forces}
    return sr.System(sr.Model("zoo", bodies=builder.bodies, gravity=(0.1, 0.2, -2.0), **parts))
