"""Pictures and numbers of the gallery: every example is drawn, simulated and compared with its reference.

python examples/gallery.py [NAME ...]         # all examples, or those that are named, into docs/gallery
"""

import runpy
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

import sarrus as sr
from sarrus import mechanisms
from sarrus.euler import A

HERE = Path(__file__).parent
PICTURES = HERE.parent / "docs" / "gallery"
DPI = 60
WIDE, COLOURS = 1000, 128  # [pixels] of pictures that are halved; of all
PRECISE = {"method": sr.ODE("DOP853", rtol=1e-11, atol=1e-13)}


class Entry(NamedTuple):
    """What is simulated of an example, what is plotted, and what is known at the end: by coordinate or joint."""

    until: float
    plotted: tuple[str, ...]
    known: dict[str, float]


ANDREWS = {
    "beta": -0.0617138900142764496,
    "gamma": 0.455279819163070380,
    "phi": 0.222668390165885885,
}  # at the start
P3 = "rod_2", (0.0, -0.5, 0.0)  # the point of Bricard's mechanism that its reference follows
ENTRIES = {
    "simple_pendulum": Entry(
        10, ("ball.x", "ball.y"), {"ball.x": 0.2750874625761169, "ball.y": -0.9614192050991251}
    ),
    "four_bars": Entry(
        0.7,  # just before they lie flat, where explicit methods go no further
        ("upright_0.x", "upright_0.y"),
        {"upright_0.x": 0.997621322207317 / 2, "upright_0.y": 0.068932557455272 / 2},
    ),
    "andrews": Entry(
        0.03,
        ("K3.x", "K3.y"),
        {
            "beta.angle": 15.81077119629904,
            "gamma.angle": 0.04082224013073101,
            "phi.angle": -0.5347301163226948,
        },
    ),
    "bricard": Entry(
        2,
        ("rod_2.x", "rod_2.y", "rod_2.z"),
        {"P3.x": -0.77813537, "P3.y": -0.98035268, "P3.z": -0.19725267},
    ),
    "governor": Entry(1, ("slider.z",), {"slider.z": 0.50142092, "bearing.angle": 5.58634697}),
    "heavy_top": Entry(
        0.2,
        ("top.x", "top.y", "top.z"),
        {"top.x": 0.6055505613770, "top.z": -0.5239830274301, "top.e0": -0.7082791529743},
    ),
    "sundials_slider_crank": Entry(10, ("rod.x",), {"rod.x": 1.0235785589798}),
    "spatial_slider_crank_x": Entry(
        1, ("slider.x",), {"slider.x": 0.233764750336, "pin.angle": 10.484073838527}
    ),
    "spatial_slider_crank_z": Entry(
        1, ("slider.x",), {"slider.x": 0.229025089534, "pin.angle": 10.574206297599}
    ),
    "double_pendulum": Entry(5, ("two.x", "two.y"), {"two.x": 0.746493363360, "two.y": -1.273357544921}),
    "double_pendulum_3d": Entry(
        3,
        ("two.x", "two.y", "two.z"),
        {"two.x": -0.453789033636, "two.y": -0.163594646840, "two.e3": 0.012799624625},
    ),
    "free_body": Entry(
        10, ("body.e0", "body.e1", "body.e2"), {"body.e0": 0.3810637645818, "body.e2": -0.9238804334463}
    ),
    "slider_crank": Entry(2, ("slider.x",), {"slider.x": 3.715022003716}),
    "hmmwv": Entry(0.2, (), {"chassis.z": 0.7642780791724884}),  # at rest
    "car_axis": Entry(
        3,
        ("left.y", "right.y"),
        {"left.x": 0.0493455784275402809, "left.y": 0.496989460230171154, "right.y": 0.373911027265361257},
    ),
}
SCRIPTS = (  # each draws into a folder
    "hmmwv_bump",
    "hmmwv_ride",
    "falling_arm",
    "stewart_platform",
    "workspaces",
    "largest_workspace",
    "workspace_in_a_box",
    "four_bar_synthesis",
    "optimal_spring",
    "estimate_parameters",
    "torque_history",
    "uncertain_spring",
    "slider_crank_servo",
    "five_bar_optimal",
    "scissor_lift",
    "motor_constants",
    "active_suspension",
    "engine_mounts",
    "press_tolerances",
    "tie_rod",
    "lane_change",
    "tyre_from_measurements",
    "implicit_midpoint",
    "bdf2",
)


def value(run: sr.Trajectory, name: str) -> float:
    """The last value of a coordinate, or of a joint's angle from the example's own zero."""
    if name.startswith("P3."):
        body, point = run[P3[0]], np.array(P3[1])
        return float((body.position[-1] + A(body.euler[-1]) @ point)["xyz".index(name[-1])])
    if not name.endswith(".angle"):
        return float(run.coordinate(name)[-1])
    joint = name.removesuffix(".angle")
    return float(run.joint(joint).angle[-1]) + ANDREWS.get(joint, 0.0)


def row(name: str, found: float, known: float) -> str:
    return f"| `{name}` | {found:.9f} | {known:.9f} |"


def show(name: str, folder: Path) -> None:
    """Draw an example, simulate it, draw the motion, and print the rows of its table."""
    shipped = name in mechanisms.names()
    entry, model = ENTRIES[name], sr.load(mechanisms.path(name) if shipped else HERE / f"{name}.yaml")
    if model.joints:
        model.view(folder / f"{name}.png")
    times = np.linspace(0, entry.until, 501)
    run = sr.simulate(sr.System(model), until=entry.until, t_eval=times, **PRECISE)
    if entry.plotted:
        run.plot(*entry.plotted).figure.savefig(folder / f"{name}-motion.png", dpi=DPI)
    print(f"{name}: {run.message}, {run.nsteps} steps, |Φ| < {run.violation.max():.0e}")
    print(*(row(key, value(run, key), known) for key, known in entry.known.items()), sep="\n")


def light(picture: Path) -> None:
    """Make a picture small enough for a page."""
    with Image.open(picture) as found:
        if found.mode == "P":
            return
        small = found.convert("RGB")
    if small.width > WIDE:
        small = small.resize((small.width // 2, small.height // 2), Image.Resampling.LANCZOS)
    small.quantize(COLOURS, dither=Image.Dither.NONE).save(picture, optimize=True)


def main(*names: str, folder: Path = PICTURES) -> None:
    folder.mkdir(exist_ok=True)
    for name in names or (*ENTRIES, *SCRIPTS):
        if name in ENTRIES:
            show(name, folder)
        else:
            runpy.run_path(str(HERE / f"{name}.py"))["main"](folder)
    for picture in folder.glob("*.png"):
        light(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
