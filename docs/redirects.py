"""Pages at earlier addresses, which lead to the present ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

MOVED = {"faq": "troubleshooting", "compare": "comparison"}
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Moved</title>
<link rel="canonical" href="{new}.html"><meta http-equiv="refresh" content="0; url={new}.html"></head>
<body><p>This page has moved to <a href="{new}.html">{new}</a>.</p></body></html>
"""


def write(app: Any, error: Exception | None) -> None:
    """Write one page for each earlier address after the others."""
    if error is None and app.builder.format == "html":
        for old, new in MOVED.items():
            Path(app.outdir, f"{old}.html").write_text(PAGE.format(new=new), encoding="utf-8")


def setup(app: Any) -> dict[str, bool]:
    app.connect("build-finished", write)
    return {"parallel_read_safe": True}
