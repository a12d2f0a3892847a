"""Reader of pickles that hold data only: models, dataclasses and tuples of Sarrus, arrays and containers."""

from __future__ import annotations

import dataclasses
import io
import pickle
from typing import Any, ClassVar

from ...model.expression.tree import Function

ARRAYS = {
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
}
FORMULAS = {  # how formulas and the elements made of them are pickled: by names and structures, no code
    ("sarrus.model.expression.tree", "function_named"),
    ("sarrus.model.forces.formula_element", "_element_class"),
}
CONTAINERS = {"set", "frozenset", "slice", "range", "complex", "bytearray"}

UNPICKLER: Any = vars(pickle)["_Unpickler"]  # written in Python, so that every step of it can be refused


class CodeInPickleError(Exception):
    """A pickle names what is no data, such as a function."""


class _DataUnpickler(UNPICKLER):  # type: ignore[misc]
    """Builds only what cannot run code: see "Restricting Globals" of Python's documentation of pickle."""

    dispatch: ClassVar[dict[int, Any]] = dict(UNPICKLER.dispatch)

    def find_class(self, module: str, name: str) -> Any:
        known = (module, name) in ARRAYS | FORMULAS or (module == "builtins" and name in CONTAINERS)
        inside = module.startswith("sarrus.") and module != "sarrus.__main__" and "." not in name
        if not known and not inside:
            raise CodeInPickleError(f"{module}.{name}")
        found = super().find_class(module, name)
        if known or (isinstance(found, type) and found.__module__ == module and _holds_data(found)):
            return found
        raise CodeInPickleError(f"{module}.{name}")

    def load_build(self) -> None:
        """Give a state to what the pickle has made, never to a class or function, which everybody shares."""
        if isinstance(self.stack[-2], type | Function):
            raise CodeInPickleError(f"another {self.stack[-2]}")
        super().load_build()

    dispatch[pickle.BUILD[0]] = load_build


def _holds_data(kind: type) -> bool:
    described = kind.__module__.startswith(("sarrus.model.", "sarrus.elements."))  # as a model file can
    return (
        described or dataclasses.is_dataclass(kind) or (issubclass(kind, tuple) and hasattr(kind, "_fields"))
    )


def loads(content: bytes, trusted: bool = False) -> Any:
    """Return the object of a pickle.

    Parameters
    ----------
    trusted : whether it may name classes and functions of other modules, which can run any code

    Raises
    ------
    CodeInPickleError
        If it is not trusted and names what is no data.
    """
    return pickle.loads(content) if trusted else _DataUnpickler(io.BytesIO(content)).load()
