"""The decisions that a run recorded, in the form of the page: who decided what, and when."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rmfs_commands.states.recorded import read_recording
from rmfs_commands.states.recording import RECORDING_FILE
from rmfs_commands.trace import Trace
from rmfs_core.clock import to_ticks
from rmfs_core.errors import InputError
from rmfs_core.roles import Role

ANSWERS = {
    "assignments": ("order", "station"),
    "trips": ("pod", "station"),
    "tasks": ("robot", "pod"),
    "bundles": ("bundle", "station"),
    "stores": ("bundle", "pod"),
    "rests": ("robot", "cell"),
    "moves": ("pod", "cell"),
}
"""Keys of a decision, and the two things that each of its parts is about."""
BUNDLES = (Role.ROA, Role.RPS, Role.ROA_RPS)


def recorded_decisions(folder: Path, start: Trace, bundles: Sequence[str] = ()) -> Mapping[str, Any] | None:
    """Return the recorded decisions of a run as columns: one a decision, and one a thing that was decided.

    ``parts`` has the number of things of each decision; ``what`` is 0 for an order and its station, 1 for a pod and
    its station, 2 for a robot and its pod, 3 for a bundle and its station, 4 for a bundle and its pod, 5 for a robot
    and the cell where it rests, 6 for a pod and the cell where it is carried, 7 for a pod and the cell where it is
    stored. ``backlog`` has what the rule was shown: orders with open lines, or bundles that wait. None: nothing was
    recorded.

    Parameters
    ----------
    folder
        Where the results are.
    start
        The header of the trace.
    bundles
        Names of the bundles by their ids.

    Raises
    ------
    InputError
        When the file is damaged, or of another run.
    """
    file = folder / RECORDING_FILE
    if not file.exists():
        return None
    ids: dict[str, Any] = {
        "order": {order.name: i for i, order in enumerate(start.instance.orders)},
        "pod": {pod.name: i for i, pod in enumerate(start.instance.pods)},
        "station": {station["name"]: i for i, station in enumerate(start.stations)},
        "robot": {str(i + 1): i for i in range(len(start.robots))},
        "bundle": {name: i for i, name in enumerate(bundles)},
        "cell": range(len(start.layout.kind)),
    }
    texts: dict[str, int] = {}
    names = ("tick", "decides", "rule", "backlog", "parts", "what", "one", "other")
    columns = {name: array("q") for name in names}
    last = 0
    place = str(file)
    try:
        for decision in read_recording(file):
            place = decision.place
            tick, decided = to_ticks(decision.time_s), decision.decision or {}
            parts = [
                (what, ids[one][part[one]], ids[other][part[other]])
                for what, (key, (one, other)) in enumerate(ANSWERS.items())
                for part in decided.get(key, ())
            ]
            if "cell" in decided:
                parts.append((len(ANSWERS), ids["pod"][decision.content["ask"]["pod"]], int(decided["cell"])))
            row = {
                "tick": tick - last,
                "decides": texts.setdefault(decision.decides.label, len(texts)),
                "rule": texts.setdefault(decision.rule, len(texts)),
                "backlog": _shown(decision.content, decision.decides),
                "parts": len(parts),
            }
            for name, value in row.items():
                columns[name].append(value)
            for what, one_id, other_id in parts:
                columns["what"].append(what)
                columns["one"].append(one_id)
                columns["other"].append(other_id)
            last = tick
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(place, f"is no decision of the run that the trace tells of: {error}") from error
    return {**columns, "texts": list(texts)}


def _shown(content: Mapping[str, Any], decides: Role) -> int:
    """Return how many orders had open lines in what a rule saw; bundles that wait, for a rule that decides on them."""
    if decides in BUNDLES:
        return sum("station" not in bundle for bundle in content.get("bundles") or ())
    if "backlog" in content:
        return len(content["backlog"])
    return sum(
        len(order["lines"]) > sum(len(part["skus"]) for part in order.get("parts") or ())
        for order in content["orders"].values()
        if not order.get("waits_for_stock")
    )
