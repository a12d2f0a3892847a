"""Program, kernels and tolerances of the error estimate of a described method for a system."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...._jit.kernels.pointer import NONE
from ....system import System
from ....system.cached import once_alike
from ...equations.block_matrix import Numbers
from ..methods.check import check
from ..methods.description import Description, FilteredEstimate, Step
from ..methods.equations import GROUPS
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
