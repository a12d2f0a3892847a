"""A robot arm from its manufacturer's URDF is released and falls for one second.

python examples/falling_arm.py [FOLDER [ROBOT.urdf [LOCKED_JOINT ...]]]
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

PANDA = Path(__file__).parent.parent / "tests/io/data/panda.urdf"


def main(folder: str | Path = ".", path: str | Path = PANDA, *locked: str) -> sr.Trajectory:
    locked = locked or (("panda_finger_joint1",) if path == PANDA else ())
    robot = sr.load_urdf(path, lock=locked, mimic="lock", inertia="given")
    print(f"{robot.name}: {len(robot.links)} links, {len(robot.bodies)} moving bodies")
    for note in robot.notes:
        print(f"  {note}")
    system = sr.System(robot)
    space = sr.JointSpace(system)
    M = space.M(space.zero())
    print(
        f"{space.freedoms} joints; their masses and inertias are between {M.diagonal().min():.3g} and "
        f"{M.diagonal().max():.3g} kg, kg m²"
    )
    motion = sr.simulate(system, until=1.0, t_eval=np.linspace(0, 1, 101))
    print(f"{motion.message}; violation of the constraints at most {motion.violation.max():.0e}")
    for body in motion.bodies:
        print(f"  {body:<24} fell by {motion[body].position[0, 2] - motion[body].position[-1, 2]:+.4f} m")
    draw(robot, motion, Path(folder))
    return motion


def draw(robot: sr.Model, motion: sr.Trajectory, folder: Path) -> None:
    """The arm in its initial position, and the angles of its joints."""
    from matplotlib.figure import Figure

    robot.view(folder / "falling_arm.png")
    figure = Figure(figsize=(7, 3.2), layout="constrained")
    angles = [name for name in motion.system.joint_coordinates.names if name.endswith(".angle")]
    motion.plot(*angles, ax=figure.subplots())
    figure.savefig(folder / "falling_arm-motion.png", dpi=60)


if __name__ == "__main__":
    main(*sys.argv[1:])
