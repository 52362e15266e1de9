"""What is known about installed rules: from their class, its fields and its docstring."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rmfs_commands.cli.description import RuleDescription, installed_rules, sections

DOCUMENTED = """
@define
class Mine:
    '''Assign as I please.

    Parameters
    ----------
    patience_s
        How long to wait, and
        no longer (s).
    mode, unused
        Fast or slow.

    References
    ----------
    A. Uthor: A paper. https://doi.org/10.1000/xyz.
    '''

    patience_s: float
    mode: str = "slow"
    share: float = field(default=0.5, metadata={"unit": "%", "doc": "How much"})
    names: list[str] = field(factory=list)
    other: int = field(init=False, default=3)

    @hookimpl
    def assign_orders(self, warehouse):
        return []

    @hookimpl
    def on_event(self, event):
        pass
"""


def described(name: str) -> RuleDescription:
    """Return what is known of a rule."""
    (found,) = [rule for rule in installed_rules() if rule.name == name]
    return found


def test_a_third_partys_rule_is_described(install: Callable[..., None]) -> None:
    """By its docstring and by the metadata of its fields; what no scenario can set is no parameter."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=DOCUMENTED)
    rule = described("mine")
    assert (rule.distribution, rule.version, rule.error) == ("acme", "1.0", None)
    assert rule.decides == ("POA", "observer")
    assert rule.summary == "Assign as I please."
    assert rule.short_references() == "10.1000/xyz"
    assert [(one.name, one.required, one.default, one.unit, one.doc) for one in rule.parameters] == [
        ("patience_s", True, None, "s", "How long to wait, and no longer (s)."),
        ("mode", False, "slow", "", "Fast or slow."),
        ("share", False, 0.5, "%", "How much"),
        ("names", False, [], "", ""),
    ]
    assert [one.shown() for one in rule.parameters] == [
        "patience_s = (required) s",
        'mode = "slow"',
        "share = 0.5 %",
        "names = []",
    ]


@pytest.mark.parametrize(
    ("source", "error"),
    [
        ("raise ImportError('no such thing')", "no such thing"),
        ("class Mine: pass", "attrs"),
        ("@define\nclass Mine:\n    @hookimpl\n    def asign_orders(self): pass", "did you mean `assign_orders`"),
    ],
)
def test_a_rule_that_cannot_be_used_says_why(install: Callable[..., None], source: str, error: str) -> None:
    """And hides no other."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    rule = described("mine")
    assert rule.error is not None
    assert error in rule.error
    assert (rule.decides, rule.parameters) == ((), ())
    assert described("demand").error is None


def test_two_rules_of_a_name_are_both_listed(install: Callable[..., None]) -> None:
    """Each by the name under which it can be chosen, and the one that both have not at all."""
    install("acme", {"demand": "acme_rules:Mine"}, acme_rules=DOCUMENTED)
    both = {rule.name: rule for rule in installed_rules() if rule.name.split(":")[-1] == "demand"}
    assert {name: rule.distribution for name, rule in both.items()} == {"acme:demand": "acme", "rmfs:demand": "rmfs"}
    assert all(rule.error is None for rule in both.values())


def test_rules_are_sorted_by_what_they_decide() -> None:
    """In the order of the decisions, then by name."""
    rules = [rule for rule in installed_rules() if rule.distribution == "rmfs"]
    firsts = list(dict.fromkeys(rule.decides[0] for rule in rules))
    assert firsts[:2] == ["POA", "PPS"]
    assert [rule.decides[0] for rule in rules] == sorted((r.decides[0] for r in rules), key=firsts.index)
    names = [rule.name for rule in rules if rule.decides == ("POA",)]
    assert names == sorted(names)


def test_references_without_a_number_are_shown_as_they_begin() -> None:
    """All numbers where there are some, each once."""

    def shown(reference: str) -> str:
        return RuleDescription("x", "rmfs", "1", reference=reference).short_references()

    assert shown("A. Uthor: A report, 1999.\nMore.") == "A. Uthor: A report, 1999."
    assert (
        shown("arXiv:1706.09347. https://doi.org/10.1/a, doi:10.1/a. DOI: 10.2/b") == "arXiv:1706.09347\n10.1/a\n10.2/b"
    )
    assert shown("") == ""


def test_sections_of_a_docstring() -> None:
    """By title, without the lines below them."""
    doc = "Summary.\n\nParameters\n----------\na\n    First.\n\nReferences\n----------\nSomebody."
    assert sections(doc) == {"Parameters": "a\n    First.", "References": "Somebody."}
    assert sections("Summary.") == {}
