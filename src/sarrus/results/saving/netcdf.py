"""A file in the classic NetCDF format, which xarray, MATLAB and many others read: named arrays with units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ...algebra import Array

Attributes: TypeAlias = Mapping[str, str | float | Array]


class Column(NamedTuple):
    """An array with the names of its dimensions and attributes such as ``units`` and ``long_name``."""

    dimensions: tuple[str, ...]
    values: Array
    attributes: Attributes = MappingProxyType({})


def write_netcdf(path: str | Path, columns: Mapping[str, Column], attributes: Attributes) -> None:
    """Write arrays and attributes of the whole; dimensions of one name have one length."""
    from scipy.io import netcdf_file

    with netcdf_file(str(path), "w", version=2) as file:
        for name, value in attributes.items():
            setattr(file, name, _encoded(value))
        for name, column in columns.items():
            values = np.asarray(column.values)
            for dimension, length in zip(column.dimensions, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.createDimension(dimension, length)
            kind = "f8" if values.dtype.kind == "f" else "i4"
            variable = file.createVariable(name, kind, column.dimensions)
            variable[:] = values.astype(kind)
            for key, value in column.attributes.items():
                setattr(variable, key, _encoded(value))


def _encoded(value: Any) -> Any:
    """Words in UTF-8, which the format's readers expect."""
    return value.encode() if isinstance(value, str) else value


def flags(names: Sequence[str], chosen: Sequence[str], dimension: str) -> Column:
    """Names as numbers, explained by attributes as the CF conventions have it; blanks become underscores."""
    attributes: Attributes = {
        "flag_values": np.arange(len(names), dtype=np.int32),
        "flag_meanings": " ".join(name.replace(" ", "_") for name in names),
    }
    return Column((dimension,), np.array([names.index(one) for one in chosen], dtype=np.int32), attributes)
