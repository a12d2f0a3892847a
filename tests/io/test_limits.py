"""What is large loads in seconds; what is larger than any model is refused at once, in a message."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from tests.patience import within

import sarrus as sr
from sarrus.io.robot.description import legal
from sarrus.model.file import include

HEAD = "name: large\nbodies:\n  a: {mass: 1, inertia: [1, 1, 1]}\n"
JOINT = "joints:\n  s: {type: revolute, bodies: [ground, a], point: [0, 0, 0], axis: [0, 0, 1]}\n"
REFUSED, LOADED = 2.0, 12.0  # seconds of processor time


def table(count: int) -> str:
    pairs = ", ".join(f"[{k}, 1]" for k in range(count))
    return HEAD + JOINT + f"drivers:\n  d: {{type: angle, joint: s, motion: {{table: [{pairs}]}}}}\n"


def bodies(count: int, mass: str = "mass: 1") -> str:
    return "name: large\nbodies:\n" + "".join(
        f"  b{k}: {{{mass}, inertia: [1, 1, 1]}}\n" for k in range(count)
    )


LARGE: dict[str, Callable[[], str]] = {
    "200,000 numbers": lambda: table(100_000),
    "20,000 bodies": lambda: bodies(20_000),
    "100,000 keys": lambda: HEAD + "parameters:\n" + "".join(f"  p{k}: 1\n" for k in range(100_000)),
    "20,000 formulas": lambda: HEAD + "parameters:\n" + "".join(f"  p{k}: 2*{k}\n" for k in range(20_000)),
    "comments": lambda: HEAD + ("# " + "x" * 98 + "\n") * 150_000,
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", LARGE)
def test_large_files_load_in_seconds(name: str, tmp_path: Path) -> None:
    (tmp_path / "large.yaml").write_text(LARGE[name]())
    with within(LOADED):
        assert sr.load(tmp_path / "large.yaml").bodies


def test_large_texts_are_read_by_the_reader_in_c(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The one in Python takes some 25 µs for each entry, on top of all else."""
    used, parse = list[Any](), yaml.parse

    def note(text: str, Loader: Any) -> Any:
        used.append(Loader)
        return parse(text, Loader=Loader)

    monkeypatch.setattr(yaml, "parse", note)
    (tmp_path / "large.yaml").write_text(table(12_000))
    assert sr.load(tmp_path / "large.yaml").bodies
    assert used == [getattr(yaml, "CSafeLoader", yaml.SafeLoader)]


WRONG: dict[str, tuple[Callable[[], str], str]] = {
    "numbers": (lambda: HEAD + "gravity: [" + "1," * 1_500_000 + "1]", "more than 1,000,000 entries"),
    "lines": (lambda: HEAD + "parameters:\n" + " p: 1\n" * 1_500_000, "more than 1,000,000 entries"),
    "names": (lambda: bodies(5_000, "mass: 2*q"), "uses the unknown name"),
    "points": (
        lambda: (
            HEAD
            + "points:\n"
            + "".join(f"  P{k}: [{k}, 0, 0]\n" for k in range(3_000))
            + "joints:\n"
            + "".join(
                f"  j{k}: {{type: spherical, bodies: [ground, a], point: Q{k}}}\n" for k in range(3_000)
            )
        ),
        "unknown point",
    ),
    "bodies": (
        lambda: (
            bodies(3_000)
            + "joints:\n"
            + "".join(
                f"  j{k}: {{type: spherical, bodies: [c{k}, b1], point: [0, 0, 0]}}\n" for k in range(3_000)
            )
        ),
        "there is no body",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_with_large_files_is_said_in_time(name: str, tmp_path: Path) -> None:
    """A suggestion for each of many unknown names, among many, would take minutes."""
    text, why = WRONG[name]
    (tmp_path / "large.yaml").write_text(text())
    with within(2 * REFUSED), pytest.raises(sr.ModelError, match=why):
        sr.load(tmp_path / "large.yaml")


def test_files_that_include_too_much_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(include, "MOST_OF_FILE", 10_000)
    (tmp_path / "part.yaml").write_text(
        "name: part\npoints:\n" + "".join(f"  P{k}: [{k}, 0, 0]\n" for k in range(100))
    )
    includes = ", ".join(f"{{file: part.yaml, prefix: p{k}_}}" for k in range(400))
    (tmp_path / "whole.yaml").write_text(HEAD + f"include: [{includes}]\n")
    with within(REFUSED), pytest.raises(sr.ModelError, match="includes more than 10,000 entries"):
        sr.load(tmp_path / "whole.yaml")


LINK = (
    '<link name="l{0}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    '</link><joint name="j{0}" type="continuous"><parent link="l{1}"/><child link="l{0}"/><axis xyz="0 0 1"/></joint>'
)


def chain(path: Path, count: int, link: str = LINK) -> Path:
    links = "".join(link.format(k, k - 1) for k in range(1, count + 1))
    path.write_text(f'<robot name="chain"><link name="l0"/>{links}</robot>')
    return path


@pytest.mark.slow
def test_a_long_chain_loads_and_a_longer_one_is_refused(tmp_path: Path) -> None:
    with within(LOADED):
        assert len(sr.load_urdf(chain(tmp_path / "chain.urdf", 3_000)).bodies) == 3_000
    with within(REFUSED), pytest.raises(sr.ModelError, match="10,002 links, more than 10,000"):
        sr.load_urdf(chain(tmp_path / "chain.urdf", 10_001))


def test_names_that_are_the_same_when_made_legal() -> None:
    with within(REFUSED):
        found = legal(["a" + "!?"[k % 2] * (k // 2 % 3) for k in range(6)], {"a"}, "_x")
        many = legal(["!" * k for k in range(2_000)], {f"_{'_' * k}" for k in range(2_000)}, "_x")
    assert len({*found.values()}) == len(found)
    assert len({*many.values()}) == 2_000


def mjcf(path: Path, body: str, assets: str = "") -> Any:
    path.write_text(f"<mujoco><asset>{assets}</asset><worldbody>{body}</worldbody></mujoco>")
    return sr.load_mjcf(path)


BALL = '<body><freejoint/><geom size="0.1"/></body>'
NESTED = '<replicate count="200"><replicate count="200">{}</replicate></replicate>'


@pytest.mark.parametrize(
    ("body", "assets", "why"),
    [
        (f'<replicate count="1000000" offset="1 0 0">{BALL}</replicate>', "", "more than 20,000 elements"),
        (NESTED.format(BALL), "", "more than 20,000 elements"),
        (f'<replicate count="9000"><include file="ball.xml"/></replicate>{BALL}', "", "more than 20,000 elements"),
        (BALL, '<hfield name="h" nrow="90000" ncol="90000" size="1 1 1 1"/>', "more than 25,000,000 cells"),
        (BALL, '<texture name="t" type="2d" builtin="flat" width="9000000" height="9"/>', "more than 25,000,000 cells"),
        ('<include file="self.xml"/>', "", "more than 16 levels"),
    ],
)  # fmt: skip
@pytest.mark.needs("mujoco")
def test_what_mujoco_could_not_make_in_seconds(body: str, assets: str, why: str, tmp_path: Path) -> None:
    (tmp_path / "ball.xml").write_text(f"<mujocoinclude>{BALL}</mujocoinclude>")
    (tmp_path / "self.xml").write_text('<mujocoinclude><include file="self.xml"/></mujocoinclude>')
    with within(REFUSED), pytest.raises(sr.ModelError, match=rf"\.xml:1: file: .*{why}"):
        mjcf(tmp_path / "a.xml", body, assets)


@pytest.mark.parametrize("anchor", ["", "1 2", "0 0 0 0"])
def test_an_anchor_that_mujoco_would_read_beyond_its_end(anchor: str, tmp_path: Path) -> None:
    connect = f'<equality><connect body1="a" body2="a" anchor="{anchor}"/></equality>'
    with pytest.raises(sr.ModelError, match=rf'xml:1: file: `anchor` of <connect> must be .* got "{anchor}"'):
        mjcf(tmp_path / "a.xml", f"{BALL}</worldbody>{connect}<worldbody>")


@pytest.mark.needs("mujoco")
def test_a_few_repetitions_are_read(tmp_path: Path) -> None:
    assert (
        len(mjcf(tmp_path / "a.xml", f'<replicate count="20" offset="1 0 0">{BALL}</replicate>').bodies) == 20
    )
