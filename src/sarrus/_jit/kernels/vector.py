"""Numbers side by side in one register: how LLVM loads, stores, and fills them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir

from ..linking.shipped import lanes

REAL, INT = ir.DoubleType(), ir.IntType(64)
LANES = lanes()


class Vector:
    """Emits numbers of some lanes; one lane is a plain number."""

    def __init__(self, lanes: int = LANES) -> None:
        self.lanes = lanes
        self.kind: Any = REAL if lanes == 1 else ir.VectorType(REAL, lanes)
        self._align = None if lanes == 1 else 8  # arrays are not aligned to more

    def constant(self, value: float) -> Any:
        """A constant with the same number in all lanes."""
        return ir.Constant(self.kind, value if self.lanes == 1 else [value] * self.lanes)

    def is_zero(self, value: Any) -> bool:
        """Whether an emitted value is plainly zero."""
        return isinstance(value, ir.Constant) and value.constant == self.constant(0.0).constant

    def pointer(self, builder: Any, data: Any) -> Any:
        """An array's memory as numbers of this kind."""
        return builder.bitcast(data, self.kind.as_pointer())

    def load(self, builder: Any, at: Any) -> Any:
        """The numbers at a pointer of this kind."""
        return builder.load(at, align=self._align)

    def store(self, builder: Any, value: Any, at: Any) -> None:
        """Write them."""
        builder.store(value, at, align=self._align)

    def fill(self, builder: Any, value: Any) -> Any:
        """A plain number in all lanes."""
        if self.lanes == 1:
            return value
        first = builder.insert_element(ir.Constant(self.kind, ir.Undefined), value, INT(0))
        return self.shuffle(builder, first, first, [0] * self.lanes)

    def shuffle(self, builder: Any, a: Any, b: Any, chosen: Sequence[int]) -> Any:
        """A vector of the chosen lanes of a followed by b."""
        mask = ir.Constant(ir.VectorType(ir.IntType(32), self.lanes), list(chosen))
        return builder.shuffle_vector(a, b, mask)

    def sqrt(self, builder: Any, x: Any) -> Any:
        """The square root."""
        name = "llvm.sqrt." + ("f64" if self.lanes == 1 else f"v{self.lanes}f64")
        kind = ir.FunctionType(self.kind, [self.kind])
        return builder.call(builder.module.declare_intrinsic(name, (), kind), [x])

    def each(self, builder: Any, args: Sequence[Any], call: Callable[[list[Any]], Any]) -> Any:
        """A function of plain numbers, applied in every lane."""
        if self.lanes == 1:
            return call(list(args))
        result: Any = ir.Constant(self.kind, ir.Undefined)
        for lane in range(self.lanes):
            own = [builder.extract_element(arg, INT(lane)) for arg in args]
            result = builder.insert_element(result, call(own), INT(lane))
        return result

    def transposed(self, builder: Any, rows: list[Any]) -> list[Any]:
        """The square of vectors transposed, by blocks that double in size at each pass."""
        size = 1
        while size < self.lanes:
            low = [n for n in range(self.lanes) if not n & size]
            first = [n if not n & size else self.lanes + n - size for n in range(self.lanes)]
            second = [n + size if not n & size else self.lanes + n for n in range(self.lanes)]
            for n in low:
                a, b = rows[n], rows[n + size]
                rows[n], rows[n + size] = (
                    self.shuffle(builder, a, b, first),
                    self.shuffle(builder, a, b, second),
                )
            size *= 2
        return rows
