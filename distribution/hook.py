"""Build hook of the wheel: with ``SARRUS_KERNELS=FOLDER`` it holds compiled kernels, and fits one Python and platform.

FOLDER is what `python -m distribution.kernels FOLDER` has filled. Without it the wheel is pure Python, for all.
"""

from __future__ import annotations

import os
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

MANYLINUX = (
    "manylinux_2_28"  # kernels call the C library by names that it has had for long; Numba asks for 2.27
)


class KernelsHook(BuildHookInterface):  # type: ignore[type-arg]
    """Puts kernels into the wheel."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the folder of kernels, and name what the wheel fits."""
        given = os.environ.get("SARRUS_KERNELS")
        if not given or version == "editable":
            return
        folder = Path(self.root, given)
        if not list(folder.glob("*/index.json")):
            raise FileNotFoundError(
                f"SARRUS_KERNELS: {folder} has no kernels. Fill it with distribution.kernels."
            )
        build_data["pure_python"] = False
        build_data["tag"] = f"{_python()}-{_python()}-{_platform()}"
        build_data["force_include"][str(folder)] = "sarrus/_kernels"


def _python() -> str:
    return f"cp{sys.version_info.major}{sys.version_info.minor}"


def _platform() -> str:
    """The platform's tag. On macOS it is the version that this Python was made for."""
    name = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    return name.replace("linux", MANYLINUX, 1) if name.startswith("linux_") else name
