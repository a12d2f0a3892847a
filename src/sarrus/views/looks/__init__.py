"""The look of a model's parts, from their joints and points alone, or as given: meshes that move with its bodies.

Pages, pictures and GLB files draw what is returned here; nothing here knows a run or a file format of pictures.
"""

from .part import Part, Span, body_frame, place_of
from .sketch import Sketch, sketch

__all__ = ["Part", "Sketch", "Span", "body_frame", "place_of", "sketch"]
