"""Sections of a run for second derivatives: last steps before some corners are apart, see `steps_to_corner`."""

from __future__ import annotations

from ....results import EventStep, Pieces, StepsTaken
from ....results.motion.steps import first_of, last_of
from .piece_chain import PieceChain
from .singular_laws import STEPS
from .steps_to_corner import StepsToCorner


def with_steps_apart(chain: PieceChain, in_curves: bool) -> Pieces:
    """The steps of a run, in which the last ones before each such corner begin with an event."""
    steps, pieces, event_steps = chain.steps, list[StepsTaken](), list[EventStep]()
    for derived, piece in zip(chain.event_steps, steps.pieces, strict=False):
        if derived.end_of_law and derived.end_of_law.second and len(piece) > 1:
            count = min(STEPS, len(piece) - 1)
            before, last = first_of(piece, len(piece) - count), last_of(piece, count)
            corner = derived.recorded(derived.event.function)
            function = StepsToCorner(chain.system, last, corner, in_curves)
            q, v, t = last.q[0], last.v[0], float(last.t[0])
            event = EventStep(
                name=derived.event.name, t=t, function=function, along=None, restitution=None, reset=None, q=q, v=v,
                after=v, named=False,
            )  # fmt: skip
            pieces.append(before)
            event_steps.append(event)
            piece = last
        pieces.append(piece)
        event_steps.append(derived.event)
    pieces += steps.pieces[len(chain.event_steps) :]
    return Pieces(pieces=tuple(pieces), event_steps=tuple(event_steps), until=steps.until)
