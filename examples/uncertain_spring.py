"""Uncertainty of the motion of a slider-crank whose spring, rod and damper are known to a few per cent only.

    python examples/uncertain_spring.py [FOLDER]

A study of random samples is compared with one run and its exact derivatives. If the response is nearly linear, both
agree, but the second needs one run only. The contributions show which parameters cause the uncertainty.
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr
from sarrus import mechanisms

SPREADS = {
    "spring.k": sr.Distribution("norm", {"loc": 10, "scale": 0.3}),
    "spring.c": sr.Distribution("norm", {"loc": 1, "scale": 0.1}),
    "rod.mass": sr.Distribution("norm", {"loc": 1, "scale": 0.03}),
}
RESPONSES = {"dip": "min(slider.x)", "end": "final(slider.x)", "load": "rms(pin.force.z)"}
RUN = sr.Simulation(until=2.0)


def main(folder: str | Path = ".", count: int = 512) -> tuple[sr.StudyTable, sr.Uncertainty]:
    from matplotlib.figure import Figure

    model = sr.load(mechanisms.path("slider_crank"))
    table = sr.study(model, SPREADS, RESPONSES, analysis=RUN, sample=sr.Sobol(count, seed=1), workers=1)
    linear = sr.uncertainty(model, SPREADS, RESPONSES, analysis=RUN)
    print(linear)
    figure = Figure(figsize=(9, 3), layout="constrained")
    for ax, name, mean, std in zip(figure.subplots(1, 3), RESPONSES, linear.values, linear.std):
        found = table.found[:, table.responses.index(name)]
        print(
            f"{name}: sampled {found.mean():.5g} ± {found.std(ddof=1):.3g}, to first order {mean:.5g} ± {std:.3g}"
        )
        ax.hist(found, bins=24, density=True, color="#8a8f98", alpha=0.6, label=f"{count} runs")
        x = np.linspace(found.min(), found.max(), 200)
        bell = np.exp(-0.5 * ((x - mean) / std) ** 2) / (std * np.sqrt(2 * np.pi))
        ax.plot(x, bell, color="#1f5f99", label="one run and its derivatives")
        ax.set(xlabel=name, yticks=[])
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper left", ncols=2, frameon=False)
    figure.savefig(Path(folder) / "uncertain_spring.png", dpi=70)
    return table, linear


if __name__ == "__main__":
    main(*sys.argv[1:])
