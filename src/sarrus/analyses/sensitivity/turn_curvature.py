"""An event differentiated twice."""

from typing import Any


class TurnCurvature:
    """The second derivatives of one event."""

    def __init__(self, one: Any, curves: Any) -> None:
        self.one, self.curves = one, curves
