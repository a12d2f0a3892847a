"""Refuse retired phrases in the documentation and in the sources.

    python -m tests.language      # exit code 1 if a retired phrase is found

A phrase is retired where the field has a standard term for it; see docs/glossary.md. Only phrases that are never right
are listed: a search cannot know the meaning of a word.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CLEAN = ("README.md", "CONTRIBUTING.md", "docs", "src")
RETIRED = {
    r"numbers of (?:the|a) model|model's numbers|design numbers": "parameters",
    r"ways of assembly": "assembly modes",
    r"singular positions?": "singular configurations",
    r"dependent rows": "redundant constraints",
    r"as the tolerances ask": "to meet the tolerances",
}


def retired(text: str) -> Iterator[tuple[int, str, str]]:
    """Line number, phrase and standard term of every retired phrase."""
    for number, line in enumerate(text.splitlines(), start=1):
        for phrase, term in RETIRED.items():
            if hit := re.search(rf"\b(?:{phrase})\b", line.lower()):
                yield number, hit.group(), term


def main() -> int:
    paths = [
        file for name in CLEAN for file in ((ROOT / name).rglob("*") if "." not in name else [ROOT / name])
    ]
    found = [
        f'{path.relative_to(ROOT)}:{number}: "{phrase}" is retired. Write: {term}.'
        for path in sorted(paths)
        if path.suffix in {".md", ".py"} and not {"_build", "api"} & set(path.parts)
        for number, phrase, term in retired(path.read_text(encoding="utf-8"))
    ]
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
