from collections.abc import Callable
from typing import Any

import numpy as np

from rmfs_commands.gym import FEATURES
from rmfs_core.roles import Role

Policy = Callable[[Any, Any], int]

COPIES: dict[tuple[str, str], tuple[str, ...]] = {
    ("PPS", "nearest-pod"): ("drive",),
    ("PPS", "demand"): ("-wanted", "drive"),
    ("PPS", "completes"): ("-completes", "-serves", "drive"),
    ("POA", "pod-match"): ("-available", "order", "load", "station"),
    ("POA", "first-come"): ("order", "load", "station"),
    ("PR", "nearest"): ("drive",),
    ("TA", "nearest-robot"): ("drive",),
}
"""Criteria of a rule for a decision: the least, or the most (``-``); ties are decided by the next."""


def copy_of(decides: str, rule: str, stations: int = 2) -> Policy:
    """Return a policy that chooses as a shipped rule does in a warehouse with so many stations."""
    names = [feature.name for feature in FEATURES[Role.labelled(decides)]]

    def choose(observation: Any, mask: Any) -> int:
        slots = np.flatnonzero(mask)
        known = {"order": slots // stations, "station": slots % stations}
        keys = []
        for key in COPIES[decides, rule]:
            name = key.removeprefix("-")
            values = known[name] if name in known else observation[slots, names.index(name)]
            keys.append(-values if key.startswith("-") else values)
        return int(slots[np.lexsort(keys[::-1])[0]])

    return choose
