"""`rmfs cite`: BibTeX, JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rmfs_commands.cli.main import main


def test_bibtex(capsys: pytest.CaptureFixture[str]) -> None:
    """Comments say whose source an entry is, and what comes from it."""
    main(["cite", "pod-index"])
    printed = capsys.readouterr().out
    assert printed.startswith("% rmfs\n@software{rmfs,\n  author = {{The rmfs authors}},\n")
    assert "% pod-index: how the largest ratio is found\n@article{dinkelbach1967nonlinear,\n" in printed


def test_json(capsys: pytest.CaptureFixture[str]) -> None:
    """The same for machines."""
    main(["cite", "pod-index", "--json"])
    found = {one["key"]: one for one in json.loads(capsys.readouterr().out)}
    assert found["dinkelbach1967nonlinear"]["rules"] == {"pod-index": "how the largest ratio is found"}
    assert found["dinkelbach1967nonlinear"]["fields"]["year"] == "1967"


def test_bad_input(capsys: pytest.CaptureFixture[str]) -> None:
    """One sentence, exit code 2."""
    with pytest.raises(SystemExit) as stop:
        main(["cite", "nothing-of-it"])
    assert stop.value.code == 2
    assert capsys.readouterr().err == (
        'Error: rmfs cite: found "nothing-of-it"; expected the folder of a run, a scenario, or a rule\n'
    )


HOSTILE = r'''
from attrs import define
from rmfs_core import hookimpl

@define
class Hostile:
    r"""POA: nothing.

    References
    ----------
    A. Bee: On honey { wax. Hive, 2001. https://doi.org/10.1000/a\b (as @article{in, year} has it)
    """

    @hookimpl
    def assign_orders(self, warehouse):
        return []
'''


def test_a_docstring_writes_no_entries(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """BibTeX sees an entry at any @, in comments too, and counts all braces."""
    monkeypatch.chdir(tmp_path)
    Path("hostile.py").write_text(HOSTILE, encoding="utf-8")
    Path("mine.toml").write_text('[rules]\npoa = "./hostile.py:Hostile"\npps = "demand"\n', encoding="utf-8")
    main(["cite", "mine.toml"])
    printed = capsys.readouterr().out
    main(["cite", "./hostile.py:Hostile"])
    assert capsys.readouterr().out == printed.partition("% demand\n")[0]
    assert "% ./hostile.py:Hostile: as (at)article{in, year} has it\n@misc{bee2001honey,\n" in printed
    assert "  title = {On honey \\textbraceleft{} wax},\n" in printed
    assert "  doi = {10.1000/a%5Cb},\n" in printed
