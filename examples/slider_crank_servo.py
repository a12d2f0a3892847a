"""Position control of a slider-crank by a DC motor and a PID controller, whose gains are optimized.

python examples/slider_crank_servo.py [FOLDER]

The slider moves by 70 mm in 0.1 s. The gains minimize its position error, and the current of the motor is limited.
"""

import math
import sys
from pathlib import Path

import sarrus as sr

CRANK, ROD, AIM = 0.1, 0.3, -0.07  # m
PATH = f"{AIM}*step(t, 0, 0, 0.1, 1)"  # m, displacement of the slider
UNTIL, MOST = 2.0, 12.0  # s, A
BOUNDS = {"pid.kp": (20, 2000), "pid.ki": (10, 2e4), "pid.kd": (0.1, 100)}  # V/m, V/(m s), V s/m
ACROSS = (0, 0, 1)


def servo() -> sr.System:
    """A slider-crank whose crank points upwards; positive torques move the slider towards the crank's axis."""
    reach = math.sqrt(ROD**2 - CRANK**2)
    crank = sr.Body.rod("crank", (0, 0, 0), (0, CRANK, 0), mass=0.5)
    rod = sr.Body.rod("rod", (0, CRANK, 0), (reach, 0, 0), mass=0.5)
    slider = sr.Body("slider", mass=2.0, inertia=(2e-3, 2e-3, 2e-3), position=(reach, 0, 0))
    joints = [
        sr.Revolute("pin", sr.ground, crank, point=(0, 0, 0), axis=ACROSS),
        sr.Spherical("crank_pin", crank, rod, point=(0, CRANK, 0)),
        sr.Revolute("wrist", rod, slider, point=(reach, 0, 0), axis=ACROSS),
        sr.Cylindrical("slide", sr.ground, slider, point=(reach, 0, 0), axis=(1, 0, 0)),
    ]
    pid = sr.PID("pid", input=f"slide.displacement - {PATH}", kp=200, ki=500, kd=5, filter=5e-3, unit="V")
    motor = sr.DCMotor("motor", "pin", "pid.output", resistance=0.8, inductance=1e-3, constant=0.05, gear=10)
    bodies = [crank, rod, slider]
    return sr.System(sr.Model("servo", bodies, joints, forces=[pid, motor], gravity=(0, -9.81, 0)))


def error(o: sr.Outputs) -> object:
    """Square of the error [mm], with a weight that increases with time [s]."""
    return o("t") * (1e3 * (o("slide.displacement") - AIM)) ** 2


COST = sr.Integral(error, name="weighted error")
CURRENT = sr.Maximum("motor.current", name="largest current")
SHOWN = {"slide.displacement": "slider [mm]", "pid.output": "voltage [V]", "motor.current": "current [A]"}


def draw(runs: dict[str, sr.Trajectory], folder: Path) -> None:
    """Position, voltage and current over time."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 3.4), layout="constrained")
    axes = figure.subplots(1, 3)
    for ax, (output, label) in zip(axes, SHOWN.items()):
        for (name, run), colour in zip(runs.items(), ("#8a8f98", "#1f5f99")):
            ax.plot(run.t, (1e3 if "mm" in label else 1) * run[output], color=colour, label=name)
        ax.set(xlabel="t [s]", ylabel=label, xlim=(0, 1))
    axes[0].axhline(1e3 * AIM, color="#d9730d", linewidth=0.8)
    axes[2].axhline(MOST, color="#d9730d", linewidth=0.8)
    axes[0].legend(frameon=False)
    figure.savefig(folder / "slider_crank_servo.png", dpi=80)


def main(folder: str | Path = ".") -> sr.Optimum:
    system, limit = servo(), sr.Within(CURRENT, upper=MOST)
    best = sr.optimize(system, COST, [*BOUNDS], until=UNTIL, bounds=BOUNDS, constraints=[limit])
    tuned = sr.System(best.model)
    print(best)
    print(sr.modes(tuned, sr.equilibrium(tuned, sr.simulate(tuned, until=UNTIL).final)))
    draw(
        {"first gains": sr.simulate(system, until=UNTIL), "optimal": sr.simulate(tuned, until=UNTIL)},
        Path(folder),
    )
    return best


if __name__ == "__main__":
    main(*sys.argv[1:])
