"""What a release consists of agrees: version, changelog, citation, tag, workflows, the documentation's build."""

import os
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

import sarrus

ROOT = Path(__file__).parent.parent
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
GITHUB = ROOT / ".github"
in_a_clone = pytest.mark.skipif(not GITHUB.exists(), reason="the source distribution has no workflows")


def opened(path: Path) -> Any:
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def test_version_is_written_once() -> None:
    assert "version" not in PYPROJECT["project"]
    assert "version" in PYPROJECT["project"]["dynamic"]
    assert PYPROJECT["tool"]["hatch"]["version"]["path"] == "src/sarrus/__init__.py"


def test_changelog_and_citation_have_the_version() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    released = re.findall(r"^## \[(\d+\.\d+\.\d+)\] - (\d{4}-\d\d-\d\d)$", changelog, re.MULTILINE)
    citation = opened(ROOT / "CITATION.cff")
    assert released[0] == (sarrus.__version__, str(citation["date-released"]))
    assert citation["version"] == sarrus.__version__
    assert citation["title"].startswith("Sarrus")


def test_each_version_of_the_changelog_has_each_kind_of_change_once() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    for version in re.split(r"^## ", changelog, flags=re.MULTILINE)[1:]:
        kinds = re.findall(r"^### (.*)$", version, re.MULTILINE)
        assert len({*kinds}) == len(kinds), version.partition("\n")[0]


@pytest.mark.skipif(os.environ.get("GITHUB_REF_TYPE") != "tag", reason="no tag is built")
def test_tag_is_the_version() -> None:
    assert os.environ["GITHUB_REF_NAME"] == f"v{sarrus.__version__}"


@in_a_clone
def test_wheels_are_built_and_tested_for_every_python_and_system() -> None:
    prefix = "Programming Language :: Python :: 3."
    supported = [name.removeprefix(prefix) for name in PYPROJECT["project"]["classifiers"] if prefix in name]
    release = opened(GITHUB / "workflows" / "release.yml")["jobs"]
    matrix = release["kernels"]["strategy"]["matrix"]
    assert matrix["python"] == [f"cp3{minor}" for minor in supported]
    assert {one["python"]: one["version"] for one in matrix["include"]} == {
        f"cp3{minor}": f"3.{minor}" for minor in supported
    }
    assert {name.partition("-")[0] for name in matrix["os"]} == {"ubuntu", "macos", "windows"}
    commands = [step.get("run", "") for step in release["kernels"]["steps"]]
    assert any("tests/test_wheel.py" in command for command in commands)
    assert release["publish"]["permissions"] == {"id-token": "write"}
    changes = opened(GITHUB / "workflows" / "ci.yml")["jobs"]["run"]["strategy"]["matrix"]
    assert changes["python"] == [f"3.{minor}" for minor in supported]


@in_a_clone
def test_every_commit_has_its_part_of_the_slow_tests() -> None:
    """`.ci/run` counts commits, and of a clone of the newest one alone it counts one."""
    assert "git rev-list --count HEAD" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    checkout, *_ = opened(GITHUB / "workflows" / "ci.yml")["jobs"]["run"]["steps"]
    assert checkout["with"]["fetch-depth"] == 0


@in_a_clone
def test_documentation_is_built_as_here() -> None:
    build = opened(ROOT / ".readthedocs.yaml")
    assert build["sphinx"] == {"configuration": "docs/conf.py", "fail_on_warning": True}
    (install,) = build["python"]["install"]
    assert {*install["extra_requirements"]} <= {*PYPROJECT["project"]["optional-dependencies"]}


@in_a_clone
def test_a_report_of_a_bug_has_model_and_version() -> None:
    fields = {one["id"]: one for one in opened(GITHUB / "ISSUE_TEMPLATE" / "bug.yml")["body"]}
    assert all(fields[name]["validations"]["required"] for name in ("what", "model", "version"))
    program = re.search(r'python -c "(.*?)"`', fields["version"]["attributes"]["description"])
    assert program
    exec(program[1], {})


@in_a_clone
def test_metadata_have_the_addresses_of_the_repository(monkeypatch: pytest.MonkeyPatch) -> None:
    core = pytest.importorskip("hatchling.metadata.core")
    manager = pytest.importorskip("hatchling.plugin.manager")
    monkeypatch.setenv("GITHUB_SERVER_URL", "https://github.com")
    monkeypatch.setenv("GITHUB_REPOSITORY", "someone/sarrus")
    found = core.ProjectMetadata(str(ROOT), manager.PluginManager()).core.urls
    assert found["Source"] == "https://github.com/someone/sarrus"
    for name, folder in {"Changelog": "CHANGELOG.md", "Documentation": "docs/index.md"}.items():
        place = found[name].removeprefix(f"https://github.com/someone/sarrus/blob/v{sarrus.__version__}/")
        assert place == folder
        assert (ROOT / place).exists()
    assert found["Issues"] == "https://github.com/someone/sarrus/issues"


@pytest.mark.parametrize(
    ("remote", "page"),
    [
        ("git@github.com:someone/sarrus.git", "https://github.com/someone/sarrus"),
        ("ssh://git@github.com/someone/sarrus", "https://github.com/someone/sarrus"),
        (
            "https://token:secret@gitlab.example.org/group/sarrus.git",
            "https://gitlab.example.org/group/sarrus",
        ),
        ("https://github.com/someone/sarrus/", "https://github.com/someone/sarrus"),
        ("/home/someone/sarrus", ""),
        ("", ""),
    ],
)
def test_page_of_a_remote_repository(remote: str, page: str) -> None:
    """Without the secrets that an address may contain."""
    urls = pytest.importorskip("distribution.urls", exc_type=ImportError)
    assert urls.page(remote) == page
