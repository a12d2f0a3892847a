"""The Python in the README runs as it stands, where the folder `src` is as it is in a clone."""

import re
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
BLOCKS = re.findall(
    r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
)


@pytest.mark.parametrize("block", BLOCKS)
def test_readme(block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mechanisms = Path("src/sarrus/mechanisms")
    shutil.copytree(ROOT / mechanisms, tmp_path / mechanisms)
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "README.md", "exec"), {"__name__": "__main__"})


def test_readme_has_an_example() -> None:
    assert BLOCKS
