"""Models as MJCF: nested bodies with joints, equalities that close loops, tendons for springs and rods."""

from __future__ import annotations

import warnings
from math import inf
from xml.etree.ElementTree import Element

import numpy as np

from ...model import Fixed, Revolute, Spherical
from ...model.bodies.shape import Look
from ...model.errors import SarrusWarning
from ...model.geometry.motion import Ball, Free, Motion, Slide, Turn
from ...model.geometry.points import GROUND
from ...model.quantity import Array, Vec3
from ..robot import Activation, Edge
from ..robot.description import WORLD
from .contents import Contents
from .looks import rgba
from .xml import child, numbers, text_of

CUT = (Fixed, Revolute, Spherical)  # joints that equalities can have
RIGID = "0.9999 0.9999 0.001 0.5 2"  # solimp: as rigid as MuJoCo permits
SMALLEST = 1e-14  # principal moment [kg m²] that MuJoCo reads
FAR = 1e6  # the end of a range that is not given
ACCURATE = {"integrator": "RK4", "timestep": "0.001"}


def mjcf(contents: Contents) -> str:
    """Return the text of an MJCF file."""
    _warn_of_moments(contents)
    return text_of(_Writer(contents).root)


def _warn_of_moments(contents: Contents) -> None:
    """Warn of bodies for which MuJoCo refuses the file."""
    moments = {
        edge.child: np.linalg.eigvalsh(contents.inertials[edge.child].tensor) for edge in contents.edges
    }
    wrong = [name for name, (a, b, c) in moments.items() if a < SMALLEST or a + b < c]
    if wrong:
        message = "MuJoCo reads no file with a principal moment of zero, or larger than the sum of the others"
        message = f"{contents.name}: {message}, as of {', '.join(wrong)}. Give these bodies another inertia."
        warnings.warn(message, SarrusWarning, stacklevel=5)


class _Writer:
    def __init__(self, contents: Contents) -> None:
        self.contents = contents
        self.root = Element("mujoco", model=contents.name)
        settings = {"angle": "radian", "autolimits": "true", "inertiafromgeom": "false", "boundmass": "0"}
        child(self.root, "compiler", balanceinertia="false", fusestatic="false", **settings)
        child(self.root, "option", gravity=contents.gravity, **ACCURATE)
        self.bodies = {WORLD: child(self.root, "worldbody")}
        for edge in contents.edges:
            self._body(edge)
        self.sites = 0
        self.sections: dict[str, Element] = {}
        for name, write in (
            ("tendon", self._tendons),
            ("equality", self._equalities),
            ("actuator", self._actuators),
        ):
            self.sections[name] = Element(name)
            write()
        self.root.extend(section for section in self.sections.values() if len(section))
        self._looks()
        self._start()

    def _body(self, edge: Edge) -> None:
        free = any(isinstance(motion, Free) for motion in edge.motions)
        pose = self.contents.poses[edge.child] if free else edge.pose
        body = child(self.bodies[edge.parent], "body", name=edge.child, pos=pose.r, quat=pose.p)
        self.bodies[edge.child] = body
        for motion in edge.motions:
            self._joint(body, motion)
        mass, center, J = self.contents.inertials[edge.child]
        entries = [J[i, k] for i, k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        child(body, "inertial", pos=center, mass=mass, fullinertia=entries)

    def _joint(self, body: Element, motion: Motion) -> None:
        if isinstance(motion, Free):
            child(body, "freejoint", name=motion.name)
            return
        joint = child(body, "joint", name=motion.name)
        if isinstance(motion, Turn | Ball):
            joint.set("type", "hinge" if isinstance(motion, Turn) else "ball")
            joint.set("pos", numbers(motion.point))
        if isinstance(motion, Slide):
            joint.set("type", "slide")
        if isinstance(motion, Turn | Slide):
            joint.set("axis", numbers(motion.axis))
        dynamics = self.contents.dynamics.get(motion.name)
        if dynamics is not None:
            values = zip(
                ("stiffness", "springref", "damping", "frictionloss", "armature"), dynamics, strict=True
            )
            for name, value in values:
                joint.set(name, numbers([value]))
        if motion.name in self.contents.ranges:
            lower, upper = self.contents.ranges[motion.name]
            joint.set("range", numbers([-FAR if lower is None else lower, FAR if upper is None else upper]))

    def _tendons(self) -> None:
        for spring in self.contents.springs:
            tendon = child(self.sections["tendon"], "spatial", name=spring.name, springlength=spring.length)
            tendon.set("stiffness", numbers([spring.stiffness]))
            tendon.set("damping", numbers([spring.damping]))
            self._path(tendon, spring.bodies, spring.points)
        for rod in self.contents.rods:
            self._path(child(self.sections["tendon"], "spatial", name=rod.name), rod.bodies, rod.points)

    def _path(self, tendon: Element, bodies: tuple[str, str], points: tuple[Vec3, Vec3]) -> None:
        for body, point in zip(bodies, points, strict=True):
            child(tendon, "site", site=self._site(body, point))

    def _site(self, body: str, point: Vec3 | Array) -> str:
        self.sites += 1
        name = f"site{self.sites}"
        child(self.bodies[WORLD if body == GROUND else body], "site", name=name, pos=point)
        return name

    def _equalities(self) -> None:
        section = self.sections["equality"]
        for edge in self.contents.loops:
            self._loop(edge)
        for name, mimic in self.contents.mimics.items():
            factors = (0, mimic.multiplier, 0, 0, 0)
            child(section, "joint", joint1=name, joint2=mimic.joint, polycoef=factors, solimp=RIGID)
        for rod in self.contents.rods:
            child(section, "tendon", tendon1=rod.name, polycoef=(0, 0, 0, 0, 0), solimp=RIGID)

    def _loop(self, edge: Edge) -> None:
        section, bodies = self.sections["equality"], (edge.child, edge.parent)
        names = {f"body{n}": body or "world" for n, body in enumerate(bodies, 1)}
        if not edge.motions:
            child(section, "weld", name=edge.name, solimp=RIGID, **names)
            return
        (motion,) = edge.motions
        assert isinstance(motion, Turn | Ball)
        ends = {edge.name: motion.point}
        if isinstance(motion, Turn):  # a second point of the axis
            ends[f"{edge.name}.axis"] = motion.point + motion.axis
        for name, anchor in ends.items():
            child(section, "connect", name=name, anchor=anchor, solimp=RIGID, **names)

    def _actuators(self) -> None:
        for name, actuator in self.contents.actuators.items():
            assert isinstance(actuator.on, str)
            force = child(self.sections["actuator"], "general", name=name, joint=actuator.on)
            force.set("gaintype", "affine")
            force.set("gainprm", numbers([actuator.gain, actuator.gain_x, actuator.gain_v]))
            force.set("biastype", "affine")
            force.set("biasprm", numbers([actuator.offset, -actuator.kp, -actuator.kv]))
            for word, ends in (("ctrlrange", actuator.controls), ("forcerange", actuator.forces)):
                if ends != (-inf, inf):
                    force.set(word, numbers([max(ends[0], -FAR), min(ends[1], FAR)]))
            if isinstance(actuator.activation, Activation):
                force.set("dyntype", "filterexact" if actuator.activation.time else "integrator")
                force.set("dynprm", numbers([actuator.activation.time or 1.0]))
        self._pushes()

    def _pushes(self) -> None:
        for push in self.contents.pushes:
            sites = {
                "site": self._site(push.body, push.point),
                "refsite": self._site(GROUND, (0.0, 0.0, 0.0)),
            }
            force = child(
                self.sections["actuator"], "general", name=push.name, gear=(*push.force, 0, 0, 0), **sites
            )
            for name, value in {"gainprm": "0", "biastype": "affine", "biasprm": "1 0 0"}.items():
                force.set(name, value)

    def _looks(self) -> None:
        assets = Element("asset")
        for look in self.contents.looks:
            place = self.bodies.get(WORLD if look.body == GROUND else look.body)
            if place is None:
                continue
            geom = child(place, "geom", type=look.shape, pos=look.pose.r, quat=look.pose.p, rgba=rgba(look))
            if look.file is None:
                geom.set("size", numbers(_size(look)))
            else:
                mesh = f"mesh{len(assets) + 1}"
                child(assets, "mesh", name=mesh, file=look.file.as_posix(), scale=look.size, inertia="shell")
                geom.set("mesh", mesh)
            for name in ("contype", "conaffinity", "mass"):
                geom.set(name, "0")
        if len(assets):
            self.root.insert(2, assets)

    def _start(self) -> None:
        """Add initial velocities, controls and activations as a keyframe; MuJoCo has none elsewhere."""
        poses, velocities = list[Array](), list[Array]()
        free = {
            motion.name: e.child
            for e in self.contents.edges
            for motion in e.motions
            if isinstance(motion, Free)
        }
        for joint in self.bodies[WORLD].iter():
            if joint.tag in ("joint", "freejoint"):
                name = joint.attrib["name"]
                there = self.contents.poses[free[name]] if name in free else None
                zero = [1.0, 0.0, 0.0, 0.0] if joint.get("type") == "ball" else [0.0]
                poses.append(np.array(zero) if there is None else np.concatenate([there.r, there.p]))
                velocities.append(self.contents.rates[name])
        controls = [*self.contents.controls.values(), *(0.0 for _ in self.contents.pushes)]
        lags = (one.activation for one in self.contents.actuators.values())
        states = [lag.start for lag in lags if isinstance(lag, Activation)]
        if np.any(np.concatenate([*velocities, controls, states])):
            key = child(child(self.root, "keyframe"), "key", name="start", qpos=np.concatenate(poses))
            for word, values in (("qvel", np.concatenate(velocities)), ("ctrl", controls), ("act", states)):
                if len(values):
                    key.set(word, numbers(values))


def _size(look: Look) -> list[float]:
    """Return the size of a shape as MuJoCo has it: halves of lengths."""
    if look.shape == "box":
        return [side / 2 for side in look.size]
    if look.shape in ("sphere", "ellipsoid"):
        return [*look.size]
    return [look.size[0], look.size[1] / 2]
