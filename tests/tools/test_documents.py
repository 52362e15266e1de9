"""Tools that keep pages, pictures, tables of results and benchmarks as they should be."""

import csv
import json
import os
import runpy
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any

import psutil
import pytest
from PIL import Image

import releases
from calling import refused
from cases import cases
from lowest import constraints, main

TOOLS = Path(__file__).resolve().parents[2] / "tools"
PAGES: dict[str, Any] = runpy.run_path(str(TOOLS / "pages.py"), run_name="pages")
done: Callable[..., str] = PAGES["done"]
PageError: type[Exception] = PAGES["PageError"]


def page(*lines: str) -> str:
    """Return a page of these lines; blocks are fenced with apostrophes for the eye."""
    return "\n".join(lines).replace("'''", "```") + "\n"


def test_files_are_written_and_commands_run(tmp_path: Path) -> None:
    shown = ("'''console", "$ cat a/b.toml", "x = 1", "'''")
    text = page("'''{code-block} toml", ":caption: a/b.toml", "", "x = 1", "'''", *shown)
    assert done(text, tmp_path) == text
    assert (tmp_path / "a" / "b.toml").read_text() == "x = 1\n"
    done(page("'''console", "$ cat a/b.toml", "$ cat \\", "  a/b.toml", "x = 1", "'''"), tmp_path)


@cases(
    "lines problem",
    (("'''console", "$ echo new", "old", "'''"), r"(?s)line 2: `echo new` prints.*new.*shows.*old"),
    (("'''console", "$ exit 3", "'''"), "ended with 3, not 0"),
    (("% exit 3", "'''console", "$ true", "'''"), "ended with 0, not 3"),
    (("'''python", "x = 1", "'''"), "a block of python needs a caption"),
)
def test_what_a_page_shows_that_is_not_so(tmp_path: Path, lines: tuple[str, ...], problem: str) -> None:
    with pytest.raises(PageError, match=problem):
        done(page(*lines), tmp_path)


def test_dots_stand_for_any_text(tmp_path: Path) -> None:
    matches = PAGES["matches"]
    assert matches("a ... c\n", "a b c\n") and matches("...\nc\n", "c\n") and matches("a\n...\n", "a\nb\nc\n")
    assert not matches("a ... c\n", "a b d\n") and not matches("...\nc\n", "c\nd\n") and not matches("a\n", "a\nb\n")


def test_codes_are_compared_and_blocks_left_out_with_their_reason(tmp_path: Path) -> None:
    done(page("% exit 3", "'''console", "$ exit 3", "'''"), tmp_path)
    done(page("% not run: a fragment", "'''python", "x = 1", "'''", "'''text", "#.#", "'''"), tmp_path)
    done(page("% not run: it fails", "'''console", "$ false", "'''"), tmp_path)


def test_what_takes_minutes_is_done_when_asked_for(tmp_path: Path) -> None:
    text = page("% long: it learns", "'''console", "$ echo new", "old", "'''")
    done(text, tmp_path)
    with pytest.raises(PageError, match="`echo new` prints"):
        done(text, tmp_path, long=True)


def test_output_is_renewed(tmp_path: Path) -> None:
    old = page("'''console", "$ echo same", "same", "$ printf '1\\n2\\n3 s\\n4\\n'", "...", "2", "... s", "5", "'''")
    new = page("'''console", "$ echo same", "same", "$ printf '1\\n2\\n3 s\\n4\\n'", "...", "2", "... s", "4", "'''")
    assert done(old, tmp_path, update=True) == new
    assert done(new, tmp_path, update=True) == new


def test_an_installed_package_is_the_pages_own(tmp_path: Path) -> None:
    done(page("'''console", "$ rmfs --version", "rmfs, version ...", "'''"), tmp_path)
    done(page("'''console", "$ python -c 'import sys; print(sys.prefix != sys.base_prefix)'", "True", "'''"), tmp_path)


def test_what_runs_in_the_background_ends_with_the_page(tmp_path: Path) -> None:
    sleeps = "$ sleep 60 > /dev/null 2>&1 & echo $! > pid"
    started = page("'''console", sleeps, "$ kill -0 $(cat pid)", "$ false", "'''")
    with pytest.raises(PageError, match="`false` ended with 1"):
        done(started, tmp_path)
    with suppress(psutil.NoSuchProcess):
        left = psutil.Process(int((tmp_path / "pid").read_text(encoding="utf-8")))
        until = time.monotonic() + 10
        while left.status() != psutil.STATUS_ZOMBIE:
            assert time.monotonic() < until
            time.sleep(0.01)


PICTURES = runpy.run_path(str(TOOLS / "pictures.py"), run_name="pictures")


@pytest.mark.slow
def test_the_picture_of_a_page_shows_it_when_it_is_drawn(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    draws = "document.body.style.background = location.hash === '#green' ? '#00ff00' : '#ff0000'"
    page.write_text(f"<!DOCTYPE html><body><script>setTimeout(() => {{ {draws} }}, 500)</script>", encoding="utf-8")
    PICTURES["picture_of_page"](page, "#green", (320, 200), tmp_path / "picture.png")
    with Image.open(tmp_path / "picture.png") as picture:
        assert picture.size == (320, 200)
        assert picture.convert("RGB").getpixel((160, 100)) == (0, 255, 0)


UPDATE_RESULTS = runpy.run_path(str(TOOLS / "update_results.py"))
REPORT = "# Title\n\n![Visits](visits.png)\n"


def test_report_and_plots_take_the_place_of_earlier_ones(tmp_path: Path) -> None:
    source, reports = tmp_path / "out", tmp_path / "reports"
    source.mkdir()
    reports.mkdir()
    (source / "report.md").write_text(REPORT)
    (source / "visits.png").write_bytes(b"new")
    (source / "unseen.png").write_bytes(b"new")
    (reports / "old.png").write_bytes(b"old")
    UPDATE_RESULTS["update"](reports, source)
    assert sorted(path.name for path in reports.iterdir()) == ["report.md", "visits.png"]
    assert (reports / "report.md").read_text() == REPORT


def test_the_folder_of_a_machine_is_left_out() -> None:
    text = "# Title\n\n- Command: `rmfs reproduce --out somewhere --jobs 2`\n"
    assert UPDATE_RESULTS["without_folder"](text) == text.replace(" --out somewhere", "")


UPDATE_COMPARISONS = runpy.run_path(str(TOOLS / "update_comparisons.py"))
FIGURES = {"good": (0.1, 10.0), "dear": (0.2, 5.0), "bad": (0.3, 20.0)}
"""Visits, and what all other figures are, by rule set; and one that was never done."""
BOUNDS = {"psv_per_order": 1.5, "distance_per_order_m": "", "turnover_s": 1.5, "packed_s": ""}
"""How many times the bound each metric is; empty: a metric without bound."""


def summarised(folder: Path, columns: str, rows: list[tuple[object, ...]]) -> Path:
    """Return the folder of a comparison with a summary."""
    folder.mkdir()
    with (folder / "summary.csv").open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream).writerows([columns.split(), *rows])
    return folder


def test_a_table_for_each_instance_set(tmp_path: Path) -> None:
    league, rows = tmp_path / "league", list[tuple[object, ...]]()
    for instances, (metric, bound) in product(("scenario=small", "overall"), BOUNDS.items()):
        for rule_set, (visits, other) in FIGURES.items():
            rows.append((instances, metric, rule_set, visits if metric == "psv_per_order" else other, bound, 3, 3))
        rows.append((instances, metric, "never", "", "", 3, 1))
    folder = summarised(tmp_path / "all", "instances metric rule_set mean times_bound runs complete", rows)
    (folder / "plots").mkdir()
    for name in ("psv_per_order", "distance_per_order_m"):
        (folder / "plots" / f"front.{name}.turnover_s.png").write_bytes(name.encode())
    UPDATE_COMPARISONS["update"](folder, tmp_path)
    lines = (league / "all.md").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if line.startswith("#")] == ["### small"]
    assert [line.split(" | ") for line in lines[-4:]] == [
        ["| good", "0.100", "10.0", "10", "10", "1.50", "1.50", "0", "visits |"],
        ["| dear", "0.200", "5.0", "5", "5", "1.50", "1.50", "0", "visits, metres |"],
        ["| bad", "0.300", "20.0", "20", "20", "1.50", "1.50", "0", " |"],
        ["| never", *"----", "-", "-", "2", " |"],
    ]
    pictures = {path.name: path.read_bytes() for path in league.glob("*.png")}
    assert pictures == {
        "all-psv_per_order-turnover_s.png": b"psv_per_order",
        "all-distance_per_order_m-turnover_s.png": b"distance_per_order_m",
    }


def test_a_study_says_what_rule_sets_change(tmp_path: Path) -> None:
    columns = "instances metric rule_set baseline mean runs relative relative_low_holm relative_high_holm"
    rows: list[tuple[object, ...]] = []
    for instances in ("robots=8", "robots=16", "overall"):
        rows.append((instances, "turnover_s", "plain", "plain", 900.2, 5, "", "", ""))
        rows.append((instances, "turnover_s", "clever", "plain", 800.2, 5, -0.111, -0.2, 0.004))
    UPDATE_COMPARISONS["update"](summarised(tmp_path / "rules", columns, rows), tmp_path)
    assert (tmp_path / "study" / "rules.md").read_text(encoding="utf-8").replace("\u00a0", " ").splitlines() == [
        "### Against plain, 5 runs each",
        "",
        "| Rule set | Turn-over |",
        "| --- | ---: |",
        "| clever | -11 % [-20, +0] |",
        "",
        "### Turn-over (s)",
        "",
        "|  | plain | clever |",
        "| --- | ---: | ---: |",
        "| 8 | 900 | -11 % [-20, +0] |",
        "| 16 | 900 | -11 % [-20, +0] |",
    ]


@cases("tool problem", (UPDATE_RESULTS, "rmfs reproduce --out"), (UPDATE_COMPARISONS, "expected folders that"))
def test_other_folders_are_refused(tmp_path: Path, monkeypatch, capsys, tool: dict[str, Any], problem: str) -> None:
    monkeypatch.setattr("sys.argv", ["update.py", str(tmp_path)])
    assert tool["main"]() == 2
    assert problem in capsys.readouterr().err


COMPARE_BENCHMARKS = TOOLS / "compare_benchmarks.py"
compare_benchmarks: Callable[..., int] = runpy.run_path(str(COMPARE_BENCHMARKS))["main"]


def stats(median: float, spread: float = 0.02, rounds: int = 20) -> dict[str, Any]:
    """Rounds around a median, their quartiles a share ``spread`` above and below it."""
    return {"rounds": rounds, "median": median, "q1": median * (1 - spread), "q3": median * (1 + spread)}


def saved(file: Path, content: Any) -> str:
    """Save a text, or benchmarks as pytest-benchmark does; None is no file."""
    if isinstance(content, dict):
        content = {"benchmarks": [{"fullname": test, "stats": stats} for test, stats in content.items()]}
    if content is not None:
        file.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return str(file)


def in_both(slower: int = 0, faster: int = 0, same: int = 0, number: int = 1) -> str:
    return f"{number} benchmarks in both: {slower} slower, {faster} faster, {same} same."


QUIET = {"a": stats(1.0, spread=0.001)}, {"a": stats(1.05, spread=0.001)}
"""Two runs that differ by 5 % as a whole."""


@cases(
    "before after options code told",
    (
        {"a": stats(0.010), "b": stats(2.0)},
        {"a": stats(0.013), "b": stats(2.0)},
        *((), 1, ["slower: a: 10 ms -> 13 ms (1.30 times)", in_both(slower=1, same=1, number=2)]),
    ),
    (
        {name: stats(1.0) for name in "ab"},
        {"a": stats(1.5), "b": stats(3.0)},  # the slowest first
        *((), 1, ["slower: b: 1 s -> 3 s (3.00 times)", "slower: a: 1 s -> 1.5 s (1.50 times)", in_both(2, number=2)]),
    ),
    ({"a": stats(1.0, spread=0.2)}, {"a": stats(1.3, spread=0.2)}, (), 0, [in_both(same=1)]),  # noise
    (*QUIET, (), 0, [in_both(same=1)]),
    (*QUIET, ("--threshold", "0.03"), 1, ["slower: a: 1 s -> 1.05 s (1.05 times)", in_both(1)]),
    ({"a": stats(3e-6)}, {"a": stats(1e-6)}, (), 0, ["faster: a: 3 us -> 1 us (0.33 times)", in_both(faster=1)]),
    (
        {"a": stats(1.0, rounds=1)},
        {"a": stats(9.0, rounds=1)},
        *((), 0, ["not judged, fewer than 5 rounds: a", in_both()]),
    ),
    (
        {"a": stats(1.0), "b": stats(1.0)},
        {"a": stats(1.0), "c": stats(1.0)},
        *((), 0, ["only before: b", "only after: c", in_both(same=1)]),
    ),
)
def test_benchmarks_are_compared(tmp_path: Path, capsys, before, after, options, code, told) -> None:
    files = (saved(tmp_path / "before.json", before), saved(tmp_path / "after.json", after))
    assert compare_benchmarks([*options, *files]) == code
    assert capsys.readouterr().out.splitlines() == told


@cases(
    "before problem",
    (None, "before.json: cannot be read: No such file or directory"),
    ("{", "before.json: this is no JSON"),
    ([], "before.json: expected a result that pytest-benchmark saved"),
    ({"a": {"rounds": 9}}, "before.json, benchmarks[0]: this is no saved benchmark: 'median'"),
    ({"a": stats(1.0) | {"q1": 2.0}}, "median and quartiles are no positive numbers in order"),
    ({"a": stats(1.0) | {"rounds": "many"}}, "this is no saved benchmark"),
)
def test_files_that_are_no_results(tmp_path: Path, capsys, before: Any, problem: str) -> None:
    assert compare_benchmarks([saved(tmp_path / "before.json", before), saved(tmp_path / "after.json", {})]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert problem in err
    assert len(err.splitlines()) == 1
    assert "expected a threshold >= 0" in refused(capsys, compare_benchmarks, ["--threshold", "-1", "x", "y"])


def test_what_pytest_benchmark_saves(tmp_path: Path) -> None:
    (tmp_path / "test_x.py").write_text("def test_x(benchmark):\n    benchmark(sum, [1, 2])\n", encoding="utf-8")
    file = tmp_path / "saved.json"
    options = ["-q", "-p", "no:cacheprovider", "--benchmark-only", f"--benchmark-json={file}"]
    alone = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    command = [sys.executable, "-m", "pytest", *options, "test_x.py"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, env=alone)
    done = subprocess.run(
        [sys.executable, str(COMPARE_BENCHMARKS), file, file], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, "1 benchmarks in both: 0 slower, 0 faster, 1 same.\n")


@pytest.fixture
def history(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "history.json"
    file.write_text(json.dumps({"1.0": {"load": 5.0, "other": 5.0}, "1.1": {"load": 10.0}}), encoding="utf-8")
    monkeypatch.setattr(releases, "HISTORY", file)


@pytest.mark.usefixtures("history")
@cases(
    "name measured least said",
    ("load", [10.9], 10.9, None),
    ("load", [12.0, 10.5], 10.5, None),  # what seems slower is measured again
    ("load", [12.0, 11.5, 13.0], 11.5, "slower: load: 10.0 yardsticks in 1.1, 11.5 now (1.15 times)"),
    ("other", [99.0], 99.0, None),  # which the last release does not have
)
def test_what_is_slower_than_in_the_last_release_is_named(name, measured, least, said) -> None:
    left = iter(measured)
    assert releases.held_against_release(name, lambda: next(left)) == (least, said)
    assert list(left) == []


PYPROJECT = """
[project]
dependencies = ["numpy>=1.26", "numba>=0.59,<0.69", "lazy-loader >= 0.4"]
[project.optional-dependencies]
serve = ["uvicorn>=0.30"]
test = ["pytest>=8", "rmfs[serve]"]
"""


def test_a_dependency_without_a_lower_bound_is_refused() -> None:
    with pytest.raises(ValueError, match=r'"numpy<3" has no lower bound; expected one such as "numpy>=1.26"'):
        constraints(PYPROJECT.replace(">=1.26", "<3"))


def test_those_of_the_checkout_are_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert "attrs==" in capsys.readouterr().out
    (tmp_path / "pyproject.toml").write_text(PYPROJECT)
    assert main([str(tmp_path / "pyproject.toml")]) == 0
    assert capsys.readouterr().out == "numpy==1.26\nnumba==0.59\nlazy-loader==0.4\nuvicorn==0.30\n"
