"""Pages are true: every file is written, every command run, its output compared, and the notebook runs as it says."""

import ast
import json
import runpy
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest

import rmfs_commands.replay
import rmfs_core
from rmfs_commands.cli.hall import Hall

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES: dict[str, Any] = runpy.run_path(str(ROOT / "tools" / "pages.py"), run_name="pages")
done: Callable[..., str] = PAGES["done"]


def pages() -> list[Any]:
    """Return the pages of tutorial and how-to: the first are tried with the quick tests, unless they take long."""
    found = sorted([*(DOCS / "tutorial").glob("*.md"), *(DOCS / "how-to").glob("*.md")])
    marked = {True: [pytest.mark.slow], False: []}
    texts = {path: path.read_text(encoding="utf-8") for path in found}
    return [
        pytest.param(texts[path], id=path.relative_to(DOCS).as_posix(), marks=marked[_is_slow(path, texts[path])])
        for path in found
    ]


def _is_slow(path: Path, text: str) -> bool:
    return path.parent.name != "tutorial" or bool(PAGES["slow"](text))


@pytest.mark.parametrize("page", pages())
def test_a_page_does_what_it_says(page: str, tmp_path: Path) -> None:
    done(page, tmp_path)


NOTEBOOK = DOCS / "tutorial" / "notebook.ipynb"
CELLS: list[dict[str, Any]] = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]


@pytest.fixture
def drawing() -> Iterator[None]:
    before = plt.get_backend()
    plt.switch_backend("agg")
    yield
    plt.close("all")
    plt.switch_backend(before)


def result_of(text: str, names: dict[str, Any]) -> object:
    """Do a cell; return what its last line amounts to where that is an expression, and is not hidden by a semicolon."""
    *most, last = ast.parse(text).body
    if not isinstance(last, ast.Expr) or text.rstrip().endswith(";"):
        exec(compile(text, NOTEBOOK.name, "exec"), names)
        return None
    exec(compile(ast.Module(most, []), NOTEBOOK.name, "exec"), names)
    return eval(compile(ast.Expression(last.value), NOTEBOOK.name, "eval"), names)


def test_the_notebook_runs_and_shows_what_it_says(tmp_path, monkeypatch, drawing, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "__main__"}
    shown = [result_of("".join(cell["source"]), names) for cell in CELLS if cell["cell_type"] == "code"]
    kinds = [type(one) for one in shown if hasattr(one, "_repr_html_")]
    assert kinds == [Hall, rmfs_core.Result, rmfs_commands.replay.Page]
    (axes,) = plt.gcf().axes
    assert len(axes.lines) == len(names["SEEDS"])
    better = zip(*reversed(names["visits"].values()), strict=True)
    assert all(few < many for few, many in better), "the text says that one sees which rules need fewer visits"
    assert capsys.readouterr().out.startswith(
        'argument rules.pps: rule "SmallestFirst" (__main__ object) does not decide'
    )


def test_the_notebook_is_kept_without_outputs() -> None:
    """These are made when the documentation is built; kept, they would grow stale."""
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in CELLS if cell["cell_type"] == "code")
