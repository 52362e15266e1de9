"""A lane that robots cannot pass each other in, and rules that heed nobody, for tests of driving."""

from pathlib import Path

from rmfs_commands.layouts import parse_map
from rmfs_commands.testing import small_instance
from rmfs_core.scenario.model import RuleChoice

CORRIDOR_MAP = "\n".join(["#" + "." * 60 + "qO", "#.." + "@" * 57 + "...", "#.#" + "@" * 60, "@#@" + "@" * 60])
"""One lane of nearly 60 cells, two-way, between all storage locations and the station."""

CORRIDOR = parse_map(CORRIDOR_MAP, "corridor")

INSTANCE = small_instance(
    {f"o{i}": [sku] for i, sku in enumerate("abcd" * 4)}, {"1": ["a"], "2": ["b"], "3": ["c"], "4": ["d"]}
)

RULE = """
from attrs import define
from rmfs_core import Leg, Path, hookimpl

@define
class Mine:
    reserves = {reserves!r}
    @hookimpl
    def plan_path(self, warehouse, robot, goal, traffic):
        start = traffic.query
        legs = warehouse.travel.fastest_path(start.cell, start.heading, goal, loaded=robot.pod is not None)
        return Path({legs})
"""


def inline(folder: Path, reserves: str, legs: str = "legs") -> RuleChoice:
    (folder / "mine.py").write_text(RULE.format(reserves=reserves, legs=legs))
    return RuleChoice("./mine.py:Mine")
