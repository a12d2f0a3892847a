"""Rates that `assemble` is given are finite numbers: nan counted as assembled, and text ended in an error of float."""

from __future__ import annotations

from typing import Any

import pytest

import sarrus as sr


@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        (float("nan"), ValueError, "rates: pin must be a finite number, but is nan"),
        (float("inf"), ValueError, "rates: pin must be a finite number, but is inf"),
        ("50 kg", sr.ModelError, 'rates: pin must be in rad/s, or another unit of that kind, got "50 kg"'),
        ([1.0], TypeError, "rates: pin must be a number"),
    ],
)
def test_rates_that_are_no_numbers_are_refused(value: Any, error: type[Exception], message: str) -> None:
    arm = sr.Body("arm", mass=1, inertia=(1, 1, 1), position=(1, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 0, 1))
    with pytest.raises(error, match=message):
        sr.assemble(sr.System(sr.Model("pendulum", [arm], [pin])), rates={"pin": value})
