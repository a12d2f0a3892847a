"""An active suspension of the vehicle: skyhook damping by four actuators with a lag, beside soft dampers.

python examples/active_suspension.py [FOLDER]

An actuator beside each spring exerts a force that is proportional to the vertical velocity of the chassis above, as a
damper between the chassis and a sky at rest would, with a lag of 10 ms. A root locus shows the best gain.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import sarrus as sr
from sarrus.functions import positive, sin

LAG, SOFT = 0.01, 0.3  # s; remaining fraction of the damping of the passive dampers
GAINS = np.linspace(0, 3e4, 61)  # N s/m
SPEED, SEAT = 8.0, "chassis(-0.2, 0.6, 0.3).acceleration.z"  # m/s, m/s²
SETTINGS = {"until": 1.5, "method": sr.Radau(rtol=1e-4, atol=1e-6, max_step=0.02)}


def bump(x):
    """Height of the road [m]: a bump of 6 cm, 2.5 m long."""
    s = (x - 3.2) / 2.5
    return 0.06 * sin(np.pi * s) ** 4 * positive(s) * positive(1 - s)


def vehicle(actuator=None, road=0.0) -> sr.System:
    """The vehicle, with a named actuator force at each spring that depends on the velocity of the chassis above."""
    model, forces = sr.load("hmmwv"), []
    for f in model.forces:
        kind, corner = f.name.split("_", 1)
        if kind == "tyre":
            f = sr.RoadTyre(f.name, f.point, f.k, f.c, f.radius, road=road)
        if kind == "damper" and actuator:
            f = replace(f, c=SOFT * f.c)
        if kind == "spring" and actuator:
            forces.append(actuator(f"force_{corner}", f"{f.point_i.label}.velocity.z"))
            forces.append(sr.Force(f"actuator_{corner}", f.point_i, f.point_j, value=f"force_{corner}"))
        forces.append(f)
    return sr.System(replace(model, forces=forces))


def skyhook(gain: float, road=0.0) -> sr.System:
    return vehicle(lambda name, rate: sr.FirstOrderLag(name, input=f"-{rate}", gain=gain, time=LAG), road)


def locus() -> np.ndarray:
    """The poles for all gains: the state space from forces to velocities, closed by a gain with a lag."""
    names = {}
    system = vehicle(lambda name, rate: sr.Input(names.setdefault(rate, name), 0.0, unit="N"))
    plant = sr.linearize(system, sr.equilibrium(system), outputs=[*names], inputs=[*names.values()])
    lag = np.eye(len(names)) / LAG
    closed = [np.block([[plant.A, plant.B], [-gain * lag @ plant.C, -lag]]) for gain in GAINS]
    return np.linalg.eigvals(np.array(closed))


def best_gain(poles: np.ndarray) -> int:
    """The index of the gain with the largest damping ratio of the least damped mode, except the steering."""
    ratios = np.where((poles.imag > 0) & (abs(poles) > 6), -poles.real / abs(poles), 1.0)
    return int(np.argmax(ratios.min(axis=1)))


def over_the_bump(system: sr.System) -> sr.Trajectory:
    v = np.zeros(system.nq)
    v[0::7] = SPEED  # of all bodies, forwards
    return sr.simulate(system, sr.assemble(system, v=v), **SETTINGS)


def main(folder: str | Path = ".") -> tuple[np.ndarray, float, dict[str, sr.Trajectory]]:
    from matplotlib.figure import Figure

    poles = locus()
    best = best_gain(poles)
    runs = {"passive": vehicle(road=bump), f"{GAINS[best]:g} N s/m": skyhook(GAINS[best], bump)}
    runs = {name: over_the_bump(system) for name, system in runs.items()}
    figure = Figure(figsize=(10, 4), layout="constrained")
    plane, seat = figure.subplots(1, 2)
    plane.plot(poles.real, poles.imag, ".", color="#8a8f98", markersize=2)
    plane.plot(poles[best].real, poles[best].imag, "x", color="#d9730d")
    plane.set(xlabel="real part [1/s]", ylabel="imaginary part [rad/s]", xlim=(-30, 1), ylim=(0, 15))
    for (name, run), colour in zip(runs.items(), ("#8a8f98", "#d9730d")):
        print(
            f"{name}: the seat has {np.std(run[SEAT]):.3f} m/s² rms, {abs(run[SEAT]).max():.2f} m/s² at most"
        )
        seat.plot(run.t, run[SEAT], color=colour, label=name)
    seat.set(xlabel="t [s]", ylabel="seat, vertical acceleration [m/s²]")
    seat.legend(frameon=False)
    figure.savefig(Path(folder) / "active_suspension.png", dpi=80)
    return poles, GAINS[best], runs


if __name__ == "__main__":
    main(*sys.argv[1:])
