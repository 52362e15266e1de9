"""Tools that keep pages, pictures, tables of results and benchmarks as they should be."""

import csv
import json
import os
import re
import runpy
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import psutil
import pytest
from PIL import Image

from cases import cases
from lowest import constraints, main

PAGES: dict[str, Any] = runpy.run_path(
    str(Path(__file__).resolve().parents[2] / "tools" / "pages.py"), run_name="pages"
)
done: Callable[..., str] = PAGES["done"]
PageError: type[Exception] = PAGES["PageError"]


def page(*lines: str) -> str:
    """Return a page of these lines; blocks are fenced with apostrophes for the eye."""
    return "\n".join(lines).replace("'''", "```") + "\n"


def test_files_are_written_and_commands_run(tmp_path: Path) -> None:
    text = page(
        "'''{code-block} toml", ":caption: a/b.toml", "", "x = 1", "'''", "'''console", "$ cat a/b.toml", "x = 1", "'''"
    )
    assert done(text, tmp_path) == text
    assert (tmp_path / "a" / "b.toml").read_text() == "x = 1\n"
    done(page("'''console", "$ cat a/b.toml", "$ cat \\", "  a/b.toml", "x = 1", "'''"), tmp_path)


def test_what_is_shown_is_compared(tmp_path: Path) -> None:
    with pytest.raises(PageError, match=r"(?s)line 2: `echo new` prints.*new.*shows.*old"):
        done(page("'''console", "$ echo new", "old", "'''"), tmp_path)


def test_dots_stand_for_any_text(tmp_path: Path) -> None:
    matches = PAGES["matches"]
    assert matches("a ... c\n", "a b c\n") and matches("...\nc\n", "c\n") and matches("a\n...\n", "a\nb\nc\n")
    assert not matches("a ... c\n", "a b d\n") and not matches("...\nc\n", "c\nd\n") and not matches("a\n", "a\nb\n")


def test_codes_are_compared(tmp_path: Path) -> None:
    with pytest.raises(PageError, match="ended with 3, not 0"):
        done(page("'''console", "$ exit 3", "'''"), tmp_path)
    done(page("% exit 3", "'''console", "$ exit 3", "'''"), tmp_path)
    with pytest.raises(PageError, match="ended with 0, not 3"):
        done(page("% exit 3", "'''console", "$ true", "'''"), tmp_path)


def test_a_block_that_is_not_run_says_why(tmp_path: Path) -> None:
    with pytest.raises(PageError, match="a block of python needs a caption"):
        done(page("'''python", "x = 1", "'''"), tmp_path)
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
    started = page(
        "'''console", "$ sleep 60 > /dev/null 2>&1 & echo $! > pid", "$ kill -0 $(cat pid)", "$ false", "'''"
    )
    with pytest.raises(PageError, match="`false` ended with 1"):
        done(started, tmp_path)
    with suppress(psutil.NoSuchProcess):
        left = psutil.Process(int((tmp_path / "pid").read_text(encoding="utf-8")))
        until = time.monotonic() + 10
        while left.status() != psutil.STATUS_ZOMBIE:
            assert time.monotonic() < until
            time.sleep(0.01)


PICTURES = runpy.run_path(str(Path(__file__).resolve().parents[2] / "tools" / "pictures.py"), run_name="pictures")


def test_the_picture_shows_a_run_on_its_way_and_at_its_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    picture_of_run, call = PICTURES["picture_of_run"], PICTURES["call"]

    def call_small(arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
        ended: subprocess.CompletedProcess[str] = call(["run", "examples/small", "--set", "instance.orders=9"], folder)
        return ended

    monkeypatch.setitem(picture_of_run.__globals__, "call", call_small)
    drawn = picture_of_run(tmp_path)
    shown = re.sub(r"<[^>]*>", "", drawn).replace("&#160;", " ")
    places = [shown.index(text) for text in ("$ rmfs run paper-250", "Simulated time", "Makespan", "Results in")]
    assert places == sorted(places)
    assert "@font-face" not in drawn


@pytest.mark.slow
def test_the_picture_of_a_page_shows_it_when_it_is_drawn(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    draws = "document.body.style.background = location.hash === '#green' ? '#00ff00' : '#ff0000'"
    page.write_text(f"<!DOCTYPE html><body><script>setTimeout(() => {{ {draws} }}, 500)</script>", encoding="utf-8")
    PICTURES["picture_of_page"](page, "#green", (320, 200), tmp_path / "picture.png")
    with Image.open(tmp_path / "picture.png") as picture:
        assert picture.size == (320, 200)
        assert picture.convert("RGB").getpixel((160, 100)) == (0, 255, 0)


UPDATE_RESULTS = runpy.run_path(str(Path(__file__).resolve().parents[2] / "tools" / "update_results.py"))
REPORT = """# Title

- Command: `rmfs reproduce`
- Time: 40 min

## Overview

| a | b |
|---|---|
| 1 | 2 |

## Runs

| c |
|---|
| 3 |

## Figure 10: visits

The paper: fewer.

| d |
|---|
| 4 |

![Visits](visits.png)

## Figure 11: distances

| e |
|---|
| 5 |
"""


def test_report_and_plots_take_the_place_of_earlier_ones(tmp_path: Path) -> None:
    """The folder has the report and the plots that it shows, and nothing else."""
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
    line = "- Command: `rmfs reproduce --out somewhere --jobs 2`"
    assert (
        UPDATE_RESULTS["without_folder"](f"# Title\n\n{line}\n") == "# Title\n\n- Command: `rmfs reproduce --jobs 2`\n"
    )


def test_a_folder_without_a_report_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys) -> None:
    monkeypatch.setattr("sys.argv", ["update_results.py", str(tmp_path)])
    assert UPDATE_RESULTS["main"]() == 2
    assert "rmfs reproduce --out" in capsys.readouterr().err


UPDATE_COMPARISONS = runpy.run_path(str(Path(__file__).resolve().parents[2] / "tools" / "update_comparisons.py"))
FIGURES = {"good": (0.1, 10.0), "dear": (0.2, 5.0), "bad": (0.3, 20.0)}
"""Visits, and what all other figures are, by rule set; and one that was never done."""


def written(folder: Path) -> Path:
    """Return the folder of a comparison."""
    (folder / "plots").mkdir(parents=True)
    for name in ("psv_per_order", "distance_per_order_m"):
        (folder / "plots" / f"front.{name}.turnover_s.png").write_bytes(name.encode())
    columns = ("instances", "metric", "rule_set", "mean", "times_bound", "runs", "complete")
    with (folder / "summary.csv").open("w", encoding="utf-8", newline="") as stream:
        rows = csv.writer(stream)
        rows.writerow(columns)
        for instances in ("scenario=small", "overall"):
            for metric in UPDATE_COMPARISONS["COLUMNS"]:
                for rule_set, (visits, other) in FIGURES.items():
                    mean = visits if metric == "psv_per_order" else other
                    rows.writerow((instances, metric, rule_set, mean, 1.5, 3, 3))
                rows.writerow((instances, metric, "never", "", "", 3, 1))
    return folder


def test_a_table_for_each_instance_set(tmp_path: Path) -> None:
    league = tmp_path / "league"
    UPDATE_COMPARISONS["update"](written(tmp_path / "all"), tmp_path)
    lines = (league / "all.md").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if line.startswith("#")] == ["### small"]
    assert [line.split(" | ") for line in lines[-4:]] == [
        ["| good", "0.100", "10.0", "10", "10", "10", "1.50", "1.50", "0", "visits |"],
        ["| dear", "0.200", "5.0", "5", "5", "5", "1.50", "1.50", "0", "visits, metres |"],
        ["| bad", "0.300", "20.0", "20", "20", "20", "1.50", "1.50", "0", " |"],
        ["| never", *"-----", "-", "-", "2", " |"],
    ]
    pictures = {path.name: path.read_bytes() for path in league.glob("*.png")}
    assert pictures == {
        "all-psv_per_order-turnover_s.png": b"psv_per_order",
        "all-distance_per_order_m-turnover_s.png": b"distance_per_order_m",
    }


def test_a_study_says_what_rule_sets_change(tmp_path: Path) -> None:
    folder = tmp_path / "rules"
    folder.mkdir()
    columns = ("instances", "metric", "rule_set", "baseline", "mean", "runs", "relative", "low", "high")
    with (folder / "summary.csv").open("w", encoding="utf-8", newline="") as stream:
        rows = csv.writer(stream)
        rows.writerow(column if column not in ("low", "high") else f"relative_{column}_holm" for column in columns)
        for instances in ("robots=8", "robots=16", "overall"):
            rows.writerow((instances, "turnover_s", "plain", "plain", 900.2, 5, "", "", ""))
            rows.writerow((instances, "turnover_s", "clever", "plain", 800.2, 5, -0.111, -0.2, 0.004))
    UPDATE_COMPARISONS["update"](folder, tmp_path)
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


def test_other_folders_are_refused(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.setattr("sys.argv", ["update_comparisons.py", str(tmp_path)])
    assert UPDATE_COMPARISONS["main"]() == 2
    assert "expected folders that" in capsys.readouterr().err


COMPARE_BENCHMARKS = Path(__file__).resolve().parents[2] / "tools" / "compare_benchmarks.py"


def stats(median: float, spread: float = 0.02, rounds: int = 20) -> dict[str, Any]:
    """Rounds around a median, their quartiles a share ``spread`` above and below it."""
    return {"rounds": rounds, "median": median, "q1": median * (1 - spread), "q3": median * (1 + spread)}


def compare(folder: Path, before: Any, after: Any, *options: str) -> tuple[int, str, str]:
    """Save two results and compare them: exit code, output, errors."""
    for name, benchmarks in (("before", before), ("after", after)):
        saved = benchmarks
        if isinstance(benchmarks, dict):
            saved = {"benchmarks": [{"fullname": test, "stats": stats} for test, stats in benchmarks.items()]}
        text = saved if isinstance(saved, str) else json.dumps(saved)
        (folder / f"{name}.json").write_text(text, encoding="utf-8")
    files = [str(folder / "before.json"), str(folder / "after.json")]
    done = subprocess.run(
        [sys.executable, str(COMPARE_BENCHMARKS), *options, *files], capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout, done.stderr


def test_slower(tmp_path: Path) -> None:
    code, out, _ = compare(tmp_path, {"a": stats(0.010), "b": stats(2.0)}, {"a": stats(0.013), "b": stats(2.0)})
    assert code == 1
    assert out.splitlines() == [
        "slower: a: 10 ms -> 13 ms (1.30 times)",
        "2 benchmarks in both: 1 slower, 0 faster, 1 same.",
    ]


def test_the_slowest_first(tmp_path: Path) -> None:
    before = {name: stats(1.0) for name in "abc"}
    _, out, _ = compare(tmp_path, before, {"a": stats(1.5), "b": stats(3.0), "c": stats(2.0)})
    assert [line.split(":")[1] for line in out.splitlines()[:3]] == [" b", " c", " a"]


def test_noise(tmp_path: Path) -> None:
    code, out, _ = compare(tmp_path, {"a": stats(1.0, spread=0.2)}, {"a": stats(1.3, spread=0.2)})
    assert (code, out) == (0, "1 benchmarks in both: 0 slower, 0 faster, 1 same.\n")


def test_what_moves_a_whole_run(tmp_path: Path) -> None:
    before, after = {"a": stats(1.0, spread=0.001)}, {"a": stats(1.05, spread=0.001)}
    assert compare(tmp_path, before, after)[0] == 0
    assert compare(tmp_path, before, after, "--threshold", "0.03")[0] == 1


def test_faster(tmp_path: Path) -> None:
    code, out, _ = compare(tmp_path, {"a": stats(3e-6)}, {"a": stats(1e-6)})
    assert code == 0
    assert "faster: a: 3 us -> 1 us (0.33 times)" in out


def test_too_few_rounds_to_judge(tmp_path: Path) -> None:
    code, out, _ = compare(tmp_path, {"a": stats(1.0, rounds=1)}, {"a": stats(9.0, rounds=1)})
    assert code == 0
    assert "not judged, fewer than 5 rounds: a" in out


def test_benchmarks_that_come_and_go(tmp_path: Path) -> None:
    code, out, _ = compare(tmp_path, {"a": stats(1.0), "b": stats(1.0)}, {"a": stats(1.0), "c": stats(1.0)})
    assert code == 0
    assert out.splitlines() == ["only before: b", "only after: c", "1 benchmarks in both: 0 slower, 0 faster, 1 same."]


@cases(
    "before problem",
    ("{", "before.json: this is no JSON"),
    ([], "before.json: expected a result that pytest-benchmark saved"),
    ({"a": {"rounds": 9}}, "before.json, benchmarks[0]: this is no saved benchmark: 'median'"),
    ({"a": stats(0.0)}, "median and quartiles are no positive numbers in order"),
    ({"a": stats(1.0) | {"q1": 2.0}}, "median and quartiles are no positive numbers in order"),
    ({"a": stats(1.0) | {"q3": "many"}}, "this is no saved benchmark"),
    ({"a": stats(1.0) | {"rounds": "many"}}, "this is no saved benchmark"),
)
def test_files_that_are_no_results(tmp_path: Path, before: Any, problem: str) -> None:
    code, out, err = compare(tmp_path, before, {})
    assert (code, out) == (2, "")
    assert problem in err
    assert len(err.splitlines()) == 1


def test_a_missing_file_and_a_wrong_threshold(tmp_path: Path) -> None:
    run = [sys.executable, str(COMPARE_BENCHMARKS), str(tmp_path / "x.json"), str(tmp_path / "y.json")]
    done = subprocess.run(run, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "x.json: cannot be read: No such file or directory" in done.stderr
    assert compare(tmp_path, {}, {}, "--threshold", "-1")[0] == 2


def test_what_pytest_benchmark_saves(tmp_path: Path) -> None:
    (tmp_path / "test_x.py").write_text("def test_x(benchmark):\n    benchmark(sum, [1, 2])\n", encoding="utf-8")
    saved = tmp_path / "saved.json"
    options = ["-q", "-p", "no:cacheprovider", "--benchmark-only", f"--benchmark-json={saved}"]
    alone = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    command = [sys.executable, "-m", "pytest", *options, "test_x.py"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, env=alone)
    done = subprocess.run(
        [sys.executable, str(COMPARE_BENCHMARKS), saved, saved], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, "1 benchmarks in both: 0 slower, 0 faster, 1 same.\n")


PYPROJECT = """
[project]
dependencies = ["numpy>=1.26", "numba>=0.59,<0.69", "lazy-loader >= 0.4"]
[project.optional-dependencies]
serve = ["uvicorn>=0.30"]
test = ["pytest>=8", "rmfs[serve]"]
"""


def test_each_dependency_at_its_lower_bound() -> None:
    assert constraints(PYPROJECT) == ["numpy==1.26", "numba==0.59", "lazy-loader==0.4", "uvicorn==0.30"]


def test_a_dependency_without_a_lower_bound_is_refused() -> None:
    with pytest.raises(ValueError, match=r'"numpy<3" has no lower bound; expected one such as "numpy>=1.26"'):
        constraints(PYPROJECT.replace(">=1.26", "<3"))


def test_those_of_the_checkout_are_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert "attrs==" in capsys.readouterr().out
    (tmp_path / "pyproject.toml").write_text(PYPROJECT)
    assert main([str(tmp_path / "pyproject.toml")]) == 0
    assert capsys.readouterr().out == "numpy==1.26\nnumba==0.59\nlazy-loader==0.4\nuvicorn==0.30\n"
