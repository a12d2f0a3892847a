"""Records of arrays that the time integration loop uses."""

from __future__ import annotations

from typing import NamedTuple

from ...._jit.kernels.pointer import KernelTable
from ...._jit.kernels.scalars import Scalars
from ....algebra import Array
from ...equations.block_matrix import Assembler
from ...equations.paired_matrix import Pairs
from ..dense_output.sample_loop import MotionSolver
from ..methods.program import Program
from ..stepping.motion_scale import Tolerance
from .crossing import Crossing, Switching


class Entries(NamedTuple):
    """The kernels of all groups of operators one after another, see `_jit.kernels.pointer`.

    bounds : where those of each group begin: of the equations, in the order of `methods.program`, then of the matrix
    """

    addresses: Array
    starts: Array
    tables: Array
    bounds: Array


class State(NamedTuple):
    """The work array x and the registers r of a program; parts of x: the state before a step (0), and after it (1).

    v_given : velocities before a step, where those in x have a part of the defect of their constraints removed
    past, past_a : the last nodes, the newest first: how long before the step they are (infinite: there is none), and
        their accelerations; as many as the error estimate needs
    """

    x: Array
    r: Array
    q0: Array
    v0: Array
    a0: Array
    lam0: Array
    q1: Array
    v1: Array
    a1: Array
    lam1: Array
    v_given: Array
    past: Array
    past_a: Array


class Memory(NamedTuple):
    """Right side (in x) and solution of Newton's method; round-off of Φ; the removed defect (s, σ); W (nq,).

    real : right side and solution of the real system of stages that are split
    """

    right: Array
    solution: Array
    noise: Array
    correction: Array
    unit: Array
    real: Array
    real_solution: Array


class Matrix(NamedTuple):
    """The values of all operators, the matrix of a step and its factors.

    Where stages are split, `pair` has the matrices of the real eigenvalue and of the complex ones, and `placed` weights
    of the real one.
    """

    values: Array
    left_out: Array
    placed: Assembler
    pair: Pairs


class Record(NamedTuple):
    """Accepted steps, row by row, as many as the buffers hold; and lengths of steps that are prescribed.

    h, removed : length of each step, and which part of the defect of the velocity constraints was removed before it
    error, iterations, rejected : its error (1 is the tolerance), Newton iterations, and the steps rejected before it
    t, q, v, a, lam : its end
    node_a : the accelerations there between which states are interpolated, see `error.smooth`
    correction, impulse : s and σ of `remove_defect`, if there are buffers for them; zero where nothing was removed
    stages : the quantities of all stages, if there are buffers for them
    memory : what elements remember there
    given : lengths to take, without error control (none: chosen to meet the tolerances)
    """

    t: Array
    h: Array
    removed: Array
    q: Array
    v: Array
    a: Array
    node_a: Array
    lam: Array
    correction: Array
    impulse: Array
    stages: Array
    memory: Array
    error: Array
    iterations: Array
    rejected: Array
    given: Array


class Control(Scalars):
    """Where the loop is, and what it has counted.

    Attributes
    ----------
    t : the time reached [s]
    h : length of the next step [s]
    last_h : length of the last step [s]; 0 at a start
    steps, rejected, residuals, matrices : accepted and rejected steps, evaluated residuals, factored matrices
    rejected_since : steps rejected since the last accepted one
    x_h, ratio : length of the step that the coefficients belong to [s], and its ratio to the one before
    defect : what part of the defect of the velocity constraints is left since the last step
    factored_h : length of the step that the factors belong to [s]; 0 where they are to be renewed
    old_factors : whether the factors are those of an earlier step
    failure : why a step was last rejected, `NEWTON` or `ERROR`
    hold, wait : for how many steps the length stays after a failure of Newton's method, and for how many it still does
    last_error : the error of the last step, over the tolerance
    projected : whether the defect of the velocities before the step has been computed
    continued : whether there is a step from which the next goes on
    """

    t: float
    h: float
    last_h: float
    steps: int
    rejected: int
    residuals: int
    matrices: int
    rejected_since: int
    x_h: float
    ratio: float
    defect: float
    factored_h: float
    old_factors: bool
    failure: int
    hold: int
    wait: int
    last_error: float
    projected: bool
    continued: bool


class Run(NamedTuple):
    """All that the loop of steps works on.

    Attributes
    ----------
    remembered, places : kernels of what elements remember, and where that is in their numbers b
    h_max : the longest step [s]
    apart : whether q and v are interpolated apart between its steps, see `nodes.between`
    """

    program: Program
    entries: Entries
    motion: MotionSolver
    remembered: KernelTable
    b: Array
    places: Array
    h_max: float
    state: State
    memory: Memory
    matrix: Matrix
    control: Control
    record: Record
    tol: Tolerance
    switching: Switching
    crossing: Crossing
    apart: bool
