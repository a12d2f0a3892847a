"""Finite differences over compiled operators, compiled themselves: what exact derivatives are measured against."""

from __future__ import annotations

from typing import Any

from .driver import Signature, compile_source

SCHEMES = ("forward", "central")


def differences(signature: Signature, driver: Any, vary: str, scheme: str) -> Any:
    """Finite differences of all outputs of a driver by the entries of the operand `vary`.

    Returns
    -------
    compiled function ``(h, index, numbers, *scalars, *arrays, *ahead, *behind, *columns)``
        It writes the transposed derivative of each output into its ``columns`` (one row per entry varied); `ahead` and
        `behind` are work space, one array per output each.
    """
    outputs = signature.outputs
    operands = ", ".join([*signature.scalars, *signature.arrays])
    ahead, behind, columns = ([f"{kind}_{out}" for out in outputs] for kind in ("ahead", "behind", "columns"))
    evaluate_behind = f"driver(index, numbers, {operands}, {', '.join(behind)})"
    central = scheme == "central"
    lines = [
        f"def differences(h, index, numbers, {operands}, {', '.join([*ahead, *behind, *columns])}):",
        f"    factor = {0.5 if central else 1.0} / h",
        *([] if central else [f"    {evaluate_behind}"]),
        f"    for k in range(len({vary})):",
        f"        value = {vary}[k]",
        f"        {vary}[k] = value + h",
        f"        driver(index, numbers, {operands}, {', '.join(ahead)})",
        *([f"        {vary}[k] = value - h", f"        {evaluate_behind}"] if central else []),
        f"        {vary}[k] = value",
    ]
    for front, back, column in zip(ahead, behind, columns, strict=True):
        lines.append(f"        for r in range(len({front})):")
        lines.append(f"            {column}[k, r] = ({front}[r] - {back}[r]) * factor")
    return compile_source(f"{scheme}_{vary}_{signature.name}", lines, {"driver": driver})


def repeated(function: Any, name: str, arguments: int) -> Any:
    """A compiled loop that calls a compiled function n times: ``(n, *arguments)``; for timing without Python."""
    parameters = ", ".join(f"a{k}" for k in range(arguments))
    lines = [f"def repeat(n, {parameters}):", "    for _ in range(n):", f"        function({parameters})"]
    return compile_source(f"repeat_{name}", lines, {"function": function})
