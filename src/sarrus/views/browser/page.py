"""One self-contained web page: saved, opened in the browser, or shown in a notebook."""

from __future__ import annotations

import html
import sys
import tempfile
import webbrowser
from dataclasses import dataclass, field
from pathlib import Path

from ...results.saving.exported_file import exports

HEIGHT = 520  # [px] in a notebook


@dataclass(frozen=True)
class Page:
    """A web page as text. Notebooks show it; `open` shows it in the browser, `save` writes it."""

    title: str
    html: str = field(repr=False)

    @exports
    def save(self, path: str | Path) -> Path:
        """Write the page to a file, and return its path."""
        Path(path).write_text(self.html, encoding="utf-8")
        return Path(path)

    def open(self) -> Path:
        """Write the page to a temporary file, open it in the browser, and return its path."""
        stem = "".join(c if c.isalnum() else "-" for c in self.title)[:40]
        path = self.save(Path(tempfile.mkdtemp(prefix="sarrus-")) / f"{stem}.html")
        webbrowser.open(path.as_uri())
        return path

    def _repr_html_(self) -> str:
        style = f"width:100%;height:{HEIGHT}px;border:1px solid #d7dde3;border-radius:8px"
        page = html.escape(self.html, quote=True)
        return f'<iframe srcdoc="{page}" sandbox="allow-scripts allow-downloads" style="{style}"></iframe>'


def in_notebook() -> bool:
    """Whether this is a notebook, which shows the last value of a cell by itself."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel")
