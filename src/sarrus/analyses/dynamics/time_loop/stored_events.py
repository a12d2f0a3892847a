"""Which runs with events can keep their steps for derivatives."""

from __future__ import annotations

from .prescribed import Prescribed


def refuse(method: object, saved: bool) -> None:
    """Refuse a run with events that shall keep its steps, where it cannot.

    Raises
    ------
    ValueError
        For other methods, and for a run that is saved, whose folder has room for the steps since the last event only.
    """
    if not isinstance(method, Prescribed):
        raise ValueError(
            "steps are kept by HHT(), GeneralizedAlpha(), Radau() and descriptions only; take one"
        )
    if saved:
        raise ValueError("the steps of a run with events are not saved; leave save= or store_steps= away")
