"""Results are values: their arrays cannot be written to."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np


def freeze(result: Any) -> None:
    """Replace every array of a frozen dataclass by a read-only view; whoever made the array may still write to it."""
    for field in fields(result):
        value = getattr(result, field.name)
        if isinstance(value, np.ndarray):
            view = value.view()
            view.setflags(write=False)
            object.__setattr__(result, field.name, view)
