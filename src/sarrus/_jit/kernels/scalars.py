"""Named scalars of compiled loops: numbers that Python and compiled code read and write in the same memory."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, Any, Self, get_type_hints

import numpy as np
from numpy.typing import NDArray

KINDS: dict[type, Any] = {float: np.float64, int: np.int64, bool: np.bool_}
Values = NDArray[np.float64]

if TYPE_CHECKING:  # NumPy's annotations do not allow a subclass of its records, which NumPy does

    class Record:
        """The part of `numpy.record` that is used."""

        dtype: np.dtype[np.void]

        def copy(self) -> Self:
            """A copy of the record in memory of its own."""
            ...

else:
    Record = np.record


class Scalars(Record):
    """Scalars with names: a subclass annotates each with ``float``, ``int`` or ``bool``.

    A compiled function takes one as an argument and reads and writes its fields, as in ``control.h = 0.5 * control.h``.
    """

    def __init_subclass__(cls) -> None:
        for name in cls.__annotations__:
            if hasattr(np.record, name):
                raise TypeError(
                    f"{cls.__name__}: {name} is a name of NumPy's records. Name the scalar otherwise."
                )

    @classmethod
    def zeros(cls) -> Self:
        """All zero."""
        made: Self = np.zeros(1, _dtype_of(cls))[0]  # type: ignore[arg-type]
        return made

    @classmethod
    def of(cls, *values: float) -> Self:
        """A record of these values, in the order of the fields."""
        made = cls.zeros()
        made.assign(values)
        return made

    def as_array(self) -> Values:
        """All as floats, in the order of the fields."""
        return np.array([getattr(self, name) for name in self.dtype.names or ()], dtype=float)

    def assign(self, values: Iterable[float]) -> None:
        """Set all, in the order of the fields."""
        for name, value in zip(self.dtype.names or (), values, strict=True):
            setattr(self, name, value)

    def clear(self) -> None:
        """Set all to zero."""
        self.assign(np.zeros(len(self.dtype.names or ())))


@cache  # Numba looks up the type of an argument by the identity of its dtype
def _dtype_of(kind: type[Scalars]) -> np.dtype[Any]:
    fields = [(name, KINDS[own]) for name, own in get_type_hints(kind).items()]
    return np.dtype((kind, np.dtype(fields, align=True)))
