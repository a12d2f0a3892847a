"""Units and limits of the arguments of manoeuvres."""

from __future__ import annotations

from ..model.checks.arguments import Number, NumberIn

POSITIVE = Number(positive=True)
SPEED = NumberIn("m/s", POSITIVE)
ANGLE = NumberIn("rad")
ANGULAR_RATE = NumberIn("rad/s", POSITIVE)
LENGTH = NumberIn("m", POSITIVE)
DURATION = NumberIn("s", POSITIVE)
START = NumberIn("s", Number(0.0))
SHARE = NumberIn("1", Number(positive=True, most=1.0))
