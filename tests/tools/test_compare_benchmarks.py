"""Two saved benchmark results held against each other."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

TOOL = Path(__file__).resolve().parents[2] / "tools" / "compare_benchmarks.py"


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
    done = subprocess.run([sys.executable, str(TOOL), *options, *files], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def test_slower(tmp_path: Path) -> None:
    """What is slower beyond the spread of the rounds is named with its medians; exit code 1."""
    code, out, _ = compare(tmp_path, {"a": stats(0.010), "b": stats(2.0)}, {"a": stats(0.013), "b": stats(2.0)})
    assert code == 1
    assert out.splitlines() == [
        "slower: a: 10 ms -> 13 ms (1.30 times)",
        "2 benchmarks in both: 1 slower, 0 faster, 1 same.",
    ]


def test_the_slowest_first(tmp_path: Path) -> None:
    """What grew most comes first."""
    before = {name: stats(1.0) for name in "abc"}
    _, out, _ = compare(tmp_path, before, {"a": stats(1.5), "b": stats(3.0), "c": stats(2.0)})
    assert [line.split(":")[1] for line in out.splitlines()[:3]] == [" b", " c", " a"]


def test_noise(tmp_path: Path) -> None:
    """The same medians, but rounds that differ as much among themselves: that is no change."""
    code, out, _ = compare(tmp_path, {"a": stats(1.0, spread=0.2)}, {"a": stats(1.3, spread=0.2)})
    assert (code, out) == (0, "1 benchmarks in both: 0 slower, 0 faster, 1 same.\n")


def test_what_moves_a_whole_run(tmp_path: Path) -> None:
    """A few percent are no change, however little the rounds differ, unless a lower threshold is asked for."""
    before, after = {"a": stats(1.0, spread=0.001)}, {"a": stats(1.05, spread=0.001)}
    assert compare(tmp_path, before, after)[0] == 0
    assert compare(tmp_path, before, after, "--threshold", "0.03")[0] == 1


def test_faster(tmp_path: Path) -> None:
    """What became faster is named, and is no reason to fail."""
    code, out, _ = compare(tmp_path, {"a": stats(3e-6)}, {"a": stats(1e-6)})
    assert code == 0
    assert "faster: a: 3 us -> 1 us (0.33 times)" in out


def test_too_few_rounds_to_judge(tmp_path: Path) -> None:
    """A single round has no spread: it is named, whatever its time."""
    code, out, _ = compare(tmp_path, {"a": stats(1.0, rounds=1)}, {"a": stats(9.0, rounds=1)})
    assert code == 0
    assert "not judged, fewer than 5 rounds: a" in out


def test_benchmarks_that_come_and_go(tmp_path: Path) -> None:
    """What only one of the files has is named."""
    code, out, _ = compare(tmp_path, {"a": stats(1.0), "b": stats(1.0)}, {"a": stats(1.0), "c": stats(1.0)})
    assert code == 0
    assert out.splitlines() == [
        "only before: b",
        "only after: c",
        "1 benchmarks in both: 0 slower, 0 faster, 1 same.",
    ]


@pytest.mark.parametrize(
    ("before", "problem"),
    [
        ("{", "before.json: this is no JSON"),
        ([], "before.json: expected a result that pytest-benchmark saved"),
        ({"a": {"rounds": 9}}, "before.json, benchmarks[0]: this is no saved benchmark: 'median'"),
        ({"a": stats(0.0)}, "median and quartiles are no positive numbers in order"),
        ({"a": stats(1.0) | {"q1": 2.0}}, "median and quartiles are no positive numbers in order"),
        ({"a": stats(1.0) | {"q3": "many"}}, "this is no saved benchmark"),
        ({"a": stats(1.0) | {"rounds": "many"}}, "this is no saved benchmark"),
    ],
)
def test_files_that_are_no_results(tmp_path: Path, before: Any, problem: str) -> None:
    """Anything else is one sentence with the place; exit code 2."""
    code, out, err = compare(tmp_path, before, {})
    assert (code, out) == (2, "")
    assert problem in err
    assert len(err.splitlines()) == 1


def test_a_missing_file_and_a_wrong_threshold(tmp_path: Path) -> None:
    """Both are wrong input."""
    run = [sys.executable, str(TOOL), str(tmp_path / "x.json"), str(tmp_path / "y.json")]
    done = subprocess.run(run, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "x.json: cannot be read: No such file or directory" in done.stderr
    assert compare(tmp_path, {}, {}, "--threshold", "-1")[0] == 2


def test_what_pytest_benchmark_saves(tmp_path: Path) -> None:
    """A file that pytest-benchmark has written is read, and compared with itself nothing has changed."""
    (tmp_path / "test_x.py").write_text("def test_x(benchmark):\n    benchmark(sum, [1, 2])\n", encoding="utf-8")
    saved = tmp_path / "saved.json"
    options = ["-q", "-p", "no:cacheprovider", "--benchmark-only", f"--benchmark-json={saved}"]
    alone = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    command = [sys.executable, "-m", "pytest", *options, "test_x.py"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, env=alone)
    done = subprocess.run([sys.executable, str(TOOL), saved, saved], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "1 benchmarks in both: 0 slower, 0 faster, 1 same.\n")
