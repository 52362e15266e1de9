"""The rule ``learned``: its network, its files, and that it is a rule as any other."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rmfs_core
from cases import cases
from rmfs_commands.gym import FEATURES, Learned, RowNetwork, write_networks
from rmfs_core import InputError, RuleError
from rmfs_core.roles import Role

FEW = ["instance.orders=15", "rules.pp=free-flow"]


def test_a_network_scores_each_row_by_itself() -> None:
    """With 2 features and 1 unit: 3 x - y + 2 tanh(x + 4 y - 1). Ties go to the lowest slot, masked slots to nobody."""
    network = RowNetwork.of([3, -1, 1, 4, -1, 2], 2)
    rows = np.array([[0.0, 1.0], [0.3, 0.0], [1.0, 1.0], [0.5, 0.5], [0.5, 0.5]], np.float32)
    scores = [3 * x - y + 2 * math.tanh(x + 4 * y - 1) for x, y in rows.tolist()]
    assert scores.index(max(scores)) == 2
    assert network.best(rows, np.ones(5)) == 2
    assert network.best(rows, np.array([1, 1, 0, 1, 1])) == 3
    assert network.best(rows, np.array([1, 1, 0, 0, 0])) == max((0, 1), key=scores.__getitem__)
    assert network.best(np.vstack([rows] * 40), np.arange(200) >= 100) == 102
    assert (RowNetwork.size(2, 1), RowNetwork.size(8, 0), RowNetwork.of(range(8), 8).outer.size) == (6, 8, 0)


def test_weights_of_a_scenario(tmp_path: Path) -> None:
    """A file's network decides as the rule that it imitates, in the environment as in a run; its digest is kept."""
    weights = [0.0] * 8
    weights[[feature.name for feature in FEATURES[Role.PPS]].index("drive")] = -1.0
    write_networks(tmp_path / "near.json", {"PPS": weights})
    rule = f'rules.pps={{rule = "learned", weights = "{tmp_path}/near.json"}}'
    learned = rmfs_core.run("examples/small", overrides=[*FEW, rule])
    nearest = rmfs_core.run("examples/small", overrides=[*FEW, "rules.pps=nearest-pod"])
    assert (learned.orders, learned.visits) == (nearest.orders, nearest.visits)
    assert any("near.json" in name for name in learned.versions)
    with pytest.raises(InputError, match=r"the features of PPS are .*; expected serves, .*, idle, wait"):
        rmfs_core.run("examples/small", overrides=[*FEW, rule.replace("}", ", may_wait = true}")])
    write_networks(tmp_path / "near.json", {"PPS": [*weights, -9]}, may_wait=True)
    waiting = rmfs_core.run("examples/small", overrides=[*FEW, rule.replace("}", ", may_wait = true}")])
    assert (waiting.orders, waiting.visits) == (nearest.orders, nearest.visits)
    write_networks(tmp_path / "near.json", {"PPS": weights})
    joint = rmfs_core.load_scenario("paper-250", [rule.replace("rules.pps", "rules.poa_pps"), *FEW])
    with pytest.raises(RuleError, match=r"its file has no network for POA\+PPS; expected one that was trained for it"):
        rmfs_core.run(joint)


@cases(
    "weights sentence",
    ({"PPS": [1.0, 2, 3]}, "weights of PPS: expected 8 finite numbers, and 10 more for each hidden unit, found 3"),
    ({"PPS": [math.nan] * 8}, "weights of PPS: expected 8 finite numbers"),
    ({"PPS": "abc"}, "weights of PPS: "),
    ({"pps": [0.0] * 8}, "weights: found 'pps'; expected POA, PPS, PR, TA or POA.PPS"),
)
def test_weights_that_no_network_has_are_not_written(weights: Any, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=sentence):
        write_networks(tmp_path / "odd.json", {"POA": [0.0] * 8, **weights})
    assert not [*tmp_path.iterdir()]


@cases(
    "told sentence",
    ("[]", "odd.json holds no weights of networks; expected a file of `rmfs.gym.write_networks`"),
    ("{", "odd.json holds no weights of networks"),
    ({"PR+TA": {}}, "no role is called 'PR.TA'"),
    ({"PPS": {"features": ["a"], "weights": [1]}}, "the features of PPS are .'a'.; expected serves, completes"),
    (
        {"PPS": {"features": ["a"], "weights": [1, 2]}},
        "expected 1 finite numbers, and 3 more for each hidden unit, fou",
    ),
    ({"PPS": {"features": ["a"], "weights": [math.nan]}}, "expected 1 finite numbers"),
    ({"PPS": {"features": ["a"], "weights": [[1]]}}, "expected 1 finite numbers"),
    ({"PPS": {"weights": [1]}}, "holds no weights of networks"),
)
def test_a_file_without_networks_is_named(told: Any, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "odd.json"
    file.write_text(told if isinstance(told, str) else json.dumps(told))
    with pytest.raises(ValueError, match=sentence):
        Learned(weights=file)
    with pytest.raises(InputError, match=f'rule "learned" .rmfs [^:]*: .*{sentence}'):
        rmfs_core.run("examples/small", overrides=[f'rules.pps={{rule="learned",weights="{file}"}}'])


@pytest.mark.parametrize("decides", Learned.decides)
def test_the_shipped_weights_give_more_than_chance(decides: Role) -> None:
    by_rule = rmfs_core.run(rmfs_core.load_scenario("examples/small", FEW), rules={decides.key: Learned()})
    by_chance = rmfs_core.run("examples/small", overrides=[*FEW, "rules.pps=random"])
    assert by_rule.metrics["psv_per_order"] < by_chance.metrics["psv_per_order"]
