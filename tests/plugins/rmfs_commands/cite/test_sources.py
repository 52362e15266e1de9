"""Which sources runs, scenarios and rules have."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from attrs import define

import rmfs_core
from rmfs_commands.cite.sources import cited
from rmfs_core import hookimpl
from rmfs_core.errors import InputError
from rmfs_core.scenario import load_scenario
from rmfs_rules.switch import Case, Switch

RULE = '''
from attrs import define
from rmfs_core import hookimpl

@define
class Mine:
    """POA: my own.

    References
    ----------
    A. Bee: On honey. Hive 1, 2, 2001.
    """

    @hookimpl
    def assign_orders(self, warehouse):
        return []
'''


def keys(*what: str) -> dict[str, list[str]]:
    """Return the rules that name each source, by its key."""
    return {one.reference.key: list(one.rules) for one in cited(what)}


def test_rules_share_sources() -> None:
    """Each source stands once, with all rules that name it; rmfs itself comes first."""
    found = keys("pod-match", "demand", "pod-match")
    assert next(iter(found)) == "rmfs"
    assert found["xie2019efficient"] == found["merschformann2019decision"] == ["pod-match", "demand"]


def test_a_scenario_names_its_rules(tmp_path: Path) -> None:
    """Rules of files are cited as others are, and so are those that a rule asks."""
    (tmp_path / "mine.py").write_text(RULE, encoding="utf-8")
    switch = '{ rule = "switch", cases = [{ rule = "nearest-pod", before_s = 60 }, { rule = "demand" }] }'
    scenario = f'[rules]\npoa = "./mine.py:Mine"\npps = {switch}\n'
    (tmp_path / "mine.toml").write_text(scenario, encoding="utf-8")
    found = keys(str(tmp_path / "mine.toml"))
    assert len(found["bee2001honey"]) == 1
    assert {"nearest-pod", "demand"} <= {*found["merschformann2019decision"]}
    assert "switch" in found["merschformann2018rawsimo"]


def test_the_folder_of_a_run(tmp_path: Path) -> None:
    """A result says which rules it was made with."""
    rules = {"poa": "pod-match", "pps": "demand", "pr": "nearest", "ta": "nearest-robot", "pp": "sipp"}
    result = {"scenario": {"rules": rules}, "metrics": {}}
    (tmp_path / "result.json").write_text(json.dumps(result), encoding="utf-8")
    assert keys(str(tmp_path))["ma2019lifelong"] == ["sipp"]


def test_a_run_whose_rule_is_gone(tmp_path: Path) -> None:
    """The message says which folder names it."""
    rules = {"poa": "./gone.py:Mine", "pps": "demand", "pr": "nearest", "ta": "nearest-robot", "pp": "sipp"}
    (tmp_path / "result.json").write_text(json.dumps({"scenario": {"rules": rules}, "metrics": {}}), encoding="utf-8")
    with pytest.raises(InputError, match=rf"^{re.escape(str(tmp_path))}, rules\.poa: rule .*: cannot read .*gone\.py"):
        cited([str(tmp_path)])


def test_a_run_whose_rule_was_an_object(tmp_path: Path) -> None:
    """One sentence where it is no installed rule; one that is has its sources, whatever its parameters were."""

    @define
    class Own:
        """Keeps robots where they are."""

        @hookimpl
        def idle_robots(self) -> list[object]:
            return []

    settings = ["instance.orders=3", "rules.pp=free-flow"]
    rmfs_core.run(load_scenario("examples/small", settings), rules={"idle": Own()}, out=tmp_path / "own")
    with pytest.raises(InputError) as caught:
        cited([str(tmp_path / "own")])
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(f'{tmp_path / "own"}, rules.idle: found rule "Own", expected one that is inst')
    switch = Switch(cases=(Case("pod-match", before_s=60), Case("random")))
    rmfs_core.run(load_scenario("examples/small", settings), rules={"poa": switch}, out=tmp_path / "switched")
    assert keys(str(tmp_path / "switched"))


def test_what_is_nothing_of_it(tmp_path: Path) -> None:
    """An empty folder, a name that nothing has."""
    with pytest.raises(InputError, match=r"no result\.json"):
        cited([str(tmp_path)])
    with pytest.raises(InputError, match=r'found "pod-mach" \(did you mean `pod-match`'):
        cited(["pod-mach"])
