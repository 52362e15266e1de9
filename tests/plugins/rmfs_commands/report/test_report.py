import csv
import re
import shutil
from collections.abc import Callable
from html import unescape
from pathlib import Path
from statistics import fmean

import pytest
from attrs import evolve

import rmfs_core
from calling import exit_code, refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.cli.not_simulated import NOT_SIMULATED
from rmfs_commands.report.drawing import Series, chart, nice, stacked
from rmfs_commands.report.hall import heat_maps
from rmfs_commands.report.page import in_days, run_page
from rmfs_commands.report.reading import read_run
from rmfs_commands.states.recorded import read_recording
from rmfs_commands.states.stories import order_story
from rmfs_core.scenario import load_scenario
from rmfs_core.wording import counted

LATE = ("instance.orders=25", "instance.due.allowance_s=150", "run.until_s=450", "robots.count=8")
RESTING = (
    "instance.orders=15",
    "robots.count=8",
    "layout.chargers=1",
    "robots.battery={capacity_wh=70, idle_w=200, charging_w=8000}",
    "rules.idle=charge-when-low",
    "run.warmup_s=60",
)
DAY = """order,arrival_s,sku,quantity,due_s,cancelled_s
A,0,tea,1,5,
B,0,tea,1,5,3
C,20,ale,1,25,
D,40,ale,1,999,
E,60,ale,1,70,
F,300,tea,1,310,
"""
HALL = """[instance]
orders_file = "orders.csv"
pods_file = "pods.csv"
[layout]
block_rows = 3
block_columns = 1
stations_east = 1
[robots]
count = 1
[stations]
item_capacity = 1
[rules]
poa = "first-come"
pps = "demand"
"""
PACKING = ("instance.orders=20", "rules.pp=free-flow")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    whole = tmp_path_factory.mktemp("runs")

    def folder(scenario: str, overrides: tuple[str, ...], *record: str) -> Path:
        out = whole / f"{scenario.rpartition('/')[2]}-{len(overrides)}"
        if not out.exists():
            rmfs_core.run(load_scenario(scenario, overrides), out=out, record=record)
        return out

    return folder


@pytest.fixture(scope="module")
def late(runs: Callable[..., Path]) -> Path:
    return runs("examples/small", LATE, "trace", "decisions")


@pytest.fixture(scope="module")
def page(late: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    tmp_path = tmp_path_factory.mktemp("pages")
    assert exit_code("report", str(late), "--quiet", "--out", str(tmp_path / "page.html")) == 0
    assert sorted(file.name for file in tmp_path.iterdir()) == ["page-replay.html", "page.html"]
    return (tmp_path / "page.html").read_text(encoding="utf-8")


def rows(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def table(page: str, heading: str) -> list[list[str]]:
    """Return the cells of the body of the table below a heading, as texts."""
    body = page.partition(f"<h2>{heading}</h2>")[2].partition("</table>")[0]
    found = re.findall(r"<tr>(.*?)</tr>", body.partition("<tbody>")[2], re.DOTALL)
    return [
        [unescape(re.sub(r"<[^>]*>", "", cell)).strip() for cell in re.findall(r"<td.*?>(.*?)</td>", row, re.DOTALL)]
        for row in found
    ]


def test_the_page_begins_with_the_limit_and_needs_nothing_else(page: str, late: Path) -> None:
    """No script, and no address but places in the replay beside it."""
    links = re.findall(r'(?:src|href|url)[=(]"?([^")]*)', page)
    assert links
    assert all(re.fullmatch(r"page-replay\.html#[^/]+", link) for link in links)
    assert "<script" not in page
    assert not re.search(r"https?:", page)
    pictures = [svg for svg in re.findall(r"<svg[^>]*>", page) if 'aria-hidden="true"' not in svg]  # beside a word
    assert all('role="img"' in svg and "aria-label=" in svg for svg in pictures)
    run = read_run(late)
    limit = run.result.summary["bottleneck"]["says"][0]
    assert f'<p class="answer">Limit: {limit}</p>' in unescape(page.partition("<h2>")[0])
    assert "The run ended at its horizon at 0:07:30" in page
    assert NOT_SIMULATED in unescape(page)
    several = evolve(run.result, summary={"bottleneck": {"says": ["No single limit: many."]}})
    assert '<p class="answer">No single limit: many.</p>' in run_page(evolve(run, result=several), 1, None)


def test_late_orders_come_first_and_have_their_causes(page: str, late: Path) -> None:
    orders = rows(late / "orders.csv")
    over = {row["order"]: float(row["completed_s"] or 450) - float(row["due_s"]) for row in orders}
    latest = sorted((name for name in over if over[name] > 0), key=lambda name: -over[name])
    assert latest
    assert [row[0] for row in table(page, f"{len(latest)} late orders")] == latest[:10]
    delays = {row["order"]: row for row in rows(late / "delays.csv")}
    slowest = table(page, "Slowest orders")
    assert float(delays[slowest[0][0]]["turnover_s"]) == max(float(row["turnover_s"] or 0) for row in delays.values())
    seconds = float(delays[slowest[0][0]]["backlog_s"]) + float(delays[slowest[0][0]]["other_parts_s"])
    assert f"waiting for station capacity {seconds:,.0f} s" in slowest[0][1]
    left = sum(row["completed_s"] == "" for row in orders)
    assert len(table(page, f"{counted(left, 'open order')} at the end")) == left > 0
    assert len(table(run_page(read_run(late), 2, None), "Slowest orders")) == 2


def test_parts_of_the_turnover_time_are_means_over_their_orders(page: str, late: Path) -> None:
    done = [row for row in rows(late / "delays.csv") if row["turnover_s"]]
    (robot,) = [row for row in table(page, "Where the turn-over time went") if row[0] == "waiting for a robot"]
    assert robot[1] == f"{fmean(float(row['robot_s']) for row in done):,.1f} s"
    slowest = max(done, key=lambda row: float(row["turnover_s"]))
    assert robot[3] == f"{float(slowest['robot_s']):,.1f} s"  # 5 % of 22 orders are one


def test_a_listed_order_has_what_explain_says_of_it(page: str, late: Path) -> None:
    name = table(page, "Slowest orders")[0][0]
    told = order_story(read_recording(late), name)
    assert told
    text = unescape(page.partition("<h2>Slowest orders</h2>")[2].partition("</tr>\n<tr>")[0])
    for episode in told:
        assert f"{episode.rule}: {episode.what}" in text
        assert f"page-replay.html#t={episode.times_s[0]}&show=order%20{name}" in text


@pytest.mark.parametrize("overrides", [LATE, RESTING])  # who drives to a charger or rests waits for nobody
def test_heat_maps_add_up_to_the_table_of_robots(runs: Callable[..., Path], overrides: tuple[str, ...]) -> None:
    run = read_run(runs("examples/small", overrides, "trace"))
    assert run.floor is not None
    assert run.replay is not None
    assert sum(run.floor.waiting) == round(1000 * sum(row["waiting_s"] for row in run.robots)) > 0
    assert sum(run.floor.traffic) == sum(row["distance_m"] for row in run.robots) > 0
    traffic, waiting = heat_maps(run.replay.start, run.floor)
    assert traffic.classes[-1] == (6, f"{-(-max(run.floor.traffic) // 2) + 1:,} to {max(run.floor.traffic):,}")
    assert waiting.svg is not None
    assert waiting.svg.count("<text") == len(run.stations)
    assert "storage locations; robots may rest there" in run_page(run, 1, None)


def test_late_when_picked_and_when_packed_are_told_apart(runs: Callable[..., Path]) -> None:
    run = read_run(runs("examples/packing", (*PACKING, "instance.due={allowance_s=200}")))
    late, packed = (run.result.metrics[name] for name in ("late_orders", "late_packed"))
    assert (late, packed) == (5, 16)
    assert run.result.metrics["late_packed_percent"] == pytest.approx(100 * 16 / run.result.metrics["orders_packed"])
    page = run_page(run, 1, None)
    assert f"<h2>{late} orders picked late</h2>" in page
    assert f"Packed late, or due and not packed: {packed}." in page


def test_a_station_that_never_opened_has_no_shares(runs: Callable[..., Path]) -> None:
    run = read_run(runs("examples/packing", PACKING))
    one, *others = run.stations
    closed = one | dict.fromkeys(("busy_s", "waiting_s", "idle_s", "open_s"), 0.0) | {"down_s": 1800.0}
    page = run_page(evolve(run, stations=[closed, *others]), 1, None)
    name, _, _, *shares = table(page, "Stations and robots")[0][:7]
    assert (name, shares) == ("1 (never open)", ["-", "-", "-", "0.5 h"])
    assert "station 1: out of service" not in page


def test_without_a_trace_the_page_says_what_is_missing(runs: Callable[..., Path]) -> None:
    folder = runs("examples/packing", PACKING)
    assert exit_code("report", str(folder), "--quiet") == 0
    assert not (folder / "replay.html").exists()
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "because the run has no trace: <code>rmfs run --trace</code> records one." in page
    assert "<code>rmfs run --record-decisions</code> records it." in page
    assert "href" not in page
    packed = rows(folder / "packing.csv")
    shown = table(page, "Packing")
    assert sum(int(row[1]) for row in shown) == len(packed) == 20
    first = [row for row in packed if row["packing_station"] == "1"]
    took = fmean(float(row["packed_s"]) - float(row["packing_s"]) for row in first)
    assert (shown[0][0], shown[0][-1]) == ("1", f"{took:,.1f} s")
    before = (folder / "report.html").read_bytes()
    assert exit_code("report", str(folder), "--quiet") == 0
    assert (folder / "report.html").read_bytes() == before


@cases(
    "changes begin late left lead",
    ((), 0, 4, 0, "6 orders, 1 cancelled, all others complete at "),
    (("run.warmup_s=30",), 30, 2, 0, "6 orders, 1 cancelled, all others complete at "),
    (("run.until_s=90",), 0, 3, 3, "The run ended at its horizon at 0:01:30: 1 of 6 orders complete, 1 cancelled. "),
    (("run.until_s=90", "run.warmup_s=30"), 30, 1, 3, "The run ended at its horizon at 0:01:30: "),
    (("run.until_s=90", "run.warmup_s=100"), 100, 0, 3, "The run ended at its horizon at 0:01:30: "),
)
def test_headings_are_the_metrics(tmp_path, changes, begin, late, left, lead) -> None:
    (tmp_path / "orders.csv").write_text(DAY, encoding="utf-8")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\nP,tea,\nQ,ale,\n", encoding="utf-8")
    (tmp_path / "day.toml").write_text(HALL, encoding="utf-8")
    result = rmfs_core.run(load_scenario(str(tmp_path / "day.toml"), changes), out=tmp_path / "run")
    assert (result.metrics["late_orders"], result.metrics["open_orders_end"]) == (late, left)
    page = run_page(read_run(tmp_path / "run"), 10, "there.html")
    assert f'<p class="lead">{lead}' in page
    headings = {kind: int(number) for number, kind in re.findall(r"<h2>(\d+) (late|open) order", page)}
    assert (headings.get("late", 0), headings.get("open", 0)) == (late, left)
    peak = 'Largest backlog at the end of an hour: 2 orders, at <a href="there.html#t=90.0">0:01:30</a>.'
    assert (peak in page) is (left > 0)
    done = {row["order"] for row in result.orders if row["turnover_s"] and row["arrival_s"] >= begin}
    assert {row[0] for row in table(page, "Slowest orders")} == done


def _cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[:-40])


def _edit(old: str, new: str) -> Callable[[Path], None]:
    return lambda file: file.write_text(file.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")


@cases(
    "name, damage, told",
    ("result.json", Path.unlink, "has no result.json; expected the folder of a run"),
    ("result.json", _cut, "this is no valid JSON"),
    ("result.json", _edit('"says": [', '"says": 3, "said": ['), "contradict each other, so that it cannot be "),
    ("delays.csv", Path.unlink, "delays.csv: cannot be read: No such file or directory"),
    ("delays.csv", _edit("\n1,", "\nsomebody's,"), "has other orders than orders.csv"),
    ("hours.csv", _edit("backlog", "logback"), "hours.csv, line 1: has no column backlog"),
    ("hours.csv", _edit("\n0,", "\nnone,"), "hours.csv, line 2: the row is not as expected"),
    ("robots.csv", _edit("\n1,", "\n1,2,3,4,5,6,7,8,9,10,"), "robots.csv, line 2"),
    ("trace.jsonl.gz", _cut, "trace.jsonl.gz"),
    ("decisions.jsonl.gz", _cut, "decisions.jsonl.gz"),
)
def test_what_is_missing_or_damaged_is_refused(late, tmp_path, capsys, name, damage, told) -> None:
    folder = tmp_path / "run"
    shutil.copytree(late, folder)
    damage(folder / name)
    files = sorted(folder.iterdir())
    error = refused(capsys, main, ["report", str(folder)])
    assert re.fullmatch(r"Error: [^\n]+\n", error), error
    assert told in error
    assert sorted(folder.iterdir()) == files


@cases("taken", "page.html", "page-replay.html")
def test_page_and_replay_are_written_both_or_neither(late: Path, tmp_path: Path, taken: str) -> None:
    (tmp_path / taken).mkdir()
    assert exit_code("report", str(late), "--quiet", "--out", str(tmp_path / "page.html")) == 2
    assert [file.name for file in tmp_path.iterdir()] == [taken]


def test_bars_have_their_figures() -> None:
    text = chart("Picks <1>", [Series("picks", [0, 3, 8, 1])], 60, "s", marks={"mean": 90})
    assert text.count("<rect") == 3  # none for nothing
    assert "<title>180 to 240: 1 pick</title>" in text
    assert "<title>60 to 120: 3 picks</title>" in text
    heights = [float(height) for height in re.findall(r'<rect[^>]* height="([\d.]+)"', text)]
    assert heights[1] / heights[0] == pytest.approx(8 / 3, rel=0.01)
    assert "Picks &lt;1&gt;" in text
    assert ">mean</text>" in text
    shares = stacked(
        "Robots", ["a", "b"], [Series("idle", [1, 0]), Series("busy", [3, 0]), Series("off", [0, 0])], "robot"
    )
    assert "<title>robot a: busy 75.0 %</title>" in shares
    assert "off" not in shares
    assert [nice(least) for least in (0, 0.3, 1, 1.1, 20, 51, 4900)] == [1, 0.5, 1, 2, 20, 100, 5000]


def test_a_page_replaces_no_other_file(late: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "orders.csv"
    file.write_text("order", encoding="utf-8")
    (tmp_path / "hall.map").write_text("......\n......\n", encoding="utf-8")
    for command in (
        ("report", str(late), "--out", str(file)),
        ("scenario", "map", "examples/small", "--html", "--out", str(file)),
        ("plan", str(tmp_path / "hall.map"), "--agents", "2", "--html", str(file)),
    ):
        assert "exists, and is no page; expected a new name" in refused(capsys, main, command)
    assert file.read_text(encoding="utf-8") == "order"
    long = refused(capsys, main, ("scenario", "map", "examples/small", "--html", "--out", "x" * 300))
    assert "cannot be written: File name too long; expected the name of a new file" in long


def test_a_truck_of_the_next_day_leaves_a_day_later() -> None:
    assert [in_days(3600.0 * hours) for hours in (14, 38, 62)] == ["14:00:00", "14:00:00 +1 day", "14:00:00 +2 days"]
