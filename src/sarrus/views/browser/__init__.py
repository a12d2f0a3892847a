"""Models and runs as one web page that needs no network."""

from .page import Page
from .scene import Shown, write_page

__all__ = ["Page", "Shown", "write_page"]
