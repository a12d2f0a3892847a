"""Units and limits of the arguments of manoeuvres."""

from __future__ import annotations

from ..model.checks.arguments import Check, Number, NumberIn

POSITIVE = Number(positive=True)
SPEED = NumberIn("m/s", POSITIVE)
ANGLE = NumberIn("rad")
ANGULAR_RATE = NumberIn("rad/s", POSITIVE)
LENGTH = NumberIn("m", POSITIVE)
DURATION = NumberIn("s", POSITIVE)
START = NumberIn("s", Number(0.0))
SHARE = NumberIn("1", Number(positive=True, most=1.0))

# Of a driver who follows a path, see `lane_change.with_driver`
DRIVER: dict[str, Check] = {
    "preview": NumberIn("m", Number(0.0)),
    "gain": Number(),
    "curvature_gain": Number(),
    "lag": DURATION,
}
