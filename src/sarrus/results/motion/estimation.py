"""Estimation of errors: runs know their errors, but do not import the analysis that estimates them.

The analysis registers itself when it is imported, with all analyses, before there is a run.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_estimators: list[Callable[[Any, Any], tuple[Any, ...]]] = []


def register(estimate: Callable[[Any, Any], tuple[Any, ...]]) -> None:
    """Let a function of a run and of responses estimate errors from now on."""
    _estimators.append(estimate)


def estimator() -> Callable[[Any, Any], tuple[Any, ...]]:
    """The function that was registered last."""
    return _estimators[-1]
