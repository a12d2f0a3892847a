"""One sample of a stepper: inputs, steps to its end, outputs; one function that is compiled."""

from __future__ import annotations

from typing import NamedTuple

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array
from ..dense_output.sample_loop import MotionSolver
from ..step_loop.error import accelerations
from ..step_loop.loop import REPIVOT, RUNNING, advance
from ..step_loop.records import Run, State


class Outputs(NamedTuple):
    """Outputs that are computed at the end of a sample.

    values : their kernels, of t, q and v
    remembered : the kernels of what their elements remember, in `places`
    b : parameters of their elements
    memory, out : buffers for both
    """

    values: KernelTable
    remembered: KernelTable
    b: Array
    places: Array
    memory: Array
    out: Array


class Inputs(NamedTuple):
    """Inputs that are set at the beginning of a sample.

    given, present : their values: those of the next sample, and those that the parameters have
    places, own : indices in the parameters of the system, and which input has each
    output_places, output_own : the same in those of the outputs
    stale : 1 where the accelerations at the present state are those of former inputs
    """

    given: Array
    present: Array
    places: Array
    own: Array
    output_places: Array
    output_own: Array
    stale: Array


class Sampling(NamedTuple):
    """All that a sample needs."""

    run: Run
    inputs: Inputs
    outputs: Outputs


@compiled
def take_sample(sampling: Sampling, until: float) -> tuple[int, int]:
    """Set the inputs, take steps until a time, and compute the outputs.

    Returns
    -------
    a status, see `advance`, and the number of steps; outputs are those at the time reached
    """
    run, inputs, outputs = sampling
    state, control = run.state, run.control
    set_inputs(inputs, run.b, outputs.b)
    if inputs.stale[0] != 0.0:
        if not new_accelerations(run.motion, run.b, control.t, state):
            return REPIVOT, 0
        inputs.stale[0], control.continued = 0.0, False
    status, taken = RUNNING, 0
    while status == RUNNING and control.t < until:
        status, one = advance(run, until, 1)
        taken += one
        if len(outputs.places) > 0:
            call_kernels(outputs.remembered, outputs.b, control.t, state.q0, outputs.memory)
            for k in range(len(outputs.places)):
                outputs.b[outputs.places[k]] = outputs.memory[k]
        if one == 0:
            break
    call_kernels(outputs.values, outputs.b, control.t, state.q0, state.v0, outputs.out)
    return status, taken


@compiled
def set_inputs(inputs: Inputs, b: Array, b_of_outputs: Array) -> None:
    """Write the values of inputs that have changed into the parameters."""
    for k in range(len(inputs.given)):
        if inputs.given[k] != inputs.present[k]:
            inputs.present[k], inputs.stale[0] = inputs.given[k], 1.0
    for k in range(len(inputs.places)):
        b[inputs.places[k]] = inputs.present[inputs.own[k]]
    for k in range(len(inputs.output_places)):
        b_of_outputs[inputs.output_places[k]] = inputs.present[inputs.output_own[k]]


@compiled
def new_accelerations(motion: MotionSolver, b: Array, t: float, state: State) -> bool:
    """a and λ at the present state, after its forces have jumped; false if pivots must be renewed."""
    for k in range(len(state.q0)):
        state.q1[k], state.v1[k] = state.q0[k], state.v0[k]
    if not accelerations(motion, b, t, state):
        return False
    for k in range(len(state.a0)):
        state.a0[k] = state.a1[k]
    for k in range(len(state.lam0)):
        state.lam0[k] = state.lam1[k]
    return True
