"""The tables of ``rmfs explain``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.console import Console, JustifyMethod
from rich.padding import Padding
from rich.rule import Rule
from rich.table import Table
from rich.text import Text

from rmfs_commands.cli.screen import ROOM_FOR_WORDS, new_table, print_named, say
from rmfs_commands.cli.summary import gap_of
from rmfs_commands.states import Answer, Outcome, Recorded, Recording, State
from rmfs_commands.states.deciding import BundleOutcome
from rmfs_commands.states.rebuilding import OpenState, open_state
from rmfs_commands.states.stories import Episode, in_words, task_in, where_in
from rmfs_core.clock import to_seconds
from rmfs_core.roles import Role
from rmfs_core.rule_helpers import ticks_to_station
from rmfs_core.scenario import RuleChoice
from rmfs_core.scenario.tomltext import toml_value
from rmfs_core.warehouse import UNLIMITED, Order, Pod, Station
from rmfs_core.wording import counted

UNUSED_WEIGHT = 2
"""Weight of a free unit of capacity relative to a pod-station visit: W_u of the paper's objective (1)."""


def overview(recording: Recording) -> dict[str, Any]:
    """Count the decisions of a run."""
    counts: Counter[tuple[str, str]] = Counter()
    periods = 0
    for recorded in recording:
        counts[recorded.decides.label, recorded.rule] += 1
        periods = max(periods, recorded.period)
    by_rule = [{"decides": decides, "rule": rule, "decisions": count} for (decides, rule), count in counts.items()]
    return {"periods": periods, "decisions": counts.total(), "by_rule": by_rule}


def print_overview(console: Console, recording: Recording) -> None:
    """Print the number of decisions of each rule."""
    counted = overview(recording)
    table = _table("Decides", "Rule", right=("Decisions",), whole=("Rule",))
    for row in counted["by_rule"]:
        table.add_row(row["decides"], row["rule"], f"{row['decisions']:,}")
    console.print(table)
    first = next((one.period for one in recording if one.decides.assigns), 1)
    ranges = f"Periods {first} to {counted['periods']}, decisions 1 to {counted['decisions']}"
    say(console, f"{ranges}: see --period, --decision, --order, --pod.")


def print_story(console: Console, name: str, episodes: Sequence[Episode]) -> None:
    """Print what happened to an order or a pod."""
    _heading(console, f"What was decided for {name}")
    if not episodes:
        say(console, "Nothing: no decision concerned it.")
        return
    figures = ("Time", "Period", "Decision")
    by = [f"{episode.rule} ({episode.decides.label})" for episode in episodes]
    apart = max(map(len, by)) + 2 * ROOM_FOR_WORDS <= console.width
    table = _table(
        *figures, *(("By", "What") if apart else ("By whom, and what",)), right=figures, whole=(*figures, "By")
    )
    for episode, who in zip(episodes, by, strict=True):
        words = (who, episode.what) if apart else (f"{who}\n{episode.what}",)
        table.add_row(
            _span(*(f"{time_s:,.0f} s" for time_s in episode.times_s)),
            _span(*map(str, episode.periods)),
            str(episode.number),
            *map(Text, words),
        )
    console.print(table)


def print_decision(console: Console, recorded: Recorded, choice: RuleChoice, state: State, limit: int) -> None:
    """Print the state that a rule saw, and what it decided."""
    opened = open_state(state, recorded.place)
    parameters = ", ".join(f"{name} = {toml_value(value)}" for name, value in choice.parameters.items())
    when = f"period {recorded.period}, at {recorded.time_s:,.3f} s"
    _heading(console, f"Decision {recorded.number}: {recorded.decides.label} by {recorded.rule}, {when}")
    if parameters:
        say(console, f"Parameters: {parameters}.")
    console.print(_stations(opened))
    decided = recorded.decision
    assigned: dict[str, list[str]] = {}
    for given in (decided or {}).get("assignments", ()):
        assigned.setdefault(given["order"], []).append(f"{given['station']}: {', '.join(given['skus'])}")
    if recorded.decides.assigns:
        _print_backlog(console, opened, assigned, limit)
    if recorded.decides is Role.PPS:
        _print_wanted(console, opened, state.ask.max_fetches)
    if recorded.decides in (Role.ROA, Role.RPS, Role.ROA_RPS):
        _print_bundles(console, opened, decided or {}, limit)
    if opened.view.packing_stations:
        _print_packing(console, opened)
    if recorded.decides is Role.IDLE:
        _print_resting(console, opened, decided or {}, limit)
    if decided is None:
        say(console, "Decided: nothing valid; the run ended here.", style="bold red")
    else:
        _print_decided(console, recorded, opened, decided)
    if recorded.report is not None:
        say(console, _reported(recorded.report))


def print_others(console: Console, others: Sequence[Recorded]) -> None:
    """Print the pod selections that followed in the same period."""
    if not others:
        return
    _heading(console, "Pods selected in this period")
    table = _table("Decision", "Time", "By", "Pods sent", right=("Decision", "Time"), whole=("By",))
    for recorded in others:
        trips = (recorded.decision or {}).get("trips", ())
        table.add_row(str(recorded.number), f"{recorded.time_s:,.3f} s", recorded.rule, Text(_pairs(trips, "pod")))
    console.print(table)


def print_comparison(
    console: Console, recorded: Recorded, outcome: Outcome | BundleOutcome | None, answers: Sequence[tuple[str, Answer]]
) -> None:
    """Print what other rules would have decided in the same state."""
    _heading(console, "The same state, other rules")
    rows = [(f"{recorded.rule} (decided)", recorded.decision or {}, recorded.report, outcome)]
    rows += [(text, answer.decision, answer.report, answer.outcome) for text, answer in answers]
    if isinstance(outcome, BundleOutcome):
        print_named(console, _bundle_outcomes(rows))
    elif outcome is not None:
        print_named(console, _outcomes(rows))
        outcomes = [row for *_, row in rows if isinstance(row, Outcome)]
        if any(row.uncovered for row in outcomes):
            say(
                console,
                "Not covered: open requests that no pod at the station or bound for it can serve yet. They take more "
                "visits, so there is no sum (-).",
            )
        if any(row.orders == 1 and row.unused for row in outcomes) and any(row.orders > 1 for row in outcomes):
            say(console, "Each rule was asked once. In a run, one that decides on one order at a time is asked again.")
        if any(report is not None for _, _, report, _ in rows):
            say(
                console,
                "Objective and bound are the rule's own; the paper's models count pods that are there already, too.",
            )
    decisions = [(name, _in_words(recorded.content, decision)) for name, decision, _, _ in rows]
    if max(len(name) for name, _ in decisions) + ROOM_FOR_WORDS <= console.width:
        table = _table("Rule", "Decision", whole=("Rule",))
        for name, words in decisions:
            table.add_row(Text(name), Text(words))
        console.print(table)
    else:
        for name, words in decisions:
            say(console, f"{name}:")
            console.print(Padding(Text(words), (0, 0, 0, 2)))


Row = tuple[str, Mapping[str, Any], Mapping[str, Any] | None, Outcome | BundleOutcome | None]
"""A rule, its decision, its report, and what the decision comes to."""


def _bundle_outcomes(rows: Sequence[Row]) -> Table:
    table = new_table()
    table.add_column("Rule")
    for heading in ("Bundles", "Items\non pods", "New\nvisits", "Unused", "Without\na pod"):
        table.add_column(heading, justify="right", no_wrap=True)
    for name, _, _, outcome in rows:
        assert isinstance(outcome, BundleOutcome)
        figures = (outcome.bundles, outcome.items, outcome.visits, outcome.unused, outcome.without_pod)
        table.add_row(Text(name), *map(str, figures))
    return table


def _outcomes(rows: Sequence[Row]) -> Table:
    table = new_table()
    table.add_column("Rule")
    weighted = f"Visits +\n{UNUSED_WEIGHT} unused"
    for heading in ("Orders", "Items", "New\nvisits", "Unused", weighted, "Not\ncovered", "Objective\n/ bound"):
        table.add_column(heading, justify="right", no_wrap=True)
    for name, _, report, outcome in rows:
        assert isinstance(outcome, Outcome)
        total = "-" if outcome.uncovered else str(outcome.visits + UNUSED_WEIGHT * outcome.unused)
        table.add_row(
            Text(name),
            str(outcome.orders),
            str(outcome.items),
            str(outcome.visits),
            str(outcome.unused),
            total,
            str(outcome.uncovered),
            f"{_number(report['objective'])} / {_number(report['bound'])}" if report else "-",
        )
    return table


def _stations(opened: OpenState) -> Table:
    stores = bool(opened.warehouse.storing)
    table = _table(
        "Station",
        "Free",
        *(("Bundles",) if stores else ()),
        "Requests",
        "Not covered",
        "Queue free",
        "Inbound pods",
        right=("Free", *(("Bundles",) if stores else ()), "Requests", "Not covered", "Queue free"),
    )
    for station in opened.warehouse.stations:
        there = set(station.pods_in_line)
        pods = [f"{pod.name}*" if pod.id in there else pod.name for pod in station.inbound_pods]
        table.add_row(
            station.name,
            _free(station),
            *((f"{len(station.bundles)} of {station.bundle_capacity}" if station.stores else "-",) if stores else ()),
            str(station.open_items),
            str(station.uncovered_items),
            str(station.queue_room),
            Text(", ".join(pods) or "-"),
        )
    if any(station.pods_in_line for station in opened.warehouse.stations):
        table.caption = "* in the line at the station"
        table.caption_justify = "left"
    return table


def _free(station: Station) -> str:
    if not station.picks:
        return "-"
    unit = "orders" if station.counts_orders else "items"
    if not station.in_service:
        return "out of service"
    return f"{station.free_capacity} of {station.capacity} {unit}" if station.open else "closed"


def _waiting(opened: OpenState) -> str:
    """Say how many orders wait for stock."""
    number = len(opened.view.orders_waiting_for_stock)
    return f"; {number:,} more {'waits' if number == 1 else 'wait'} for stock" if number else ""


def _print_backlog(console: Console, opened: OpenState, assigned: Mapping[str, Sequence[str]], limit: int) -> None:
    backlog, whole = opened.view.backlog, opened.warehouse.backlog
    items = sum(order.open_items for order in backlog)
    hidden = f" (the prefilters left out {len(whole) - len(backlog)} more)" if len(whole) > len(backlog) else ""
    say(
        console,
        f"Backlog: {counted(len(backlog), 'order')} with {counted(items, 'open item')}{hidden}{_waiting(opened)}; "
        f"decided for: {len(assigned):,}.",
    )
    due = ("Due in", "Priority") if any(order.due_s is not None or order.priority for order in backlog) else ()
    table = _table("Order", "Waits", *due, "Open lines (SKUs)", "Goes to station", right=("Waits", *due))
    rows = [order for order in backlog if order.name in assigned]
    rows += [order for order in backlog if order.name not in assigned][: max(limit - len(rows), 0)]
    for order in rows[:limit]:
        waits = opened.warehouse.now - order.arrival_tick
        table.add_row(
            Text(order.name),
            f"{to_seconds(waits):,.0f} s",
            *(("-" if order.slack_s is None else f"{order.slack_s:,.0f} s", str(order.priority)) if due else ()),
            Text(_lines(opened, order)),
            Text("; ".join(assigned.get(order.name, ()))),
        )
    console.print(table)
    if len(backlog) > len(rows[:limit]):
        say(console, f"... and {counted(len(backlog) - len(rows[:limit]), 'more order')}; --limit shows more.")


def _print_wanted(console: Console, opened: OpenState, max_fetches: int | None) -> None:
    """Print what pods are wanted for, and which could be sent."""
    table = _table("Station", "SKUs not covered")
    for station in opened.warehouse.stations:
        skus = Counter[str]()
        for request in station.uncovered_requests:
            skus[opened.instance.skus[request.sku]] += request.items
        if skus:
            table.add_row(station.name, Text(_counted(skus)))
    console.print(table)
    leaving = ", ".join(pod.name for pod in opened.view.leaving_pods)
    say(
        console,
        f"{max_fetches} of {len(opened.view.free_pods)} free pods could be sent (robots that can start); "
        + (f"leaving a station: {leaving}." if leaving else "no pod is leaving a station."),
    )


def _print_bundles(console: Console, opened: OpenState, decided: Mapping[str, Any], limit: int) -> None:
    """Print the bundles that wait for a station or a pod, and what was decided for them."""
    stations = {given["bundle"]: given["station"] for given in decided.get("bundles", ())}
    pods = {given["bundle"]: given["pod"] for given in decided.get("stores", ())}
    at_stations = (bundle for station in opened.warehouse.storing for bundle in station.bundles)
    waiting = [bundle for bundle in (*opened.warehouse.bundles.values(), *at_stations) if bundle.pod is None]
    table = _table("Bundle", "Waits", "Items", "Space", "Station", "Goes on pod", right=("Waits", "Items", "Space"))
    for bundle in sorted(waiting, key=lambda one: one.name not in {*stations, *pods})[:limit]:
        at = stations.get(bundle.name, "")
        table.add_row(
            Text(bundle.name),
            f"{to_seconds(opened.warehouse.now - bundle.arrival_tick):,.0f} s",
            Text(f"{bundle.items} x {opened.instance.skus[bundle.sku]}"),
            str(bundle.size),
            Text(at if bundle.station is None else opened.warehouse.stations[bundle.station].name),
            Text(_with_room(opened, pods[bundle.name]) if bundle.name in pods else ""),
        )
    console.print(table)
    if len(waiting) > limit:
        say(console, f"... and {counted(len(waiting) - limit, 'more bundle')}; --limit shows more.")


def _print_resting(console: Console, opened: OpenState, decided: Mapping[str, Any], limit: int) -> None:
    """Print the robots without a task, first the ones that are sent somewhere, with the charge of their batteries."""
    layout, sent = opened.warehouse.travel.layout, {rest["robot"]: rest["cell"] for rest in decided.get("rests", ())}
    robots = opened.view.resting_robots
    kinds = {
        cell: ", a charger" if cell in opened.view.chargers else ", a charger out of service"
        for cell in layout.chargers
    }
    charged = any(robot.charge is not None for robot in robots)
    table = _table("Robot", "At", *(("Charge",) if charged else ()), "Goes to", right=("Charge",) if charged else ())
    for robot in sorted(robots, key=lambda one: (one.name not in sent, one.charge or 0))[:limit]:
        charge = "" if robot.charge is None else f"{robot.charge:.1%}{', too low for a task' if robot.low else ''}"
        places = [robot.cell, *([sent[robot.name]] if robot.name in sent else [])]
        at, *to = [f"{layout.where(cell)}{kinds.get(cell, '')}" for cell in places]
        table.add_row(Text(robot.name), at, *((charge,) if charged else ()), *(to or [""]))
    console.print(table)
    if len(robots) > limit:
        say(console, f"... and {counted(len(robots) - limit, 'more robot')}; --limit shows more.")


def _with_room(opened: OpenState, name: str) -> str:
    pod = opened.warehouse.pods[opened.names.pods[name]]
    return name if pod.free_space >= UNLIMITED else f"{name} ({pod.free_space} free)"


def _print_packing(console: Console, opened: OpenState) -> None:
    """Print what there is at packing stations."""
    table = _table("Packing station", "Free boxes", "Orders", "To put", "To pack", "At work", right=_OF_PACKING)
    for station in opened.view.packing_stations:
        kinds = Counter(task.kind for task in station.tasks)
        numbers = station.free_boxes, len(station.orders), kinds["put"], kinds["pack"], len(station.working)
        table.add_row(station.label, *map(str, numbers))
    console.print(table)


_OF_PACKING = ("Free boxes", "Orders", "To put", "To pack", "At work")


def _print_decided(console: Console, recorded: Recorded, opened: OpenState, decided: Mapping[str, Any]) -> None:
    if decided.get("trips"):
        table = _table("Pod sent", "To station", "Drive", "Holds SKUs", right=("Drive",))
        for trip in decided["trips"]:
            pod = opened.warehouse.pods[opened.names.pods[trip["pod"]]]
            station = opened.warehouse.stations[opened.names.stations[trip["station"]]]
            drive = to_seconds(ticks_to_station(opened.view, pod, station))
            table.add_row(Text(trip["pod"]), Text(trip["station"]), f"{drive:.1f} s", Text(_held(opened, pod)))
        console.print(table)
    elif "trips" in decided:
        say(console, "Decided: no pod is sent.")
    if decided.keys() & {"tasks", "cell", "active", "rests", "moves", "packing", "task"}:
        say(console, f"Decided: {_in_words(recorded.content, decided)}.")


def _in_words(content: Mapping[str, Any], decision: Mapping[str, Any]) -> str:
    said = []
    if "cell" in decision:
        said.append(f"pod {content['ask']['pod']} is stored at {where_in(content, decision['cell'])}")
    if "tasks" in decision:
        said.append(
            ", ".join(f"robot {task['robot']} fetches pod {task['pod']}" for task in decision["tasks"]) or "no task"
        )
    if "packing" in decision:
        said.append(f"packing stations: orders {_pairs(decision['packing'], 'order')}")
    if "task" in decision:
        said.append(in_words(task_in(content, decision["task"])))
    if "active" in decision:
        said.append(f"active stations: {', '.join(decision['active']) or 'none'}")
    for move in (*decision.get("rests", ()), *decision.get("moves", ())):
        what = f"robot {move['robot']} goes" if "robot" in move else f"pod {move['pod']} is carried"
        until = f" until its battery is filled to {move['charge']:.0%}" if move.get("charge") else ""
        said.append(f"{what} to {where_in(content, move['cell'])}{until}")
    if not said and {"rests", "moves"} & decision.keys():
        said.append("no move")
    if "assignments" in decision:
        said.append(f"orders {_pairs(decision['assignments'], 'order')}")
    if "trips" in decision:
        said.append(f"pods {_pairs(decision['trips'], 'pod')}")
    if "bundles" in decision:
        said.append(f"bundles {_pairs(decision['bundles'], 'bundle')}")
    if "stores" in decision:
        onto = [{"station": f"pod {given['pod']}", "bundle": given["bundle"]} for given in decision["stores"]]
        said.append(f"bundles {_pairs(onto, 'bundle')}")
    return "; ".join(said) or "nothing valid"


def _pairs(entries: Iterable[Mapping[str, str]], what: str) -> str:
    """Name what goes to which station, station by station: ``4, 17 to 1; 8 to 2``."""
    by_station: dict[str, list[str]] = {}
    for entry in entries:
        by_station.setdefault(entry["station"], []).append(entry[what])
    return "; ".join(f"{', '.join(names)} to {station}" for station, names in sorted(by_station.items())) or "none"


def _lines(opened: OpenState, order: Order) -> str:
    return _counted({opened.instance.skus[line.sku]: line.quantity for line in order.open_lines})


def _held(opened: OpenState, pod: Pod) -> str:
    if opened.warehouse.unlimited_stock:
        return ", ".join(opened.instance.skus[sku] for sku in pod.contents)
    return _counted({opened.instance.skus[sku]: number for sku, number in pod.contents.items()})


def _counted(skus: Mapping[str, int]) -> str:
    """Name SKUs with their numbers of items, where these are not 1."""
    return ", ".join(sku if number == 1 else f"{number} x {sku}" for sku, number in skus.items())


def _reported(report: Mapping[str, Any]) -> str:
    early = ""
    if report["stopped_early"]:
        limit = "its effort" if report["status"] == "effort" else "a limit"
        gap = gap_of(report["objective"], report["bound"])
        early = f"; {limit} ended the solve before its proof" + ("" if gap is None else f", gap {gap:.1%}")
    return (
        f"Model: {report['status']}, objective {_number(report['objective'])}, bound {_number(report['bound'])}{early}."
    )


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:,.6g}"


def _span(first: str, last: str) -> str:
    return first if first == last else f"{first} - {last}"


def _table(*columns: str, right: Sequence[str] = (), whole: Sequence[str] = ()) -> Table:
    table = new_table()
    for column in (*columns, *(name for name in right if name not in columns)):
        justify: JustifyMethod = "right" if column in right else "left"
        table.add_column(column, justify=justify, overflow="fold", no_wrap=column in whole)
    return table


def _heading(console: Console, text: str) -> None:
    title = Text(text, style="bold")
    console.print(Rule(title, align="left", style="dim") if len(text) + 4 <= console.width else title)
