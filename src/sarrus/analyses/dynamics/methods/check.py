"""Checks of a method's description: names, kinds and sizes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from .description import CONSTRAINTS, COORDINATES, Affine, Description, Stage, Step
from .equations import KINDS, MULTIPLIERS

SIZES = (COORDINATES, CONSTRAINTS)
IN_STEPS = tuple(kind for kind in KINDS if kind != "impulse")


def check(method: Description) -> None:
    """Refuse a description that is not complete.

    Raises
    ------
    TypeError
        If `step` does not return a `Step`, or branches on its arguments.
    ValueError
        With what is wrong, and what is allowed.
    """
    step = method.step(1.0, 1.0)
    if not isinstance(step, Step):
        raise TypeError(
            f"{method.name}: step must return a sarrus.Step, got {type(step).__name__}. "
            "Return Step(stages, equations, update)."
        )
    for problem in _problems(method, step):
        raise ValueError(f"{method.name}: {problem}")


def _problems(method: Description, step: Step) -> Iterator[str]:
    for name, size in method.unknowns.items():
        if size not in SIZES:
            yield f'the unknown {name} has the size {size!r}. Give "coordinates" or "constraints".'
        if name in method.state:
            yield f"{name} is an unknown and a block of the state. Give it another name."
    yield from _wrong_maps(method, step)
    for kind, s, *_ in step.equations:
        if kind not in IN_STEPS:
            yield f"there is no equation {kind!r}. Choose from {', '.join(IN_STEPS)}."
        if not 0 <= s < len(step.stages):
            yield f"the equation {kind!r} is of stage {s}, but there are {len(step.stages)}."
    for size in SIZES:
        wanted = sum(own == size for own in method.unknowns.values())
        found = sum(KINDS[kind].size == size for kind, *_ in step.equations)
        if wanted != found:
            yield f"{wanted} unknowns have the size of the {size}, but {found} equations. Give as many of both."
    if not {"q", "v", *method.extra} <= set(step.update):
        missing = ", ".join(sorted({"q", "v", *method.extra} - set(step.update)))
        yield f"the update has no {missing}. Give q, v and all extra blocks."
    if ("a" in step.update) != ("lam" in step.update):
        yield "the update has only one of a and lam. Give both, or none for those of the equations of motion."


def _wrong_maps(method: Description, step: Step) -> Iterator[str]:
    """Names of blocks that are not there, or of another size."""
    blocks = {**method.state, **method.unknowns}
    for s, stage in enumerate(step.stages):
        for name in Stage._fields[1:]:
            size = CONSTRAINTS if name in MULTIPLIERS else COORDINATES
            yield from _wrong_blocks(f"{name} of stage {s}", getattr(stage, name), blocks, size)
    for name, affine in step.update.items():
        if name not in method.state:
            yield f"the update has {name}, which is no block of the state. Add it to extra."
        else:
            yield from _wrong_blocks(f"{name} of the update", affine, blocks, method.state[name])
    for name, affine in method.extra.items():
        own = {n: size for n, size in method.state.items() if n not in method.extra}
        yield from _wrong_blocks(f"the extra block {name}", affine, own, COORDINATES)


def _wrong_blocks(what: str, affine: Affine, blocks: Mapping[str, str], size: str) -> Iterator[str]:
    for name in affine:
        if name not in blocks:
            yield f"{what} uses {name}, which is no block. Choose from {', '.join(blocks)}."
        elif blocks[name] != size:
            yield f"{what} has the size of the {size}, but uses {name}, of the size of the {blocks[name]}."
