"""Lists of what comes with the package: scenarios and experiments."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import takewhile
from pathlib import Path


def print_shipped(files: Mapping[str, Path], as_json: bool) -> None:
    """Print names, and the first comment of each file, which says what it is for."""
    from rmfs_commands.cli.screen import output_console, print_described, print_json

    found = {name: summary(file) for name, file in files.items()}
    if as_json:
        print_json([{"name": name, "summary": text, "file": str(files[name])} for name, text in found.items()])
        return
    print_described(output_console(), found)


def summary(path: Path) -> str:
    """Return the first paragraph of the comment that a file begins with."""
    lines = path.read_text(encoding="utf-8").splitlines()
    paragraph = takewhile(lambda line: line.startswith("#") and line.strip("# "), lines)
    return " ".join(line.removeprefix("#").strip() for line in paragraph)
