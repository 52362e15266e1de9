"""A rule that is loaded once and decides in many states."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rmfs_commands.states import Decider, decide, state_from_dict
from rmfs_commands.states.decider import MOST_LOADED
from rmfs_core import InputError
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice

COUNTING = """
from attrs import define, field
from rmfs_core import OrderAssignment, hookimpl

print("loaded")


@define
class Once:
    "POA and PPS: an order the first time it is asked, and nothing afterwards."

    seen: list = field(factory=list)

    def __attrs_post_init__(self):
        self.calls = 0

    calls: int = field(init=False)

    @hookimpl(specname="assign_orders")
    def something_else(self, warehouse):
        self.calls += 1
        self.seen.append(warehouse.now_s)
        return [OrderAssignment(0, 0)] if self.calls == len(self.seen) == 1 else []

    @hookimpl
    def select_pods(self, warehouse):
        return []
"""


@pytest.fixture
def once(tmp_path: Path) -> str:
    """Return the name of a rule in a file that remembers what it was asked."""
    (tmp_path / "once.py").write_text(COUNTING, encoding="utf-8")
    return "./once.py:Once"


def test_it_remembers_nothing(once: str, tmp_path: Path, by_hand: dict[str, Any], capsys: Any) -> None:
    """Each state is as the first, also for a rule that counts; the file is loaded once."""
    decider = Decider(RuleChoice(once), folder=str(tmp_path))
    asked = state_from_dict(by_hand | {"ask": {"decides": "POA"}})
    answers = [decider.decide(asked) for _ in range(3)]
    assert [len(answer.decision["assignments"]) for answer in answers] == [1, 1, 1]
    assert decider.decide(state_from_dict(by_hand | {"ask": {"decides": "PPS"}})).decision == {"trips": []}
    assert capsys.readouterr().out == "loaded\n"


def test_what_to_ask_of_a_rule_of_several_things(once: str, tmp_path: Path, by_hand: dict[str, Any]) -> None:
    """The state says it, or who makes the decider; else it is an error."""
    state = state_from_dict(by_hand)
    with pytest.raises(InputError, match="say which of them is asked"):
        Decider(RuleChoice(once), folder=str(tmp_path)).decide(state)
    assert Decider(RuleChoice(once), decides=Role.PPS, folder=str(tmp_path)).decide(state).decides is Role.PPS
    with pytest.raises(InputError, match=r"expected POA, .*ROA\+RPS, activation, idle or repositioning, found 'PP'"):
        Decider(RuleChoice("first-come"), decides=Role.PP)


@pytest.mark.parametrize("name", ["first-come", "random"])
def test_a_wrong_parameter_is_told_at_once(name: str) -> None:
    """Before any state, also for a rule that decides several things."""
    with pytest.raises(InputError, match=r"^rule.nonsense: .* has no parameter `nonsense`"):
        Decider(RuleChoice(name, {"nonsense": 1}))


def test_a_file_that_has_changed(once: str, tmp_path: Path, by_hand: dict[str, Any]) -> None:
    """`decide` keeps the last rules loaded, but for files: these are read anew."""
    state = state_from_dict(by_hand)
    ask = {"decides": Role.POA, "folder": str(tmp_path)}
    assert decide(state, RuleChoice(once), **ask).decision["assignments"]
    text = (tmp_path / "once.py").read_text(encoding="utf-8")
    (tmp_path / "once.py").write_text(text.replace("[OrderAssignment(0, 0)]", "[]"), encoding="utf-8")
    assert not decide(state, RuleChoice(once), **ask).decision["assignments"]


def test_files_of_parameters_are_in_the_folder(tmp_path: Path, by_hand: dict[str, Any]) -> None:
    """By default where the command is given; read anew in each state."""
    code = "from pathlib import Path\n" + COUNTING.replace("    seen: list =", "    file: Path\n    seen: list =")
    code = code.replace("if self.calls == len(self.seen) == 1", 'if self.file.read_text() == "yes"')
    (tmp_path / "once.py").write_text(code, encoding="utf-8")
    choice = RuleChoice("./once.py:Once", {"file": "answer.txt"})
    with pytest.raises(InputError, match=r"rule\.file: there is no file .*answer\.txt"):
        Decider(choice, folder=str(tmp_path))
    (tmp_path / "answer.txt").write_text("yes", encoding="utf-8")
    decider = Decider(choice, folder=str(tmp_path))
    state = state_from_dict(by_hand | {"ask": {"decides": "POA"}})
    assert len(decider.decide(state).decision["assignments"]) == 1
    (tmp_path / "answer.txt").write_text("no", encoding="utf-8")
    assert len(decider.decide(state).decision["assignments"]) == 0


def test_many_rules_one_after_the_other(by_hand: dict[str, Any]) -> None:
    """More than are kept, with parameters of their own: each answers for itself."""
    by_hand["orders"] = {"B": {"lines": {"jam": 1}}}
    state = state_from_dict(by_hand)
    for percent in [*range(1, 2 * MOST_LOADED), *range(1, 2 * MOST_LOADED)]:
        report = decide(state, RuleChoice("integrated", {"unused_capacity_weight": percent / 100})).report
        assert report is not None
        assert report["objective"] == pytest.approx(4 * percent / 100)  # four places stay free: less than a visit


def test_no_name_is_taken_for_another(by_hand: dict[str, Any], install: Any) -> None:
    """A rule that is no longer installed is gone, though it was asked before."""
    source = "\n@define\nclass Lazy:\n    @hookimpl\n    def assign_orders(self, warehouse):\n        return []\n"
    with pytest.raises(InputError, match="there is no rule"):
        decide(state_from_dict(by_hand), RuleChoice("acme-lazy"))
    install("acme", {"acme-lazy": "acme_lazy:Lazy"}, acme_lazy=source)
    assert decide(state_from_dict(by_hand), RuleChoice("acme-lazy")).distribution == "acme"


def test_what_is_no_rule_or_state_is_refused() -> None:
    with pytest.raises(InputError, match=r'^choice: expected a RuleChoice such as .*, found "?.first-come'):
        Decider("first-come")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"^state: expected a State, such as `read_state` returns, found {}"):
        Decider(RuleChoice("first-come")).decide({})  # type: ignore[arg-type]
