"""Which mutants are drawn, and that tests are told from tests that fail."""

from __future__ import annotations

from pathlib import Path

import pytest

import mutants

CODE = '"""A text."""\nif a < b and not c:\n    d = (e + 1) * f if g is None else True\n'


def test_each_change_is_of_one_expression(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    file = tmp_path / "code.py"
    file.write_text(CODE, encoding="utf-8")
    changed = set()
    for mutant in mutants.mutants_of(file):
        content = CODE.encode()
        text = (content[: mutant.begin] + mutant.after.encode() + content[mutant.end :]).decode()
        compile(text, "code.py", "exec")
        changed.add(text.splitlines()[mutant.line - 1].strip())
    assert changed == {
        "if a <= b and not c:",
        "if a < b or not c:",
        "if a < b and c:",
        "d = (e - 1) * f if g is None else True",
        "d = (e + 2) * f if g is None else True",
        "d = (e + 1) * f if g is not None else True",
        "d = (e + 1) * f if not (g is None) else True",
        "d = (e + 1) * f if g is None else False",
    }


@pytest.mark.slow
def test_a_failing_test_kills(tmp_path: Path) -> None:
    (tmp_path / "test_good.py").write_text("def test(): pass\n", encoding="utf-8")
    (tmp_path / "test_bad.py").write_text("def test(): assert False\n", encoding="utf-8")
    assert not mutants.is_killed(tmp_path, ["test_good.py"], 1)
    assert mutants.is_killed(tmp_path, ["test_good.py", "test_bad.py"], 1)
