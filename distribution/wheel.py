"""Build a wheel with compiled kernels for this Python and this machine's kind: `python -m distribution.wheel`.

Arguments are those of `distribution.kernels`, without its folder. The wheel is written to `dist/`.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def build_wheel(kernels: Path, output: Path) -> Path:
    """Build a wheel with the kernels of a folder; return the file."""
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(output), str(ROOT)]
    before = set(output.glob("*.whl"))
    subprocess.run(command, env=os.environ | {"SARRUS_KERNELS": str(kernels)}, check=True)
    return max(
        set(output.glob("*.whl")) - before or output.glob("*.whl"), key=lambda file: file.stat().st_mtime
    )


def main(arguments: list[str]) -> int:
    """Compile the kernels, and build the wheel."""
    with tempfile.TemporaryDirectory(prefix="sarrus-wheel-") as place:
        kernels = Path(place) / "kernels"
        made = subprocess.run(
            [sys.executable, "-m", "distribution.kernels", str(kernels), *arguments], cwd=ROOT
        )
        if made.returncode:
            return made.returncode
        wheel = build_wheel(kernels, ROOT / "dist")
    print(f"{wheel}: {wheel.stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
