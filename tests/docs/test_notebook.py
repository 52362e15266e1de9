"""The notebook of the tutorial: it runs from top to bottom, and ends each part with what its text says is shown."""

import ast
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest

import rmfs_commands.replay
import rmfs_core
from rmfs_commands.cli.hall import Hall

FILE = Path(__file__).resolve().parents[2] / "docs" / "tutorial" / "notebook.ipynb"
CELLS: list[dict[str, Any]] = json.loads(FILE.read_text(encoding="utf-8"))["cells"]


@pytest.fixture
def drawing() -> Iterator[None]:
    before = plt.get_backend()
    plt.switch_backend("agg")
    yield
    plt.close("all")
    plt.switch_backend(before)


def done(text: str, names: dict[str, Any]) -> object:
    """Do a cell; return what its last line amounts to where that is an expression, and is not hidden by a semicolon."""
    *most, last = ast.parse(text).body
    if not isinstance(last, ast.Expr) or text.rstrip().endswith(";"):
        exec(compile(text, FILE.name, "exec"), names)
        return None
    exec(compile(ast.Module(most, []), FILE.name, "exec"), names)
    return eval(compile(ast.Expression(last.value), FILE.name, "eval"), names)


def test_it_runs_and_shows_what_it_says(tmp_path, monkeypatch, drawing, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "__main__"}
    shown = [done("".join(cell["source"]), names) for cell in CELLS if cell["cell_type"] == "code"]
    kinds = [type(one) for one in shown if hasattr(one, "_repr_html_")]
    assert kinds == [Hall, rmfs_core.Result, rmfs_commands.replay.Page]
    (axes,) = plt.gcf().axes
    assert len(axes.lines) == len(names["SEEDS"])
    better = zip(*reversed(names["visits"].values()), strict=True)
    assert all(few < many for few, many in better), "the text says that one sees which rules need fewer visits"
    assert capsys.readouterr().out.startswith(
        'argument rules.pps: rule "SmallestFirst" (__main__ object) does not decide'
    )


def test_it_is_kept_without_outputs() -> None:
    """These are made when the documentation is built; kept, they would grow stale."""
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in CELLS if cell["cell_type"] == "code")
