"""A hydraulic scissor lift: a valve follows the height of the platform, with 500 kg on it.

python examples/scissor_lift.py [FOLDER]

Two bars cross in a pin. One end of each is pinned to the ground or the platform, the other end rolls. A planar
mechanism with spatial revolute joints has redundant constraints. They require no change of the model.
"""

import math
import sys
from pathlib import Path

import sarrus as sr

BAR, ANGLE = 2.0, math.radians(15)  # m; initial angle of the bars
BOTTOM, LIFT, UNTIL = BAR * math.sin(ANGLE), 0.8, 6.0  # m, s
ATTACHED = 1.2  # m along the second bar from its roller, where the piston pushes
OIL = {"supply": 160e5, "rated_flow": 5e-4, "rated_drop": 35e5, "dead": 1e-4, "leakage": 5e-12}  # SI units
HELD = {"initial_a": 64.5e5, "initial_b": 20e5}  # N/m², pressures that hold the platform approximately
PISTON = {"area": 7.85e-3, "rod_area": 4e-3, "retracted": 0.8, "stroke": 0.3}  # m², m² and m, m
SIDE, FORWARD = (0, 1, 0), (1, 0, 0)


def lift() -> sr.System:
    """The lift at its lowest position."""
    span, middle = BAR * math.cos(ANGLE), (BAR * math.cos(ANGLE) / 2, 0, BOTTOM / 2)
    first = sr.Body.rod("first", (0, 0, 0), (span, 0, BOTTOM), mass=40)
    second = sr.Body.rod("second", (span, 0, 0), (0, 0, BOTTOM), mass=40)
    platform = sr.Body("platform", mass=500, inertia=(50, 150, 150), position=(span / 2, 0, BOTTOM))
    joints = [
        sr.Revolute("foot", sr.ground, first, point=(0, 0, 0), axis=SIDE),
        sr.Revolute("cross", first, second, point=middle, axis=SIDE),
        sr.Revolute("top", second, platform, point=(0, 0, BOTTOM), axis=SIDE),
        sr.PointOnLine("lower_roller", sr.ground, second, point=(span, 0, 0), axis=FORWARD),
        sr.PointOnLine("upper_roller", platform, first, point=(span, 0, BOTTOM), axis=FORWARD),
    ]
    share = ATTACHED / BAR
    end = sr.Point(second, (span * (1 - share), 0, BOTTOM * share), axes="global")
    path = f"{BOTTOM} + {LIFT}*step(t, 0.5, 0, 4.5, 1)"
    valve = sr.PID("valve", input=f"{path} - platform.z", kp=10, lower=-1, upper=1)
    cylinder = sr.HydraulicCylinder(
        "cylinder", sr.ground.point(0, 0, 0), end, input="valve.output", **PISTON, **OIL, **HELD
    )
    bodies = [first, second, platform]
    return sr.System(
        sr.Model("scissor lift", bodies, joints, forces=[valve, cylinder], gravity=(0, 0, -9.81))
    )


def draw(run: sr.Trajectory, folder: Path) -> None:
    """Height, pressures and force over time."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 3.4), layout="constrained")
    height, pressure, force = figure.subplots(1, 3)
    height.plot(run.t, run["platform.z"], color="#1f5f99")
    height.set(xlabel="t [s]", ylabel="height of the platform [m]")
    for side, colour in (("a", "#1f5f99"), ("b", "#d9730d")):
        pressure.plot(run.t, run[f"cylinder.pressure_{side}"] / 1e5, color=colour, label=f"chamber {side}")
    pressure.set(xlabel="t [s]", ylabel="pressure [bar]")
    pressure.legend(frameon=False)
    force.plot(run.t, run["cylinder.value"] / 1e3, color="#1f5f99")
    force.set(xlabel="t [s]", ylabel="force of the cylinder [kN]")
    figure.savefig(folder / "scissor_lift.png", dpi=80)


def main(folder: str | Path = ".") -> sr.Trajectory:
    system = lift()
    print(sr.mobility(system))
    run = sr.simulate(system, until=UNTIL)
    print(
        f"lifted by {run['platform.z'][-1] - BOTTOM:.4f} m with at most {run['cylinder.flow_a'].max() * 6e4:.1f} l/min"
    )
    draw(run, Path(folder))
    return run


if __name__ == "__main__":
    main(*sys.argv[1:])
