"""A scenario as TOML text that reads back as an equal scenario."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from attrs import evolve

from rmfs_commands.cli.toml_scenario import describe, to_toml
from rmfs_core.scenario import RuleChoice, RulesSection, Scenario, load_scenario, shipped_scenarios


@pytest.mark.parametrize("name", shipped_scenarios())
def test_shipped_scenarios_read_back(name: str, tmp_path: Path) -> None:
    """Every value is there; files that a scenario names stay beside it, so folder and source may differ."""
    scenario = load_scenario(name)
    (tmp_path / "again.toml").write_text(to_toml(scenario), encoding="utf-8")
    again = load_scenario(tmp_path / "again.toml")
    assert evolve(again, folder=scenario.folder, source=scenario.source) == scenario


def test_comments_say_what_a_key_means() -> None:
    """With its unit, above it, no line too long; without them only keys and headers are left."""
    scenario = load_scenario("examples/small")
    text = to_toml(scenario)
    lines = text.splitlines()
    place = next(i for i, line in enumerate(lines) if line.startswith("top_speed_m_per_s"))
    assert lines[place - 1].startswith("# ")
    assert lines[place - 1].endswith("(m/s)")
    assert max(map(len, lines)) <= 100
    bare = to_toml(scenario, comments=False)
    assert "#" not in bare
    assert tomllib.loads(bare) == tomllib.loads(text)


def test_what_is_not_set_is_left_out() -> None:
    """TOML has no word for nothing; a table's own keys come before the tables below it."""
    rules = RulesSection(poa_pps=RuleChoice("integrated", {"time_limit_s": 5.0}))
    text = to_toml(Scenario(rules=rules), comments=False)
    table = tomllib.loads(text)["rules"]
    assert table["poa_pps"] == {"rule": "integrated", "time_limit_s": 5.0}
    assert "poa" not in table
    assert text.index("seed = ") < text.index("[")
    assert text.endswith("\n")
    assert not text.startswith("\n")


@pytest.mark.parametrize(
    ("metadata", "text"),
    [
        ({"doc": "Top speed", "unit": "m/s"}, "Top speed (m/s)"),
        ({"doc": "Robots", "unit": ""}, "Robots"),
        ({"doc": "Robots"}, "Robots"),
    ],
)
def test_a_unit_stands_in_brackets(metadata: dict[str, str], text: str) -> None:
    """Where there is one."""
    assert describe(metadata) == text
