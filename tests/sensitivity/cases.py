"""Mechanisms with reference gradients, of real joints; their numbers follow from a few by a function."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

import sarrus as sr
from sarrus.model.written import with_numbers

LABELS = {"orientation": ("e0", "e1", "e2", "e3"), "inertia": ("xx", "yy", "zz")}
ACROSS = (0, 0, 1)


@dataclass(frozen=True, eq=False)
class Case:
    """A mechanism, the numbers that it follows from, and what is asked of its motion until a time.

    Bodies in `held` start as the function says, and the others where assembly finds them.
    """

    drawn: sr.Model
    design: Mapping[str, float]
    formula: Callable[[Mapping[str, float]], Mapping[str, object]]
    responses: Mapping[str, object]
    until: float
    held: tuple[str, ...] = ()

    @cached_property
    def system(self) -> sr.System:
        """The model with the numbers that follow from the design."""
        return sr.System(with_numbers(self.drawn, flat(self.formula(self.design))))

    def run(self, method: object = None, *, tolerance: float = 0.0, **settings: object) -> sr.Trajectory:
        """The motion, with its steps, by a method, perhaps with another tolerance."""
        start = sr.assemble(self.system, fixed=self.held)
        assert start.success, start.message
        options = {"until": self.until, "t_eval": [self.until], "store": "steps"} | settings
        by = sr.Radau() if method is None else method
        options["method"] = replace(by, rtol=tolerance, atol=tolerance) if tolerance else by
        found = sr.simulate(self.system, start, **options)
        assert found.success, found.message
        return found

    def gradient(self, run: sr.Trajectory, method: str = "adjoint") -> sr.Gradient:
        """Of all responses by all numbers of the design."""
        named = {"design": self.design, "formula": self.formula, "method": method}
        return sr.sensitivity(run, list(self.responses.values()), [*self.design], **named)

    def hessian(self, run: sr.Trajectory, name: str, wrt: list[str] | None = None) -> sr.Hessian:
        """Of one response."""
        named = {"design": self.design, "formula": self.formula}
        return sr.hessian(run, self.responses[name], wrt or [*self.design], **named)


def flat(numbers: Mapping[str, object]) -> dict[str, float]:
    """Vectors taken apart: `rod.position.x` and so on."""
    found = {}
    for name, value in numbers.items():
        labels = LABELS.get(name.rpartition(".")[2], ("x", "y", "z"))
        pairs = zip(labels, value, strict=True) if np.ndim(value) else [("", value)]
        found |= {f"{name}.{label}".rstrip("."): float(x) for label, x in pairs}
    return found


def bodies(names: str) -> list[sr.Body]:
    """Bodies that can turn in the plane, their numbers to be given."""
    turned, moved = sr.AxisAngle(ACROSS, 0.0), (0.0, 0.0, 0.0)
    given = {"mass": 1.0, "inertia": (1.0, 1.0, 1.0), "orientation": turned, "angular_velocity": moved}
    return [sr.Body(name, **given, velocity=moved, position=moved) for name in names.split()]


def hinge(name: str, i: object, j: object) -> sr.Revolute:
    """A hinge across the plane between two points of bodies, their places to be given."""
    frames = (sr.Frame(body.point(0.0, 0.0, 0.0), z=ACROSS) for body in (i, j))
    return sr.Revolute(name, i, j, **dict(zip(("frame_i", "frame_j"), frames, strict=True)))


def model(name: str, parts: list[sr.Body], joints: list[object], forces: list[object] = ()) -> sr.Model:
    """A model with weight."""
    return sr.Model(name, parts, joints, forces, gravity=(0.0, -1.0, -1.0))


def unit(angle: object) -> np.ndarray:
    """The direction of an angle in the plane."""
    return np.array([np.cos(angle), np.sin(angle), 0.0], dtype=object)


def across(angle: object) -> np.ndarray:
    """How it turns."""
    return np.array([-1 * np.sin(angle), np.cos(angle), 0.0], dtype=object)


def bar(name: str, mass: object, length: object) -> dict[str, object]:
    """A uniform bar; what it weighs about lines in the plane does not matter."""
    return {f"{name}.mass": mass, f"{name}.inertia.zz": mass * length**2 / 12}


def weight(g: object) -> dict[str, object]:
    return {"gravity": [0.0, -1 * g, 0.0]}


def oscillator() -> Case:
    """m ẍ + c ẋ + k x = 0 on a guide."""
    (mass,) = bodies("mass")
    guide = sr.Translational("guide", sr.ground, mass, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(-2.0, 0, 0), mass.point(0, 0, 0), k=1.0, c=1.0, length=2.0)
    names = {
        "m": "mass.mass",
        "c": "spring.c",
        "k": "spring.k",
        "x0": "mass.position.x",
        "v0": "mass.velocity.x",
    }
    responses = {
        "x_T": sr.Final("mass.x"),
        "v_T": sr.Final("mass.velocity.x"),
        "int_x2": sr.Integral(lambda o: o("mass.x") ** 2),
    }
    design = {"m": 2.0, "c": 0.6, "k": 50.0, "x0": 0.3, "v0": -1.2}
    drawn = model("oscillator", [mass], [guide], [spring])
    return Case(drawn, design, lambda d: {names[n]: x for n, x in d.items()}, responses, 3.0)


def pendulum(theta0: float = np.pi / 3) -> Case:
    """A point mass on a rod without one, from rest."""
    bob = sr.Body("bob", mass=1.0, inertia=(1, 1, 1), position=(1.0, 0, 0))
    rod = sr.Distance("rod", sr.ground.point(0, 0, 0), bob.point(0, 0, 0), length=1.0)

    def hung(d):
        return {
            "bob.position": [d["L"] * np.sin(d["theta0"]), -1 * d["L"] * np.cos(d["theta0"]), 0.0],
            "bob.mass": d["m"],
            "rod.length": d["L"],
            **weight(d["g"]),
        }

    def tension(o):
        x, y = o("bob.x"), o("bob.y")
        return -1 * (o("rod.force.x") * x + o("rod.force.y") * y) / np.sqrt(x**2 + y**2)

    responses = {
        "x": sr.Final("bob.x"),
        "y": sr.Final("bob.y"),
        "xd": sr.Final("bob.velocity.x"),
        "yd": sr.Final("bob.velocity.y"),
        "rod_tension": sr.Final(tension),
        "int_x2": sr.Integral(lambda o: o("bob.x") ** 2),
        "int_tension2": sr.Integral(lambda o: tension(o) ** 2),
    }
    design = {"L": 1.0, "g": 9.81, "theta0": theta0, "m": 1.0}
    return Case(model("pendulum", [bob], [rod]), design, hung, responses, 2.0)


def double_pendulum() -> Case:
    """Two uniform rods; everything starts where the angles and rates say."""
    one, two = bodies("one two")

    def hung(d):
        angles, rates, lengths = ([d[f"{n}{k}"] for k in (1, 2)] for n in ("th", "w", "L"))
        ends = [length * unit(angle) for length, angle in zip(lengths, angles, strict=True)]
        speeds = [
            rate * length * across(angle) for rate, length, angle in zip(rates, lengths, angles, strict=True)
        ]
        found = weight(d["g"]) | {
            "one.position": ends[0] / 2,
            "two.position": ends[0] + ends[1] / 2,
            "one.velocity": speeds[0] / 2,
            "two.velocity": speeds[0] + speeds[1] / 2,
            "top.frame_j.point.x": -0.5 * lengths[0],
            "knee.frame_i.point.x": 0.5 * lengths[0],
            "knee.frame_j.point.x": -0.5 * lengths[1],
        }
        for name, mass, length, angle, rate in zip(
            ("one", "two"), (d["m1"], d["m2"]), lengths, angles, rates, strict=True
        ):
            found |= bar(name, mass, length)
            found |= {f"{name}.orientation.angle": angle, f"{name}.angular_velocity.z": rate}
        return found

    def tip(o):
        return o.position("two", (0.5 * o.parameter("L2"), 0, 0))

    responses = {
        "tip_x": sr.Final(lambda o: tip(o)[0]),
        "tip_y": sr.Final(lambda o: tip(o)[1]),
        "tip_r2": sr.Final(lambda o: tip(o)[0] ** 2 + tip(o)[1] ** 2),
        "int_KE": sr.Integral("energy.kinetic"),
        "int_tip_minus_1_-1_sq": sr.Integral(lambda o: (tip(o)[0] - 1) ** 2 + (tip(o)[1] + 1) ** 2),
    }
    design = {
        "L1": 1.0, "L2": 0.8, "m1": 1.5, "m2": 1.2, "g": 9.81, "th1": 0.0, "th2": np.pi / 6, "w1": 0.5, "w2": -0.3
    }  # fmt: skip
    joints = [hinge("top", sr.ground, one), hinge("knee", one, two)]
    return Case(model("double pendulum", [one, two], joints), design, hung, responses, 1.5)


def four_bar() -> Case:
    """Crank, coupler and rocker, the last two assembled to a crank that stands and turns as given."""
    crank, coupler, rocker = bodies("crank coupler rocker")
    spring = sr.TSDA("spring", coupler.point(0, 0, 0), sr.ground.point(1.0, 3.5, 0), k=1.0, c=1.0, length=1.0)

    def placed(d):
        found = weight(d["g"]) | {
            "crank.position": 0.5 * d["L1"] * unit(d["th0"]),
            "crank.velocity": 0.5 * d["L1"] * d["w0"] * across(d["th0"]),
            "crank.orientation.angle": d["th0"],
            "crank.angular_velocity.z": d["w0"],
            "coupler.position": [1.0, 1.3, 0.0],  # guesses
            "rocker.position": [2.3, 0.9, 0.0],
            "coupler.orientation.angle": 0.3,
            "rocker.orientation.angle": -1.3,
            "A.frame_j.point.x": -0.5 * d["L1"],
            "C.frame_i.point.x": 0.5 * d["L1"],
            "C.frame_j.point.x": -0.5 * d["L2"],
            "D.frame_i.point.x": 0.5 * d["L2"],
            "D.frame_j.point.x": -0.5 * d["L3"],
            "B.frame_j.point.x": 0.5 * d["L3"],
            "B.frame_i.point.x": d["L0"],
            "spring.point_i.x": 0.5 * d["L2"],
            "spring.k": d["k"],
            "spring.length": d["l0"],
            "spring.c": d["c"],
        }
        for n, name in enumerate(("crank", "coupler", "rocker"), 1):
            found |= bar(name, d[f"m{n}"], d[f"L{n}"])
        return found

    def D(o):
        return o.position("coupler", (0.5 * o.parameter("L2"), 0, 0))

    responses = {
        "D_x": sr.Final(lambda o: D(o)[0]),
        "D_y": sr.Final(lambda o: D(o)[1]),
        "th_T": sr.Final("A.angle"),
        "w_T": sr.Final("A.angle.rate"),
        "int_D_minus_1.5_1.5_sq": sr.Integral(lambda o: (D(o)[0] - 1.5) ** 2 + (D(o)[1] - 1.5) ** 2),
        "int_KE": sr.Integral("energy.kinetic"),
    }
    design = {
        "L0": 2.5, "L1": 1.0, "L2": 2.2, "L3": 1.8, "m1": 1.0, "m2": 2.0, "m3": 1.5, "g": 9.81, "k": 40.0, "l0": 1.6,
        "c": 3.0, "th0": np.pi / 2, "w0": 6.0,
    }  # fmt: skip
    joints = [
        hinge(*made)
        for made in (
            ("A", sr.ground, crank),
            ("C", crank, coupler),
            ("D", coupler, rocker),
            ("B", sr.ground, rocker),
        )
    ]
    return Case(
        model("four-bar", [crank, coupler, rocker], joints, [spring]),
        design,
        placed,
        responses,
        2.0,
        ("crank",),
    )


def five_bar() -> Case:
    """Four uniform bars from A over P1, P2, P3 to B, and two springs to P2; from rest."""
    points = np.array([(0, 0, 0), (-0.5, 1, 0), (1, 2, 0), (2, 1, 0), (1.5, 0, 0)], dtype=float)
    lines, middles = np.diff(points, axis=0), (points[1:] + points[:-1]) / 2
    lengths = np.linalg.norm(lines, axis=1)
    bars = [
        sr.Body(
            f"bar{n}",
            1.0,
            (1.0, 1.0, 1.0),
            position=middle,
            orientation=sr.AxisAngle(ACROSS, np.arctan2(y, x)),
        )
        for n, (middle, (x, y, _)) in enumerate(zip(middles, lines, strict=True), 1)
    ]
    ends = [sr.ground, *bars, sr.ground]
    joints = [sr.Revolute(f"P{n}", ends[n], ends[n + 1], point=points[n], axis=ACROSS) for n in range(5)]
    top = bars[1].point(lengths[1] / 2, 0, 0)
    springs = [
        sr.TSDA(f"spring{n}", sr.ground.point(*points[at]), top, k=1.0, length=1.0)
        for n, at in ((1, 0), (2, 4))
    ]

    def given(d):
        found = weight(d["g"])
        for n, length in enumerate(lengths, 1):
            found |= bar(f"bar{n}", d[f"m{n}"], length)
        for n in (1, 2):
            found |= {f"spring{n}.k": d[f"k{n}"], f"spring{n}.length": d[f"L0{n}"]}
        return found

    def away(o):
        x, y, _ = o.position("bar2", (lengths[1] / 2, 0, 0))
        return (x - 1) ** 2 + (y - 2) ** 2

    design = {
        "L01": np.sqrt(5), "L02": np.sqrt(4.25), "k1": 100.0, "k2": 100.0, "m1": 1.0, "m2": 1.5, "m3": 1.5, "m4": 1.0,
        "g": 9.81,
    }  # fmt: skip
    return Case(model("five-bar", bars, joints, springs), design, given, {"J": sr.Integral(away)}, 2.0)


def spatial_slider_crank() -> Case:
    """Crank about x, rod with a ball and a cross, slider; rod and slider are assembled to the crank."""
    crank = sr.Body("crank", 1.0, (1.0, 1.0, 1.0), position=(1.0, 0, 0), orientation=sr.AxisAngle((1, 0, 0), 0.5),
                    angular_velocity=(1.0, 0, 0), velocity=(0.0, 0, 0))  # fmt: skip
    d = np.array([-4.0, 2.7, 2.2]) / np.linalg.norm([-4.0, 2.7, 2.2])  # a guess
    y = np.cross([0, 0, 1], d) / np.linalg.norm(np.cross([0, 0, 1], d))
    rod = sr.Body(
        "rod", 1.0, (1, 1, 1), position=(2.0, 1.4, 1.1), orientation=np.array([d, y, np.cross(d, y)]).T
    )
    slider = sr.Body("slider", 1.0, (1, 1, 1), position=(4.0, 0, 0))
    along = {"z": (1, 0, 0)}
    joints = [
        sr.Revolute("pin", sr.ground, crank, frame_i=sr.Frame(sr.ground.point(0.0, 0, 0), **along),
                    frame_j=sr.Frame(crank.point(0, 0.0, 0), **along)),
        sr.Spherical("ball", point_i=crank.point(0, 0.0, 0), point_j=rod.point(0.0, 0, 0)),
        sr.Universal("cross", slider, rod, frame_i=sr.Frame(slider.point(0, 0, 0), z=(0, 0, 1)),
                     frame_j=sr.Frame(rod.point(0.0, 0, 0), z=(0, 1, 0))),
        sr.Translational("guide", sr.ground, slider, frame_i=sr.Frame(sr.ground.point(0, 0, 0), **along),
                         frame_j=sr.Frame(slider.point(0, 0, 0), **along)),
    ]  # fmt: skip
    spring = sr.TSDA("spring", slider.point(0, 0, 0), sr.ground.point(10, 0, 0), k=1.0, c=1.0, length=1.0)

    def placed(d):
        c, s = np.cos(d["th0"]), np.sin(d["th0"])
        O, half = np.array([0.0, d["yc"], d["zc"]], dtype=object), 0.5 * d["lc"]
        return {
            "pin.frame_i.point": O,
            "pin.frame_j.point.y": -1 * half,
            "ball.point_i.y": half,
            "ball.point_j.x": 0.5 * d["lr"],
            "cross.frame_j.point.x": -0.5 * d["lr"],
            "crank.position": O + half * np.array([0.0, c, s], dtype=object),
            "crank.velocity": half * d["w0"] * np.array([0.0, -1 * s, c], dtype=object),
            "crank.orientation.angle": d["th0"],
            "crank.angular_velocity.x": d["w0"],
            "crank.mass": d["m1"],
            "rod.mass": d["m2"],
            "slider.mass": d["m3"],
            "spring.k": d["k"],
            "spring.c": d["c"],
            "spring.length": d["l0"],
            "gravity": [0.0, 0.0, -1 * d["g"]],
        }

    responses = {
        "x_T": sr.Final("slider.x"),
        "xd_T": sr.Final("slider.velocity.x"),
        "th_T": sr.Final(lambda o: o("pin.angle")),
        "w_T": sr.Final("pin.angle.rate"),
        "int_xd2": sr.Integral(lambda o: o("slider.velocity.x") ** 2),
        "int_KE": sr.Integral("energy.kinetic"),
        "int_stretch2": sr.Integral(lambda o: (o("spring.length") - 5) ** 2),
    }
    design = {
        "lc": 2.0, "lr": 5.0, "m1": 1.0, "m2": 1.0, "m3": 1.0, "k": 10.0, "l0": 5.0, "c": 1.0, "g": 9.81, "yc": 1.0,
        "zc": 1.2, "th0": 0.5, "w0": 2.0,
    }  # fmt: skip
    drawn = model("spatial slider-crank", [crank, rod, slider], joints, [spring])
    return Case(drawn, design, placed, responses, 2.0, ("crank",))


def free_top() -> Case:
    """A body that turns freely."""
    body = sr.Body("top", 1.0, (1.0, 1.0, 1.0), angular_velocity=(0.0, 0.0, 0.0))

    def given(d):
        return {
            "top.inertia": [d[f"J{n}"] for n in (1, 2, 3)],
            "top.angular_velocity": [d[f"w{n}"] for n in (1, 2, 3)],
        }

    def rate(o, n):
        return sum(x * y for x, y in zip(axes(o)[:, n], o.angular_velocity("top"), strict=True))

    def axes(o):
        return np.column_stack([o.position("top", e) - o.position("top") for e in np.eye(3)])

    responses = {
        **{f"e{n}": sr.Final(f"top.e{n}") for n in range(4)},
        **{f"w{n + 1}_T": sr.Final(lambda o, n=n: rate(o, n)) for n in range(3)},
        "int_w1sq": sr.Integral(lambda o: rate(o, 0) ** 2),
        "int_A33": sr.Integral(lambda o: axes(o)[2, 2]),
    }
    design = {"J1": 1.0, "J2": 2.5, "J3": 3.0, "w1": 0.3, "w2": 2.0, "w3": 0.1}
    return Case(sr.Model("free top", [body]), design, given, responses, 5.0)


def heavy_top() -> Case:
    """A body on a ball joint at the origin, with its centre of mass anywhere."""
    tilt = np.array([np.cos(0.3), np.sin(0.3), 0.0, 0.0])
    c, s = np.cos(0.6), np.sin(0.6)
    body = sr.Body("top", 1.0, (1.0, 1.0, 1.0), center_of_mass=(0.1, 0.1, 0.1), orientation=tilt,
                   angular_velocity=(0.0, 0.0, 0.0))  # fmt: skip
    foot = sr.Spherical("foot", sr.ground, body, point=(0, 0, 0))

    def given(d):
        x, y, z = (d[f"w{n}"] for n in (1, 2, 3))
        return {
            "top.mass": d["m"],
            "top.inertia": [d["Jx"], d["Jy"], d["Jz"]],
            "top.center_of_mass": [d["sx"], d["sy"], d["sz"]],
            "top.angular_velocity": [x, c * y - s * z, s * y + c * z],
            "gravity": [0.0, 0.0, -1 * d["g"]],
        }

    def center(o):
        return o.position("top", tuple(o.parameter(f"s{a}") for a in "xyz"))

    def rate3(o):
        axis = o.position("top", (0, 0, 1))
        return sum(x * y for x, y in zip(axis, o.angular_velocity("top"), strict=True))

    def spin(o):
        return sum(x**2 for x in o.angular_velocity("top"))

    responses = {
        **{f"com_{a}": sr.Final(lambda o, n=n: center(o)[n]) for n, a in enumerate("xyz")},
        "w3_T": sr.Final(rate3),
        "int_com_z": sr.Integral(lambda o: center(o)[2]),
        "int_w2": sr.Integral(spin),
    }
    design = {
        "m": 2.0, "sx": 0.05, "sy": -0.02, "sz": 0.4, "Jx": 0.08, "Jy": 0.1, "Jz": 0.05, "g": 9.81, "w1": 0.2,
        "w2": -0.1, "w3": 12.0,
    }  # fmt: skip
    return Case(model("heavy top", [body], [foot]), design, given, responses, 1.5)


def quarter_car(**numbers: float) -> sr.System:
    """Chassis and wheel above each other, at rest 0.05 m below where the tyre holds them."""
    k = {"ks": 14000.0, "cs": 1300.0, "kt": 180000.0} | numbers
    chassis = sr.Body("chassis", 250.0, (1.0, 1.0, 1.0), position=(0, 0, 1))
    wheel = sr.Body("wheel", 40.0, (1.0, 1.0, 1.0))
    joints = [
        sr.Translational(f"{body.name}_guide", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
        for body in (chassis, wheel)
    ]
    ends = chassis.point(0, 0, 0), wheel.point(0, 0, 0), sr.ground.point(0, 0, -1)
    forces = [
        sr.TSDA("strut", *ends[:2], k=k["ks"], c=k["cs"], length=1.0),
        sr.TSDA("tyre", *ends[1:], k=k["kt"], length=1.05),
    ]
    return sr.System(sr.Model("quarter car", [chassis, wheel], joints, forces))
