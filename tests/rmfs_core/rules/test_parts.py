"""Files that parameters name, and what rules are made of."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from attrs import define, field

from rmfs_core import InputError
from rmfs_core.rules import RuleSet
from rmfs_core.rules.parameters import build
from rmfs_core.rules.parts import FileProblem, add_paths, find_file, made_in, parts_now, with_given
from rmfs_core.scenario.model import RuleChoice, RulesSection
from rmfs_core.scenario.rulenames import GivenText

RULE = """
from __future__ import annotations
from typing import TYPE_CHECKING
from attrs import define
from rmfs_core import hookimpl
if TYPE_CHECKING:
    from pathlib import Path

@define
class Mine:
    weights: Path

    @hookimpl
    def choose_storage_location(self, warehouse):
        return min(warehouse.free_storage_locations)
"""


@define
class Many:
    """A rule's class with files in every kind of type."""

    one: Path | None = None
    several: tuple[Path, ...] = ()
    either: str | Path = "no file"
    converted: Path = field(default=None, converter=lambda path: path and path.parent)
    default: Path = Path("default.bin")
    text: str = ""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with files, and one in a folder in it."""
    (tmp_path / "deep").mkdir()
    for name in ("default.bin", "a.bin", "b.bin", "deep/a.bin"):
        (tmp_path / name).write_text(name, encoding="utf-8")
    return tmp_path


def test_files_are_beside_the_scenario(folder: Path) -> None:
    """Those of every type that has paths in it, and defaults; texts are no files."""
    values = {"one": "a.bin", "several": ["b.bin", "deep/a.bin"], "either": "a.bin", "converted": "b.bin", "text": "x"}
    with made_in(str(folder)) as parts:
        rule = build(Many, values, "rules.pr", "it")
    assert (rule.one, rule.several) == (folder / "a.bin", (folder / "b.bin", folder / "deep" / "a.bin"))
    assert (rule.either, rule.converted, rule.text) == (folder / "a.bin", folder, "x")
    assert rule.default == folder / "default.bin"
    assert sorted(one.name for one in parts.files) == ["a.bin", "a.bin", "b.bin", "b.bin", "deep/a.bin", "default.bin"]
    assert parts.files[-1].digest().startswith("sha256:")
    assert parts.classes == [Many]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"one": "none.bin"}, "rules.pr.one: there is no file {folder}/none.bin"),
        ({"several": ["a.bin", "none.bin"]}, "rules.pr.several: there is no file {folder}/none.bin"),
        ({"either": "none.bin"}, "rules.pr.either: there is no file {folder}/none.bin"),
        ({"one": "deep"}, "rules.pr.one: expected a file, found a folder, {folder}/deep"),
        ({"one": "/dev/null"}, "rules.pr.one: expected a file, found a device, /dev/null"),
        ({"one": "x" * 5000}, "rules.pr.one: there is no file {folder}/xxx"),
        ({"one": 3}, "rules.pr.one: expected the name of a file or nothing, found 3"),
    ],
)
def test_what_is_no_file_is_refused(folder: Path, values: dict[str, Any], message: str) -> None:
    """With the key and the file that was looked for."""
    with made_in(str(folder)), pytest.raises(InputError) as caught:
        build(Many, values, "rules.pr", "it")
    expected = message.format(folder=folder)
    assert str(caught.value).startswith(expected)
    assert len(str(caught.value)) < len(expected) + 1000


def test_a_text_that_was_given_elsewhere_is_looked_up_there(folder: Path) -> None:
    """The scenario calls it by the name as seen from its folder, or by the absolute path."""
    (folder / "deep" / "only.bin").write_text("", encoding="utf-8")
    with made_in(str(folder)) as parts:
        assert find_file(GivenText("only.bin", str(folder / "deep"))) == folder / "deep" / "only.bin"
    with made_in(str(folder / "deep")) as other:
        find_file(GivenText("a.bin", str(folder)))
    assert [one.name for one in (*parts.files, *other.files)] == ["deep/only.bin", str(folder / "a.bin")]


def test_outside_of_a_scenario_the_working_directory_counts(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As for a file that a command is given."""
    monkeypatch.chdir(folder)
    assert parts_now().folder == "."
    assert find_file("a.bin").samefile(folder / "a.bin")
    with pytest.raises(FileProblem):
        find_file("none.bin")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="permissions do not hold the superuser")
def test_a_file_that_may_not_be_read(folder: Path) -> None:
    """Before any run."""
    (folder / "a.bin").chmod(0)
    with pytest.raises(FileProblem, match="cannot be read: permission denied"):
        find_file(str(folder / "a.bin"))


def test_an_object_has_its_files_too(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever they are in; as seen from the working directory, as everywhere in Python."""
    monkeypatch.chdir(folder / "deep")
    with made_in(str(folder)) as parts:
        add_paths({"x": [Path("a.bin"), Path("none.bin"), 3]})
    assert [one.name for one in parts.files] == ["deep/a.bin"]


def test_texts_are_changed_wherever_they_are() -> None:
    """In choices, tables and lists; the rest stays."""
    given = GivenText("b", "/there")
    value = (RuleChoice("rule", {"x": [given, "c"], "y": 1}), "d")
    assert with_given(value, str.upper) == (RuleChoice("rule", {"x": ["B", "c"], "y": 1}), "d")


def test_a_rule_set_knows_its_files(folder: Path, install: Callable[..., None]) -> None:
    """With digests; a type that is imported for type checkers alone counts; choices get the scenario's names."""
    install("acme", {"mine": "acme_rules:Mine"})
    (folder / "acme" / "acme_rules.py").write_text(RULE, encoding="utf-8")
    given = GivenText("a.bin", str(folder / "deep"))
    rules = RulesSection(RuleChoice("pod-match"), RuleChoice("demand"), pr=RuleChoice("mine", {"weights": given}))
    loaded = RuleSet.load(rules, str(folder))
    (one,) = loaded.files
    assert loaded.pr.instance.weights == folder / "deep" / "a.bin"
    assert (one.name, one.digest()) == ("deep/a.bin", f"sha256:{hashlib.sha256(b'deep/a.bin').hexdigest()}")
    named = loaded.with_file_names(rules)
    assert named.pr.parameters == {"weights": "deep/a.bin"}
    assert type(named.pr.parameters["weights"]) is str
