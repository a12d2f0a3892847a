"""A mechanism in its initial pose: each body as lines from its origin to its points, joints and forces as marks."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...model import Model
from ...model.expansion.blueprint import Blueprint, Placement, blueprint
from ...model.words import global_point
from ..looks.anchors import fields, masses
from ..meshes.mesh import POINT
from .style import ORANGE, figure_of

BODIES = ("#1f5f99", "#2f8f6b", "#8a4fa3", "#a6761d", "#c23b4e", "#4a7a8c")
JOINT, GROUND_COLOUR = "#222222", "#8a8f98"
MARGIN = 0.12  # of the largest extent, around the drawing
FRONT = {0: (0, 0), 1: (0, -90), 2: (90, -90)}  # elevation and azimuth [deg] of a view along x, y, z
SHORT = 0.4  # of the largest extent: axes with space for few tick labels
ORIGIN = (0.0, 0.0, 0.0)


class Lettering(NamedTuple):
    """Names in a figure."""

    letter: float = 0.58  # width, of the size of the font
    line: float = 1.25  # height, of the size of the font
    farthest: int = 14  # lines that a name is moved at most
    order: int = 1000  # of drawing: above all else
    most: int = 16  # names of joints and forces


NAMES = Lettering()


class Mark(NamedTuple):
    """A point at which a joint or force holds a body."""

    owner: str
    body: int
    place: Array
    is_joint: bool


def mechanism_figure(model: Model) -> Any:
    """Draw a model in its initial pose, as one figure.

    Parameters
    ----------
    model : Model

    Returns
    -------
    Figure

    Raises
    ------
    ModelError
        If anything is wrong in the model.
    ImportError
        If Matplotlib is not installed.
    """
    plan = blueprint(model)
    marks = _marks(plan)
    figure = figure_of(8.5, 7.0)
    ax = figure.add_subplot(projection="3d")
    centers = {body: global_point(plan, body, center) for body, (_, _, center) in masses(plan).items()}
    for number in range(1, len(plan.bodies) + 1):
        places = [mark.place for mark in marks if mark.body == number]
        _draw_body(ax, plan, number, [*places, centers[number]])
    _write_bodies(ax, plan)
    _draw_joints(ax, [mark for mark in marks if mark.is_joint])
    _draw_forces(ax, [mark for mark in marks if not mark.is_joint])
    _write_names(ax, marks)
    origins = [_origin(plan, number) for number in centers]
    _fit(ax, [*(mark.place for mark in marks), *origins, *centers.values()])
    ax.set_title(model.name, loc="left", fontsize=11)
    part_labels(ax)
    return figure


def _marks(plan: Blueprint) -> list[Mark]:
    """Return the points of all joints and forces: the fields s, s_i and s_j of their elements."""
    return [
        Mark(placement.owner, body, global_point(plan, body, point), placement.element.rows > 0)
        for placement in plan.placed
        for body, point in _points(placement._replace(bodies=plan.bodies_of(placement)))
    ]


def _points(placement: Placement) -> Iterable[tuple[int, Any]]:
    names, known = ("s",) if len(placement.bodies) == 1 else ("s_i", "s_j"), fields(placement)
    return [(body, known[name]) for name, body in zip(names, placement.bodies, strict=False) if name in known]


def _origin(plan: Blueprint, body: int) -> Array:
    return global_point(plan, body, ORIGIN)


def _colour(number: int) -> str:
    return BODIES[(number - 1) % len(BODIES)]


def _draw_body(ax: Any, plan: Blueprint, number: int, points: list[Array]) -> None:
    """Draw lines from the origin to all points, the last of which is the centre of mass, and a square there."""
    origin, colour = _origin(plan, number), _colour(number)
    for point in points:
        _line(ax, origin, point, color=colour, linewidth=2.2)
    if len(points) <= 5:
        for one, other in combinations(points[:-1], 2):
            _line(ax, one, other, color=colour, linewidth=0.8, alpha=0.5)
    ax.scatter(*points[-1], color=colour, s=26, marker="s", depthshade=False)


def _write_bodies(ax: Any, plan: Blueprint) -> None:
    """Write the names of bodies above their origins."""
    for number, name in enumerate(plan.bodies, start=1):
        ax.text(*_origin(plan, number), f" {name}\n", color=_colour(number), fontsize=9)


def _draw_joints(ax: Any, marks: list[Mark]) -> None:
    """Draw a ring at every point of a joint, filled on the ground; a line between its group if they are apart."""
    for group in _by_owner(marks):
        _line(ax, group[0].place, group[-1].place, color=JOINT, linewidth=1.2, linestyle=":")
    for mark in sorted(marks, key=lambda mark: mark.body, reverse=True):
        ground = mark.body == 0
        colours = {"facecolor": GROUND_COLOUR if ground else "white", "edgecolor": JOINT}
        ax.scatter(
            *mark.place, **colours, s=60 if ground else 30, marker="^" if ground else "o", depthshade=False
        )


def _draw_forces(ax: Any, marks: list[Mark]) -> None:
    """Draw a dashed line between the group of a force, or a mark at its only one."""
    for group in _by_owner(marks):
        places = [mark.place for mark in group]
        _line(ax, places[0], places[-1], color=ORANGE, linewidth=1.6, linestyle="--")
        ax.scatter(*np.transpose(places), color=ORANGE, s=16, marker="D", depthshade=False)


def _write_names(ax: Any, marks: list[Mark]) -> None:
    """Write the names of joints and forces, those at one place together; none if there are many."""
    names: dict[tuple[float, ...], list[Mark]] = {}
    for group in _by_owner(marks):
        middle = np.round((group[0].place + group[-1].place) / 2, 3) + 0.0
        names.setdefault((*middle.tolist(), group[0].is_joint), []).append(group[0])
    if len(names) > NAMES.most:
        return
    for (x, y, z, is_joint), group in names.items():
        text = "\n" + ", ".join(mark.owner for mark in group)
        ax.text(x, y, z, text, color=JOINT if is_joint else ORANGE, fontsize=8, va="top", ha="center")


def _by_owner(marks: list[Mark]) -> list[list[Mark]]:
    owners = dict.fromkeys(mark.owner for mark in marks)
    return [[mark for mark in marks if mark.owner == owner] for owner in owners]


def _line(ax: Any, one: Array, other: Array, **style: Any) -> None:
    ax.plot(*np.transpose([one, other]), **style)


def _fit(ax: Any, places: list[Array]) -> None:
    """Give all axes the same scale, around all places; look at a flat mechanism from the front."""
    low, high = np.min(places, axis=0), np.max(places, axis=0)
    largest = max(float(np.max(high - low)), 1e-3)
    flat = [axis for axis in range(3) if high[axis] - low[axis] < POINT * largest]
    pad = np.full(3, MARGIN * largest)
    pad[flat] = 3 * MARGIN * largest
    for set_limits, a, b in zip((ax.set_xlim, ax.set_ylim, ax.set_zlim), low - pad, high + pad, strict=True):
        set_limits(a, b)
    for axis, extent in zip((ax.xaxis, ax.yaxis, ax.zaxis), high - low + 2 * pad, strict=True):
        if extent < SHORT * largest:
            axis.get_major_locator().set_params(nbins=2)
    front = 0 < len(flat) < 3
    ax.set_box_aspect(high - low + 2 * pad, zoom=1.1 if len(flat) == 1 else 0.95)
    _label(ax)
    if front:
        _from_the_front(ax, flat[-1])
    else:
        ax.view_init(elev=20, azim=-60)


def _label(ax: Any) -> None:
    for axis, name in zip((ax.xaxis, ax.yaxis, ax.zaxis), "xyz", strict=True):
        axis.set_label_text(f"{name} [m]")
        axis.pane.set_visible(False)
    ax.tick_params(labelsize=7)


def _from_the_front(ax: Any, along: int) -> None:
    """Look along an axis, of which nothing is to be seen then."""
    ax.set_proj_type("ortho")
    ax.view_init(*FRONT[along])
    hidden = (ax.xaxis, ax.yaxis, ax.zaxis)[along]
    hidden.set_ticks([])
    hidden.set_label_text("")
    hidden.line.set_visible(False)


def part_labels(ax: Any) -> None:
    """Shift the texts of axes in space on the page, each as little as may be, until no two overlap; above all lines."""
    from matplotlib.patheffects import withStroke
    from matplotlib.transforms import ScaledTranslation

    ax.figure.draw_without_rendering()  # where the axes lie is known then
    placed: list[Any] = []
    for text in ax.texts:
        text.set(zorder=NAMES.order, path_effects=[withStroke(linewidth=2.5, foreground="white")])
        box, half = _box(ax, text), 0.5 * NAMES.line * text.get_fontsize()
        lifts = (half * step * (-1) ** step for step in range(NAMES.farthest))
        lift = next((lift for lift in lifts if not box.translated(0.0, lift).count_overlaps(placed)), 0.0)
        placed.append(box.translated(0.0, lift))
        if lift:
            shift = ScaledTranslation(0.0, lift / 72, ax.figure.dpi_scale_trans)
            text.set_transform(text.get_transform() + shift)


def _box(ax: Any, text: Any) -> Any:
    """The box of a text on the page [points], from the number of its letters."""
    from matplotlib.transforms import Bbox
    from mpl_toolkits.mplot3d import proj3d

    x, y, _ = proj3d.proj_transform(*text.get_position_3d(), ax.get_proj())
    right, up = ax.transData.transform((x, y)) * 72 / ax.figure.dpi
    lines, size = text.get_text().split("\n"), text.get_fontsize()
    wide = NAMES.letter * size * max(map(len, lines))
    left = right - {"left": 0.0, "center": 0.5, "right": 1.0}[text.get_ha()] * wide
    written = [n for n, line in enumerate(lines) if line.strip()]  # empty lines only move the others
    below = NAMES.line * size * (len(lines) - 1 - written[-1])
    above = NAMES.line * size * written[0]
    full = NAMES.line * size * len(lines)
    low = up - full if text.get_va() == "top" else up
    return Bbox.from_extents(left, low + below, left + wide, low + full - above)
