"""tools/pages.py: what it makes of a page, and which pages it refuses."""

from __future__ import annotations

import runpy
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import psutil
import pytest

PAGES: dict[str, Any] = runpy.run_path(
    str(Path(__file__).resolve().parents[2] / "tools" / "pages.py"), run_name="pages"
)
done: Callable[..., str] = PAGES["done"]
PageError: type[Exception] = PAGES["PageError"]


def page(*lines: str) -> str:
    """Return a page of these lines; blocks are fenced with apostrophes for the eye."""
    return "\n".join(lines).replace("'''", "```") + "\n"


def test_files_are_written_and_commands_run(tmp_path: Path) -> None:
    """In the order of the page, in its folder; output that no line shows is not compared."""
    text = page(
        "'''{code-block} toml", ":caption: a/b.toml", "", "x = 1", "'''", "'''console", "$ cat a/b.toml", "x = 1", "'''"
    )
    assert done(text, tmp_path) == text
    assert (tmp_path / "a" / "b.toml").read_text() == "x = 1\n"
    done(page("'''console", "$ cat a/b.toml", "$ cat \\", "  a/b.toml", "x = 1", "'''"), tmp_path)


def test_what_is_shown_is_compared(tmp_path: Path) -> None:
    """The first command that prints something else is named with both outputs."""
    with pytest.raises(PageError, match=r"(?s)line 2: `echo new` prints.*new.*shows.*old"):
        done(page("'''console", "$ echo new", "old", "'''"), tmp_path)


def test_dots_stand_for_any_text(tmp_path: Path) -> None:
    """Within a line, and alone for any lines, none among them; but not for missing ones around."""
    matches = PAGES["matches"]
    assert matches("a ... c\n", "a b c\n") and matches("...\nc\n", "c\n") and matches("a\n...\n", "a\nb\nc\n")
    assert not matches("a ... c\n", "a b d\n") and not matches("...\nc\n", "c\nd\n") and not matches("a\n", "a\nb\n")


def test_codes_are_compared(tmp_path: Path) -> None:
    """A command that fails is an error, unless the page says so; and then success is one."""
    with pytest.raises(PageError, match="ended with 3, not 0"):
        done(page("'''console", "$ exit 3", "'''"), tmp_path)
    done(page("% exit 3", "'''console", "$ exit 3", "'''"), tmp_path)
    with pytest.raises(PageError, match="ended with 0, not 3"):
        done(page("% exit 3", "'''console", "$ true", "'''"), tmp_path)


def test_a_block_that_is_not_run_says_why(tmp_path: Path) -> None:
    """Code without a file's name is refused without a reason; drawings are not code."""
    with pytest.raises(PageError, match="a block of python needs a caption"):
        done(page("'''python", "x = 1", "'''"), tmp_path)
    done(page("% not run: a fragment", "'''python", "x = 1", "'''", "'''text", "#.#", "'''"), tmp_path)
    done(page("% not run: it fails", "'''console", "$ false", "'''"), tmp_path)


def test_what_takes_minutes_is_done_when_asked_for(tmp_path: Path) -> None:
    """Elsewhere it is left out, as if it were not there."""
    text = page("% long: it learns", "'''console", "$ echo new", "old", "'''")
    done(text, tmp_path)
    with pytest.raises(PageError, match="`echo new` prints"):
        done(text, tmp_path, long=True)


def test_output_is_renewed(tmp_path: Path) -> None:
    """Only what differs, and what was left out stays left out."""
    old = page("'''console", "$ echo same", "same", "$ printf '1\\n2\\n3 s\\n4\\n'", "...", "2", "... s", "5", "'''")
    new = page("'''console", "$ echo same", "same", "$ printf '1\\n2\\n3 s\\n4\\n'", "...", "2", "... s", "4", "'''")
    assert done(old, tmp_path, update=True) == new
    assert done(new, tmp_path, update=True) == new


def test_an_installed_package_is_the_pages_own(tmp_path: Path) -> None:
    """The command of rmfs is found, and python is another environment's than this one."""
    done(page("'''console", "$ rmfs --version", "rmfs, version ...", "'''"), tmp_path)
    done(page("'''console", "$ python -c 'import sys; print(sys.prefix != sys.base_prefix)'", "True", "'''"), tmp_path)


def test_what_runs_in_the_background_ends_with_the_page(tmp_path: Path) -> None:
    """It goes on from one command to the next, and no further, also where the page fails."""
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
