"""Pages hold what they show, and ask for nothing from outside."""

from __future__ import annotations

import re
import webbrowser
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.analyses.driven import turned
from tests.views.page_parts import PageParts, read

import sarrus as sr
from sarrus import mechanisms
from sarrus.views.browser import Page

CRANK = mechanisms.path("slider_crank")
ROUNDED = 2e-6  # float32


@cache
def run() -> sr.Trajectory:
    return sr.kinematics(turned(3.0, 0.5), np.linspace(0.0, 1.0, 41))


@cache
def page(**options: Any) -> PageParts:
    return PageParts(_page(**options).html)


def _page(**options: Any) -> Page:
    opened: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(webbrowser, "open", opened.append)
        made = run().animate(**options)
    assert isinstance(made, Page)
    assert opened[0].startswith("file:")
    return made


def test_a_page_needs_no_network() -> None:
    html = page().html
    assert "default-src 'none'" in html
    assert not re.findall(r"<(?:script|link|img|iframe)[^>]+(?:src|href)=", html)
    assert not re.findall(r"@import|\burl\(\s*['\"]?https?:", html)
    assert "MIT licence" in html


def test_frames_of_systems_with_states_are_those_of_the_bodies() -> None:
    lag = sr.FirstOrderLag("lag", input="puck.velocity.x", time=0.1, initial=1.0)
    puck = sr.Body("puck", 1.0, (0.1, 0.1, 0.1), velocity=(1.0, 0.5, 0.2))
    moved = sr.simulate(
        sr.System(sr.Model("puck", [puck], forces=[lag])), until=1.0, t_eval=np.linspace(0, 1, 11)
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(webbrowser, "open", lambda page: None)
        parts = PageParts(moved.animate(count=11).html)
    assert parts.array(parts.told["runs"][0]["q"], 7) == pytest.approx(moved.q[:, :7], abs=ROUNDED)


def test_frames_are_the_run() -> None:
    told, parts = page(count=41).told, page(count=41)
    assert told["runs"][0]["count"] == 41
    assert parts.array(told["runs"][0]["q"], 21) == pytest.approx(run().q, abs=ROUNDED)
    between = page(count=81)
    fine = sr.kinematics(turned(3.0, 0.5), np.linspace(0.0, 1.0, 81))
    assert between.array(between.told["runs"][0]["q"], 21) == pytest.approx(fine.q, abs=2e-5)


def test_euler_parameters_keep_their_sign(tmp_path: Path) -> None:
    q, v = run().q.copy(), run().v.copy()
    q[20:, 3:7] *= -1
    v[20:, 3:7] *= -1
    parts = read(replace(run(), q=q, v=v).animate(tmp_path / "page.html", count=41))
    assert parts.array(parts.told["runs"][0]["q"], 21) == pytest.approx(run().q, abs=ROUNDED)


def test_arrows_are_reactions() -> None:
    told = page(count=41, reactions=("pin",), forces=False).told["runs"][0]
    parts = page(count=41, reactions=("pin",), forces=False)
    (force,) = [arrow for arrow in told["arrows"] if not arrow["turning"]]
    expected = run().reaction("pin")
    assert parts.array(force["ways"]) == pytest.approx(expected.force, rel=1e-5, abs=1e-4)
    assert parts.array(force["points"]) == pytest.approx(expected.point, abs=ROUNDED)


def test_arrows_are_applied_forces() -> None:
    parts = page(count=41, reactions=False)
    (spring,) = [arrow for arrow in parts.told["runs"][0]["arrows"] if not arrow["turning"]]
    x, v = run()["slider"].position[:, 0], run()["slider"].velocity[:, 0]
    tension = 10 * (x - 5) + v
    assert parts.array(spring["ways"])[:, 0] == pytest.approx(-tension, rel=1e-5, abs=1e-4)
    assert spring["description"] == "force of spring on slider"


def test_weights_are_arrows_on_request(tmp_path: Path) -> None:
    system = sr.System(replace(run().system.model, gravity=(0, 0, -10)))
    moved = sr.kinematics(system, np.linspace(0.0, 1.0, 5))
    for shown, count in ((False, 0), (True, 3)):
        parts = read(moved.animate(tmp_path / "page.html", count=5, weights=shown))
        found = [one for one in parts.told["runs"][0]["arrows"] if one["description"].startswith("weight of")]
        assert len(found) == count
    (rod,) = [one for one in found if one["name"] == "rod"]
    mass = next(body.mass for body in system.model.bodies if body.name == "rod")
    assert parts.array(rod["ways"])[:, 2] == pytest.approx(-10 * mass, rel=1e-6)
    assert parts.array(rod["points"]) == pytest.approx(moved["rod"].position, abs=ROUNDED)


def test_all_names_are_there() -> None:
    told = page().told
    model = run().system.model
    drawn = {part["name"] for sketch in told["sketches"] for part in (*sketch["parts"], *sketch["spans"])}
    wanted = {part.name for section in ("bodies", "joints", "forces") for part in model.sections()[section]}
    assert wanted <= drawn


def test_runs_beside_each_other() -> None:
    other = sr.kinematics(turned(1.0, 0.0), np.linspace(0.0, 2.0, 41))
    told = PageParts(_page(beside=(other,), labels=("quick", "slow")).html).told
    assert [one["name"] for one in told["runs"]] == ["quick", "slow"]
    assert told["runs"][0]["color"] is None
    assert told["runs"][1]["color"].startswith("#")
    with pytest.raises(ValueError, match=r"there are 2 runs, but 1 labels. Give one for each"):
        run().animate("x.html", beside=(other,), labels=("quick",))


def test_traces_are_points_of_bodies() -> None:
    system = run().system
    slider = next(body for body in system.model.bodies if body.name == "slider")
    told = page(traces=("rod", slider.point(0.1, 0.2, 0.3))).told["runs"][0]
    assert told["traces"][0] == {"body": 2, "point": [0.0, 0.0, 0.0]}
    assert told["traces"][1] == {"body": 3, "point": [0.1, 0.2, 0.3]}
    with pytest.raises(KeyError, match=r'no body "rope" in slider-crank. Choose from crank, rod, slider'):
        run().animate("x.html", traces=["rope"])


def test_names_cannot_break_the_page(tmp_path: Path) -> None:
    evil = replace(sr.load(CRANK), name="</script><b>@SCENE@ & co")
    parts = read(sr.view(evil, tmp_path / "page.html"))
    assert parts.told["title"] == evil.name
    assert "<b>" not in parts.html.replace("<b></b>", "")


def test_notebooks_show_a_frame() -> None:
    shown = Page("one", "<p>\"a\" & 'b'</p>")._repr_html_()
    assert 'srcdoc="&lt;p&gt;&quot;a&quot; &amp; &#x27;b&#x27;&lt;/p&gt;"' in shown
    assert 'sandbox="allow-scripts' in shown


def test_a_position_can_be_given(tmp_path: Path) -> None:
    q = run().q[-1]
    parts = read(run().system.model.view(tmp_path / "page.html", q=q))
    assert parts.array(parts.told["runs"][0]["q"], 21)[0] == pytest.approx(q, abs=ROUNDED)
    with pytest.raises(ValueError, match="has 21 coordinates, but q has 20"):
        run().system.model.view(tmp_path / "page.html", q=q[1:])


def test_misuse_is_told(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"one of \.html, \.glb, \.gif, \.mp4"):
        run().animate(tmp_path / "motion.avi")
    with pytest.raises(ValueError, match="does not know its system"):
        replace(run(), system=None).animate(tmp_path / "motion.html")
    empty = replace(run(), t=run().t[:0], q=run().q[:0], message="it broke")
    with pytest.raises(ValueError, match="holds no states, so there is nothing to show: it broke"):
        empty.animate(tmp_path / "motion.html")
    with pytest.raises(KeyError, match="no joint or driver 'pim'"):
        run().animate(tmp_path / "motion.html", reactions=["pim"])


def test_bars_are_the_largest_influences(tmp_path: Path) -> None:
    names, responses = (
        ["spring.k", "slider.mass", "gravity.x", "rod.mass"],
        ["final of slider.x", "mean of y"],
    )
    matrix, at = np.array([[2.0, -300.0, 5.0, 0.1], [0.0, 1.0, 0.0, -2.0]]), np.array([10.0, 1.0, 0.0, 4.0])
    found = sr.Gradient(tuple(responses), tuple(names), np.ones(2), at, matrix)
    first, second = page(count=3, gradient=found).told["influences"]
    assert first["title"] == "final of slider.x, by 1 % more of"
    assert first["names"] == ["slider.mass", "spring.k", "rod.mass"]  # nothing for what is 0
    assert first["changes"] == pytest.approx([-3.0, 0.2, 0.004])
    assert second["names"][:2] == ["rod.mass", "slider.mass"]
    with pytest.raises(ValueError, match="only pages show curves of outputs and influences"):
        run().animate(tmp_path / "x.gif", gradient=found)


def test_curves_are_outputs(tmp_path: Path) -> None:
    names = ("rod(0.1, 0, 0).y", "pin.force.z", "energy.total")
    parts = page(count=41, outputs=names)
    curves = parts.told["runs"][0]["curves"]
    assert [one["name"] for one in curves] == list(names)
    assert [one["unit"] for one in curves] == ["m", "N", "J"]
    for one in curves:
        wanted = run().output(one["name"]).values
        assert parts.array(one["values"], 1)[:, 0] == pytest.approx(wanted, rel=1e-5, abs=1e-5)
    assert page(traces=("rod(0.1, 0, 0)",)).told["runs"][0]["traces"] == [{"body": 2, "point": [0.1, 0, 0]}]
    with pytest.raises(KeyError, match=r"no output 'rod\.w'. Did you mean"):
        run().animate("x.html", outputs=["rod.w"])
    with pytest.raises(ValueError, match="only pages show curves"):
        run().animate(tmp_path / "x.gif", outputs=["rod.x"])
    with pytest.raises(KeyError, match=r"rod\(1, 2\) is no point"):
        run().animate("x.html", traces=["rod(1, 2)"])
