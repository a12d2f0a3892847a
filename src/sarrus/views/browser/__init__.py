"""Models and runs as one web page that needs no network: its data, and the script, style and library beside it."""

from .page import Page, Shown, write_page

__all__ = ["Page", "Shown", "write_page"]
