"""Finite differences over compiled operators, compiled themselves: what exact derivatives are measured against."""

from __future__ import annotations

from typing import Any

from .driver import Signature, compiled


def differences(signature: Signature, driver: Any, vary: str) -> Any:
    """Forward differences of all outputs of a driver by the entries of the operand `vary`.

    Returns
    -------
    compiled function ``(h, index, numbers, *scalars, *arrays, *bases, *outputs, *columns)``
        It writes the transposed derivative of each output into its ``columns`` (one row per entry varied).
    """
    outputs = signature.outputs
    operands = [*signature.scalars, *signature.arrays]
    bases, columns = [f"base_{o}" for o in outputs], [f"columns_{o}" for o in outputs]
    name = f"differences_{vary}_{signature.name}"
    lines = [
        f"def {name}(h, index, numbers, {', '.join([*operands, *bases, *outputs, *columns])}):",
        f"    driver(index, numbers, {', '.join([*operands, *bases])})",
        f"    for k in range(len({vary})):",
        f"        kept = {vary}[k]",
        f"        {vary}[k] = kept + h",
        f"        driver(index, numbers, {', '.join([*operands, *outputs])})",
        f"        {vary}[k] = kept",
    ]
    for out, base, column in zip(outputs, bases, columns, strict=True):
        lines += [f"        for r in range(len({out})):", f"            {column}[k, r] = ({out}[r] - {base}[r]) / h"]
    return compiled(name, lines, {"driver": driver})


def repeated(function: Any, name: str, arguments: int) -> Any:
    """A compiled loop that calls a compiled function n times: ``(n, *arguments)``; for timing without Python."""
    parameters = ", ".join(f"a{k}" for k in range(arguments))
    lines = [f"def repeat_{name}(n, {parameters}):", "    for _ in range(n):", f"        function({parameters})"]
    return compiled(f"repeat_{name}", lines, {"function": function})
