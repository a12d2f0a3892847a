"""Pages as a browser shows them: what is drawn, played, pointed at and switched on. Needs Playwright and Chromium.

`make browser` runs these. With SARRUS_PICTURES=folder the screenshots are kept there, to be looked at.
"""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from tests.analyses.driven import turned
from tests.views.test_roads import ride

import sarrus as sr
from sarrus import mechanisms
from sarrus.views.browser import Page

sync_api = pytest.importorskip("playwright.sync_api", reason="needs Playwright; make browser installs it")
pytestmark = pytest.mark.needs("playwright")
ROOT = Path(__file__).parents[2]
FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox", "--ignore-gpu-blocklist"]
SIZE = {"width": 900, "height": 560}
PATIENCE = 60_000  # [ms] on a busy machine without a graphics card


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    with sync_api.sync_playwright() as playwright:
        try:
            started = playwright.chromium.launch(executable_path=program, args=FLAGS)
        except sync_api.Error as trouble:
            pytest.skip(
                f"no Chromium: python -m playwright install chromium ({str(trouble).splitlines()[0]})"
            )
        yield started
        started.close()


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    folder = Path(os.environ.get("SARRUS_PICTURES", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@cache
def run() -> sr.Trajectory:
    return sr.kinematics(turned(3.0, 0.5), np.linspace(0.0, 2.0, 81))


class Opened:
    """A page in the browser, with what it complained about and asked for."""

    def __init__(self, browser: Any, path: Path) -> None:
        self.tab = browser.new_page(viewport=SIZE)
        self.complaints: list[str] = []
        self.asked: list[str] = []
        self.tab.on("console", lambda said: self.complaints.append(said.text))
        self.tab.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.tab.on("request", lambda request: self.asked.append(request.url))
        self.tab.set_default_timeout(PATIENCE)
        self.tab.goto(path.as_uri())
        self.wait("document.documentElement.dataset.ready === 'yes'")

    def wait(self, condition: str, frame: Any = None) -> None:
        """Ask until it is so: the page's own policy forbids a script that waits."""
        end = time.monotonic() + PATIENCE / 1000
        while not (frame or self.tab).evaluate(condition):
            assert time.monotonic() < end, f"waited in vain for {condition}; {self.complaints}"
            self.tab.wait_for_timeout(50)

    def shot(self, path: Path) -> np.ndarray:
        self.tab.wait_for_timeout(300)
        self.tab.screenshot(path=path, timeout=PATIENCE)
        return np.asarray(Image.open(path).convert("RGB"), dtype=float)


@pytest.fixture
def moving(browser: Any, tmp_path: Path) -> Iterator[Opened]:
    opened = Opened(browser, run().animate(tmp_path / "motion.html", play=False, traces=["rod"]))
    yield opened
    assert opened.complaints == []
    opened.tab.close()


@pytest.mark.parametrize(
    "model",
    [mechanisms.path("slider_crank"), mechanisms.path("hmmwv"), ROOT / "examples/four_bars.yaml", "arm"],
    ids=["slider_crank", "hmmwv", "four_bars", "arm"],
)
def test_mechanisms_are_drawn(model: Any, browser: Any, tmp_path: Path, pictures: Path) -> None:
    said = sr.load_urdf(ROOT / "tests/io/data/panda.urdf", mimic="free") if model == "arm" else sr.load(model)
    opened = Opened(browser, said.view(tmp_path / "page.html"))
    pixels = opened.shot(pictures / f"{said.name}.png")
    colorful = np.ptp(pixels[60:-60, :700], axis=2) > 40
    assert colorful.sum() > 1000
    assert opened.complaints == []
    assert [url for url in opened.asked if not url.startswith(("file:", "blob:", "data:"))] == []
    opened.tab.close()


def test_the_slider_sets_the_time(moving: Opened) -> None:
    moving.tab.evaluate("sarrus.show(1.0)")
    x, y, z = moving.tab.evaluate("sarrus.actors[0].bodies[3].position.toArray()")
    assert [x, y, z] == pytest.approx(run()["slider"].position[40], abs=1e-4)
    assert moving.tab.inner_text("#clock") == "1.000 s"
    moving.tab.fill("#slider", "0.5")
    assert moving.tab.inner_text("#clock") == "0.500 s"


def test_a_road_that_moves(browser: Any, tmp_path: Path, pictures: Path) -> None:
    opened = Opened(browser, ride().animate(tmp_path / "ride.html", play=False))
    for time_of, height in ((0.0, 0.02), (np.pi / 9, -0.02)):
        opened.tab.evaluate(f"sarrus.show({time_of})")
        place = opened.tab.evaluate("sarrus.actors[0].bodies[4].position.toArray()")
        assert place == pytest.approx([0, 0, height], abs=1e-5)
        opened.shot(pictures / f"road_{time_of:.2f}.png")
    assert opened.complaints == []
    opened.tab.close()


def test_it_plays_and_stops(moving: Opened) -> None:
    moving.tab.select_option("#speed", "0.1")
    moving.tab.click("#play")
    moving.wait("sarrus.time > 0")
    moving.tab.keyboard.press("Home")
    assert moving.tab.evaluate("[sarrus.playing, sarrus.time]") == [False, 0]


def test_names_on_hover_and_traces_by_a_double_click(moving: Opened) -> None:
    moving.tab.evaluate("sarrus.show(0.5)")
    moving.tab.wait_for_timeout(300)
    x, y = moving.tab.evaluate(
        "(() => { sarrus.render(); const c = sarrus.actors[0].bodies[2].position.clone().project(sarrus.camera);"
        " return [(c.x + 1) / 2 * innerWidth, (1 - c.y) / 2 * innerHeight]; })()"
    )
    moving.tab.mouse.move(x, y)
    tip = moving.tab.inner_text("#tip")
    assert tip.startswith("rod\nbody, 1 kg")
    moving.tab.mouse.dblclick(x, y)
    moving.wait("sarrus.actors[0].traces.length === 0 || sarrus.actors[0].traces.length === 2")


def test_arrows_and_names_are_switched_on(moving: Opened, pictures: Path) -> None:
    moving.tab.evaluate("sarrus.show(0.8)")
    before = moving.shot(pictures / "plain.png")
    for switch in ("reactions", "forces", "names", "frames", "glass"):
        moving.tab.click(f"#show-{switch}")
    after = moving.shot(pictures / "arrows.png")
    pink = (after[:, :, 0] > after[:, :, 1] + 90) & (after[:, :, 2] > after[:, :, 1] + 20)
    assert pink.sum() > 100
    assert abs(after - before).max(axis=2).mean() > 1
    assert set(moving.tab.locator("#names span").all_inner_texts()) == {"crank", "rod", "slider"}


def test_the_legend_has_colours_and_the_scale_of_arrows(moving: Opened) -> None:
    read = "[...document.querySelectorAll('#legend div')].map((row) => row.textContent)"
    (before,) = [row for row in moving.tab.evaluate(read) if row.startswith("reaction")]
    assert " m = " in before
    assert before.endswith("N m")
    size = "const s = document.getElementById('arrowsize'); s.value = 1; s.dispatchEvent(new Event('input'))"
    moving.tab.evaluate(size)
    (after,) = [row for row in moving.tab.evaluate(read) if row.startswith("reaction")]
    first, second = (float(row.partition(" = ")[2].split()[0]) for row in (before, after))
    assert second == pytest.approx(first / 10, rel=0.06)
    colour = moving.tab.evaluate("document.querySelector('#legend i').style.background")
    assert colour == "rgb(179, 23, 95)"


def test_runs_are_drawn_over_each_other(browser: Any, tmp_path: Path, pictures: Path) -> None:
    other = sr.kinematics(turned(1.0, 0.0), np.linspace(0.0, 2.0, 41))
    file = run().animate(tmp_path / "both.html", beside=[other], labels=["quick", "slow"], play=False)
    opened = Opened(browser, file)
    opened.tab.evaluate("sarrus.show(1.0)")
    opened.shot(pictures / "both.png")
    assert opened.tab.locator("#keys div").all_inner_texts() == ["quick", "slow"]
    places = opened.tab.evaluate("sarrus.actors.map((actor) => actor.bodies[3].position.x)")
    assert places == pytest.approx(
        [run()["slider"].position[40, 0], other["slider"].position[20, 0]], abs=1e-4
    )
    opened.tab.close()


def test_a_notebook_shows_it_in_a_closed_frame(browser: Any, tmp_path: Path) -> None:
    page = Page("crank", run().animate(tmp_path / "motion.html").read_text())
    (tmp_path / "notebook.html").write_text(
        f"<html data-ready='yes'><body>{page._repr_html_()}</body></html>"
    )
    opened = Opened(browser, tmp_path / "notebook.html")
    frame = opened.tab.frames[1]
    opened.wait("document.documentElement.dataset.ready === 'yes'", frame)
    assert opened.complaints == []
    opened.tab.close()


def test_influences_are_bars_to_the_left_and_right_of_zero(
    browser: Any, tmp_path: Path, pictures: Path
) -> None:
    names, changes = ("spring.k", "rod.mass", "slider.mass"), np.array([[2.0, -1.0, 0.5]])
    gradient = sr.Gradient(("final of slider.x",), names, np.ones(1), np.ones(3), changes)
    opened = Opened(
        browser, run().animate(tmp_path / "bars.html", play=False, outputs=["slider.x"], gradient=gradient)
    )
    rows = "[...document.querySelectorAll('.tornado > div')]"
    assert opened.tab.evaluate(f"{rows}.map(row => row.firstChild.textContent)") == list(names)
    boxes = opened.tab.evaluate(
        f"{rows}.map(row => [row.lastChild, row.lastChild.firstChild].map(one => one.getBoundingClientRect()))"
    )
    for (track, bar), change in zip(boxes, changes[0], strict=True):
        assert bar["width"] == pytest.approx(abs(change) / 4 * track["width"], abs=1)
        zero = track["x"] + track["width"] / 2
        assert (bar["x"] if change > 0 else bar["x"] + bar["width"]) == pytest.approx(zero, abs=1)
    opened.shot(pictures / "bars.png")
    assert opened.complaints == []
    opened.tab.close()


def test_curves_of_outputs_have_the_present_value(browser: Any, tmp_path: Path, pictures: Path) -> None:
    names = ["spring.tension", "pin.angle"]
    options = {"outputs": names, "beside": [run()], "labels": ["one", "two"]}
    opened = Opened(browser, run().animate(tmp_path / "curves.html", play=False, **options))
    wanted = {name: run().output(name) for name in names}
    for time_ in (0.0, 1.0, 2.0):
        opened.tab.evaluate(f"sarrus.show({time_})")
        lines = opened.tab.inner_text("#curves").split("\n")
        for name, line in zip(names, filter(None, lines), strict=True):
            shown, unit = line.removeprefix(f"{name} = ").split(" ")
            assert unit == wanted[name].unit
            there = np.interp(time_, wanted[name].t, wanted[name].values)
            assert float(shown) == pytest.approx(there, rel=1e-3, abs=1e-6)
    before = opened.shot(pictures / "curves.png")
    opened.tab.evaluate("sarrus.show(0.3)")
    assert abs(opened.shot(pictures / "curves_early.png") - before)[100:240, 14:240].max() > 50
    assert opened.complaints == []
    opened.tab.close()
