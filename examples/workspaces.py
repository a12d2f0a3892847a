"""Well-known workspaces: a 3R arm, a planar platform, a five-bar with its dexterity, a barrier inside a volume.

python examples/workspaces.py [FOLDER]
"""

import sys
from math import atan2, cos, hypot, sin
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

import sarrus as sr

matplotlib.use("Agg")
DEGREE = np.pi / 180


def arm() -> sr.Workspace:
    """Links of 4, 2 and 1 m, all joint angles between -60° and 60°."""
    links, joints, end = [], [], 0.0
    for n, length in enumerate((4.0, 2.0, 1.0), start=1):
        links.append(sr.Body(f"link_{n}", mass=1, inertia=(1, 1, 1), position=(end, 0, 0)))
        before = links[-2] if n > 1 else sr.ground
        joints.append(sr.Revolute(f"q{n}", before, links[-1], point=(end, 0, 0), axis=(0, 0, 1)))
        end += length
    system = sr.System(sr.Model("3R arm", bodies=links, joints=joints))
    limits = {f"q{n}": (-60 * DEGREE, 60 * DEGREE) for n in (1, 2, 3)}
    return sr.workspace(system, links[-1].point(1, 0, 0)["x", "y"], limits=limits)


def platform() -> sr.Workspace:
    """A platform of 2 m on three legs, two of which meet in one corner: four components that are not connected."""
    plate = sr.Body("platform", mass=1, inertia=(1, 1, 1), position=(0.3, 1.2, 0))
    plane = sr.Planar("plane", sr.ground, plate, point=(0, 0, 0), axis=(0, 0, 1))
    feet, corners, limits = (-1, 1, 2), (-1, -1, 1), ((2**0.5, 2), (2**0.5, 2), (1, 3))
    legs = {
        sr.Length(sr.ground.point(foot, 0, 0), plate.point(corner, 0, 0), f"leg {n}"): pair
        for n, (foot, corner, pair) in enumerate(zip(feet, corners, limits, strict=True), start=1)
    }
    system = sr.System(sr.Model("planar platform", bodies=[plate], joints=[plane]))
    return sr.workspace(system, plate.point(0, 0, 0)["x", "y"], limits=legs)


def five_bar() -> tuple[sr.Workspace, sr.InputSingularities, sr.InputSingularities]:
    """Cranks of 1.2 m at (-1, 0) and (1, 0), rods of 1.5 m; singular configurations of its motors and of its tip."""
    height = 0.5
    reach = hypot(0.9, height)
    elbows = [(-1 + 1.2 * 0.9 / reach, 1.2 * height / reach), (1 - 1.2 * 0.9 / reach, 1.2 * height / reach)]
    tip = (0.0, elbows[0][1] + (1.5**2 - elbows[0][0] ** 2) ** 0.5)
    cranks = [
        bar(f"crank_{n}", (x, 0.0), elbow) for n, (x, elbow) in enumerate(zip((-1, 1), elbows, strict=True))
    ]
    rods = [bar(f"rod_{n}", elbow, tip) for n, elbow in enumerate(elbows)]
    joints = []
    for n, x in enumerate((-1, 1)):
        joints.append(sr.Revolute(f"motor_{n}", sr.ground, cranks[n], point=(x, 0, 0), axis=(0, 0, 1)))
        joints.append(sr.Revolute(f"elbow_{n}", cranks[n], rods[n], point=(*elbows[n], 0), axis=(0, 0, 1)))
    joints.append(sr.Revolute("tip", *rods, point=(*tip, 0), axis=(0, 0, 1)))
    system = sr.System(sr.Model("five-bar", bodies=[*cranks, *rods], joints=joints))
    output = rods[0].point(1.5, 0, 0)["x", "y"]
    inputs = ("motor_0", "motor_1")
    lost = sr.input_singularities(system, output, inputs)
    return sr.workspace(system, output), lost, sr.input_singularities(system, output, inputs, lost="outputs")


def bar(name: str, start: tuple[float, float], end: tuple[float, float]) -> sr.Body:
    half = 0.5 * atan2(end[1] - start[1], end[0] - start[0])
    turned = (cos(half), 0, 0, sin(half))
    return sr.Body(name, mass=1, inertia=(1, 1, 1), position=(*start, 0), orientation=turned)


def orthogonal_arm() -> sr.WorkspaceVolume:
    """An arm with joints about z, y and z that changes its assembly mode around a barrier inside its volume."""
    places, axes = [(0, 0, 0), (1, 0, 0), (3, 1, 0)], [(0, 0, 1), (0, 1, 0), (0, 0, 1)]
    links = [sr.Body(f"link_{n}", mass=1, inertia=(1, 1, 1), position=at) for n, at in enumerate(places, 1)]
    joints = [
        sr.Revolute(f"q{n}", before, link, point=at, axis=axis)
        for n, (before, link, at, axis) in enumerate(
            zip([sr.ground, *links], links, places, axes, strict=False), 1
        )
    ]
    system = sr.System(sr.Model("orthogonal arm", bodies=links, joints=joints))
    return sr.workspace_volume(system, links[-1].point(1.5, 0, 0)["x", "y", "z"], rtol=1e-4)


def main(folder: Path) -> None:
    for name, found in {"arm": arm(), "platform": platform()}.items():
        print(found, end="\n\n")
        save(found.plot(), folder / f"workspace_{name}.png")
    found, by_inputs, by_outputs = five_bar()
    field = sr.workspace_field(found, by_inputs.inputs, cells=40)
    print(found, field, by_inputs, by_outputs, sep="\n\n", end="\n\n")
    save(by_inputs.plot(found.plot(ghosts=1)), folder / "workspace_five_bar.png")
    save(by_inputs.plot(field.plot("conditioning")), folder / "workspace_field.png")
    over = by_inputs.plot(over="inputs")
    save(by_outputs.plot(over, over="inputs"), folder / "workspace_inputs.png")
    inside = orthogonal_arm()
    print(inside)
    inside.view(folder / "workspace_inside.png")


def save(axes: Any, file: Path) -> None:
    axes.figure.savefig(file, dpi=60)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
