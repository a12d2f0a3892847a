"""What the parts of a model look like, from their joints and points alone, or as they are given."""

from .part import Part, Span
from .sketch import Sketch, sketch

__all__ = ["Part", "Sketch", "Span", "sketch"]
