"""Random roads of the classes of ISO 8608, as two tracks of a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..checks.arguments import Number, WholeNumber
from ..errors import ModelError
from ..quantity import Array
from ..show import quote
from .curve import Curve
from .surface import Surface

CLASSES = "ABCDEFGH"
REFERENCE = 0.1  # [1/m] the reference spatial frequency n0; ISO 8608
ROUGHNESS_OF_A = 16e-6  # [m³] displacement PSD of class A at it, geometric mean; ISO 8608
BAND = (0.011, 2.83)  # [1/m] of the spatial frequencies that ISO 8608 evaluates
TERMS_IN_OCTAVE = 40
POINTS_IN_WAVE = 20  # of the shortest wave: the spline through them is exact to 3e-5 of it
POINTS_IN_RISE = 20  # at least, of the spline within the blend
LEVEL = 1000.0  # [m] of the table before the road, on which a vehicle begins
POINTS_BEFORE = 40  # of height 0: from each to the one before, a spline falls by 2 - √3, by 1e-23 in total
# Ω_p [rad/s] and p of the classes; Ammon (1992)
COHERENCE = {"A": (8.5, 3.5), "B": (5.3, 2.2), "C": (3.0, 1.3), "D": (1.6, 0.8), "E": (0.8, 0.5)}


@dataclass(frozen=True)
class RandomRoad:
    """A random road whose two tracks have the spectrum of a class of ISO 8608.

    Each track is a sum of cosines with random phases (Shinozuka),

        z(x) = Σ_k √(2 ∫_k G dn) cos(2π n_k x + φ_k),   G(n) = G(n0) (n / n0)^-waviness,   n0 = 0.1 / m,

    over intervals of equal ratio between 0.011 and 2.83 cycles/m, with n_k at a random place of its interval, so that
    the road does not repeat. The tracks have the coherence γ(n) = (1 + (2π n width / Ω_p)²)^-p of Ammon ("Problems in
    road surface modelling", 1992), for class E and rougher with the numbers of E: long waves lift both wheels, short
    ones each for itself. Each wave of the right track is the left one moved by the phase ± arccos γ, with a random
    sign, so that both have exactly the wanted spectrum. The road is flat before `start` and reaches its full roughness
    `blend` metres later.

    Parameters
    ----------
    roughness
        The class, "A" (very good) to "H"; or G(n0) [m³], for which the coherence of the nearest class is taken.
    length
        Of the road [m]; beyond it, it is continued by its tangent.
    seed
        The same number gives the same road.
    width
        Between the two tracks [m].
    start
        The x at which the road begins [m].
    blend
        Length over which the roughness begins [m].
    waviness
        The exponent of the spectrum.

    Raises
    ------
    ModelError
        If there is no such class, or a number is out of its range.

    Examples
    --------
    >>> road = RandomRoad("B", length=50.0, seed=3)
    >>> round(road.left(0.0), 12)
    0.0
    """

    roughness: str | float
    length: float
    seed: int = 0
    width: float = 1.6
    start: float = 0.0
    blend: float = 10.0
    waviness: float = 2.0

    def __post_init__(self) -> None:
        for name in ("length", "blend"):
            Number(positive=True)(name, getattr(self, name))
        for name in ("width", "waviness"):
            Number(0.0)(name, getattr(self, name))
        Number()("start", self.start)
        WholeNumber()("seed", self.seed)
        if self.blend > self.length:
            message = f"blend is {self.blend:g} m, longer than the road of {self.length:g} m"
            raise ModelError(f"{message}. Give a shorter one.", part="road")
        if isinstance(self.roughness, str):
            if len(self.roughness) != 1 or self.roughness not in CLASSES:
                message = f"there is no class {quote(self.roughness)} of roads"
                raise ModelError(f"{message}. Give one of {', '.join(CLASSES)}, or G(n0) in m³.", part="road")
        else:
            Number(positive=True)("roughness", self.roughness)

    @property
    def reference_psd(self) -> float:
        """The displacement PSD G(n0) at 0.1 cycles/m [m³]."""
        if isinstance(self.roughness, str):
            return ROUGHNESS_OF_A * 4.0 ** CLASSES.index(self.roughness)
        return float(self.roughness)

    def coherence(self, n: float | Array) -> Array:
        """Return γ, the cross spectrum of the two tracks divided by the spectrum of each, at n [1/m]."""
        nearest = round(np.log(self.reference_psd / ROUGHNESS_OF_A) / np.log(4.0))
        peak, exponent = COHERENCE["ABCDE"[min(max(nearest, 0), 4)]]
        return np.asarray((1 + (2 * np.pi * np.asarray(n, float) * self.width / peak) ** 2) ** -exponent)

    @property
    def left(self) -> Curve:
        """Height of the left track over x [m]."""
        return self._tracks[0]

    @property
    def right(self) -> Curve:
        """Height of the right track over x [m]."""
        return self._tracks[1]

    @cached_property
    def surface(self) -> Surface:
        """The road between and beside both tracks: straight from the left one, at y = width/2, to the right one.

        Raises
        ------
        ModelError
            If the width is zero.
        """
        if self.width == 0:
            message = "width is 0, so that both tracks are one. Use left, or give a width."
            raise ModelError(message, part="road")
        x, right = np.array(self.right.pairs).T
        heights = np.column_stack([right, [z for _, z in self.left.pairs]])
        return Surface(x, [-self.width / 2, self.width / 2], heights)

    @cached_property
    def _tracks(self) -> tuple[Curve, Curve]:
        random = np.random.default_rng(self.seed)
        edges = np.geomspace(*BAND, round(TERMS_IN_OCTAVE * np.log2(BAND[1] / BAND[0])) + 1)
        n = edges[:-1] + random.random(len(edges) - 1) * np.diff(edges)
        amplitudes = np.sqrt(2 * self._power(edges))
        wave = amplitudes * np.exp(2j * np.pi * random.random(len(n)))
        shared = self.coherence(n)
        other = wave * (shared + 1j * random.choice([-1.0, 1.0], len(n)) * np.sqrt(1 - shared**2))
        x = self._places()
        u = np.clip(x / self.blend, 0.0, 1.0)
        rise = u**3 * (10 - 15 * u + 6 * u * u)  # twice continuously differentiable
        left, right = (
            Curve.table(np.column_stack([self.start + x, rise * _sum(x, n, one)])) for one in (wave, other)
        )
        return left, right

    def _places(self) -> Array:
        """The x - start of the spline's points, the first ones before the start, so that its tangent there is level."""
        spacing = 1 / (BAND[1] * POINTS_IN_WAVE)
        rise = np.linspace(0.0, self.blend, max(int(np.ceil(self.blend / spacing)), POINTS_IN_RISE) + 1)
        number = int(np.ceil((self.length - self.blend) / spacing))
        rest = np.linspace(self.blend, self.length, number + 1)[1:]
        before = np.arange(-POINTS_BEFORE, 0) * rise[1]
        return np.concatenate([[before[0] - LEVEL], before, rise, rest])

    def _power(self, edges: Array) -> Array:
        """∫ G dn over each interval."""
        if self.waviness == 1.0:
            integral = REFERENCE * np.log(edges / REFERENCE)
        else:
            integral = REFERENCE * (edges / REFERENCE) ** (1 - self.waviness) / (1 - self.waviness)
        return np.asarray(self.reference_psd * np.diff(integral))


def _sum(x: Array, n: Array, wave: np.ndarray[Any, Any]) -> Array:
    """Re Σ_k wave_k exp(2πi n_k x)."""
    cosines = (np.abs(a) * np.cos(2 * np.pi * f * x + np.angle(a)) for f, a in zip(n, wave, strict=True))
    return np.asarray(sum(cosines))
