"""Tolerances of a press: the accuracy of the ram along its stroke, and the contribution of every part.

python examples/press_tolerances.py [FOLDER]

The bearing in the frame, the crank, the connecting rod and the ram have tolerances of some hundredths of a millimetre.
Exact derivatives of the driven motion by the parts' dimensions give the standard deviation of every position.
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

ACROSS, STEPS = {"z": (0, 1, 0)}, 360
PARTS = {  # part: parameter, mean [m] and tolerance [mm]; 99.7 % of the values are within the mean ± tolerance
    "frame": {"bearing.frame_i.point.z": (0.0, 0.05)},
    "crank": {"crank_pin.frame_i.point.z": (-0.06, 0.02)},
    "rod": {"crank_pin.frame_j.point.z": (0.25, 0.03), "wrist_pin.point_i.z": (-0.25, 0.03)},
    "ram": {"wrist_pin.point_j.z": (0.14, 0.04)},
}
DIMENSIONS = {name: given for own in PARTS.values() for name, given in own.items()}
TOLERANCES = {
    name: sr.Distribution("norm", {"loc": mean, "scale": width * 1e-3 / 3})
    for name, (mean, width) in DIMENSIONS.items()
}
RESPONSES = {"lowest": "min(ram.z)", "stroke": "max(ram.z) - min(ram.z)"}


def press() -> sr.Model:
    """The press at its lowest position; one revolution takes a second."""
    shaft = sr.Body("shaft", mass=40, inertia=(0.5, 0.5, 0.5))
    rod = sr.Body("rod", mass=15, inertia=(0.3, 0.3, 0.02), position=(0, 0, -0.31))
    ram = sr.Body("ram", mass=60, inertia=(1, 1, 1), position=(0, 0, -0.7))
    frames = sr.ground.frame((0, 0, 0), **ACROSS), shaft.frame((0, 0, 0), **ACROSS)
    pins = shaft.frame((0, 0, -0.06), **ACROSS), rod.frame((0, 0, 0.25), **ACROSS)
    joints = [
        sr.Revolute("bearing", frame_i=frames[0], frame_j=frames[1]),
        sr.Revolute("crank_pin", frame_i=pins[0], frame_j=pins[1]),
        sr.Spherical("wrist_pin", point_i=rod.point(0, 0, -0.25), point_j=ram.point(0, 0, 0.14)),
        sr.Translational("guide", sr.ground, ram, point=(0, 0, -0.7), axis=(0, 0, 1)),
    ]
    motor = sr.AngleDriver("motor", "bearing", "2*pi*t")
    return sr.Model("press", [shaft, rod, ram], joints, drivers=[motor], gravity=(0, 0, -9.81))


def variances(times: np.ndarray) -> dict[str, np.ndarray]:
    """The contribution of each part to the variance of the ram's position at some times [m²]."""
    run = sr.kinematics(sr.System(press()), times)
    slopes = sr.sensitivity(run, [sr.At("ram.z", time=t) for t in times], [*DIMENSIONS])
    return {
        part: sum((slopes.matrix[:, slopes.names.index(name)] * w * 1e-3 / 3) ** 2 for name, (_, w) in own.items())
        for part, own in PARTS.items()
    }  # fmt: skip


def main(folder: str | Path = ".") -> tuple[sr.Uncertainty, np.ndarray, dict[str, np.ndarray]]:
    from matplotlib.figure import Figure

    found = sr.uncertainty(press(), TOLERANCES, RESPONSES, analysis=sr.Kinematics(until=1.0, steps=STEPS))
    print(found)
    times = np.linspace(0, 0.5, 37)
    parts = variances(times)
    figure = Figure(figsize=(9, 3.2), layout="constrained")
    stroke, bars = figure.subplots(1, 2)
    colours = "#1f5f99", "#d9730d", "#3f8f5f", "#8a8f98"
    stroke.stackplot(360 * times, *(1e12 * one for one in parts.values()), labels=[*parts], colors=colours)
    stroke.set(
        xlabel="angle of the crank [°]",
        ylabel="variance of the position [µm²]",
        xlim=(0, 180),
        xticks=range(0, 181, 30),
    )
    figure.legend(*stroke.get_legend_handles_labels(), loc="outside upper center", ncols=4, frameon=False)
    left = np.zeros(len(RESPONSES))
    for own, colour in zip(PARTS.values(), colours):
        share = 100 * found.shares[:, [found.parameters.index(name) for name in own]].sum(axis=1)
        bars.barh([*RESPONSES], share, left=left, height=0.5, color=colour)
        left += share
    bars.set(xlabel="contribution to the variance [%]", xlim=(0, 100))
    figure.savefig(Path(folder) / "press_tolerances.png", dpi=80)
    return found, times, parts


if __name__ == "__main__":
    main(*sys.argv[1:])
