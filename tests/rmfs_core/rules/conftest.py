from collections.abc import Callable
from pathlib import Path

import pytest

from rmfs_core import InputError
from rmfs_core.rules import RuleSet
from rmfs_core.scenario.model import RuleChoice, RulesSection
from saying import said


@pytest.fixture
def refusal() -> Callable[..., str]:

    def refused(folder: str | Path = ".", **choices: RuleChoice | None) -> str:
        rules = RulesSection(**({"poa": RuleChoice("pod-match"), "pps": RuleChoice("demand")} | choices))
        return said(InputError, RuleSet.load, rules, str(folder))

    return refused
