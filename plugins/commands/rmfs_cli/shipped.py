"""Lists of what comes with the package: scenarios and experiments."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path


def print_shipped(files: Mapping[str, Path], as_json: bool) -> None:
    """Print names, and the first comment line of each file, which says what it is for."""
    from rmfs_cli.screen import output_console, print_described, print_json

    found = {name: summary(file) for name, file in files.items()}
    if as_json:
        print_json([{"name": name, "summary": text, "file": str(files[name])} for name, text in found.items()])
        return
    print_described(output_console(), found)


def summary(path: Path) -> str:
    """Return the first comment line of a file."""
    first = path.read_text(encoding="utf-8").partition("\n")[0]
    return first.removeprefix("#").strip() if first.startswith("#") else ""
