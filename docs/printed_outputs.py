"""The printed outputs of pages: what their code prints while the documentation is built.

A page's code is run as the tests run it, each page in a process and an empty folder of its own. A page whose text is
not what its code prints is a warning.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import tempfile
import webbrowser
from pathlib import Path
from typing import Any

from sphinx.util import logging

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))  # for tests.pages

from tests.pages import executed, has_code  # noqa: E402


def run(page: Path) -> str:
    """Return the text of a page with what its code prints; called in a process of its own."""
    os.environ["MPLBACKEND"] = "agg"
    webbrowser.open = lambda *_, **__: True
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        text, _ = executed(page)
        os.chdir(ROOT)
    return text


def start(app: Any, env: Any, names: list[str]) -> None:
    """Start to run the pages that will be read."""
    pages = {name: Path(env.doc2path(name)) for name in names}
    pool = multiprocessing.get_context("spawn").Pool(os.cpu_count(), maxtasksperchild=1)
    app.printed = {name: pool.apply_async(run, (page,)) for name, page in pages.items() if has_code(page)}
    pool.close()


def put(app: Any, name: str, source: list[str]) -> None:
    """Replace a page's text by that with its outputs."""
    if name in app.printed:
        try:
            source[0] = app.printed[name].get()
        except Exception as error:
            logging.getLogger(__name__).warning("%s: its code does not print this: %s", name, error)


def setup(app: Any) -> dict[str, bool]:
    app.connect("env-before-read-docs", start)
    app.connect("source-read", put)
    return {"parallel_read_safe": False}
