"""The parts of joints and forces: an element's class, names of bodies, plain values."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..elements import Element


class Primitive(NamedTuple):
    """One element of the equations of motion, before bodies have numbers.

    ``element`` is a class of ``sarrus.elements`` or of one's own; ``values`` follow its declared
    fields; ``label`` distinguishes the primitives of one joint, as in ``pin: f_i.h_j``.
    """

    element: type[Element]
    bodies: tuple[str, ...]
    values: tuple[Any, ...]
    label: str
