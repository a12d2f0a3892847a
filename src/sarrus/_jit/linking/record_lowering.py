"""From Numba's typed functions to LLVM's code, with records of arrays taken apart at once.

Numba keeps a tuple in memory, and reads and writes all of it at each use. A record of some hundred arrays has some
thousand parts, which LLVM then takes apart again, at great cost. Here a record that is assigned once is a value; what
is taken from it is what was put into it; and what nobody uses of it is not written.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

from llvmlite.ir import Function, IRBuilder
from llvmlite.ir import instructions as llvm
from numba.core import ir, types
from numba.core.lowering import Lower

PURE = (llvm.InsertValue, llvm.ExtractValue, llvm.LoadInstr, llvm.GEPInstr, llvm.CastInstr)


class FoldingBuilder(IRBuilder):  # type: ignore[misc]
    """Takes parts from where they were put into a tuple or structure."""

    def extract_value(self, agg: Any, idx: Any, name: str = "") -> Any:
        """A part, without an instruction if it was put in before."""
        wanted, whole = list(idx) if isinstance(idx, (tuple, list)) else [idx], agg
        while isinstance(whole, llvm.InsertValue):
            put = list(whole.indices)
            if put == wanted[: len(put)]:
                rest = wanted[len(put) :]
                return self.extract_value(whole.value, rest, name) if rest else whole.value
            if put[: len(wanted)] == wanted:
                break
            whole = whole.aggregate
        return super().extract_value(whole, wanted, name)


class RecordLowering(Lower):
    """Numba's lowering, in which records that are assigned once are values."""

    def setup_function(self, fndesc: Any) -> None:
        super().setup_function(fndesc)  # type: ignore[no-untyped-call]
        self.builder.__class__ = FoldingBuilder

    def pre_lower(self) -> None:
        super().pre_lower()  # type: ignore[no-untyped-call]
        self._records: dict[str, Any] = {}
        self._names = self._assigned_once()

    def lower_normal_function(self, fndesc: Any) -> None:
        super().lower_normal_function(fndesc)  # type: ignore[no-untyped-call]
        leave_out_unused(self.function)

    def lower_assign(self, ty: Any, inst: Any) -> Any:
        if inst.target.name in self._names and isinstance(inst.value, ir.Arg):
            return self.fnargs[inst.value.index]  # the caller holds its references
        return super().lower_assign(ty, inst)  # type: ignore[no-untyped-call]

    def loadvar(self, name: str) -> Any:
        return self._records[name] if name in self._records else super().loadvar(name)  # type: ignore[no-untyped-call]

    def storevar(self, value: Any, name: str, argidx: Any = None) -> None:
        if name in self._names:
            self._records[name] = value
        else:
            super().storevar(value, name, argidx)  # type: ignore[no-untyped-call]

    def delvar(self, name: str) -> None:
        if name not in self._names:
            super().delvar(name)  # type: ignore[no-untyped-call]

    def _alloca_var(self, name: str, fetype: Any) -> None:
        if name not in self._names:
            super()._alloca_var(name, fetype)  # type: ignore[no-untyped-call]

    def _assigned_once(self) -> set[str]:
        """Records with one assignment, which Numba makes come before all uses.

        Arguments are held by the caller; others are among them only where no references are counted.
        """
        made = [one for block in self.blocks.values() for one in block.find_insts(ir.Assign)]
        counts, kinds = Counter(one.target.name for one in made), self.fndesc.typemap
        found = set()
        for one in made:
            name = one.target.name
            if counts[name] == 1 and isinstance(kinds[name], types.BaseTuple):
                argument = isinstance(one.value, ir.Arg) and kinds[name] == kinds[f"arg.{one.value.name}"]
                if argument or not self.context.enable_nrt:
                    found.add(name)
        return found


def leave_out_unused(function: Function) -> None:
    """Remove instructions without effect whose values nobody uses."""
    uses = Counter(
        id(value) for block in function.blocks for one in block.instructions for value in _values(one)
    )
    for block in reversed(function.blocks):
        needed = []
        for one in reversed(block.instructions):
            if isinstance(one, PURE) and not uses[id(one)]:
                uses.subtract(map(id, _values(one)))
            else:
                needed.append(one)
        block.instructions[:] = needed[::-1]


def _values(instruction: Any) -> list[Any]:
    found = list(instruction.operands)
    if isinstance(instruction, llvm.PhiInstr):
        found += [value for value, _ in instruction.incomings]
    return found
