"""Put a reproduction's report and its plots into docs/paper/reproduction.

Usage: python tools/update_results.py DIR

DIR is what `rmfs reproduce --out DIR` has written. docs/paper/results.md, which says what the figures mean, is yours to
bring up to date.
"""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

REPORTS = Path(__file__).resolve().parent.parent / "docs" / "paper" / "reproduction"


def update(reports: Path, folder: Path) -> None:
    """Copy report and plots from a reproduction's folder instead of those in ``reports``."""
    report = (folder / "report.md").read_text(encoding="utf-8")
    reports.mkdir(parents=True, exist_ok=True)
    for old in reports.iterdir():
        old.unlink()
    (reports / "report.md").write_text(without_folder(report), encoding="utf-8")
    for name in re.findall(r"^!\[.*?\]\((.*?)\)$", report, flags=re.MULTILINE):
        shutil.copyfile(folder / name, reports / name)


def without_folder(report: str) -> str:
    """Return a report whose command does not say where on this machine it was written."""
    return re.sub(r"^(- Command: `.*?) --out \S+(.*`)$", r"\1\2", report, flags=re.MULTILINE)


def main() -> int:
    """Update the checkout from the folder on the command line."""
    if len(sys.argv) != 2 or not (Path(sys.argv[1]) / "report.md").is_file():
        print("expected a folder that `rmfs reproduce --out` has written", file=sys.stderr)
        return 2
    update(REPORTS, Path(sys.argv[1]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
