"""A page taken apart again, as its script does."""

from __future__ import annotations

import base64
import gzip
import json
import re
from pathlib import Path
from typing import Any

import numpy as np


class PageParts:
    """The words of a page, and the arrays that they point to."""

    def __init__(self, html: str) -> None:
        self.html = html
        self.told: Any = json.loads(_script(html, "scene"))
        self.numbers = gzip.decompress(base64.b64decode(_script(html, "numbers")))

    def array(self, place: list[int], columns: int = 3) -> Any:
        first, count = place
        return np.frombuffer(self.numbers, "<f4", count, first).reshape(-1, columns)


def read(path: Path) -> PageParts:
    return PageParts(path.read_text(encoding="utf-8"))


def _script(html: str, name: str) -> str:
    found = re.search(rf'<script type="[^"]*" id="{name}">(.*?)</script>', html, re.DOTALL)
    assert found is not None
    return found[1]
