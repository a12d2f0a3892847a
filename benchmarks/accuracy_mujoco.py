"""The same mechanism in MuJoCo: trees of hinges, slides, balls and free bodies with springs."""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
from exudyn_told import Told

import sarrus as sr

JOINTS = {sr.Revolute: "hinge", sr.Translational: "slide", sr.Spherical: "ball"}
GROUND = {
    "position": [0.0, 0.0, 0.0],
    "axes": np.eye(3),
    "velocity": [0.0] * 3,
    "angular_velocity": [0.0] * 3,
}


class CannotBeStated(ValueError):
    """The mechanism has a part that this conversion does not know."""


class Tree:
    """The model as MJCF, from a start; bodies in the tree that its joints make."""

    def __init__(self, system: sr.System, told: Told) -> None:
        self._joints = dict(
            zip((joint.name for joint in system.model.joints), told.data["joints"], strict=True)
        )
        self._kinds = {joint.name: JOINTS.get(type(joint)) for joint in system.model.joints}
        self._bodies = {"ground": GROUND, **{body["name"]: body for body in told.data["bodies"]}}
        self._root = Element("mujoco")
        SubElement(
            self._root,
            "compiler",
            angle="radian",
            inertiafromgeom="false",
            boundmass="0",
            balanceinertia="false",
        )
        SubElement(self._root, "option", gravity=_text(told.data["gravity"]))
        self._elements = {"ground": SubElement(self._root, "worldbody")}
        self.rates: dict[str, list[float]] = {}
        self._place_bodies()
        self._springs(told.data["forces"])

    def xml(self) -> str:
        """The model in MuJoCo's format, each joint with its name."""
        return tostring(self._root, encoding="unicode")

    def _place_bodies(self) -> None:
        to_do, loose = dict(self._joints), {"ground"}
        while to_do:
            found = [
                (name, one, other)
                for name, joint in to_do.items()
                for one, other in ((joint["i"], joint["j"]), (joint["j"], joint["i"]))
                if one["body"] in self._elements and other["body"] not in self._elements
            ]
            if not found:
                break
            name, one, other = found[0]
            self._body(other["body"], one["body"])
            self._joint(name, self._joints[name]["j"] is other, one, other)
            del to_do[name]
        if to_do:
            raise CannotBeStated(f"{', '.join(to_do)} close loops")
        for name in self._bodies.keys() - self._elements.keys() - loose:
            SubElement(self._body(name, "ground"), "freejoint", name=name)
            body = self._bodies[name]
            self.rates[name] = [*body["velocity"], *(np.array(body["axes"]).T @ body["angular_velocity"])]

    def _body(self, name: str, parent: str) -> Element:
        body, before = self._bodies[name], self._bodies[parent]
        back = np.array(before["axes"]).T
        place = back @ (np.array(body["position"]) - before["position"])
        x, y = (back @ np.array(body["axes"]))[:, :2].T
        element = SubElement(
            self._elements[parent], "body", name=name, pos=_text(place), xyaxes=_text([*x, *y])
        )
        J = np.array(body["inertia"])
        full = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
        SubElement(element, "inertial", pos="0 0 0", mass=repr(body["mass"]), fullinertia=_text(full))
        self._elements[name] = element
        return element

    def _joint(self, name: str, forward: bool, one: dict[str, Any], other: dict[str, Any]) -> None:
        kind = self._kinds[name]
        if kind is None:
            raise CannotBeStated(f"{name} has no joint in MuJoCo")
        axis = np.array(other["axes"])[:, 2] if "axes" in other else np.array([0.0, 0.0, 1.0])
        given = {} if kind == "ball" else {"axis": _text(axis)}
        SubElement(
            self._elements[other["body"]], "joint", name=name, type=kind, pos=_text(other["at"]), **given
        )
        here, there = self._bodies[one["body"]], self._bodies[other["body"]]
        spin = np.array(there["angular_velocity"]) - here["angular_velocity"]
        slide = np.array(there["velocity"]) - here["velocity"]
        local = np.array(there["axes"]).T @ (slide if kind == "slide" else spin)
        self.rates[name] = [*local] if kind == "ball" else [float(local @ axis)]

    def _springs(self, forces: list[dict[str, Any]]) -> None:
        tendons = SubElement(self._root, "tendon")
        for n, force in enumerate(forces):
            if force["type"] != "tsda":
                raise CannotBeStated(f"there is no {force['type']}")
            law = {
                "stiffness": repr(force["k"]),
                "damping": repr(force["c"]),
                "springlength": repr(force["length"]),
            }
            tendon = SubElement(tendons, "spatial", name=f"spring_{n}", **law)
            for end in "ij":
                at = force[end]
                site = SubElement(self._elements[at["body"]], "site", name=f"{end}_{n}", pos=_text(at["at"]))
                SubElement(tendon, "site", site=site.get("name", ""))


def _text(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)


def end(system: sr.System, told: Told, until: float) -> tuple[np.ndarray, int]:
    """Places of the wanted points at the end (n, 3), with MuJoCo's default options; number of steps."""
    import mujoco

    tree = Tree(system, told)
    model = mujoco.MjModel.from_xml_string(tree.xml())
    data = mujoco.MjData(model)
    for name, rates in tree.rates.items():
        joint = model.joint(name)
        data.qvel[joint.dofadr[0] : joint.dofadr[0] + len(rates)] = rates
    steps = max(1, round(until / model.opt.timestep))
    for _ in range(steps):
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    bodies = [data.body(point["body"]) for point in told.data["points"]]
    places = [
        b.xpos + b.xmat.reshape(3, 3) @ p["at"] for b, p in zip(bodies, told.data["points"], strict=True)
    ]
    return np.array(places), steps
