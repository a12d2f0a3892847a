"""Check which runs with events can store their steps for derivatives."""

from __future__ import annotations

from .prescribed import Prescribed


def refuse(method: object, saved: bool) -> None:
    """Refuse a run with events that is to store its steps, where it cannot.

    Raises
    ------
    ValueError
        For other methods, and for a run that is saved, whose folder holds the steps since the last event only.
    """
    if not isinstance(method, Prescribed):
        raise ValueError(
            "method: stores no steps. Choose HHT(), GeneralizedAlpha(), Radau() or a description."
        )
    if saved:
        raise ValueError("save: the steps of a run with events are not saved. Remove save= or store_steps=.")
