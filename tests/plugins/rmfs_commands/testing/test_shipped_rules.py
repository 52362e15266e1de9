"""Every shipped rule passes the conformance suite."""

from typing import Any

import pytest

from rmfs_commands.testing import check_rule
from rmfs_core.entrypoints import RULES, offers, origin
from rmfs_rules.switch import Case

REQUIRED: dict[str, dict[str, Any]] = {
    "most-covered": {"n": 3},
    "switch": {"cases": (Case("random", before_s=60), Case("random"))},
}
"""Parameters of the rules that cannot do without."""

SHIPPED = [name for name, entries in offers(RULES).items() if origin(entries[0])[0] == "rmfs" and name != "remote"]


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_rule_conforms(name: str) -> None:
    rule = offers(RULES)[name][0].load()
    report = check_rule(rule(**REQUIRED.get(name, {})))
    assert len(report.worlds) + len(report.left_out) == 37
    assert len(report.worlds) >= 17
    assert ("Not checked: collisions" in str(report)) is (name == "free-flow")
