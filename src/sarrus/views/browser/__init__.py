"""Models and runs as one web page that works offline, with its data, script, style and library."""

from .page import Page, Shown, write_page

__all__ = ["Page", "Shown", "write_page"]
