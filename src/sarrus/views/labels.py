"""Names in a drawing in space, moved up or down so that none lies on another."""

from __future__ import annotations

from itertools import count, takewhile
from typing import Any, NamedTuple

WIDE, HIGH = 0.58, 1.25  # of the size of the font: a letter, a line
FAR = 14  # lines that a name is moved at most


class Box(NamedTuple):
    """Left, right, lower and upper end [points]."""

    left: float
    right: float
    low: float
    high: float

    def meets(self, other: Box) -> bool:
        """Whether two boxes have a place in common."""
        return (
            self.left < other.right
            and other.left < self.right
            and self.low < other.high
            and other.low < self.high
        )

    def raised(self, by: float) -> Box:
        """The box, higher."""
        return self._replace(low=self.low + by, high=self.high + by)


def part_labels(ax: Any) -> None:
    """Shift the texts of axes in space on the page, each as little as may be, until no two overlap."""
    from matplotlib.transforms import ScaledTranslation

    ax.figure.draw_without_rendering()  # where the axes lie is known then
    placed: list[Box] = []
    for text in ax.texts:
        box, line = _box(ax, text), HIGH * text.get_fontsize()
        lifts = (0.5 * line * step * (-1) ** step for step in takewhile(lambda n: n < FAR, count()))
        lift = next((by for by in lifts if not any(box.raised(by).meets(one) for one in placed)), 0.0)
        placed.append(box.raised(lift))
        if lift:
            shift = ScaledTranslation(0.0, lift / 72, ax.figure.dpi_scale_trans)
            text.set_transform(text.get_transform() + shift)


def _box(ax: Any, text: Any) -> Box:
    """The place of a text on the page, from the number of its letters."""
    from mpl_toolkits.mplot3d import proj3d

    x, y, _ = proj3d.proj_transform(*text.get_position_3d(), ax.get_proj())
    right, up = ax.transData.transform((x, y)) * 72 / ax.figure.dpi
    lines, size = text.get_text().split("\n"), text.get_fontsize()
    wide = WIDE * size * max(map(len, lines))
    left = right - {"left": 0.0, "center": 0.5, "right": 1.0}[text.get_ha()] * wide
    written = [n for n, line in enumerate(lines) if line.strip()]  # empty lines only move the others
    below = HIGH * size * (len(lines) - 1 - written[-1])
    above = HIGH * size * written[0]
    full = HIGH * size * len(lines)
    low = up - full if text.get_va() == "top" else up
    return Box(left, left + wide, low + below, low + full - above)
