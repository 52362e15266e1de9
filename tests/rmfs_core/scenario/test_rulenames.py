"""The names of rules in a scenario."""

from __future__ import annotations

import copy
import json
import pickle
from collections.abc import Callable
from pathlib import Path

import pytest

from rmfs_core.entrypoints import RULES, offers
from rmfs_core.scenario.model import RuleChoice, RulesSection
from rmfs_core.scenario.rulenames import (
    GivenText,
    check_rule_name,
    given_in,
    inline_parts,
    is_inline,
    rule_choices,
    rule_name_from,
)
from rmfs_core.scenario.structuring import KeyProblem

Install = Callable[..., None]


def test_every_choice_has_its_path() -> None:
    """In the order of the section's keys, lists with their places; keys that are left out or name no rule have none."""
    a, b, c, d = (RuleChoice(name) for name in "abcd")
    rules = RulesSection(poa_pps=a, pr=b, wait_for_stock=True, filters=(c, a), observers=(d,))
    assert [(path, choice.rule) for path, choice in rule_choices(rules)] == [
        (("poa_pps",), "a"),
        (("pr",), "b"),
        (("ta",), "balanced"),
        (("pp",), "sipp"),
        (("filters", 0), "c"),
        (("filters", 1), "a"),
        (("observers", 0), "d"),
    ]


@pytest.mark.parametrize("name", ["./a.py:A", "../a.py:A", "/x/a.py:A", "a.py:A", "a.py", "./a", "rules/a.py:A"])
def test_names_of_files_are_told_from_names_of_rules(name: str) -> None:
    """Also where the dot at the beginning, or the class at the end, was forgotten."""
    assert is_inline(name)


@pytest.mark.parametrize("name", ["pod-match", "acme.rule", "mypy", "a:b"])
def test_names_of_rules_are_no_files(name: str) -> None:
    """Whatever is in them."""
    assert not is_inline(name)


def test_an_inline_name_has_a_file_and_a_class() -> None:
    """The colon is the last one: a folder may have one in its name."""
    assert inline_parts("./a.py:A") == ("./a.py", "A")
    assert inline_parts("./c:d/a.py:A") == ("./c:d/a.py", "A")


@pytest.mark.parametrize("name", ["./a.py", "./a:A", "./a.py:", "./a.py:A.B", "./a.py:1", ":A", "./a.pyc:A"])
def test_half_an_inline_name_is_refused(name: str) -> None:
    """The form is shown."""
    with pytest.raises(KeyProblem) as caught:
        inline_parts(name)
    assert str(caught.value) == f'expected "./file.py:Class" for a rule beside the scenario, found "{name}"'


@pytest.mark.parametrize(
    ("name", "there", "named"),
    [
        ("pod-match", "home", "pod-match"),  # no file: as it is
        ("./a.py", "home", "./a.py"),  # wrong: left for the check to refuse
        ("./a.py:A", "home", "./a.py:A"),
        ("a.py:A", "home/sub", "./sub/a.py:A"),
        ("../home/sub/../a.py:A", "other", "./a.py:A"),
        ("./a.py:A", "other", "{tmp}/other/a.py:A"),
        ("{tmp}/home/a.py:A", "other", "./a.py:A"),
        ("{tmp}/homely/a.py:A", "home", "{tmp}/homely/a.py:A"),  # beside the folder, not in it
    ],
)
def test_a_file_keeps_its_place_when_it_is_named_from_elsewhere(
    tmp_path: Path, name: str, there: str, named: str
) -> None:
    """As a scenario file names it where it is in the scenario's folder, by its absolute path where it is not."""
    tmp = str(tmp_path.resolve())
    assert rule_name_from(name.format(tmp=tmp), tmp_path / there, tmp_path / "home") == named.format(tmp=tmp)


def test_rules_that_are_there_are_accepted(tmp_path: Path, install: Install) -> None:
    """Installed ones, whether or not they can be imported, and files."""
    install("acme", {"mine": "acme_missing:Mine"})
    (tmp_path / "a.py").write_text("raise SystemExit", encoding="utf-8")
    for name in ("demand", "mine", "./a.py:A", "a.py:A", f"{tmp_path}/a.py:Whatever"):
        check_rule_name(name, tmp_path, offers(RULES))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("demnd", 'there is no rule "demnd" (did you mean `demand`?)'),
        ("./b.py:A", "there is no file `./b.py` in the scenario's folder ({folder})"),
        ("/nowhere/b.py:A", "there is no file `/nowhere/b.py`"),
        ("./b.py", 'expected "./file.py:Class" for a rule beside the scenario, found "./b.py"'),
    ],
)
def test_rules_that_are_not_there_are_refused(tmp_path: Path, name: str, message: str) -> None:
    """With the nearest name, or where the file was looked for."""
    with pytest.raises(KeyProblem) as caught:
        check_rule_name(name, tmp_path, offers(RULES))
    assert str(caught.value) == message.format(folder=tmp_path)


@pytest.mark.parametrize("name", ["./a\0b.py:A", "/x/a\0b.py:A"])
def test_a_name_that_no_file_can_have_is_kept(tmp_path: Path, name: str) -> None:
    """Whoever looks for the file says that there is none."""
    assert rule_name_from(name, tmp_path, tmp_path / "home") == name
    with pytest.raises(KeyProblem, match="there is no file"):
        check_rule_name(name, tmp_path, ())


def test_texts_of_parameters_know_where_they_were_given() -> None:
    """Those below a rule, in lists and tables, too; names of rules, and what was given elsewhere, stay."""
    kept = GivenText("x", "/first")
    rules = {"poa": {"rule": "a", "file": "x", "deep": [{"file": "x", "n": 1}], "kept": kept}, "pps": "b"}
    given = given_in(rules, ("rules",), "/there")
    assert given == rules
    assert type(given["poa"]["rule"]) is type(given["pps"]) is str
    assert given["poa"]["file"].there == given["poa"]["deep"][0]["file"].there == "/there"
    assert given["poa"]["kept"].there == "/first"
    assert type(given_in(["a"], ("rules", "filters"), "/there")[0]) is str
    assert given_in("w", ("rules", "poa", "file"), "/there").there == "/there"


def test_a_given_text_is_a_text() -> None:
    """Written like any other, copied and sent to workers with where it was given, which its repr tells."""
    text = GivenText("x", "/there")
    assert (text, json.dumps([text]), repr(text)) == ("x", '["x"]', "'x' in /there")
    for same in (copy.deepcopy(text), pickle.loads(pickle.dumps(text))):
        assert (same, same.there) == ("x", "/there")
