"""Constants of a motor from one noisy test: a DC motor swings an arm; its current and angle are measured.

python examples/motor_constants.py [FOLDER]

The measurements are simulated with the true constants, which the fit does not know.
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

GEAR, UNTIL = 8, 2.0  # revolutions of the motor for one of the arm; s
TRUE = {"resistance": 0.8, "inductance": 4e-3, "constant": 0.05, "friction": 0.3, "rotor": 2e-5}
GUESS = {"resistance": 1.5, "inductance": 6e-3, "constant": 0.03, "friction": 0.1, "rotor": 4e-5}
NAMES = {  # of the parameters in the model; in ohm, H, N m/A, N m s, kg m²
    "motor.resistance": "resistance",
    "motor.inductance": "inductance",
    "motor.constant": "constant",
    "friction.parameters.c": "friction",
    "rotor.inertia": "rotor",  # at the joint: that of the rotor times the square of the gear ratio
}
TIMES = np.linspace(0.02, UNTIL, 100)
SENSORS = {"motor.current": 0.1, "pin.angle": 2e-3}  # standard deviations, A and rad


def rig(constants: dict[str, float]) -> sr.System:
    """An arm that hangs on the shaft of a geared motor; the voltage is a sine whose frequency increases."""
    across, c = (0, 0, 1), constants
    arm = sr.Body.rod("arm", (0, 0, 0), (0, -0.3, 0), mass=0.6)
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=across)
    forces = [
        sr.DCMotor(
            "motor", "pin", "12*sin(6*t + 8*t**2)", gear=GEAR,
            resistance=c["resistance"], inductance=c["inductance"], constant=c["constant"],
        ),
        sr.Torque("friction", "pin", value="-c*pin.rate", parameters={"c": c["friction"]}),
        sr.AngleInertia("rotor", sr.ground, arm, point=(0, 0, 0), axis=across, inertia=GEAR**2 * c["rotor"]),
    ]  # fmt: skip
    return sr.System(sr.Model("test rig", [arm], [pin], forces=forces, gravity=(0, -9.81, 0)))


def measurements(seed: int) -> list[sr.Misfit]:
    """Current and angle of the true motor, with noise."""
    run = sr.simulate(rig(TRUE), until=UNTIL, t_eval=[0, *TIMES])
    noise = np.random.default_rng(seed)
    return [
        sr.Misfit(name, at=TIMES, data=run[name][1:] + noise.normal(0, sigma, len(TIMES)), sigma=sigma)
        for name, sigma in SENSORS.items()
    ]


def draw(data: list[sr.Misfit], found: sr.Optimum, folder: Path) -> None:
    """The measurements, with the simulation before and after the fit."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 3.6), layout="constrained")
    runs = {"guess": (sr.simulate(rig(GUESS), until=UNTIL), "#8a8f98"), "fit": (found.run, "#1f5f99")}
    for ax, one, label in zip(figure.subplots(1, 2), data, ("current [A]", "angle of the arm [rad]")):
        for name, (run, colour) in runs.items():
            ax.plot(run.t, run[one.of], color=colour, label=name)
        ax.plot(TIMES, one.data, ".", color="#d9730d", markersize=4, label="measured")
        ax.set(xlabel="t [s]", ylabel=label)
    ax.legend(frameon=False)
    figure.savefig(folder / "motor_constants.png", dpi=80)


def main(folder: str | Path = ".", seed: int = 0) -> sr.Optimum:
    data = measurements(seed)
    found = sr.fit(rig(GUESS), data, [*NAMES], bounds={"motor.inductance": (1e-4, 0.1)})
    print(found)
    print(f"rotor: {found['rotor.inertia'] / GEAR**2:.3g} kg m²")
    draw(data, found, Path(folder))
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
