"""Tutorial and how-to pages are true: every file is written, every command run, its output compared."""

import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

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
