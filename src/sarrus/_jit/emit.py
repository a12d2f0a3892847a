"""From recorded kernels to one compiled loop over all elements of a kind.

The loop of an element type does, for each element: read its numbers and the coordinates of its bodies, compute every
operator of a group in one go (what they share is computed once), and put the blocks into the operators' arrays.
It allocates nothing.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .compiled_functions import COMPILED, READS_NUMBERS
from .expression import Expression, Graph

HEADER = 4  # count, bodies, rows, numbers; then one entry per output
REAL, INT = ir.DoubleType(), ir.IntType(64)


@dataclass
class Output:
    """What one operator computes for an element: its blocks (object arrays) and whether they add to what is there."""

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

    def __init__(
        self, recording: Recording, context: Any, builder: Any, inputs: Callable[[tuple[Any, ...]], Any]
    ):
        self.nodes = recording.graph.nodes
        self.context, self.builder, self.inputs = context, builder, inputs
        self.numbers: Any = None
        self.values: dict[int, Any] = {}

    def value(self, expression: Any) -> Any:
        """The LLVM value of an expression or of a plain number."""
        if not isinstance(expression, Expression):
            return ir.Constant(REAL, float(expression))
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
                return ir.Constant(REAL, float(node.value))
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
                return builder.call(builder.module.declare_intrinsic("llvm.sqrt", [REAL]), args)
            case function:
                return self._call(function, args)

    def _call(self, function: str, args: list[Any]) -> Any:
        kinds: list[Any] = [types.float64] * len(args)
        if function in READS_NUMBERS:
            args, kinds = [self.numbers, *args], [types.CPointer(types.float64), *kinds]
        signature = types.float64(*kinds)
        compiled = self.context.compile_subroutine(self.builder, COMPILED[function], signature)
        _, result = self.context.call_internal_no_propagate(self.builder, compiled.fndesc, signature, args)
        return result


def _function(module: Any, recording: Recording) -> Any:
    """Declare the loop: count, bodies, rows, numbers, all numbers, places..., scalars..., arrays..., outputs..."""
    real, whole, count = REAL.as_pointer(), INT.as_pointer(), len(recording.outputs)
    kinds = [INT, whole, whole, real, real, *[whole] * count]
    kinds += [REAL] * len(recording.scalars) + [real] * len(recording.arrays) + [real] * count
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), kinds), f"sarrus.{recording.name}")
    function.linkage = "internal"
    function.attributes.add("noinline")
    for argument in function.args[-count:]:
        argument.add_attribute("noalias")
    return function


def _emit_loop(module: Any, context: Any, recording: Recording) -> Any:
    function = _function(module, recording)
    outputs = len(recording.outputs)
    count, bodies, rows, numbers, all_numbers, *rest = function.args
    places, rest = rest[:outputs], rest[outputs:]
    scalars = dict(zip(recording.scalars, rest, strict=False))
    rest = rest[len(recording.scalars) :]
    arrays = dict(zip(recording.arrays, rest, strict=False))
    results = rest[len(recording.arrays) :]
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    with cgutils.for_range(builder, count) as loop:
        k = loop.index

        def pointer(base: Any, stride: int) -> Any:
            return builder.gep(base, [builder.mul(k, INT(stride))])

        def body(name: str, slot: int) -> Any:
            at = builder.load(builder.gep(pointer(bodies, recording.bodies), [INT(slot)]))
            return builder.gep(arrays[name], [at])

        bases: dict[Any, Any] = {}

        def load(name: tuple[Any, ...]) -> Any:
            kind, *where = name
            if kind in scalars:
                return scalars[kind]
            if kind == "numbers":
                key, offset = kind, where[0]
                base = bases.get(key) or pointer(numbers, recording.numbers)
            elif kind == "lam":
                key, offset = kind, where[0]
                base = bases.get(key) or builder.gep(arrays["lam"], [builder.load(pointer(rows, 1))])
            else:
                key, offset = (kind, where[0]), where[1]
                base = bases.get(key) or body(kind, where[0])
            bases[key] = base
            return builder.load(builder.gep(base, [INT(offset)]))

        emitter = Emitter(recording, context, builder, load)
        emitter.numbers = all_numbers
        for output, place, result in zip(recording.outputs, places, results, strict=True):
            at = pointer(place, 2 * len(output.blocks))
            for n, block in enumerate(output.blocks):
                _put(builder, emitter, at, n, result, block, output.adds)
    builder.ret_void()
    return function


def _put(builder: Any, emitter: Emitter, at: Any, n: int, result: Any, block: Any, adds: bool) -> None:
    """Store (or add) one block at its base and row stride."""
    matrix = np.atleast_2d(block) if block.ndim != 1 else block.reshape(-1, 1)
    values = [[emitter.value(entry) for entry in row] for row in matrix]
    base, stride = (builder.load(builder.gep(at, [INT(2 * n + m)])) for m in (0, 1))
    row = builder.gep(result, [base])
    for r, line in enumerate(values):
        if r:
            row = builder.gep(row, [stride])
        for c, value in enumerate(line):
            if adds and isinstance(value, ir.Constant) and value.constant == 0.0:
                continue
            target = builder.gep(row, [INT(c)])
            builder.store(builder.fadd(builder.load(target), value) if adds else value, target)


def loop(record: Callable[[], Recording], arrays: int, scalars: int, outputs: int) -> Any:
    """The compiled loop of one element type and group, as a function that Numba code can call:
    ``loop(index, slot, numbers, *scalars, *arrays, *outputs)``. `record` is called only if there is no cached code.
    """
    parameters = [f"a{n}" for n in range(scalars + arrays + outputs)]
    namespace: dict[str, Any] = {"types": types, "codegen": _codegen(record, scalars)}
    lines = [
        f"def body(typingctx, index, slot, numbers, {', '.join(parameters)}):",
        f"    return types.void(index, slot, numbers, {', '.join(parameters)}), codegen",
    ]
    exec("\n".join(lines), namespace)
    return intrinsic(namespace["body"])


def _codegen(record: Callable[[], Recording], scalars: int) -> Callable[..., Any]:
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

        operands = [args[3 + n] if n < scalars else data(3 + n) for n in range(len(args) - 3)]
        function = _emit_loop(builder.module, context, recording)
        count = entry(0)
        with builder.if_then(builder.icmp_signed(">", count, INT(0))):
            call = [count, table(1), table(2), builder.gep(numbers, [entry(3)]), numbers]
            call += [table(HEADER + n) for n in range(outputs)] + operands
            builder.call(function, call)
        return context.get_dummy_value()

    return codegen
