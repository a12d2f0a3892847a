"""A tyre from measurements: coefficients of the Magic Formula from sweeps on a flat-track rig, with their errors.

python examples/tyre_from_measurements.py [FOLDER]

The data are synthetic: forces of a known tyre in sweeps of the slip angle at three loads and three inclinations, in
sweeps of the longitudinal slip, and in both at once, with noise. The fit begins with a tyre that is softer and has less
grip.
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

LOADS = (2000.0, 4500.0, 7000.0)  # N
NOISE = {"F_x": 40.0, "F_y": 40.0, "M_z": 1.5}  # N, N, N m
LATERAL = ("PCY1", "PDY1", "PDY2", "PEY1", "PKY1", "PKY2", "PKY6", "PHY1", "PVY1", "PVY3")
LONGITUDINAL = ("PCX1", "PDX1", "PDX2", "PEX1", "PKX1", "PKX3")
COMBINED = ("RBX1", "RCX1", "RBY1", "RCY1")
ALIGNING = ("QBZ1", "QCZ1", "QDZ1", "QEZ1", "QDZ8")
UNKNOWN = (*LATERAL, *LONGITUDINAL, *COMBINED, *ALIGNING)


def sweeps() -> dict[str, np.ndarray]:
    """The slips of all measurements: rows of κ, α, γ and load."""
    alpha, kappa = np.radians(np.linspace(-12, 12, 49)), np.linspace(-0.25, 0.25, 41)
    rows = [
        np.broadcast_arrays(along, across, gamma, load)
        for load in LOADS
        for along, across, gamma in (
            *((0.0, alpha, angle) for angle in np.radians((-3.0, 0.0, 3.0))),
            *((kappa, angle, 0.0) for angle in np.radians((0.0, -2.0, -5.0))),
        )
    ]
    return dict(zip(("kappa", "alpha", "gamma", "load"), np.concatenate(rows, axis=1), strict=True))


def rig(tyre: sr.TyreFile, seed: int) -> dict[str, np.ndarray]:
    """Forces and the aligning moment that the rig measures in all sweeps."""
    measured, random = sweeps(), np.random.default_rng(seed)
    exact = tyre.forces(measured)
    return measured | {name: exact[name] + random.normal(0, NOISE[name], exact[name].size) for name in NOISE}


def first_guess(tyre: sr.TyreFile) -> sr.TyreFile:
    """A tyre with less grip and stiffness, and neutral further coefficients."""
    start = {name: 0.8 * tyre.coefficients[name] for name in UNKNOWN}
    start |= dict.fromkeys(("PHY1", "PVY1", "PVY3", "PDX2", "PDY2"), 0.0)
    return sr.TyreFile("start", {**tyre.coefficients, **start}, tyre.side)


def picture(measured: dict, start: sr.TyreFile, fit: sr.TyreFit, true: sr.TyreFile, path: Path) -> None:
    """Data, start and fit; and the intervals of the coefficients beside their true values."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 7.4), layout="constrained")
    (lateral, moment), (longitudinal, intervals) = figure.subplots(2, 2)
    upright = measured["gamma"] == 0.0
    pure = {"alpha": upright & (measured["kappa"] == 0.0), "kappa": upright & (measured["alpha"] == 0.0)}
    shown = (
        (lateral, "alpha", "F_y", "lateral force [kN]", 1e-3),
        (moment, "alpha", "M_z", "aligning moment [N m]", 1),
    )
    shown += ((longitudinal, "kappa", "F_x", "longitudinal force [kN]", 1e-3),)
    for ax, slip, force, label, scale in shown:
        for load in LOADS:
            rows = pure[slip] & (measured["load"] == load)
            at = {name: measured[name][rows] for name in ("kappa", "alpha", "gamma", "load")}
            order = np.argsort(at[slip])
            at = {name: column[order] for name, column in at.items()}
            x = np.degrees(at[slip]) if slip == "alpha" else at[slip]
            for tyre, colour, width in ((start, "#d9730d", 0.9), (fit.tyre, "#1f5f99", 1.4)):
                ax.plot(x, tyre.forces(at)[force] * scale, color=colour, linewidth=width)
            ax.plot(x, measured[force][rows][order] * scale, "o", color="#5b616b", markersize=2.2)
        ax.set(xlabel="slip angle [°]" if slip == "alpha" else "longitudinal slip [-]", ylabel=label)
    lateral.plot([], [], "o", color="#5b616b", markersize=2.2, label="measured")
    lateral.plot([], [], color="#d9730d", label="start")
    lateral.plot([], [], color="#1f5f99", label="fit")
    lateral.legend(frameon=False)
    for place, name in enumerate(UNKNOWN):
        ends = 100 * (np.array(fit.interval(name)) / true.coefficients[name] - 1)
        intervals.plot(ends, [place, place], color="#1f5f99", linewidth=3)
    intervals.axvline(0, color="#8a8f98", linewidth=0.8)
    intervals.set_yticks(range(len(UNKNOWN)), UNKNOWN, fontsize=6.5)
    intervals.set(xlabel="95 % interval beside the true value [%]", xlim=(-30, 30))
    for ax in figure.axes:
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(alpha=0.25)
    figure.savefig(path, dpi=80)


def main(folder: str | Path = ".", seed: int = 0) -> tuple[sr.TyreFile, sr.TyreFit]:
    true = sr.load_tyre("passenger_car")
    measured, start = rig(true, seed), first_guess(true)
    fit = start.fit(measured, UNKNOWN, sigma=NOISE)
    print(f"{len(measured['load'])} points, {len(UNKNOWN)} coefficients")
    print(fit)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    picture(measured, start, fit, true, folder / "tyre_from_measurements.png")
    return true, fit


if __name__ == "__main__":
    main(*sys.argv[1:2])
