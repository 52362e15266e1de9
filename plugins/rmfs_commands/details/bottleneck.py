"""Parts of the orders' time, causes of their waiting, and so the limit of a run: ``bottleneck`` of `Result.summary`.

Every tick of an order's time has a cause; the limit is the cause with the largest share. While an order waits in the
backlog, the cause is what the picking stations do at that time, each its part: a picker who handles an item (the
pickers), a closed station (the hours, or the rule that closes it), one with nothing to pick, while another has more
than its share (the spread) or while none has (the rules hold the orders back). A station that waits for pods does so
since its queue is full and pods wait for it (the queues), or since no robot is free (the robots); else its pods
are on their way, and it has no capacity for orders that could be picked meanwhile (the room). Robots off duty are a
matter of the hours, and robots that wait for chargers or stand there one of the chargers; robots in queues and under
pods wait themselves, for what the stations do.

Packing comes after that: packers, or boxes, limit a run where they are at work all the time or take longer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from math import fsum
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import define, field, frozen
from numpy.typing import NDArray

from rmfs_commands.details.delays import Delays
from rmfs_commands.details.outages import robots_may_fail
from rmfs_commands.details.packing import Packing
from rmfs_commands.details.robots import Robots
from rmfs_commands.details.slots import at_work
from rmfs_commands.details.spans import Span, open_spans, ratio
from rmfs_commands.details.stations import Followed, Stations
from rmfs_commands.processes.hours import hours_of, mean_speed, shifts_of
from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.simulation.services import Services

if TYPE_CHECKING:
    from rmfs_core.info import RunInfo

PARTS: Mapping[str, tuple[str, ...]] = {
    "before": ("before_s",),
    "stock": ("stock_s",),
    "room": ("backlog_s", "other_parts_s"),
    "robot": ("robot_s",),
    "pod": ("pod_s",),
    "driving": ("to_pod_s", "driving_s"),
    "queueing": ("room_s", "queueing_s"),
    "picking": ("station_s",),
    "hands": ("handling_s",),
}
"""Parts of the turn-over time, by the columns of delays.csv that they are made of; ``before`` only of runs that begin
in a state."""

LIMITS: Mapping[str, tuple[str, str]] = {
    "pickers": ("busy with other items", "one more station"),
    "robots": ("none was free", "one more robot"),
    "chargers": ("robots charged or waited for it", "one more charger"),
    "queues": ("queues full, pickers without a pod", "longer queues (`stations.queue_length`)"),
    "spread": ("other stations had less to pick", "rules that spread the orders evenly"),
    "held": ("held back, no station was given them", "rules that assign them earlier"),
    "stock": ("the pods held too little", "stock that never lacks"),
    "hours": ("stations closed or robots off duty", "stations and robots at all hours"),
    "closed": ("`rules.activate` had stations closed", "a rule that opens more stations"),
    "outages": ("stations or robots out of service", "machines that do not fail"),
    "room": ("stations were full, with robots free", "more capacity (`stations.item_capacity`)"),
    "pods": ("pods were elsewhere, robots free", "the same SKUs on more pods"),
}
"""Causes that there could be less of: what happened meanwhile, and what would help. Those besides are ``driving`` and
``picking``, the work on an order itself; ``outages`` only where stations or robots may fail."""

WORTH_SAYING = 10
"""Percent of the orders' time from which on a cause is said besides the limit."""

LEAST_THERE = 0.1
"""Share of the time of the station that was there the longest from which on a station can be the busiest or idlest."""

_NO_LESS: Mapping[str, float | None] = {"time_s": None, "time_percent": None}
"""Of a gain that no time is known of."""

LINE = 72
"""Characters of a sentence, so that a summary takes ten lines of a terminal."""

BUSY = 90
"""Percent of the packers' time at work, or of the boxes reserved, from which on they limit a run."""

DOES = {
    "idle": "idle",
    **dict.fromkeys(("to_pod", "to_station", "storing", "to_rest", "moving_pods"), "driving"),
    "waiting": "traffic",
    "queue": "queueing",
    "station": "at_station",
    "charging": "charging",
    "off": "off",
    "down": "down",
}
"""Activities of robots, by the columns of robots.csv. Waiting under a pod for a queue cell is queueing, too."""

Ticks = NDArray[np.int64]


@define
class _Pieces:
    """Time cut into pieces in each of which nothing changes at stations and among robots.

    Parameters
    ----------
    bounds
        Where the pieces begin, and where the last one ends. Shape (pieces + 1,).
    """

    bounds: Ticks

    def level(self, begins: Ticks, ends: Ticks) -> Ticks:
        """Return how many of some spans, which begin and end at bounds, hold in each piece."""
        change = np.bincount(np.searchsorted(self.bounds, begins), minlength=len(self.bounds))
        change -= np.bincount(np.searchsorted(self.bounds, ends), minlength=len(self.bounds))
        return change.cumsum()[:-1]

    def beneath(self, spans: Sequence[Span]) -> Ticks:
        """Return in how many of some spans, during which robots stand under pods, each piece is."""
        return self.level(*np.array(spans, dtype=np.int64).reshape(-1, 2).T)

    def of(self, station: Followed, staffed: Sequence[Span] | None) -> tuple[Ticks, Ticks, Ticks, Ticks]:
        """Return, as 0 or 1 for each piece, whether a station's picker handles an item, does or has one to pick, and
        whether the station is there: open, or finishing what it has; and whether it is out of service instead: not
        while it is closed by its timetable, where there is one, with nothing to finish."""
        begins = self.bounds[:-1]
        here = np.minimum(self.level(np.array(station.begun), np.array(station.free)), 1)
        down = np.where(here > 0, 0, station.down.at(begins))
        if staffed is not None:
            down = np.where((self.beneath(staffed) > 0) | (station.requests.at(begins) > 0), down, 0)
        either = np.maximum(here, (station.requests.at(begins) > 0) & (down == 0))
        return here, either, np.maximum(either, station.open.at(begins) > 0), down

    def ticks_of(self, begins: Ticks, ends: Ticks) -> Ticks:
        """Return how many ticks of some spans are in each piece, summed over the spans."""
        number, found = len(self.bounds) - 1, np.zeros(len(self.bounds) - 1, dtype=np.int64)
        for ticks, sign in ((begins, 1), (ends, -1)):
            piece = np.minimum(np.searchsorted(self.bounds, ticks, side="right") - 1, number - 1)
            later = np.bincount(piece, minlength=number).cumsum()
            within = np.bincount(piece, weights=self.bounds[piece + 1] - ticks, minlength=number).astype(np.int64)
            found += sign * (within + np.diff(self.bounds) * np.concatenate(([0], later[:-1])))
        return found


@define
class _Waits:
    """When orders waited for something: begins and ends, some of which are the same."""

    begins: list[int] = field(factory=list)
    ends: list[int] = field(factory=list)

    def add(self, begin: int, end: int) -> None:
        if begin < end:
            self.begins.append(begin)
            self.ends.append(end)

    def extend(self, begins: Ticks, ends: Ticks) -> None:
        self.begins += begins[begins < ends].tolist()
        self.ends += ends[begins < ends].tolist()

    def ticks_in(self, pieces: _Pieces) -> Ticks:
        """Return how many ticks of waiting are in each piece, summed over the orders."""
        return pieces.ticks_of(*(np.array(ticks, dtype=np.int64) for ticks in (self.begins, self.ends)))


class Bottleneck:
    """Tells it, when a run is over.

    Parameters
    ----------
    run
        The run.
    begin, end
        The times between which is counted; orders that arrive before the first are left out, or count from there on
        where they are open in the state in which the run begins.
    stations, robots, delays, packing
        Observers that have followed the run.
    """

    def __init__(
        self, run: RunInfo, begin: int, end: int, stations: Stations, robots: Robots, delays: Delays, packing: Packing
    ) -> None:
        self._run, self._begin, self._end = run, begin, end
        if packing.on and delays.all_done is not None:
            self._end = max(begin, delays.all_done)  # what packers do then is no matter of pickers and robots
        self._robots, self._delays = robots, delays
        self._packing = Packed.of(packing, end, run) if packing.on else None
        self._lift, self._stations = run.motion.lift_ticks, stations.followed
        self._lengths: list[tuple[int, ...]] = []  # of each station: as `_Pieces.of`, in ticks
        self._fails = run.scenario.stations.outages is not None or robots_may_fail(run.scenario.robots)
        causes = (cause for cause in LIMITS if self._fails or cause != "outages")
        self.causes: dict[str, float] = dict.fromkeys((*causes, "driving", "picking"), 0.0)
        """Ticks of the orders' time by cause, summed over the orders."""
        self._room, self._robot = _Waits(), _Waits()
        self._beneath = [_Waits() for _ in run.warehouse.stations]
        self._queueing = [_Waits() for _ in run.warehouse.stations]
        self._given = [_Waits() for _ in run.warehouse.stations]
        speeds, numbers = run.scenario.stations.speed, range(1, len(run.warehouse.stations) + 1)
        self._speeds = [mean_speed(speeds.get(str(number), 1.0)) for number in numbers]
        self._staffed: dict[int, list[Span]] = {}  # when each station is open by its timetable, if that matters
        if self._fails and run.scenario.stations.open is not None:
            timetables, _ = shifts_of(hours_of(run.scenario, len(self._speeds)), len(self._speeds))
            until = max(run.warehouse.now_tick, 1)
            self._staffed = {number: open_spans(one, 0, until) for number, one in enumerate(timetables)}
        self._orders = self._collect()
        self._share_out()

    def _collect(self) -> int:
        """Collect what each order waited for, and add up what needs no more; return how many orders count."""
        delays, causes, counted, done = self._delays, self.causes, 0, list[int]()
        end = min(self._end, self._run.warehouse.now_tick)  # earlier than the end of the warm-up, where the run was
        for order, arrival in delays.arrival.items():
            if delays.counts(order) and arrival <= end:
                counted += 1
                if order in delays.times:
                    done.append(order)
                else:
                    self._collect_left(order, delays.since(arrival))
        if not done:
            return counted
        times = np.frombuffer(b"".join([delays.times[order] for order in done]), dtype=np.int64)
        ticks = dict(zip(delays.columns, times.reshape(len(done), -1).T, strict=True))
        arrivals, picks = np.array([delays.since(delays.arrival[i]) for i in done]), [delays.picks[i] for i in done]
        picking = {pick: self._picking(*pick) for pick in set(picks)}
        own = np.minimum([picking[pick] for pick in picks], ticks["station_s"])
        joins = arrivals + ticks.get("stock_s", 0)
        last = joins + ticks["backlog_s"] + ticks["other_parts_s"]
        asked = last + ticks["robot_s"] + ticks["pod_s"]
        lifted = asked + ticks["to_pod_s"] + ticks["room_s"]
        joined = lifted + ticks["driving_s"]
        self._room.extend(joins, last)
        self._robot.extend(last, asked)
        served = joined + ticks["queueing_s"] + ticks["station_s"] - own
        stations = np.array([station for station, _ in picks])
        for number, (beneath, queueing) in enumerate(zip(self._beneath, self._queueing, strict=True)):
            here = stations == number
            beneath.extend((lifted - self._lift - ticks["room_s"])[here], (lifted - self._lift)[here])
            queueing.extend(joined[here], served[here])
        causes["stock"] += int((joins - arrivals).sum())
        causes["pods"] += int(ticks["pod_s"].sum())
        causes["driving"] += int((ticks["to_pod_s"] + ticks["driving_s"]).sum())
        causes["picking"] += int((own + ticks.get("handling_s", 0)).sum())
        return counted

    def _picking(self, station: int, items: int) -> int:
        """Return the ticks of picking items of an order one after the other, by mean times."""
        section = self._run.scenario.stations
        begun_s = (section.order_s or 0) + (section.line_s or 0) + section.pick_s
        return to_ticks((begun_s + (items - 1) * section.handle_s) / self._speeds[station])

    def _collect_left(self, order: int, arrival: int) -> None:
        """Collect what an order waited for until the end, or was cancelled, as far as that is known."""
        end = min(self._delays.cancelled.get(order, self._end), self._end)
        if (known := self._delays.last.get(order)) is not None:
            joins = self._delays.since(self._delays.in_stock.get(order, arrival))
            self.causes["stock"] += joins - arrival
            last = self._delays.since(known.tick) if known.whole else end
            self._room.add(joins, last)
            self._robot.add(last, end)
            self._given[known.station].add(last, end)
        elif order in self._delays.out_of_stock:
            self.causes["stock"] += end - arrival
        else:
            joins = self._delays.since(self._delays.in_stock.get(order, arrival))
            self.causes["stock"] += joins - arrival
            self._room.add(joins, end)

    def _pieces(self) -> _Pieces:
        """Return the pieces of time between any two changes at stations and among robots."""
        robots, ends = self._robots, [(self._begin, self._end)]
        ticks = [robots.free.ticks, robots.on_duty.ticks, robots.down.ticks]
        for station in self._stations:
            counts = (station.requests, station.queue, station.open, station.down, station.pods)
            ticks += [np.array(station.begun), np.array(station.free), *(count.ticks for count in counts)]
        ends += chain.from_iterable((*robots.beneath_for.values(), *self._staffed.values()))
        bounds = np.sort(np.concatenate((np.array(ends, dtype=np.int64).ravel(), *ticks)))
        return _Pieces(bounds[np.append(True, bounds[1:] != bounds[:-1])])  # quicker than `np.unique`

    def _share_out(self) -> None:
        """Share out the waits among the causes."""
        pieces, number = self._pieces(), len(self._stations)
        begins = pieces.bounds[:-1]
        busy, idle, short, waiting, failed, stuck, jammed, halted, wanted, most = np.zeros(
            (10, len(begins)), dtype=np.int64
        )
        duration, levels = np.diff(pieces.bounds.clip(self._begin, self._end)), list[tuple[Ticks, ...]]()
        for number_of, station in enumerate(self._stations):
            here, wanting, open_, down = pieces.of(station, self._staffed.get(number_of))
            self._lengths.append(tuple(int(duration @ one) for one in (here, wanting, open_, down)))
            beneath = pieces.beneath(self._robots.beneath_for.get(number_of, []))
            busy += here
            idle += open_ - wanting
            short += np.where(beneath > 0, wanting - here, 0)
            waiting += np.where(beneath > 0, 0, wanting - here)
            known, held_up = station.requests.at(begins), beneath + station.queue.at(begins)
            failed += down
            levels.append((here, known, held_up, down))
            stuck += held_up
            jammed += held_up * down
            halted += station.pods.at(begins) * down
            wanted += known
            most = np.maximum(most, known)
        broken = failed / number
        closed = (number - busy - idle - short - waiting - failed) / number
        shut = self._shut_by_rule(begins, closed)
        even = wanted / np.maximum(busy + idle + short + waiting, 1)
        held_back = most <= np.ceil(even)  # no station has more than its share
        uneven = np.zeros(len(begins))
        none_free = self._robots.free.at(begins) == 0
        for number_of, (here, known, held_up, down) in enumerate(levels):
            beyond = np.maximum(1 - even / np.maximum(known, 1), 0.0) * (1 - closed)
            uneven += beyond * held_up * (1 - down)
            shares = {"spread": here * beyond, "hours": here * (closed - shut), "closed": here * shut}
            shares |= {"pickers": here * (1 - beyond - closed), "outages": down}
            self._add(self._beneath[number_of], pieces, shares | {"queues": 1 - here - down})
            self._add(self._queueing[number_of], pieces, shares | {"driving": 1 - here - down})
            given = {cause: share * ~none_free for cause, share in (shares | {"driving": 1 - here - down}).items()}
            self._add(self._given[number_of], pieces, given)
        fleet, on_duty = len(self._run.warehouse.robots), self._robots.on_duty.at(begins)
        charging = self._robots.charging.at(begins)
        fails = np.minimum(self._robots.down.at(begins) + halted, on_duty - charging)
        off, held = 1 - on_duty / fleet, np.minimum(stuck, on_duty - charging - fails) / fleet
        working = 1 - off - held - (charging + fails) / fleet
        uneven *= held / np.maximum(stuck, 1)
        lost = held * jammed / np.maximum(stuck, 1)
        held -= lost
        of_robots = {
            "robots": working,
            "chargers": charging / fleet,
            "spread": uneven,
            "hours": off + held * (closed - shut),
            "closed": held * shut,
            "outages": fails / fleet + lost,
            "pickers": held * (1 - closed) - uneven,
        }
        self._add(self._robot, pieces, {cause: none_free * share for cause, share in of_robots.items()})
        handling, at_work = busy / np.maximum(busy + waiting, 1), (busy + waiting) / number
        both = handling + working + off + (charging + fails) / fleet  # none where all robots move up in queues
        each = none_free * at_work / np.where(both > 0, both, 1)
        of_stations = {
            "pickers": np.where(none_free, each * handling, busy / number),
            "robots": each * working,
            "chargers": each * charging / fleet,
            "hours": closed - shut + each * off,
            "closed": shut,
            "outages": broken + each * fails / fleet,
            "room": np.where(none_free, 0.0, waiting / number),
            "queues": short / number + none_free * at_work * (both <= 0),
            "spread": np.where(held_back, 0.0, idle / number),
            "held": np.where(held_back, idle / number, 0.0),
        }
        self._add(self._room, pieces, of_stations)

    def _shut_by_rule(self, begins: Ticks, closed: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of the stations that are closed although their timetable has them open."""
        if self._run.scenario.rules.activate is None:
            return np.zeros(len(begins))
        number = len(self._stations)
        timetables, _ = shifts_of(hours_of(self._run.scenario, number), number)
        off = np.array([sum(not one.at(tick) for one in timetables) for tick in begins.tolist()]) / number
        return np.maximum(closed - off, 0.0)

    def _add(self, waits: _Waits, pieces: _Pieces, shares: Mapping[str, NDArray[Any]]) -> None:
        """Add to the causes their shares of some waits."""
        if waits.begins:
            ticks = waits.ticks_in(pieces)
            for cause in self.causes.keys() & shares.keys():
                # One after the other, the same everywhere.
                self.causes[cause] += float(np.cumsum(ticks * shares[cause])[-1])

    def summary(self) -> dict[str, Any]:
        """Return it as plain values; means and shares of nothing are None."""
        whole = fsum(self.causes.values())
        largest = max(self.causes, key=lambda cause: self.causes[cause])
        limit = largest if whole and largest in LIMITS else None
        percent = {cause: _percent(ticks, whole) for cause, ticks in self.causes.items()}
        gain = None if limit is None else self._one_more(limit)
        says = [*self._nothing()]
        if whole:
            says = [*sentences(limit, percent, gain)]
        if (packed := self._packing) is not None:
            if (named := packed.limit(ratio(self.causes[largest], self._orders * TICKS_PER_S) or 0.0)) is not None:
                limit, gain = named, packed.one_more(named)
                says = [*packed.says(named, gain)]
            says.append(packed.covers())
        return {
            "turnover_parts_s": self._parts(),
            "completed": sum(map(self._delays.counts, self._delays.times)),
            "pickers_percent": self._of_pickers(),
            **self._of_stations(),
            "robots_percent": self._of_robots(),
            "orders_time_s": whole / self._orders / TICKS_PER_S if self._orders else None,
            "causes_percent": percent,
            "limit": limit,
            "gain": gain,
            **({} if packed is None else {"packing": packed.to_dict()}),
            "says": says,
        }

    def _nothing(self) -> Iterator[str]:
        """Yield why nothing is said of orders that there are."""
        if not self._orders and any(arrival < self._begin for arrival in self._delays.arrival.values()):
            since = "the warm-up ends (`run.warmup_s`)" if self._delays.began is None else "what counts begins"
            yield f"Not known: all orders arrive before {since}, and none of them counts."

    def _parts(self) -> dict[str, float | None]:
        """Return the mean of each part of the turn-over time, over the orders that it is measured of."""
        delays = self._delays
        timed = [times for order, times in delays.times.items() if delays.counts(order)]
        sums = dict(zip(delays.columns, map(sum, zip(*timed, strict=True)), strict=True)) if timed else {}
        return {
            part: ratio(sum(sums.get(column, 0) for column in columns), len(timed) * TICKS_PER_S)
            for part, columns in PARTS.items()
            if part != "before" or delays.began is not None
        }

    def _of_pickers(self) -> dict[str, float | None]:
        """Return what the time went to in which stations were there."""
        handled, either, there, down = map(sum, zip(*self._lengths, strict=True))
        parts = {"handling": handled, "waiting": either - handled, "idle": there - either}
        parts |= {"down": down} if down else {}
        return {part: _percent(ticks, there + down) for part, ticks in parts.items()}

    def _of_stations(self) -> dict[str, dict[str, Any] | None]:
        """Return the stations whose pickers handled items for the most and the least of their time.

        Without those that were there for less than `LEAST_THERE` of the time of the one that was there the longest.
        """
        longest = max(there for _, _, there, _ in self._lengths)
        shares = {
            station.name: _percent(handled, there)
            for station, (handled, _, there, _) in zip(self._run.warehouse.stations, self._lengths, strict=True)
            if there >= LEAST_THERE * longest
        }
        known = {name: share for name, share in shares.items() if share is not None}
        ends = {"busiest_station": max, "idlest_station": min}
        if not known:
            return dict.fromkeys(ends)
        named = {key: choose(known, key=lambda name: known[name]) for key, choose in ends.items()}
        return {key: {"station": name, "handling_percent": known[name]} for key, name in named.items()}

    def _of_robots(self) -> dict[str, float | None]:
        """Return what the robots' time went to."""
        ticks: Counter[str] = Counter()
        spent, for_room = self._robots.spent(self._end)
        for state, does in DOES.items():
            ticks[does] += spent[state]
        ticks["traffic"] -= for_room
        ticks["queueing"] += for_room
        low = sum(one.mean(self._begin, self._end) for one in self._robots.low)
        ticks["low"] = round(low * (self._end - self._begin))
        ticks["idle"] -= ticks["low"]
        named = [does for does in dict.fromkeys((*DOES.values(), "low")) if does != "down" or ticks["down"]]
        return {does: _percent(ticks[does], ticks.total()) for does in named}

    def _one_more(self, limit: str) -> dict[str, float | None]:
        """Return what more of the limit brings at most: less time per order; where orders are refilled, more picks.

        The least time is that of pickers and robots who are always at work on the orders with the least left.
        """
        stations, robots = len(self._stations) + (limit == "pickers"), len(self._run.warehouse.robots)
        if self._run.scenario.instance.arrivals.backlog is not None:  # when orders arrive depends on the rules
            share = (self._of_pickers()["handling"] or 0.0) * len(self._stations)
            return {**_NO_LESS, "throughput_percent": _more(stations, share)}
        whole = fsum(self.causes.values())
        less = whole - self._least(stations, robots + (limit == "robots"))
        return {
            "time_s": round(less / self._orders / TICKS_PER_S, 3) + 0.0,  # not -0.0
            "time_percent": _percent(less, whole),
            "throughput_percent": None,
        }

    def _least(self, stations: int, robots: int) -> int:
        """Return the least ticks that the orders spend until the end, with so many stations and robots.

        Orders that may be cancelled count as nothing.
        """
        scenario, orders = self._run.scenario, self._run.instance.orders
        end = min(self._end, self._run.warehouse.now_tick)
        arrivals = np.array([order.arrival_tick for order in orders], dtype=np.int64)
        stay = np.array([order.cancelled_tick is None for order in orders])
        counted = (arrivals >= self._begin) & (arrivals <= end) & stay
        if not counted.any():
            return 0
        arrived = arrivals[counted]
        services = Services(scenario.stations, scenario.seed, stations)
        workers = at_work(scenario, orders, services, np.full(stations, arrived.min()), robots)
        done = np.maximum(*(one.completions(units[counted], arrived) for one, units in workers))
        return int(np.minimum(done, end).sum() - arrived.sum())


@frozen
class Packed:
    """Time that packing adds to orders, and how busy packers are.

    Parameters
    ----------
    after_s
        From the last pick to packed, mean of the orders packed whose last pick is in the run; None where none is.
    wait_s
        Part of it in which an order waits for a packer.
    packers_percent
        Share of the time in which packers are at work.
    boxes_percent
        Share of the boxes that are reserved, mean over time.
    packers
        How many there are, in all.
    off_duty_percent
        Share of the wait for a packer in which the packing station is closed.
    """

    after_s: float | None
    wait_s: float | None
    packers_percent: float | None
    boxes_percent: float | None
    packers: int
    off_duty_percent: float = 0.0

    @classmethod
    def of(cls, packing: Packing, end: int, run: RunInfo) -> Packed:
        section, stations, measured = run.scenario.packing, len(run.warehouse.packing_stations), packing.values(end)
        assert section is not None
        after_s = None if packing.after_s is None else round(packing.after_s, 3)
        reserved, boxes = measured["boxes_mean"] or 0.0, section.boxes * stations
        at_work, wait_s = measured["packer_utilisation_percent"], measured["packing_wait_s"]
        share, packers = _percent(reserved, boxes), section.packers * stations
        return cls(after_s, wait_s, at_work, share, packers, packing.off_duty_percent)

    def limit(self, largest_s: float) -> str | None:
        """Return who limits the run instead of the largest cause of picking, which takes an order so long, if any."""
        after_s = self.after_s or 0.0
        if (self.packers_percent or 0.0) > BUSY:
            return "packers"
        if after_s <= largest_s:
            return None
        if (self.boxes_percent or 0.0) > BUSY:
            return "boxes"
        return "packers" if (self.wait_s or 0.0) > after_s / 2 else None

    def one_more(self, limit: str) -> dict[str, float | None]:
        """Return what one more of the limit brings at most; nothing is known of boxes or idle packers.

        How long an order reserves its box depends on when its parts come, and so on the rules: with one more box they
        may decide otherwise, and each box may serve more orders. Orders wait for packers with time to spare
        in peaks, or until they are on duty: the orders, not the packers, determine how many are packed.
        """
        if limit == "boxes" or (self.packers_percent or 0.0) <= BUSY:
            return {**_NO_LESS, "throughput_percent": None}
        more = _more(self.packers + 1, self.packers * (self.packers_percent or 0.0))
        return {**_NO_LESS, "throughput_percent": more}

    def says(self, limit: str, gain: Mapping[str, float | None]) -> Iterator[str]:
        """Yield what limits the run, and what one more of it brings at most, as sentences."""
        after = f"from the last pick to packed {_seconds(self.after_s or 0.0)} on average"
        share = (
            f"{self.packers_percent or 0.0:.0f} % at work"
            if limit == "packers"
            else f"{self.boxes_percent or 0.0:.0f} % reserved"
        )
        yield f"{limit.capitalize()}, {share}: {after}."
        if (most := gain["throughput_percent"]) is not None:
            yield f"One more packer: at most {most:.3g} % more orders packed."
        if limit == "packers" and self.off_duty_percent > 50:
            yield f"Packers are off duty for {self.off_duty_percent:.0f} % of the wait; longer hours may help."

    def covers(self) -> str:
        """Return how long packing takes, which the rest is not about."""
        if self.after_s is None:
            return "No order that counts was picked and packed."
        told = f"Last pick to packed: {_seconds(self.after_s)}; packers {self.packers_percent or 0.0:.0f} % busy"
        return f"{told}, boxes {self.boxes_percent or 0.0:.0f} % reserved."

    def to_dict(self) -> dict[str, float | None]:
        return {name: getattr(self, name) for name in ("after_s", "packers_percent", "boxes_percent")}


def sentences(
    limit: str | None, percent: Mapping[str, float | None], gain: Mapping[str, float | None] | None
) -> Iterator[str]:
    """Yield what limits the run, and what more of it brings at most, as sentences."""
    if limit is None or gain is None:
        work = (percent["driving"] or 0) + (percent["picking"] or 0)
        yield _with_others(f"No single limit: {work:.0f} % driving and picking", limit, percent)
        return
    told = f"{limit.capitalize()}, {percent[limit]:.0f} % of the orders' time: {LIMITS[limit][0]}"
    yield _with_others(told, limit, percent)
    helps = f"{LIMITS[limit][1][:1].upper()}{LIMITS[limit][1][1:]}"
    if (seconds := gain["time_s"]) is not None:  # more than the limit's share of the time, where rules could be better
        helps += " and ideal rules" if helps.startswith("One more") else ""
        yield f"{helps}: at most {_seconds(seconds)} ({gain['time_percent']:.0f} %) less time."
    elif (more := gain["throughput_percent"]) is not None:
        yield f"{helps}: at most {more:.3g} % more picks per hour."


def _with_others(told: str, limit: str | None, percent: Mapping[str, float | None]) -> str:
    """Return a sentence with the next causes, the largest first; without its explanation where both do not fit."""
    shares = {cause: percent.get(cause) or 0.0 for cause in LIMITS if cause != limit}
    others = {cause: share for cause, share in shares.items() if share >= WORTH_SAYING}
    named = ", ".join(f"{cause} {others[cause]:.0f} %" for cause in sorted(others, key=lambda cause: -others[cause]))
    then = "then" if limit is not None else "largest causes:"
    if named and len(f"{told}; {then} {named}") >= LINE:
        told = told.partition(":")[0]
    return f"{told}; {then} {named}." if named else f"{told}."


def _seconds(seconds: float) -> str:
    return f"{seconds:,.{seconds < 10:d}f} s"


def _more(number: int, percent: float) -> float | None:
    """Return by how many percent so many do at most more than those whose shares of time at work add up to percent."""
    return round(100 * (100 * number / percent - 1), 3) if percent else None


def _percent(part: float, whole: float) -> float | None:
    return round(100 * part / whole, 3) if whole else None
