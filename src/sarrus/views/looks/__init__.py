"""The look of a model's parts, from their joints and points alone, or as given."""

from .part import Part, Span
from .sketch import Sketch, sketch

__all__ = ["Part", "Sketch", "Span", "sketch"]
