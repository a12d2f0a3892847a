"""The tie rod for least bump steer: a double wishbone suspension on the rig, its sheet, and the best inner joint.

python examples/tie_rod.py [FOLDER]

The points are those of a published report of Lotus suspension analysis (4x4V23, v4.03), in mm: x rearward, y to the
right, z upward, with the origin in the right wheel centre. The optimizer moves the inner joint of the tie rod until
toe changes as little as possible over a stroke of ±50 mm; the camber of the suspension stays within a band.
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

POINTS = {
    "lower_front": (-105.88, 240.00, 65.40), "lower_rear": (116.32, 240.00, 25.57), "lower_ball": (-12.46, 562.18, -60),
    "upper_front": (-184.08, 240.00, 206.34), "upper_rear": (167.42, 240.00, 135.02), "upper_ball": (28.28, 538.13, 80),
    "tie_inner": (75.00, 230.23, 108.91), "tie_outer": (58.00, 526.75, 11.78),
    "damper_arm": (-7.78, 431.24, 29.98), "damper_body": (52.33, 262.89, 362.10),
    "spindle": (0, 551.87, 0), "wheel": (0, 650.00, 0),
}  # fmt: skip
WHEEL = sr.Corner(
    "knuckle", "wheel", "spindle", 0.2794, kingpin=("lower_ball", "upper_ball"), spring="spring"
)
VEHICLE = sr.Vehicle(wheelbase=1.351, cg_height=0.55, brake_share=0.81)
BOUNDS = {"tie_inner.y": (0.20, 0.26), "tie_inner.z": (0.07, 0.13)}
SHEET = (
    *("toe", "camber", "caster", "track_change", "wheel_recession", "scrub_radius"),
    *("roll_centre_height", "anti_dive", "spring_ratio"),
)
MOST_CAMBER = np.radians(1.8)


def corner() -> sr.Model:
    """The right corner; the arms and the knuckle follow the hardpoints."""
    p, ground = sr.Hardpoints(POINTS, unit="mm"), sr.ground
    lower = sr.Body("lower_arm", 5, (0.1, 0.1, 0.1), position=p.lower_ball)
    upper = sr.Body("upper_arm", 3, (0.1, 0.1, 0.1), position=p.upper_ball)
    knuckle = sr.Body("knuckle", 20, (0.5, 0.5, 0.5), position=p.wheel)
    joints = [
        sr.Revolute("lower_hinge", ground, lower, point=p.lower_front, axis=(p.lower_front, p.lower_rear)),
        sr.Revolute("upper_hinge", ground, upper, point=p.upper_front, axis=(p.upper_front, p.upper_rear)),
        sr.Spherical("lower_joint", lower, knuckle, point=p.lower_ball),
        sr.Spherical("upper_joint", upper, knuckle, point=p.upper_ball),
        sr.Distance("tie_rod", ground.global_point(*p.tie_inner), knuckle.global_point(*p.tie_outer)),
    ]
    ends = ground.global_point(*p.damper_body), lower.global_point(*p.damper_arm)
    return sr.Model(
        "double wishbone", [lower, upper, knuckle], joints, [sr.TSDA("spring", *ends, k=60e3, length=0.43)]
    )


def analysed(model: sr.Model) -> sr.Suspension:
    """The suspension on the rig."""
    return sr.suspension(sr.System(model), right=WHEEL, forward="-x", vehicle=VEHICLE)


def best_tie_rod(result: sr.Suspension) -> sr.Optimum:
    """The inner joint of least toe over the stroke, in the mean of squares; camber stays within a band."""
    toe, camber = result.response("toe"), result.response("camber")
    return sr.optimize(
        result.sweeps["bump"].run.system,
        sr.Integral(lambda o: (1e3 * toe(o)) ** 2, name="toe"),
        [*BOUNDS],
        analysis=result.analysis(),
        bounds=BOUNDS,
        constraints=[
            sr.Within(sr.Maximum(camber, name="largest camber"), upper=MOST_CAMBER),
            sr.Within(sr.Minimum(camber, name="smallest camber"), lower=-MOST_CAMBER),
        ],
    )


def picture(before: sr.Suspension, after: sr.Suspension, gradient: sr.Gradient, path: Path, dpi: int) -> None:
    """Toe before and after, and the hardpoints with the largest influence on the slope of toe."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3.4), layout="constrained")
    curves, bars = figure.subplots(1, 2)
    for result, label, colour in ((before, "published", "#8a8f98"), (after, "optimal", "#1f5f99")):
        curves.plot(1e3 * result.x(), np.degrees(result["toe"]), color=colour, label=label)
    curves.set(xlabel="wheel travel [mm]", ylabel="toe-in [°]")
    curves.legend(frameon=False)
    names = sorted(gradient.names, key=lambda name: -abs(gradient[name]))[:10][::-1]
    bars.barh(names, [np.degrees(gradient[name]) * 1e-3 for name in names], color="#d9730d", height=0.6)
    bars.set(xlabel="change of bump steer [°/m per mm]")
    for ax in (curves, bars):
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(alpha=0.25)
    figure.savefig(path, dpi=dpi)


def main(folder: str | Path = ".", dpi: int = 80) -> tuple[sr.Suspension, sr.Optimum, sr.Suspension]:
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    before = analysed(corner())
    print(before)
    gradient = before.sensitivity("ride_steer", wrt=["hardpoints"])
    print(gradient.table(most=8))
    best = best_tie_rod(before)
    print(best)
    moved = dict(zip(best.names, best.x.tolist(), strict=True))
    after = analysed(corner().with_parameters(moved))
    picture(before, after, gradient, folder / "tie_rod.png", dpi)
    before.plot("bump", *SHEET)[0].figure.savefig(folder / "tie_rod-sheet.png", dpi=0.7 * dpi)
    return before, best, after


if __name__ == "__main__":
    main(*sys.argv[1:2])
