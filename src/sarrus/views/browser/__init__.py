"""Models and runs as one web page that works offline, with its data, script, style and library."""

from .page import Page, Scene, write_page

__all__ = ["Page", "Scene", "write_page"]
