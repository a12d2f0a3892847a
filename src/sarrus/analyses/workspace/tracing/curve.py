"""One candidate curve by pseudo-arclength continuation, from its beginning to its next event."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..problem.watch import check
from .event import SLACK, Event, Own, first_event
from .point import Point, Step, point_at, point_with
from .stratum import NoPoint, Stratum, Tangent, correct, plane
from .vertex import directions

ANGLE = 0.22  # rad that the tangent may turn in one step
SHORTEST = 1e-7
LONGEST = 0.35  # free of units, in x
CROSSING = 0.03  # of a step that ends where curves cross
OFF = 2e-3  # how far Newton's method may move the predicted point, for a step of 1
DOUBT = 1e-5  # of the outputs in the middle of a step, free of units: areas are then right to some 1e-8
TURN = 2 * np.pi


class Trace:
    """A curve that is followed to its next event.

    Parameters
    ----------
    stratum : Stratum
    start : where it begins, its tangent into the curve
    own : the event at which it begins
    closes : whether it may come back to its start
    longest : step, free of units
    most : points

    Attributes
    ----------
    points : up to the event
    event : at the end
    failure : why there is none
    """

    def __init__(
        self,
        stratum: Stratum,
        start: Point,
        own: Own,
        closes: bool,
        *,
        longest: float = LONGEST,
        most: int = 5000,
    ) -> None:
        self.stratum, self.points = stratum, [start]
        self.event: Event | None = None
        self.failure = ""
        self._own, self._closes, self._longest, self._most = own, closes, longest, most
        self._h = self._wanted(start)

    def follow(self) -> Trace:
        """Take steps until the next event or a failure."""
        while self.event is None and not self.failure:
            check()
            self._advance()
        return self

    def _advance(self) -> None:
        """Take one more step, so short that it succeeds."""
        message = "the curve bends too much at its start"
        while self._h > SHORTEST:
            try:
                if self._step():
                    return
            except NoPoint as error:
                self._h *= 0.4
                message = str(error)
        self.failure = f"the step became too short: {message}"

    def _wanted(self, point: Point) -> float:
        longest = self._longest if point.tangent.bends else CROSSING
        return min(longest, ANGLE / max(float(np.linalg.norm(point.tangent.turn)), 1e-9))

    def _step(self) -> bool:
        """Try a step; false if it has to end before a crossing of curves."""
        a, h, stratum = self.points[-1], self._h, self.stratum
        guess = a.x + h * a.t + 0.5 * h * h * a.tangent.turn
        x, linear = correct(stratum, guess, plane(guess, a.t), steps=4)
        off = float(np.linalg.norm(x - guess))
        if off > 10 * OFF:
            raise NoPoint("the curve bends too much")
        b = self._near(a, point_at(stratum, x, linear, a.t), h)
        if float(a.t @ b.t) < np.cos(1.6 * ANGLE):
            raise NoPoint("the curve bends too much")
        if Step(a, b).doubt() > DOUBT:
            raise NoPoint("the curve bends too quickly")
        if not self._take(a, b):
            return False
        grow = min(2.0, max(0.5, (OFF / max(off, 1e-12)) ** (1 / 3)))
        self._h = min(self._wanted(b), grow * h)
        return True

    def _take(self, a: Point, b: Point) -> bool:
        """Keep a step up to its first event."""
        first = len(self.points) == 1
        start = self.points[0] if self._closes and len(self.points) > 2 else None
        event = first_event(self.stratum, Step(a, b), self._own if first else None, start)
        if event is not None and event.kind == "branch":
            if event.tau * self._h > CROSSING:
                self._h = event.tau * self._h - 0.7 * CROSSING
                return False
            event = event._replace(point=self._crossed(a, event.point))
        if event is not None:
            b = self._near(a, event.point, event.tau * self._h)
            event = event._replace(point=b)
        if first and event is not None and abs(event.tau) * self._h < SLACK:
            self.points.clear()
        self.points.append(b)
        self.event = event
        if event is None and len(self.points) > self._most:
            self.failure = "it has too many points"
        return True

    def _crossed(self, a: Point, b: Point) -> Point:
        """A crossing with the exact direction of the curve that was followed."""
        linear = self.stratum.linear(b.x)
        found = directions(self.stratum, b.x, linear)
        if not found:
            return b
        t = max(found, key=lambda t: abs(float(t @ a.t)))
        t = t if t @ a.t > 0 else -t
        return point_with(self.stratum, b.x, linear, Tangent(t, np.zeros_like(t), 0.0, False))

    def _near(self, a: Point, b: Point, h: float) -> Point:
        """Angles among the outputs counted on from the last point."""
        problem = self.stratum.problem
        angles = problem.output_angles
        if not angles.any():
            return b
        goal = a.u + h * a.u_s
        return replace(b, u=b.u + np.where(angles, TURN * np.round((goal - b.u) / TURN), 0.0))
