"""Lists of what comes with the package."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rmfs_commands.cli.shipped import print_shipped, summary


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    """Return three files by name: two say what they are for, one does not."""
    texts = {"a": "#  What a is for. \nseed = 1\n", "long-name": "# Another\n", "none": "seed = 1\n# later\n"}
    found = {name: tmp_path / f"{name}.toml" for name in texts}
    for name, text in texts.items():
        found[name].write_text(text, encoding="utf-8")
    return found


def test_the_first_comment_says_what_a_file_is_for(files: dict[str, Path], tmp_path: Path) -> None:
    """All of its first paragraph, and only where the file begins with it."""
    assert [summary(file) for file in files.values()] == ["What a is for.", "Another", ""]
    longer = tmp_path / "longer.toml"
    longer.write_text("# What it is\n# for.\n#\n# Details.\nseed = 1\n", encoding="utf-8")
    assert summary(longer) == "What it is for."
    empty = tmp_path / "empty.toml"
    empty.write_text("", encoding="utf-8")
    assert summary(empty) == ""


def test_names_and_summaries_are_in_columns(files: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    """No blanks at the ends of lines; nothing for nothing."""
    print_shipped(files, as_json=False)
    assert capsys.readouterr().out == "a          What a is for.\nlong-name  Another\nnone\n"
    print_shipped({}, as_json=False)
    assert capsys.readouterr().out == ""


def test_json(files: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    """With the files."""
    print_shipped(files, as_json=True)
    found = json.loads(capsys.readouterr().out)
    assert found[0] == {"name": "a", "summary": "What a is for.", "file": str(files["a"])}
    assert [entry["name"] for entry in found] == list(files)
