"""A Stewart platform on six telescopic legs: their lengths are driven, and the required forces are computed.

    python examples/stewart_platform.py [FOLDER]

The lengths are formulas of time that correspond to a heave h(t) and a rotation ψ(t) about the vertical. The motion that
the forward kinematics must compute is therefore known.
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

BASE, TOP = 1.0, 0.6  # [m] radii of the joints
MASS, LEG = 80.0, 2.0  # [kg]
HEAVE, TURN = "(1.2 + 0.15*sin(2*t))", "(0.25*sin(t))"  # [m], [rad]
FEET = np.radians([-10, 10, 110, 130, 230, 250])
HANDS = np.radians([-50, 50, 70, 170, 190, 290])
UP = np.array([0.0, 0.0, 1.0])


def on_circle(radius: float, angle: float, height: float = 0.0) -> np.ndarray:
    return np.array([radius * np.cos(angle), radius * np.sin(angle), height])


def turned_to(way: np.ndarray) -> tuple[float, ...]:
    """Euler parameters of a body whose z points along a unit vector."""
    p = np.array([1 + way[2], -way[1], way[0], 0.0])
    return tuple(p / np.linalg.norm(p))


def leg(n: int, platform: sr.Body) -> tuple[list, list, sr.DisplacementDriver]:
    """Cylinder and rod between foot n and hand n, and the driver of the displacement between them."""
    foot, hand = on_circle(BASE, FEET[n]), on_circle(TOP, HANDS[n], 1.2)
    length = float(np.linalg.norm(hand - foot))
    way = (hand - foot) / length
    across = np.cross(UP, way) / np.linalg.norm(np.cross(UP, way))
    own = {"mass": LEG, "inertia": (0.1, 0.1, 0.005), "orientation": turned_to(way)}
    cylinder = sr.Body(f"cylinder_{n}", position=tuple(foot + 0.35 * way), **own)
    rod = sr.Body(f"rod_{n}", position=tuple(hand - 0.35 * way), **own)
    joints = [
        sr.Universal(
            f"foot_{n}", sr.ground, cylinder, point=foot, axis_i=across, axis_j=np.cross(way, across)
        ),
        sr.Translational(f"slide_{n}", cylinder, rod, point=foot + 0.5 * length * way, axis=way),
        sr.Spherical(f"hand_{n}", rod, platform, point=hand),
    ]
    flat = f"{BASE**2 + TOP**2} - {2 * BASE * TOP}*cos({HANDS[n] - FEET[n]} + {TURN})"
    return (
        [cylinder, rod],
        joints,
        sr.DisplacementDriver(f"motor_{n}", f"slide_{n}", f"sqrt({flat} + {HEAVE}**2) - {length}"),
    )


def stewart() -> sr.Model:
    platform = sr.Body("platform", mass=MASS, inertia=(6, 6, 12), position=(0, 0, 1.2))
    legs = [leg(n, platform) for n in range(6)]
    return sr.Model(
        "Stewart platform",
        bodies=[platform, *(body for bodies, _, _ in legs for body in bodies)],
        joints=[joint for _, joints, _ in legs for joint in joints],
        drivers=[driver for _, _, driver in legs],
        gravity=(0, 0, -9.81),
    )


def main(folder: str | Path = ".") -> sr.Trajectory:
    from matplotlib.figure import Figure

    model = stewart()
    model.view(Path(folder) / "stewart_platform.png")
    run = sr.kinematics(sr.System(model), np.linspace(0, 6, 241))
    t, up = run.t, run["platform"].position[:, 2]
    heave = 1.2 + 0.15 * np.sin(2 * t)
    forces = [run.reaction(f"motor_{n}").force for n in range(6)]
    sizes = np.array([np.linalg.norm(force, axis=1) for force in forces])
    print(f"{run.message}; the platform follows to {abs(up - heave).max():.0e} m")
    print(f"legs push with {sizes.min():.1f} to {sizes.max():.1f} N")
    figure = Figure(figsize=(7, 5), layout="constrained")
    lift, push = figure.subplots(2, 1, sharex=True)
    lift.plot(t, up, label="height [m]")
    lift.plot(t, 2 * np.arctan2(run["platform"].euler[:, 3], run["platform"].euler[:, 0]), label="turn [rad]")
    lift.legend(frameon=False)
    push.plot(t, sizes.T, linewidth=1)
    push.set(xlabel="t [s]", ylabel="forces of the motors [N]")
    figure.savefig(Path(folder) / "stewart_platform-motion.png", dpi=60)
    return run


if __name__ == "__main__":
    main(*sys.argv[1:])
