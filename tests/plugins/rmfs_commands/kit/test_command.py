"""`rmfs new-rule` on the command line."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from rmfs_commands.cli.main import main


def test_it_writes_the_folder_and_says_what_comes_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The commands it prints are for this rule."""
    monkeypatch.chdir(tmp_path)
    main(["new-rule", "fine-rule", "--decides", "POA+PPS"])
    assert (tmp_path / "fine-rule" / "pyproject.toml").exists()
    out = capsys.readouterr().out
    assert out.startswith(
        "Wrote fine-rule: pyproject.toml, README.md, src/fine_rule/__init__.py, tests/test_fine_rule.py."
    )
    assert "  pip install -e ./fine-rule\n" in out
    assert "--set rules.poa_pps=fine-rule\n" in out
    main(["new-rule", "fine-tool", "--decides", "command"])
    assert "\n  rmfs fine-tool examples/small\n" in capsys.readouterr().out


def test_into_another_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """--into makes the folder, and the commands name it so that a shell takes it for one word."""
    main(["new-rule", "fine-rule", "--decides", "PR", "--into", str(tmp_path / "my rules")])
    assert (tmp_path / "my rules" / "fine-rule" / "README.md").exists()
    assert f"pip install -e '{tmp_path}/my rules/fine-rule'" in capsys.readouterr().out


def test_a_folder_whose_name_is_no_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is written all the same, and said."""
    monkeypatch.chdir(tmp_path)
    with io.TextIOWrapper(io.BytesIO(), "utf-8") as output:
        monkeypatch.setattr(sys, "stdout", output)
        main(["new-rule", "fine-rule", "--decides", "PR", "--into", "x\udcff"])
        output.flush()
        assert b"Wrote x\\udcff/fine-rule" in output.buffer.getvalue()
    assert (tmp_path / "x\udcff" / "fine-rule" / "README.md").exists()


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["Bad Name", "--decides", "PR"], 'Error: rule name "Bad Name": expected small letters'),
        (["nearest", "--decides", "PR"], 'Error: rule name "nearest": a rule of that name is installed'),
        (["fine-rule", "--decides", "XYZ"], "'XYZ' is not one of 'POA', 'PPS', 'POA+PPS'"),
        (["fine-rule"], "Missing option '--decides'"),
        (["there", "--decides", "PR"], "Error: there: is there already"),
    ],
)
def test_bad_input_is_refused(
    arguments: list[str],
    problem: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Exit code 2, one sentence, nothing written."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there").mkdir()
    with pytest.raises(SystemExit) as caught:
        main(["new-rule", *arguments])
    assert caught.value.code == 2
    assert problem in capsys.readouterr().err
    assert [path.name for path in tmp_path.rglob("*")] == ["there"]
