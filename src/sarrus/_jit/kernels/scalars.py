"""Named scalars of compiled loops: numbers that Python and compiled code read and write in the same memory."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Self, get_type_hints

import numpy as np
from numpy.typing import NDArray

KINDS: dict[type, Any] = {float: np.float64, int: np.int64, bool: np.bool_}

if TYPE_CHECKING:  # NumPy's annotations do not allow a subclass of its structured scalars, which NumPy does

    class Void:
        """The part of `numpy.void` that is used."""

        dtype: np.dtype[np.void]

        def __setitem__(self, name: str, value: Any) -> None: ...

        def copy(self) -> Self:
            """A copy of the record in memory of its own."""
            ...

else:
    Void = np.void


class Scalars(Void):
    """Scalars with names: a subclass annotates each with ``float``, ``int`` or ``bool``.

    A compiled function takes one as an argument and reads and writes its fields, as in ``control.h = 0.5 * control.h``.
    """

    def __init_subclass__(cls) -> None:
        for name in cls.__annotations__:
            if hasattr(np.void, name):
                raise TypeError(
                    f"{cls.__name__}: {name} is a name of NumPy's records. Name the scalar otherwise."
                )
            setattr(cls, name, _field(name))

    @classmethod
    def zeros(cls) -> Self:
        """All zero."""
        made: Self = np.zeros(1, _dtype_of(cls))[0]  # type: ignore[arg-type]
        return made

    def as_array(self) -> NDArray[np.float64]:
        """All as floats, in the order of the fields."""
        return np.array([getattr(self, name) for name in self.dtype.names or ()], dtype=float)

    def assign(self, values: Iterable[float]) -> None:
        """Set all, in the order of the fields."""
        for name, value in zip(self.dtype.names or (), values, strict=True):
            self[name] = value

    def clear(self) -> None:
        """Set all to zero."""
        self.assign(np.zeros(len(self.dtype.names or ())))


def _field(name: str) -> property:
    """The access from Python to a scalar, without the search for attributes that `numpy.record` makes."""

    def write(scalars: Scalars, value: float) -> None:
        scalars[name] = value

    return property(itemgetter(name), write)


@cache  # Numba looks up the type of an argument by the identity of its dtype
def _dtype_of(kind: type[Scalars]) -> np.dtype[Any]:
    fields = [(name, KINDS[own]) for name, own in get_type_hints(kind).items()]
    return np.dtype((kind, np.dtype(fields, align=True)))
