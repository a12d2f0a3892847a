"""From recorded kernels to one compiled loop over all elements of a kind.

The loop of an element type does, for each element: read its numbers and the coordinates of its bodies, compute every
operator of a group in one go (what they share is computed once), and put the blocks into the operators' arrays.
It allocates nothing. In lanes it does so for several states at once: every number of an array is then as many numbers
side by side; elements' numbers are the same in all lanes.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..formulas.expression import Equation, Expression, Graph, Node
from ..formulas.functions import CLOSE, ROOT_STEPS
from .compiled_functions import COMPILED, READS_NUMBERS
from .vector import INT, REAL, Vector

HEADER = 4  # count, bodies, rows, numbers; then one entry per output
ROWS = ("lam", "nu", "lam_dot")  # operands along constraint equations
NUMBERS_DOT = "numbers_dot"  # changes of the elements' numbers


@dataclass
class Output:
    """Result of one operator for an element: its blocks (object arrays) and whether they add to the present values."""

    blocks: list[np.ndarray[Any, Any]]
    adds: bool


@dataclass
class Recording:
    """The kernels of one element type, recorded as one graph."""

    name: str
    graph: Graph
    bodies: int
    numbers: int
    arrays: tuple[str, ...]
    scalars: tuple[str, ...]
    outputs: list[Output] = field(default_factory=list)

    def fingerprint(self) -> str:
        """Hash of everything that is compiled."""
        blocks = [[str(getattr(e, "id", e)) for e in np.ravel(b)] for o in self.outputs for b in o.blocks]
        shapes = [[(o.adds, b.shape) for b in o.blocks] for o in self.outputs]
        text = repr((self.graph.nodes, blocks, shapes, self.bodies, self.numbers, self.arrays))
        return hashlib.sha256(text.encode()).hexdigest()[:16]


class Emitter:
    """Emits the nodes of a graph on demand, in the order in which the outputs need them."""

    def __init__(self, nodes: Sequence[Node], context: Any, inputs: Inputs | RootInputs) -> None:
        self.nodes = nodes
        self.context, self.builder, self.inputs = context, inputs.builder, inputs
        self.numbers, self.vector = inputs.arguments.all_numbers, inputs.arguments.vector
        self.values: dict[int, Any] = {}

    def value(self, expression: Any) -> Any:
        """The LLVM value of an expression or of a plain number."""
        if not isinstance(expression, Expression):
            return self.vector.constant(float(expression))
        stack = [expression.id]
        while stack:
            node = self.nodes[stack[-1]]
            waiting = [arg for arg in node.args if arg not in self.values]
            if stack[-1] in self.values or not waiting:
                identity = stack.pop()
                if identity not in self.values:
                    self.values[identity] = self._emit(node)
            else:
                stack.extend(reversed(waiting))
        return self.values[expression.id]

    def _emit(self, node: Any) -> Any:
        args = [self.values[arg] for arg in node.args]
        builder, flags = self.builder, ("contract",)
        match node.op:
            case "constant":
                return self.vector.constant(float(node.value))
            case "input":
                return self.inputs(node.value)
            case "add":
                return builder.fadd(*args, flags=flags)
            case "sub":
                return builder.fsub(*args, flags=flags)
            case "mul":
                return builder.fmul(*args, flags=flags)
            case "div":
                return builder.fdiv(*args, flags=flags)
            case "neg":
                return builder.fneg(*args, flags=flags)
            case "sqrt":
                return self.vector.sqrt(builder, *args)
            case "root":
                function = root_function(builder.module, self.context, node.value)
                return self.vector.each(
                    builder, args, lambda own: builder.call(function, [self.numbers, *own])
                )
            case function:
                return self.vector.each(builder, args, partial(self._call, function))

    def _call(self, function: str, args: list[Any]) -> Any:
        kinds: list[Any] = [types.float64] * len(args)
        if function in READS_NUMBERS:
            args, kinds = [self.numbers, *args], [types.CPointer(types.float64), *kinds]
        signature = types.float64(*kinds)
        if function not in COMPILED:  # a derivative of a table that only plain Python has
            raise TypeError(
                f"{function} of a table is not available in a kernel. Use derivatives up to the third order."
            )
        compiled = self.context.compile_subroutine(self.builder, COMPILED[function], signature)
        _, result = self.context.call_internal_no_propagate(self.builder, compiled.fndesc, signature, args)
        return result


class RootInputs:
    """What an equation takes: the unknown, and numbers that stay the same."""

    def __init__(self, builder: Any, unknown: Any, numbers: Any, x: Sequence[Any]) -> None:
        self.builder, self.unknown, self.x = builder, unknown, x
        self.arguments = SimpleNamespace(all_numbers=numbers, vector=Vector(1))

    def __call__(self, name: tuple[Any, ...]) -> Any:
        return self.unknown if name[0] == "u" else self.x[name[1]]


def root_function(module: Any, context: Any, equation: Equation) -> Any:
    """The function of all numbers, a start and x that solves an equation by Newton's method, emitted once."""
    name = f"sarrus.root.{hashlib.sha256(repr(equation).encode()).hexdigest()[:16]}"
    if name in module.globals:
        return module.globals[name]
    count = sum(node.op == "input" and node.value[0] == "x" for node in equation.nodes)
    kinds = [REAL.as_pointer(), REAL, *[REAL] * count]
    function = ir.Function(module, ir.FunctionType(REAL, kinds), name)
    function.linkage = "internal"
    function.attributes.add("noinline")
    numbers, start, *x = function.args
    entry, step, again, found, lost = (
        function.append_basic_block(word) for word in ("entry", "step", "again", "found", "lost")
    )
    ir.IRBuilder(entry).branch(step)
    builder = ir.IRBuilder(step)
    u, n = builder.phi(REAL), builder.phi(INT)
    emitter = Emitter(equation.nodes, context, RootInputs(builder, u, numbers, x))
    g, by_u = (emitter.value(equation.graph.at(place)) for place in equation.results[:2])
    change = builder.fdiv(g, by_u)
    closer, left = builder.fsub(u, change), builder.sub(n, INT(1))
    size = module.declare_intrinsic("llvm.fabs.f64", (), ir.FunctionType(REAL, [REAL]))
    largest = builder.fadd(REAL(equation.scale), builder.call(size, [closer]))
    limit = builder.fmul(REAL(CLOSE), largest)
    close = builder.fcmp_ordered("<=", builder.call(size, [change]), limit)
    builder.cbranch(close, found, again)
    for phi, first, later in ((u, start, closer), (n, INT(ROOT_STEPS), left)):
        phi.add_incoming(first, entry)
        phi.add_incoming(later, again)
    after = ir.IRBuilder(again)
    after.cbranch(after.icmp_signed(">", left, INT(0)), step, lost)
    ir.IRBuilder(found).ret(closer)
    ir.IRBuilder(lost).ret(REAL(math.nan))
    return function


def _function(module: Any, recording: Recording, operands: Sequence[Any]) -> Any:
    """Declare the loop: count, bodies, rows, numbers, all numbers, places..., scalars..., arrays..., outputs..."""
    real, whole, count = REAL.as_pointer(), INT.as_pointer(), len(recording.outputs)
    kinds = [INT, whole, whole, real, real, *[whole] * count, *(operand.type for operand in operands)]
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), kinds), f"sarrus.{recording.name}")
    function.linkage = "internal"
    function.attributes.add("noinline")
    for argument in function.args[-count:]:
        argument.add_attribute("noalias")
    return function


class Arguments:
    """The arguments of a loop, by what they are; `k` is the element whose turn it is."""

    def __init__(self, function: Any, recording: Recording, vector: Vector) -> None:
        self.recording, self.vector = recording, vector
        self.count, self.bodies, self.rows, self.numbers, self.all_numbers, *rest = function.args
        sizes = (len(recording.outputs), len(recording.scalars), len(recording.arrays))
        cuts = [0, *np.cumsum(sizes), len(rest)]
        parts = [rest[start:end] for start, end in pairwise(cuts)]
        self.places, self.results = parts[0], parts[3]
        self.scalars = dict(zip(recording.scalars, parts[1], strict=True))
        self.arrays = dict(zip(recording.arrays, parts[2], strict=True))


class Inputs:
    """Emits the loads of one element's inputs; where each vector begins is computed once."""

    def __init__(self, builder: Any, arguments: Arguments, k: Any) -> None:
        self.builder, self.arguments, self.k = builder, arguments, k
        self.bases: dict[tuple[Any, ...], Any] = {}

    def __call__(self, name: tuple[Any, ...]) -> Any:
        """The value of an input: ``("t",)``, ``("numbers", n)``, ``("lam", n)`` or ``("q", body, n)``."""
        if name[0] in self.arguments.scalars:
            return self.arguments.scalars[name[0]]
        key, offset = name[:-1], name[-1]
        if key not in self.bases:
            self.bases[key] = self._base(*key)
        at = self.builder.gep(self.bases[key], [INT(offset)])
        if key[0] in ("numbers", NUMBERS_DOT):
            return self.arguments.vector.fill(self.builder, self.builder.load(at))
        return self.arguments.vector.load(self.builder, at)

    def pointer(self, base: Any, stride: int) -> Any:
        """This element's entry of a table."""
        return self.builder.gep(base, [self.builder.mul(self.k, INT(stride))])

    def _base(self, kind: str, slot: int = 0) -> Any:
        """Where the element's numbers, its multipliers, or the part of an operand that is a body's begin."""
        given, recording = self.arguments, self.arguments.recording
        if kind == "numbers":
            return self.pointer(given.numbers, recording.numbers)
        if kind == NUMBERS_DOT:
            return self.pointer(given.arrays[kind], recording.numbers)
        if kind in ROWS:
            return self.builder.gep(given.arrays[kind], [self.builder.load(self.pointer(given.rows, 1))])
        body = self.builder.gep(self.pointer(given.bodies, recording.bodies), [INT(slot)])
        return self.builder.gep(given.arrays[kind], [self.builder.load(body)])


def _emit_loop(
    module: Any, context: Any, recording: Recording, vector: Vector, operands: Sequence[Any]
) -> Any:
    """The function that computes a recording for every element of a population."""
    function = _function(module, recording, operands)
    arguments = Arguments(function, recording, vector)
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    with cgutils.for_range(builder, arguments.count) as loop:
        _emit_element(context, recording, Inputs(builder, arguments, loop.index))
    builder.ret_void()
    return function


def _emit_element(context: Any, recording: Recording, inputs: Inputs) -> None:
    """All outputs of one element, block by block."""
    emitter, arguments = Emitter(recording.graph.nodes, context, inputs), inputs.arguments
    for output, place, result in zip(recording.outputs, arguments.places, arguments.results, strict=True):
        at = inputs.pointer(place, 2 * len(output.blocks))
        for n, block in enumerate(output.blocks):
            _put(emitter, at, n, result, block, output.adds)


def _put(emitter: Emitter, at: Any, n: int, result: Any, block: Any, adds: bool) -> None:
    """Store (or add) one block at its base and row stride."""
    matrix = np.atleast_2d(block) if block.ndim != 1 else block.reshape(-1, 1)
    builder, vector = emitter.builder, emitter.vector
    values = [[emitter.value(entry) for entry in row] for row in matrix]
    base, stride = (builder.load(builder.gep(at, [INT(2 * n + m)])) for m in (0, 1))
    row = builder.gep(result, [base])
    for r, line in enumerate(values):
        if r:
            row = builder.gep(row, [stride])
        for c, value in enumerate(line):
            if adds and vector.is_zero(value):
                continue
            target = builder.gep(row, [INT(c)])
            vector.store(
                builder, builder.fadd(vector.load(builder, target), value) if adds else value, target
            )


def loop(record: Callable[[], Recording], arrays: int, scalars: int, outputs: int, lanes: int = 1) -> Any:
    """The compiled loop of one element type and group, as a function that Numba code can call:
    ``loop(index, slot, numbers, *scalars, *arrays, *outputs)``. `record` is called only if there is no cached code.
    In several lanes scalars are arrays too.
    """
    parameters = [f"a{n}" for n in range(scalars + arrays + outputs)]
    namespace: dict[str, Any] = {"types": types, "codegen": _codegen(record, Vector(lanes))}
    lines = [
        f"def body(typingctx, index, slot, numbers, {', '.join(parameters)}):",
        f"    return types.void(index, slot, numbers, {', '.join(parameters)}), codegen",
    ]
    exec("\n".join(lines), namespace)
    return intrinsic(namespace["body"])


def _codegen(record: Callable[[], Recording], vector: Vector) -> Callable[..., Any]:
    def codegen(context: Any, builder: Any, signature: Any, args: Sequence[Any]) -> Any:
        def data(n: int) -> Any:
            return context.make_array(signature.args[n])(context, builder, args[n]).data

        recording = record()
        outputs = len(recording.outputs)
        index, numbers = data(0), data(2)
        header = builder.mul(args[1], INT(HEADER + outputs))

        def entry(n: int) -> Any:
            return builder.load(builder.gep(index, [builder.add(header, INT(n))]))

        def table(n: int) -> Any:
            return builder.gep(index, [entry(n)])

        def operand(n: int, name: str) -> Any:
            if name in recording.scalars and vector.lanes == 1:
                return args[n]
            if name == NUMBERS_DOT:
                return builder.gep(data(n), [entry(3)])
            at = vector.pointer(builder, data(n))
            return vector.load(builder, at) if name in recording.scalars else at

        names = (*recording.scalars, *recording.arrays, *[""] * outputs)
        operands = [operand(n, name) for n, name in enumerate(names, 3)]
        function = _emit_loop(builder.module, context, recording, vector, operands)
        count = entry(0)
        with builder.if_then(builder.icmp_signed(">", count, INT(0))):
            call = [count, table(1), table(2), builder.gep(numbers, [entry(3)]), numbers]
            call += [table(HEADER + n) for n in range(outputs)] + operands
            builder.call(function, call)
        return context.get_dummy_value()

    return codegen
