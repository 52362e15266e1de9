"""tools/pictures.py: the picture of a run."""

import re
import runpy
import subprocess
from pathlib import Path

import pytest
from PIL import Image

TOOL = runpy.run_path(str(Path(__file__).resolve().parents[2] / "tools" / "pictures.py"), run_name="pictures")


def test_the_picture_shows_a_run_on_its_way_and_at_its_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a small run here: the command, the live display, the summary; and no font is asked of the network."""
    picture_of_run, call = TOOL["picture_of_run"], TOOL["call"]

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
    """What a script draws is in it, and so is what the address asks for."""
    page = tmp_path / "page.html"
    draws = "document.body.style.background = location.hash === '#green' ? '#00ff00' : '#ff0000'"
    page.write_text(f"<!DOCTYPE html><body><script>setTimeout(() => {{ {draws} }}, 500)</script>", encoding="utf-8")
    TOOL["picture_of_page"](page, "#green", (320, 200), tmp_path / "picture.png")
    with Image.open(tmp_path / "picture.png") as picture:
        assert picture.size == (320, 200)
        assert picture.convert("RGB").getpixel((160, 100)) == (0, 255, 0)
