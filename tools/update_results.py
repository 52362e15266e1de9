"""Put a reproduction's report into the checkout: its plots and report.md into results/, its tables into README.md.

Usage: python tools/update_results.py DIR

DIR is what `rmfs reproduce --out DIR` has written.
"""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BEGIN = "<!-- results: begin (tools/update_results.py) -->\n"
END = "<!-- results: end -->"
OPEN = ("Overview", "Runs")
"""Sections of the report that README.md shows as they are; the others are folded."""


def results_section(report: str) -> str:
    """Return what README.md shows of a report.

    Parameters
    ----------
    report
        The text of report.md.
    """
    head, *sections = re.split(r"^## ", report, flags=re.MULTILINE)
    facts = head.partition("\n")[2].strip()
    plots = re.findall(r"^!\[.*?\]\(.*?\)$", report, flags=re.MULTILINE)
    texts = [f"### {re.sub(r'^!.*$', '', section, flags=re.MULTILINE).strip()}\n" for section in sections]
    shown = [text for text in texts if _title(text).startswith(OPEN)]
    folded = [text for text in texts if not _title(text).startswith(OPEN)]
    return "\n".join(
        [
            facts + "\n",
            *shown,
            *(f"{plot.replace('](', '](results/')}\n" for plot in plots),
            f"<details>\n<summary>All {len(folded)} tables</summary>\n",
            *folded,
            "</details>\n",
        ]
    )


def _title(section: str) -> str:
    return section.partition("\n")[0].removeprefix("### ")


def updated(readme: str, report: str) -> str:
    """Return README.md with the report's results between its marks."""
    before, rest = readme.split(BEGIN)
    return before + BEGIN + results_section(report) + END + rest.split(END, 1)[1]


def update(root: Path, folder: Path) -> None:
    """Copy report and plots from a reproduction's folder into ``root/results``, and renew ``root/README.md``."""
    report = (folder / "report.md").read_text(encoding="utf-8")
    results = root / "results"
    results.mkdir(exist_ok=True)
    for old in results.iterdir():
        old.unlink()
    shutil.copyfile(folder / "report.md", results / "report.md")
    for name in re.findall(r"^!\[.*?\]\((.*?)\)$", report, flags=re.MULTILINE):
        shutil.copyfile(folder / name, results / name)
    readme = root / "README.md"
    readme.write_text(updated(readme.read_text(encoding="utf-8"), report), encoding="utf-8")


def main() -> int:
    """Update the checkout from the folder on the command line."""
    if len(sys.argv) != 2 or not (Path(sys.argv[1]) / "report.md").is_file():
        print("expected a folder that `rmfs reproduce --out` has written", file=sys.stderr)
        return 2
    update(ROOT, Path(sys.argv[1]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
