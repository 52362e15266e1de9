"""All placements of a history, and the one that is chosen by it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from attrs import frozen

from rmfs_commands.slotting.changes import Change, Floor, best_changes
from rmfs_commands.slotting.judging import pods_csv
from rmfs_commands.slotting.past import Past
from rmfs_commands.slotting.placing import NOW, Placement, Placer, Stock, cells_of, driving_s, located
from rmfs_core.scenario.model import Scenario
from rmfs_core.wording import counted
from rmfs_core.world import make_layout


@frozen(eq=False)
class Made:
    """The placements.

    Parameters
    ----------
    batch
        Orders of a batch of the surrogate.
    placements
        All of them, the pods as they are first.
    chosen
        The one that needs the fewest visits in the held-back part of the history.
    changes
        The changes of the placement ``moves``.
    pods
        Text of the file of pods, by name of the placement.
    notes
        Sentences about orders and SKUs left out.
    """

    batch: int
    placements: Sequence[Placement]
    chosen: Placement
    changes: Sequence[Change]
    pods: dict[str, str]
    notes: Sequence[str]


def make_placements(
    scenario: Scenario, past: Past, names: Sequence[str], steps: int, moves: int, tell: Callable[[str], None]
) -> Made:
    """Make placements, improve the best one, and look for single changes.

    Parameters
    ----------
    scenario
        The scenario whose pods are filled.
    past
        Its history.
    names
        Placements to make.
    steps
        Exchanges that the local search tries.
    moves
        Changes of the pods as they are to look for.
    tell
        Is told what is being done.
    """
    layout = make_layout(scenario)
    seconds = driving_s(scenario, layout)
    visit_s = 2 * float(seconds.mean() + float(scenario.robots.lift_s))
    batch = _batch(scenario, past, visit_s, len(layout.stations) - layout.replenishing)
    placer = Placer(past, Stock.of(past, scenario), batch, scenario.seed)
    made, notes = [placer.now()], list[str]()
    for name in names:
        tell(f"Placing: {name}.")
        if (found := placer.made(name)) is None:
            notes.append(f"Placement {name} is left out: it does not fit into `instance.pod_capacity`.")
        else:
            made.append(found)
    tell(f"Improving the best by local search: {steps:,} exchanges.")
    made.append(placer.improved(min(made, key=lambda one: one.held_back), steps))
    chosen = min(made, key=lambda one: one.held_back)
    if past.strange:
        notes.append(f"SKUs of the history that stand on no pod: {past.strange:,}, left out.")
    skus = past.skus()
    if unknown := sum(sku.lines == 0 for sku in skus):
        notes.append(f"SKUs on pods without history: {unknown:,} of {len(skus):,}, placed anywhere.")
    pods = past.instance.pods
    cells = {one.name: located(pods, placer.visits(one), layout, seconds) for one in made}
    cells[NOW] = cells_of(pods, layout)
    changes = list[Change]()
    if moves:
        tell(f"Looking for what pays soonest: {counted(moves, 'change')}.")
        stays = scenario.rules.pr is not None and scenario.rules.pr.rule == "fixed"
        floor = Floor(layout, seconds, visit_s, float(scenario.stations.handle_s), stays)
        moved, changes, cells_after = best_changes(placer, floor, moves, scenario.seed)
        made.append(moved)
        cells[moved.name] = cells_after
        if len(changes) < moves:
            notes.append(f"Changes that save visits in the history: {len(changes):,}, not {moves:,}.")
    texts = {one.name: pods_csv(past, one.contents, cells[one.name], layout) for one in made}
    return Made(batch, made, chosen, changes, texts, notes)


def _batch(scenario: Scenario, past: Past, visit_s: float, stations: int) -> int:
    """Return how many orders of the history a picking station has at a time, in the hours in which most arrive.

    By Little's law: arrivals times the time of an order, a visit and its items, longer by the load of the picker; at
    most the station's capacity.
    """
    given = scenario.stations.order_capacity
    most = _mean(scenario.stations.item_capacity) / past.quantities if given is None else _mean(given)
    rate = past.orders_per_hour / 3600 / stations
    work_s = past.quantities * float(scenario.stations.handle_s)
    return max(1, round(min(most, rate * (visit_s + work_s) / max(1 - rate * work_s, 0.01))))


def _mean(given: int | tuple[int, ...]) -> float:
    numbers = given if isinstance(given, tuple) else (given,)
    return sum(numbers) / len(numbers)
