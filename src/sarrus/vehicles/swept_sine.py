"""Swept sine of the steering wheel, ISO 7401, and the frequency responses that follow from its run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..algebra import Array
from ..analyses.sensitivity.responses.responses import At, Integral
from ..model import SarrusError
from ..model.checks.arguments import checked_by
from ..outputs import find_output
from ..outputs.units import quotient
from ..results import FrequencyResponse, Trajectory
from ..system import System
from .manoeuvre import (
    CAR,
    CHECKS,
    DURATION,
    Manoeuvre,
    Measured,
    Metric,
    VehicleNames,
    driven,
    histories,
    judged,
)

POINTS = 100  # of a frequency response, unless frequencies are given


@dataclass(frozen=True, eq=False)
class SweptSine(Manoeuvre):
    """Result of `swept_sine_steer`.

    Attributes
    ----------
    steer : input of the steering wheel
    at : start of the sweep [s]
    band : its first and its last frequency [Hz]
    """

    steer: str = field(repr=False)
    at: float = field(repr=False)
    band: tuple[float, float] = field(repr=False)

    def frequency_response(self, frequencies: ArrayLike | None = None) -> FrequencyResponse:
        """Return the response of all histories to the steering wheel, Y(f)/U(f), from Fourier integrals of the run.

        Parameters
        ----------
        frequencies : (nf,) rising, within the band [Hz]; by default 100 of them

        Raises
        ------
        SarrusError
            If a frequency is outside of the band.
        """
        given = np.geomspace(*self.band, POINTS) if frequencies is None else frequencies
        f = np.atleast_1d(np.asarray(given, dtype=float))
        _refuse_outside(self.name, f, self.band)
        outputs = [one for one in self.histories.values() if one != self.steer]
        steer, *others = (_fourier(self.run, one, f, self.at) for one in (self.steer, *outputs))
        units = [_unit(self.run, one) for one in (self.steer, *outputs)]
        values = np.stack(others, axis=1)[:, :, None] / steer[:, None, None]
        return FrequencyResponse(self.name, f, values, (self.steer,), (*outputs,), (units[0],), (*units[1:],))


@checked_by(**CHECKS | {"at": DURATION})
def swept_sine_steer(
    system: System,
    speed: float = 80 / 3.6,
    angle: float = 0.25,
    *,
    band: tuple[float, float] = (0.1, 4.0),
    duration: float = 10.0,
    rise: float = 0.5,
    frequencies: Sequence[float] = (0.5, 1.0, 2.0),
    at: float = 2.0,
    names: VehicleNames = CAR,
    **options: Any,
) -> SweptSine:
    """Sine of the steering wheel whose frequency grows uniformly, at constant speed, ISO 7401.

    The numbers: at each of the `frequencies` the gains and phases of yaw rate and lateral acceleration over the angle
    of the steering wheel, such as ``yaw_rate_gain_1_Hz`` [1/s], ``yaw_rate_phase_1_Hz`` [rad] and
    ``lateral_acceleration_gain_0.5_Hz``. They are H(f) = ∫ w (y − y_0) e^(−2πift) dt / ∫ u e^(−2πift) dt, with the
    value y_0 at the start of the sweep and a window w that leaves out the time in which the vehicle settles. The run
    ends when the vehicle drives straight ahead again, so that H of a linear vehicle has no error of a window. Of one
    that is not linear, harmonics of lower frequencies are part of it: compare amplitudes.

    ``result.frequency_response()`` is that of all histories at any frequencies of the band, with the yaw rate, lateral
    acceleration, sideslip and roll. See `steering_response` for the limit of small angles.

    Parameters
    ----------
    system : System
    speed : [m/s]
    angle : amplitude of the steering wheel [rad]
    band : first and last frequency [Hz]
    duration : of the sweep [s]
    rise : duration in which the amplitude grows at the begin of the sweep, and falls at its end [s]
    frequencies : of the numbers, within the band [Hz]
    at : time before the sweep, and behind it, in which the vehicle settles [s]
    names : of the parts of the vehicle
    options : for `simulate`

    Raises
    ------
    SarrusError
        If frequencies are outside of the band, or numbers are out of their range.
    """
    first, last = band
    if not (angle and 0 < first < last and 2 * rise <= duration):
        message = "angle must not be 0, band must be positive and rise, and duration must be at least 2*rise"
        raise SarrusError(f"{system.name}: {message}. Change {angle=:g}, {band=}, {duration=:g}, {rise=:g}.")
    _refuse_outside(system.name, np.array(frequencies, dtype=float), band)
    names.refuse_missing(system, [names.steer])
    end, since = at + duration, f"(t - {at})"
    phase = f"2*pi*({first}*{since} + {(last - first) / (2 * duration)}*{since}^2)"
    amplitude = f"{angle}*step(t, {at}, 0, {at + rise}, 1)*step(t, {end - rise}, 1, {end}, 0)"
    inputs = {names.steer: f"{amplitude}*sin({phase})", names.speed: speed}
    run = driven(system, speed, end + at, inputs, names, options)
    outputs = {"yaw_rate": names.yaw_rate, "lateral_acceleration": names.lateral_acceleration}
    responses = {
        f"{name}_{word}_{frequency:g}_Hz": metric
        for frequency in frequencies
        for name, output in outputs.items()
        for word, metric in _transfer(run, output, names.steer, float(frequency), at)
    }
    result = judged("swept sine steer", run, responses, histories(names))
    return SweptSine(**vars(result), steer=names.steer, at=at, band=band)


def _refuse_outside(name: str, f: Array, band: tuple[float, float]) -> None:
    if len(wrong := f[~((f >= band[0]) & (f <= band[1]))]):
        message = f"{wrong[0]:g} Hz is outside of the band of the sweep, {band[0]:g} to {band[1]:g} Hz"
        raise SarrusError(f"{name}: {message}. Change frequencies or band.")


def _window(at: float) -> str:
    """W, that rises from 0 to 1 before the start of the sweep, to 1e-7 of both."""
    return f"(1 + tanh(16*t/{at} - 8))/2"


def _fourier(run: Trajectory, output: str, f: Array, at: float) -> Array:
    """∫ w (y − y(at)) e^(−2πift) dt (nf,): sums of equidistant samples, as both ends vanish."""
    y = (run[output] - run[output][np.searchsorted(run.t, at)]) * run[_window(at)]
    return np.asarray(np.exp(-2j * np.pi * np.outer(f, run.t)) @ y * (run.t[1] - run.t[0]))


def _unit(run: Trajectory, output: str) -> str:
    assert run.system is not None
    return find_output(run.system, output).unit


def _transfer(run: Trajectory, output: str, steer: str, f: float, at: float) -> Iterator[tuple[str, Metric]]:
    """Gain and phase: with U = |U| e^(iθ), H = ∫ w (y − y_0) (cos(ωt + θ) − i sin(ωt + θ)) dt / |U|."""
    U = _fourier(run, steer, np.array([f]), at)[0]
    size, turned = abs(U), f"({2 * np.pi * f}*t + {np.angle(U)})"
    waves = [f"{_window(at)}*{wave}{turned}" for wave in ("cos", "-sin")]
    of_one = [np.trapezoid(run[wave], run.t) for wave in waves]  # the integral over y_0 = 1
    parts = [At(output, time=at), *(Integral(f"({wave})*{output}") for wave in waves)]
    unit = quotient(_unit(run, output), _unit(run, steer))

    def gain(y_0: Any, real: Any, imaginary: Any) -> Any:
        return ((real - y_0 * of_one[0]) ** 2 + (imaginary - y_0 * of_one[1]) ** 2) ** 0.5 / size

    def phase(y_0: Any, real: Any, imaginary: Any) -> Any:
        return np.arctan2(imaginary - y_0 * of_one[1], real - y_0 * of_one[0])

    yield "gain", Measured(gain, parts, symbol=unit)
    yield "phase", Measured(phase, parts, symbol="rad")
