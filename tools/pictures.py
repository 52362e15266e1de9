"""Make the pictures of README.md and the documentation: a run on the terminal and in a browser, a comparison's plot.

Usage: python tools/pictures.py

Writes docs/_static/run.svg (`rmfs run paper-250`: its live display on the way, and its summary),
docs/_static/comparison.png (the differences that `rmfs compare small-rules` plots), docs/_static/replay.png and
docs/_static/report.png (what Chromium shows of the pages that `rmfs replay` and `rmfs report` write of paper-250).
Takes half a minute.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from io import StringIO
from pathlib import Path

from rich.console import Console
from rich.terminal_theme import SVG_EXPORT_THEME
from rich.text import Text

PICTURES = Path(__file__).resolve().parent.parent / "docs" / "_static"
WIDTH = 88
ERASE = re.compile(r"(?:\x1b\[2K|\x1b\[1A|\x1b\[\?25[lh]|\r)+")
"""Control sequence that the live display sends before it draws itself again."""


def call(arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the command line as if it were on a terminal."""
    variables = {**os.environ, "FORCE_COLOR": "1", "COLUMNS": str(WIDTH), "TERM": "xterm-256color"}
    command = [str(Path(sys.executable).parent / "rmfs"), *arguments]
    return subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True, check=True)


def picture_of_run(folder: Path) -> str:
    """Return an SVG of a run: the command, the display on the way, the summary."""
    run = call(["run", "paper-250"], folder)
    frames = [frame for frame in ERASE.split(run.stderr) if "Simulated time" in frame]
    console = Console(record=True, width=WIDTH, file=StringIO(), force_terminal=True)
    console.print(Text.assemble(("$ ", "bold green"), "rmfs run paper-250"))
    console.print(Text.from_ansi(frames[len(frames) // 2].strip("\n")))
    console.print(Text.from_ansi(run.stdout.rstrip("\n")))
    svg = console.export_svg(
        title="rmfs run paper-250, on its way and at the end", theme=SVG_EXPORT_THEME, unique_id="run"
    )
    # The fonts of the network are not asked for; a monospaced one is everywhere.
    return re.sub(r"@font-face \{.*?\}\s*", "", svg, flags=re.DOTALL)


def picture_of_page(page: Path, asked: str, size: tuple[int, int], picture: Path) -> None:
    """Save what Chromium shows of a page as a PNG; ``asked`` stands behind the page's address."""
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--disable-background-networking"]
    wait = "--virtual-time-budget=3000"  # milliseconds of the page's own time, for it to unpack and draw
    shape = f"--window-size={size[0]},{size[1]}"
    command = ["chromium", *options, wait, shape, f"--screenshot={picture}", f"{page.resolve().as_uri()}{asked}"]
    subprocess.run(command, capture_output=True, check=True)


def main() -> int:
    """Write the pictures."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (PICTURES / "run.svg").write_text(picture_of_run(folder), encoding="utf-8")
        call(["compare", "small-rules", "--quiet", "--width", "27"], folder)
        plot = folder / "rmfs-runs" / "small-rules" / "plots" / "differences.png"
        shutil.copyfile(plot, PICTURES / "comparison.png")
        call(["run", "paper-250", "--trace", "--record-decisions", "--quiet", "--out", "paper-250"], folder)
        call(["report", "paper-250"], folder)  # writes replay.html, too
        picture_of_page(folder / "paper-250" / "report.html", "", (1280, 900), PICTURES / "report.png")
        asked = "#t=1200&show=robot 2&theme=light"
        picture_of_page(folder / "paper-250" / "replay.html", asked, (1280, 720), PICTURES / "replay.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
