"""The README's examples work, and the links of it and its neighbours lead somewhere."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import rmfs_core
from try_wheel import README, blocks, commands, save_files

ROOT = Path(__file__).resolve().parent.parent
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")),
    *(ROOT / "docs").rglob("*.md"),
]
COMMANDS = commands()


def test_it_is_short() -> None:
    assert len(README.splitlines()) <= 150


def test_the_readmes_rule_runs(tmp_path: Path) -> None:
    save_files(tmp_path)
    result = rmfs_core.run(tmp_path / "my-scenario.toml")
    assert result.status == "complete"
    assert result.metrics["orders_completed"] == 50
    assert len(blocks("python")[0].split("\n\n")[-1].strip().splitlines()) <= 10


def test_the_readmes_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    exec(blocks("python")[1], {})
    assert capsys.readouterr().out.startswith("complete ")


@pytest.mark.slow
def test_the_readmes_tour_runs(tmp_path: Path) -> None:
    save_files(tmp_path)
    for words in COMMANDS:
        call = [sys.executable, "-c", "from rmfs_commands.cli.main import main; main()", *words[1:]]
        done = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{shlex.join(words)}: {done.stderr}"


FIGURES = r"^\| (.+) \| ([0-9.]+) \| ([0-9]+) \| ([0-9]+) s \| ([0-9]+) s \| ([0-9.]+) s \|$"
"""A row of the README's table: the rules, and five figures."""
UNTIL_NOON = [words[4::2] for words in COMMANDS if "run.until_s=43200" in words]
"""The overrides of the commands whose figures the table has, row by row."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("overrides", "row"), list(zip(UNTIL_NOON, re.findall(FIGURES, README, re.MULTILINE), strict=True)), ids=str
)
def test_the_readmes_figures(overrides: list[str], row: tuple[str, ...]) -> None:
    _, *shown = row
    metrics = rmfs_core.run("grocery-day", overrides=overrides).metrics
    packed = rmfs_core.run("grocery-day", overrides=(*overrides, "packing={}")).metrics
    metrics = {**metrics, "packed_s": packed["packed_s"]}
    names = ("psv_per_order", "distance_per_order_m", "turnover_s", "packed_s", "waiting_per_visit_s")
    found = [f"{metrics[name]:.{digits}f}" for name, digits in zip(names, (2, 0, 0, 0, 1), strict=True)]
    assert found == shown
    assert metrics["late_orders"] == 0


def test_the_readmes_table_is_that_of_the_documentation() -> None:
    rows = [line for line in README.splitlines() if re.fullmatch(FIGURES, line)]
    assert len(rows) == len(UNTIL_NOON) == 3
    assert set(rows) <= set((ROOT / "docs" / "index.md").read_text(encoding="utf-8").splitlines())


def links(page: Path) -> list[str]:
    """Return the addresses that a page links to or shows pictures from, but for those elsewhere."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    found = re.findall(r"\]\(([^)\s]+)\)", text)
    return [address for address in found if "://" not in address and not address.startswith("#")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    missing = [address for address in links(page) if not (page.parent / address.partition("#")[0]).is_file()]
    assert missing == []


def test_links_are_found() -> None:
    assert len(links(ROOT / "README.md")) > 15
