"""Addresses in the metadata of a release: those of the repository that it is built from, wherever that is.

A workflow knows its repository by ``GITHUB_SERVER_URL`` and ``GITHUB_REPOSITORY``, a clone by its remote ``origin``. A
build from a source distribution knows none, and names none.
"""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface


class UrlsHook(MetadataHookInterface):
    """Writes ``urls``."""

    PLUGIN_NAME = "custom"

    def update(self, metadata: dict[str, Any]) -> None:
        """Add the addresses."""
        metadata["urls"] = urls(repository(Path(self.root)), str(metadata["version"]))


def urls(home: str, version: str) -> dict[str, str]:
    """Addresses of a version by name; none without a repository."""
    if not home:
        return {}
    files = f"{home}/blob/v{version}"
    return {
        "Source": home,
        "Documentation": f"{files}/docs/index.md",
        "Changelog": f"{files}/CHANGELOG.md",
        "Issues": f"{home}/issues",
    }


def repository(root: Path) -> str:
    """The address of the repository, or an empty text."""
    server, name = (os.environ.get(f"GITHUB_{key}", "") for key in ("SERVER_URL", "REPOSITORY"))
    if server and name:
        return f"{server}/{name}"
    if not (root / ".git").exists():  # git would find a repository above
        return ""
    try:
        asked = ["git", "config", "--get", "remote.origin.url"]
        remote = subprocess.run(asked, cwd=root, capture_output=True, text=True, check=False).stdout.strip()
    except OSError:  # there is no git
        return ""
    return page(remote)


def page(remote: str) -> str:
    """The page of a remote repository, by SSH or HTTPS; an empty text for a folder."""
    found = re.fullmatch(
        r"(?:ssh://git@|git@|https://(?:[^@/]*@)?)([\w.-]+)[:/](.+?)(?:\.git)?/?", remote, re.ASCII
    )
    return f"https://{found[1]}/{found[2]}" if found else ""
