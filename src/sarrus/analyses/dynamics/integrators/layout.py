"""Program, kernels and tolerances of the error estimate of a described method for a system."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from ...._jit.kernels.pointer import NONE
from ....system import System
from ....system.cached import once_alike
from ...equations.block_matrix import Numbers
from ..methods.description import CONSTRAINTS, COORDINATES, Affine, Description, FilteredEstimate, Stage, Step
from ..methods.equations import GROUPS, KINDS, MULTIPLIERS
from ..methods.leading_error import leading_errors
from ..methods.nonholonomic import method_for
from ..methods.program import NODE, OF_EQUATIONS, OUTPUTS, Program, ProgramBuilder
from ..methods.tables import Tables
from ..step_loop.newton import NEWTON_SHARE
from ..step_loop.records import Entries
from ..stepping.entries import entry_of, joined
from ..stepping.motion_scale import Tolerance
from ..stepping.tolerance import Tolerances

SHARE = 0.1  # of rtol^(2/3)
SLOW = 0.03  # contraction above which the matrices of split stages are renewed for the next step
STALLED = 0.1  # of the tolerance: corrections that are smaller and no longer fall are round-off
REPEATED = 1.0  # the same where equations repeat others, whose combination may be weak
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


class Layout(NamedTuple):
    """Data derived from a description for systems of one structure.

    program, tables : see `methods.program`, `methods.tables`
    of_matrix : tables of the matrix, which are those of one stage where stages are split
    size : of the work array
    recorded : how many numbers of the stages of a step are stored; none where they are those of the state after it
    nodes : where q, v, a and λ before (0) and after (1) a step are in it
    """

    program: Program
    tables: Tables
    of_matrix: Tables
    size: int
    recorded: int
    nodes: Mapping[str, slice]


@once_alike
def layout_of(system: System, method: Description) -> Layout:
    """The layout of a method.

    Raises
    ------
    TypeError, ValueError
        If the description is not one of a method.
    """
    check(method)
    builder, later = ProgramBuilder(system, method_for(system, method)), leading_errors(method).later
    tables = builder.tables
    numbers = Numbers(system, builder.of_matrix.names, builder.of_matrix.like)
    program = builder.program(numbers, *later)
    places = {f"{name}{k}": (builder.block(where, name), name) for k, where in enumerate(("state", "after"))
              for name in NODE}  # fmt: skip
    nodes = {key: slice(at, at + tables.size(method.state[name])) for key, (at, name) in places.items()}
    recorded = 0 if _ends_alone(tables, builder.step) else tables.stage_size
    return Layout(program, tables, builder.of_matrix, builder.size, recorded, nodes)


def _ends_alone(tables: Tables, step: Step) -> bool:
    """Whether all quantities of the stages are those of the state after the step."""
    return all(getattr(step.stages[s], name) is step.update.get(name) for s, name in tables.recorded)


@once_alike
def kernels_of(system: System, method: Description) -> Entries:
    """The kernels of the operators that steps of a method need."""
    program = layout_of(system, method).program
    needed = {*program.calls[:, 0].tolist(), *(OF_EQUATIONS + program.operators[:, 0]).tolist()}
    groups = enumerate((*OUTPUTS.values(), *GROUPS.values()))
    found = [entry_of(system, *names) if n in needed else NONE for n, names in groups]
    bounds = np.cumsum([0, *(len(group.addresses) for group in found)])
    return Entries(*joined(found), bounds)


def filtered_tolerance(given: Tolerances, error: FilteredEstimate) -> Tolerance:
    """The tolerances of an estimate of lower order than the method's.

    The estimate falls with h^(p + 1), the error with a higher power: steps are controlled as in Hairer and Wanner's
    RADAU5, with a share of rtol^(2/3) in the place of rtol. Newton's method leaves half as much: derivatives hold it
    constant, so that it costs them more digits than it costs the motion.
    """
    power = (error.order + 1) / (error.of_method + 1)
    inner_q, inner_v = (SHARE * rtol**power for rtol in (given.rtol_q, given.rtol_v))
    inner = float(min(inner_q.min(), inner_v.min()))
    newton = float(max(1e-14 / inner, min(NEWTON_SHARE, inner**0.5 / 2)))
    found = given.for_loop(inner_q / given.rtol_q, inner_v / given.rtol_v, speed=True)
    return found._replace(
        newton=newton,
        stalled=STALLED,
        stalled_repeated=REPEATED,
        slow=SLOW,
        noise=0.0,
    )
