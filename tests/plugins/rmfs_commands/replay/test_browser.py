"""The page in a real browser: what it shows, and what keys and clicks do."""

import csv
import random
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from PIL import Image

import rmfs_commands.replay
import rmfs_core
from chromium import Chromium
from rmfs_commands.replay.page import page, script
from rmfs_commands.replay.positions import ways
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_core.world import CellKind

SIZES = [(1280, 720), (1600, 1000), (900, 700), (400, 800)]

SEEN_AT = """
(async () => {
  const [view] = replay.views;
  const seen = [];
  for (const tick of %s) {
    replay.seek(tick);
    replay.draw(performance.now());
    const { scene } = view;
    seen.push(scene.places.map(({ x, y, heading }) => [x, y, heading]));
  }
  return seen;
})()
"""

COLOURS_AT = """
(() => {
  const { scene } = replay.views[0];
  replay.seek(%d);
  replay.draw(performance.now());
  const hex = (data) => "#" + [...data.slice(0, 3)].map((value) => value.toString(16).padStart(2, "0")).join("");
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [scene.canvas.width, scene.canvas.height];
  const pen = copy.getContext("2d", { willReadFrequently: true });
  pen.drawImage(scene.canvas, 0, 0);
  return %s.map(([x, y]) => hex(pen.getImageData(
    Math.round(scene.toX(x + 0.5)), Math.round(scene.toY(y + 0.5)), 1, 1).data));
})()
"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Chromium]:
    with Chromium() as found:
        yield found


@pytest.fixture(scope="module")
def written(day: Path, short: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pages")
    replays = {"day": [read_replay(day)], "short": [read_replay(short)]}
    replays["both"] = [*replays["day"], *replays["short"]]
    for name, runs in replays.items():
        (folder / f"{name}.html").write_text(page(runs), encoding="utf-8")
    return {name: folder / f"{name}.html" for name in replays}


@pytest.fixture(autouse=True)
def quiet(browser: Chromium) -> Iterator[None]:
    """No page may complain, or ask for anything but itself."""
    browser.problems.clear()
    browser.requests.clear()
    browser.size(1280, 720)
    yield
    assert browser.problems == []
    assert all(address.startswith(("file:", "data:", "about:")) for address in browser.requests)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["day", "short"])
def test_robots_are_on_screen_where_the_validator_has_them(browser, written, day, short, name) -> None:
    """At 200 random times, forwards and backwards, and at the end; test_positions holds ours against the validator."""
    replay = read_replay({"day": day, "short": short}[name])
    found = ways(replay)
    draw = random.Random(17)
    ticks = [*(draw.randrange(replay.tick) for _ in range(200)), replay.tick]
    browser.open(written[name])
    for tick, places in zip(ticks, browser.evaluate(SEEN_AT % ticks), strict=True):
        for way, (x, y, heading) in zip(found, places, strict=True):
            here = way.at(tick)
            assert (x, y, heading) == pytest.approx((here.column, here.row, here.heading), abs=1e-9), tick


@pytest.mark.slow
def test_robots_are_drawn_there(browser: Chromium, written: dict[str, Path], replay: Replay) -> None:
    browser.size(1600, 1000)
    browser.open(written["day"])
    browser.evaluate("replay.theme('light')")
    found, draw = ways(replay), random.Random(3)
    steps = ((1, 0), (0, -1), (-1, 0), (0, 1))
    for tick in (draw.randrange(replay.tick) for _ in range(50)):
        here = [place for place in (way.at(tick) for way in found) if place.heading % 1 == 0]
        behind = [
            (place.column - 0.16 * across, place.row - 0.16 * down)
            for place in here
            for across, down in [steps[int(place.heading) % 4]]
        ]
        shown = browser.evaluate(COLOURS_AT % (tick, [list(point) for point in behind]))
        assert set(shown) <= {"#d55e00", "#8f1d14", "#9aa3ad"}, tick
    floor = [c for c, kind in enumerate(replay.start.layout.kind.tolist()) if kind == CellKind.FLOOR]
    width = replay.start.layout.width
    taken = {(round(p.column), round(p.row)) for p in (way.at(0) for way in found)}
    empty = [[cell % width, cell // width] for cell in floor if (cell % width, cell // width) not in taken]
    assert set(browser.evaluate(COLOURS_AT % (0, empty))) == {"#ffffff"}


@pytest.mark.slow
def test_heat_maps_add_up_to_the_tables(browser: Chromium, written: dict[str, Path], day: Path, replay: Replay) -> None:
    browser.open(written["day"])
    sums = {}
    for name in ("waiting", "traffic", "picks"):
        browser.evaluate(f"replay.setHeat('{name}')")
        sums[name] = browser.evaluate("replay.views[0].scene.heat.values.reduce((a, b) => a + b)")
    with (day / "robots.csv").open(encoding="utf-8", newline="") as file:
        waiting = sum(float(row["waiting_s"]) for row in csv.DictReader(file))
    assert sums["waiting"] == pytest.approx(waiting, abs=0.01)
    assert sums["traffic"] == replay.metrics["distance_m"]
    assert sums["picks"] == replay.metrics["picks"]


@pytest.mark.slow
def test_keys(browser: Chromium, written: dict[str, Path], replay: Replay) -> None:
    browser.open(written["day"])
    tick = "replay.clock.tick"
    browser.press("ArrowRight")
    assert browser.evaluate(tick) == 10_000
    browser.press("End")
    assert browser.evaluate(tick) == replay.tick
    browser.press("Home")
    browser.press(" ")
    time.sleep(0.5)
    browser.press(" ")
    stopped = browser.evaluate(tick)
    assert stopped > 0
    time.sleep(0.1)
    assert browser.evaluate(tick) == stopped
    browser.press("Home")
    browser.press(".")
    assert browser.evaluate(f"replay.views[0].run.events.decision_made.tick.includes({tick})")
    before = browser.evaluate(tick)
    browser.press("n")
    following = f"replay.views[0].run.sequence.tick.find((one) => one > {before})"
    assert browser.evaluate(tick) == browser.evaluate(following)
    assert "What limits it" in browser.evaluate("document.getElementById('panel').textContent")
    browser.press("ArrowUp")
    assert browser.evaluate("replay.clock.speed") == 20
    browser.press("h")
    assert browser.evaluate("replay.heat") == "waiting"
    browser.press("d")
    assert browser.evaluate("document.documentElement.dataset.theme") == "dark"
    browser.press("?")
    assert browser.evaluate("document.getElementById('keys').open")
    browser.press("Escape")
    assert not browser.evaluate("document.getElementById('keys').open")
    browser.press("?")
    browser.evaluate("document.querySelector('#keys button').click()")
    assert not browser.evaluate("document.getElementById('keys').open")


@pytest.mark.slow
def test_finding_and_clicking(browser: Chromium, written: dict[str, Path]) -> None:
    browser.open(written["day"], "#t=100")
    browser.press("/")
    for sign in "robot 2":
        browser.press(sign)
    browser.press("Enter")
    heading = "document.querySelector('#panel h2').textContent"
    wait_until(browser, f"{heading} === 'Robot 2'")
    assert browser.evaluate("document.querySelector('#panel .now').textContent.length > 5")
    assert "rmfs explain day --decision" in browser.evaluate("document.getElementById('panel').textContent")
    first, said = browser.evaluate(
        "(() => { const item = document.querySelector('.history li button'); item.click();"
        "return [item.textContent, document.querySelector('.history li span').textContent]; })()"
    )
    wait_until(browser, f"document.getElementById('time').textContent === '{first}'")
    assert said.startswith("told to fetch pod ")
    x, y = browser.evaluate(
        "(() => { const { scene } = replay.views[0]; const box = scene.canvas.getBoundingClientRect();"
        "const { x, y } = scene.places[0];"
        "return [box.left + scene.toX(x + 0.5) / scene.ratio, box.top + scene.toY(y + 0.5) / scene.ratio]; })()"
    )
    browser.click(x, y)
    wait_until(browser, f"{heading} === 'Robot 1'")
    said = "document.getElementById('said').textContent"
    for name in ("pod 4", "station 1", "order 7"):
        browser.evaluate(f"replay.find('{name}')")
        wait_until(browser, f"{heading}.toLowerCase() === '{name}'")
        assert browser.evaluate(f"{said}.startsWith('{name}: ') && {said}.endsWith('.')")
    browser.evaluate("replay.find('robot 99')")
    assert browser.evaluate(said) == "robot 99 is not here; try robot 1, pod 2, station 1 or order 3"


def wait_until(browser: Chromium, condition: str) -> None:
    for _ in range(200):
        if browser.evaluate(condition):
            return
        time.sleep(0.01)
    raise AssertionError(condition)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["day", "both"])
@pytest.mark.parametrize("size", SIZES)
def test_nothing_overlaps_or_is_cut_off(browser, written, size, name) -> None:
    browser.size(*size)
    browser.open(written[name], "#t=60")
    boxes = browser.evaluate(
        "['header', '#views', '#legend', '#panel'].map((name) => {"
        "const { left, top, right, bottom } = document.querySelector(name).getBoundingClientRect();"
        "return [left, top, right, bottom]; })"
    )
    for i, (left, top, right, bottom) in enumerate(boxes):
        assert right - left > 100, i
        assert 0 <= left < right <= size[0]
        for other in boxes[i + 1 :]:
            assert right <= other[0] + 1 or other[2] <= left + 1 or bottom <= other[1] + 1 or other[3] <= top + 1
    assert browser.evaluate("document.documentElement.scrollWidth") <= size[0]
    assert browser.evaluate("replay.views.every((view) => view.scene.scale >= 6)")


@pytest.mark.slow
def test_dark_and_light_as_the_reader_has_it(browser: Chromium, written: dict[str, Path]) -> None:
    for dark in (False, True):
        browser.size(1280, 720, dark=dark)
        browser.open(written["day"])
        assert browser.evaluate("document.documentElement.dataset.theme") == ("dark" if dark else "light")
        for element in ("h1", "label", "#panel dt", "#panel button.link"):
            assert contrast(browser, element) >= 4.5, element


def contrast(browser: Chromium, element: str) -> float:
    """Return the contrast of a text with the surface behind it, after WCAG 2."""
    text, behind = browser.evaluate(
        f"(() => {{ const element = document.querySelector('{element}');"
        "const back = element.closest('header, aside, footer');"
        "const parts = (colour) => colour.match(/\\d+/g).slice(0, 3).map(Number);"
        "return [parts(getComputedStyle(element).color), parts(getComputedStyle(back).backgroundColor)]; })()"
    )

    def luminance(colour: list[int]) -> float:
        linear = [value / 255 / 12.92 if value <= 10 else ((value / 255 + 0.055) / 1.055) ** 2.4 for value in colour]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    high, low = sorted((luminance(text), luminance(behind)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.slow
def test_everything_has_a_name_for_who_does_not_see_it(browser: Chromium, written: dict[str, Path]) -> None:
    browser.open(written["day"], "#t=3661")
    nameless = browser.evaluate(
        "[...document.querySelectorAll('button, select, input, canvas, section, aside, dialog')].filter((one) =>"
        "!(one.getAttribute('aria-label') || one.getAttribute('aria-labelledby') || one.closest('label')"
        "|| one.textContent.trim() || one.getAttribute('aria-hidden'))).map((one) => one.outerHTML)"
    )
    assert nameless == []
    browser.evaluate("replay.seek(61000)")
    wait_until(browser, "document.getElementById('seek').getAttribute('aria-valuetext') === '1 minute 1 second'")


@pytest.mark.slow
@pytest.mark.parametrize("forbidden", [True, False])
def test_a_foreign_script_does_not_run(browser, written, tmp_path, forbidden) -> None:
    text = written["day"].read_text(encoding="utf-8")
    policy = re.search(r"<meta http-equiv=.*>", text)
    assert policy
    file = tmp_path / "page.html"
    file.write_text(text if forbidden else text.replace(policy[0], ""), encoding="utf-8")
    browser.open(file)
    browser.evaluate(
        "(() => { const script = document.createElement('script'); script.textContent = 'window.ran = true';"
        "document.body.append(script);"
        "const html = `<button id='foreign' onclick='window.clicked = true'>`;"
        "document.body.insertAdjacentHTML('beforeend', html); document.getElementById('foreign').click(); })()"
    )
    assert browser.evaluate("[window.ran === true, window.clicked === true]") == [not forbidden] * 2
    refused = [one for one in browser.problems if "violates the following Content Security Policy" in one]
    assert len(refused) == (2 if forbidden else 0)
    browser.problems[:] = [one for one in browser.problems if one not in refused]


@pytest.mark.slow
def test_the_script_hides_nothing_of_the_browser(browser: Chromium, written: dict[str, Path]) -> None:
    """Its modules share a scope: a name of one must not be what another means by a browser's object."""
    browser.open(written["day"])
    names = re.findall(r"^(?:async )?(?:const|class|function) (\w+)", script(), re.MULTILINE)
    assert len(names) > 100
    assert browser.evaluate(f"{names}.filter((name) => Object.hasOwn(window, name))") == []


@pytest.mark.slow
def test_a_page_of_hours_opens_at_once_and_runs_smoothly(browser: Chromium, tmp_path: Path) -> None:
    overrides = ("robots.count=100", "layout.stations_west=4", "run.until_s=7200", "rules.pp=sipp")
    rmfs_core.run("paper-2000", overrides=overrides, out=tmp_path, record=["trace"])
    (tmp_path / "page.html").write_text(page([read_replay(tmp_path)]), encoding="utf-8")
    assert (tmp_path / "page.html").stat().st_size < 500_000
    assert browser.open(tmp_path / "page.html", "#t=3000&speed=50") < 2
    browser.evaluate("replay.drawn = { frames: 0, ms: 0 }")
    browser.press(" ")
    time.sleep(2)
    frames, spent_ms = browser.evaluate("[replay.drawn.frames, replay.drawn.ms]")
    assert frames > 20
    assert spent_ms / frames < 1000 / 60 / 2


@pytest.mark.slow
def test_a_notebook_shows_it_in_a_frame(browser: Chromium, day: Path, tmp_path: Path) -> None:
    around = f"<body style='margin:0'>{rmfs_commands.replay.replay(day)._repr_html_()}<script>replay = true</script>"
    (tmp_path / "notebook.html").write_text(f"<!DOCTYPE html><meta charset='utf-8'>{around}", encoding="utf-8")
    browser.open(tmp_path / "notebook.html")

    def pixels(colour: tuple[int, int, int]) -> int:
        browser.picture(tmp_path / "seen.png")
        with Image.open(tmp_path / "seen.png") as seen:
            colours = seen.convert("RGB").getcolors(1 << 24) or []
        return sum(number for number, found in colours if found == colour)

    def waited_for(seen: Callable[[], bool]) -> bool:
        end = time.monotonic() + 20
        while not (found := seen()) and time.monotonic() < end:
            time.sleep(0.1)
        return found

    robot = (0xD5, 0x5E, 0x00)
    assert waited_for(lambda: pixels(robot) > 100)
    before = pixels(robot)
    browser.click(640, 520)
    assert waited_for(lambda: pixels(robot) != before)
