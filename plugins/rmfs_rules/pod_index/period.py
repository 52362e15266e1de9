"""What pod-index keeps and works on: all that its compiled parts read and write."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from rmfs_core.jit import njit

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Records = NDArray[Any]

NONE = -1
CLOSE = 1e-9
"""Relative difference up to which two indices count as equal: sums of the same numbers in another order may differ."""

MOST_SECONDS = 4096
"""Of how many seconds the power is kept in a table."""

WORDS = np.dtype([("word", np.int64)], align=True)


def _record(whole: str = "", real: str = "", flags: str = "") -> np.dtype[Any]:
    """Return records of numbers and flags of these names, which take whole words of eight bytes."""
    kinds = (np.int64, whole), (np.float64, real), (np.bool_, flags)
    return np.dtype([(name, kind) for kind, names in kinds for name in names.split()], align=True)


WEIGHTS = _record(
    "most_pods urge_ticks base_ticks",
    "handle_s cost_s finish visit_s stay elsewhere full near due_factor due_s",
    "packing",
)
ENTRY = _record("pod sku free holder")
HOLDER = _record("pod free")
LINE = _record("order sku quantity before after", flags="untaken")
ORDER = _record("arrival begin end open_items parts", "due_s worth highest left base root power", "split single ever")
SKU = _record("head tail number arrivals start stop there", "share")
AGES = _record("lines_of arrivals_of")
POD = _record("cell last urge", "gain", "free movable able")
STATION = _record("room load capacity inbound", flags="counts_orders open")
BID = _record("items", "worth")
TAKE = _record("line station order sku")
SEND = _record("pod station before")
REACH = _record("sku begin end")
RECORDS = {"weights": WEIGHTS, "entries": ENTRY, "holders": HOLDER, "skus": SKU, "ages": AGES, "pods": POD}
RECORDS |= {
    "front": AGES,
    "within": REACH,
    "bearers": HOLDER,
    "stations": STATION,
    "lines": LINE,
    "orders": ORDER,
    "bids": BID,
    "takes": TAKE,
    "sends": SEND,
}


class Period(NamedTuple):
    """An account of lines and items that is kept from call to call, and a period under construction.

    Parameters
    ----------
    weights
        The parameters of the rule, as its class explains them: one record.
    entries
        The SKUs of the pods, sorted by pod and SKU: ids of both, ``free`` items, and where in ``holders`` it is.
    holders
        The same sorted by SKU and pod: the pod, and ``free`` items.
    first, first_with
        Where in ``entries`` those of pod p begin, and in ``holders`` those of SKU i; those of the next one begin where
        they end.
    skus
        Of each SKU: ``head`` and ``tail``, its first and last open line, the ``number`` of these, and ``arrivals``,
        when their orders came, added up; ``share``: seconds of a visit that a line of it has to bear; ``start`` and
        ``stop`` of its lines in ``bids``; ``there``: what a station had before pods were sent.
    ages, front
        Of each pod: ``lines_of``, how many open lines it has items for, and ``arrivals_of``, when their orders came,
        added up. All pods are looked through, so this is kept together. And of those that may be wanted enough next.
    pods
        Of each pod: ``last``: the station where it goes last, whose its free items are, NONE for none; whether it is
        ``free``: bound for no station and with no robot, or leaving; then its ``cell``. Of one that is wanted enough in
        this period: ``urge``, the ages of its lines added up; whether it is still ``movable``, and ``able`` to be sent
        to the station whose turn it is; ``gain``: what it brings beyond a rate.
    stations
        Of each station: ``room``, ``load``, ``capacity``: free places, places that are taken, all of them;
        ``inbound``: pods at or bound for it; ``counts_orders``: what its places are for; ``open``: whether it may go
        on.
    available
        Items of each SKU that the pods of each station have free, shape (SKUs, stations).
    lines
        Of each line that ever was in the backlog, oldest first: ids of its order and SKU, and items; the open lines of
        its SKU ``before`` and ``after`` it, NONE for none; ``untaken``: whether it is open and not taken in this
        period.
    orders
        Of each order, by id: when it came, when it is due, how many times more it is ``worth`` by its priority, and
        ``highest``, how many times at most, and a trifle; ``begin`` and ``end`` of its lines; ``open_items``: items of
        its lines that are left; ``left``: seconds of these, below 0 where not needed yet; ``power``: what the seconds
        of a line are divided by for its worth; ``base``, ``root``: a number of seconds, and what it is to the power of
        ``finish``. Where packing stations are full at some number of split orders, whether it is ``split``, has a
        ``single`` open line, was split before (``ever``), and at how many stations this period has ``parts`` of it.
    bids
        Items and worth of the lines that a station might be brought, by SKU.
    within, bearers
        The SKUs with open lines of which pods that are ``movable`` have items, and where in ``bearers`` these pods are:
        those of ``holders`` that may be sent.
    takes, sends
        What was taken so far: line, station, and the line's order and SKU; and sent: pod, station, and where it went
        last ``before``.
    wanted, urgent, gaining, found, turn, looked
        Lists: the SKUs that have open lines, ascending; the pods that may be sent and for which ``urge`` is enough at
        some station; the pods that bring anything; those that are equally good; the stations in the order of the turn;
        the orders for which ``left`` is known.
    least
        So many seconds to the power of ``finish``: what it takes to know what a line could be worth at most.
    numbers
        See below.
    ticks
        Driving times to each station from each cell, shape (stations, cells).
    placed
        Of each station that counts orders: which orders have a place there, shape (stations, orders).
    """

    weights: Records
    entries: Records
    holders: Records
    first: Ints
    first_with: Ints
    skus: Records
    ages: Records
    front: Records
    pods: Records
    stations: Records
    available: Ints
    lines: Records
    orders: Records
    bids: Records
    within: Records
    bearers: Records
    takes: Records
    sends: Records
    wanted: Ints
    urgent: Ints
    gaining: Ints
    found: Ints
    turn: Ints
    looked: Ints
    least: Floats
    numbers: Ints
    ticks: Ints
    placed: Bools


TAKES, SENDS, COMPLETED, FOUND, LENGTH, AT_WORK, PACKING_ROOM, WANTED, URGENT, GAINING, LOOKED, NOW, WITHIN = range(13)
"""Where in ``Period.numbers`` each number is: how many of ``takes``, ``sends``, ``found``, ``turn``, ``wanted``,
``urgent``, ``gaining`` and ``looked`` there are; whether a station is at work; room at the packing stations; orders of
which all lines are taken; the tick; how many of ``within`` there are."""


@intrinsic
def lent(_, array):
    """Return an array that is not counted as one more that needs its memory: who calls the compiled code has it.

    To count each array of a period up and down whenever it is named would take longer than what is done with them.
    """

    def make(context, builder, signature, values):  # noqa: ARG001
        (value,) = values
        for part in range(2):  # what is counted, and the Python object
            nothing = cgutils.get_null_value(value.type.elements[part])  # type: ignore[no-untyped-call]
            value = builder.insert_value(value, nothing, part)
        return value

    return array(array), make


@njit(cache=True)
def period_of(words, at, ticks, placed):
    """Return a period, as long as what its arrays lie in is there."""
    return arrays_of(lent(words), lent(at), lent(ticks), lent(placed))  # type: ignore[call-arg]


@njit(cache=True)
def arrays_of(words, at, ticks, placed):
    """Return a period, the arrays of which lie one after another in ``words``, each from where ``at`` says.

    To hand each of them from Python to compiled code would take longer than most of what is done there.
    """
    words = words.view(np.int64)
    skus, stations = words[at[5] : at[6]].view(SKU), words[at[9] : at[10]].view(STATION)
    return Period(
        words[at[0] : at[1]].view(WEIGHTS),
        words[at[1] : at[2]].view(ENTRY),
        words[at[2] : at[3]].view(HOLDER),
        words[at[3] : at[4]],
        words[at[4] : at[5]],
        skus,
        words[at[6] : at[7]].view(AGES),
        words[at[7] : at[8]].view(AGES),
        words[at[8] : at[9]].view(POD),
        stations,
        words[at[10] : at[11]].reshape(len(skus), len(stations)),
        words[at[11] : at[12]].view(LINE),
        words[at[12] : at[13]].view(ORDER),
        words[at[13] : at[14]].view(BID),
        words[at[14] : at[15]].view(REACH),
        words[at[15] : at[16]].view(HOLDER),
        words[at[16] : at[17]].view(TAKE),
        words[at[17] : at[18]].view(SEND),
        words[at[18] : at[19]],
        words[at[19] : at[20]],
        words[at[20] : at[21]],
        words[at[21] : at[22]],
        words[at[22] : at[23]],
        words[at[23] : at[24]],
        words[at[24] : at[25]].view(np.float64),
        words[at[25] : at[26]],
        ticks,
        placed,
    )


LEAST_ROOM = 4096
"""How long arrays become at least: to make them longer takes as long as some decisions."""
OF_LINES = ("lines", "bids", "takes", "orders", "looked")
"""Arrays that become longer with lines and orders."""


class Account:
    """A period, and the words in which it lies.

    Parameters
    ----------
    lengths
        Of each array of the period: how many of whatever is in it there are; those that are left out are empty.
    ticks
        Driving times to each station from each cell, shape (stations, cells).

    Attributes
    ----------
    parts
        What compiled parts make the period of: words, where each array begins and the last one ends, and other arrays.
    period
        The period as Python sees it.
    """

    def __init__(self, lengths: dict[str, int], ticks: Ints) -> None:
        self._lengths = dict.fromkeys(list(Period.__annotations__)[:-2], 0) | lengths
        words = [n * (RECORDS[name].itemsize // 8 if name in RECORDS else 1) for name, n in self._lengths.items()]
        at = np.cumsum([0, *words], dtype=np.int64)
        self._set(np.zeros(at[-1], WORDS), at, ticks, np.zeros((0, 0), np.bool_))
        self.period.skus["head"] = self.period.skus["tail"] = self.period.pods["last"] = NONE

    def _set(self, words: Records, at: Ints, ticks: Ints, placed: Bools) -> None:
        self.parts = words, at, ticks, placed
        self.period = Period(*arrays_of.py_func(*self.parts))

    def make_room(self, lengths: dict[str, int]) -> None:
        """Make arrays at least so long, with zeros at the end."""
        short = {name: max(2 * length, LEAST_ROOM) for name, length in lengths.items() if self._lengths[name] < length}
        if short:
            grown = Account(self._lengths | short, self.period.ticks)
            for new, old in zip(grown.period[:-2], self.period[:-2], strict=True):
                new[: len(old)] = old
            self._lengths = grown._lengths
            self._set(*grown.parts)

    def place(self, placed: Bools) -> None:
        """Note which orders have a place at each station."""
        self._set(*self.parts[:3], placed)

    def without_lines(self) -> Account:
        """Return an account of the same pods and items that has no lines."""
        account = Account(self._lengths | dict.fromkeys(OF_LINES, 0), self.period.ticks)
        for name in ("weights", "entries", "holders", "first", "first_with", "pods", "stations", "available", "least"):
            getattr(account.period, name)[:] = getattr(self.period, name)
        return account


def new_account(pods: Ints, skus: Ints, n_pods: int, n_skus: int, ticks: Ints) -> Account:
    """Return an account without lines, and without items, of the SKUs that the pods have.

    Parameters
    ----------
    pods, skus
        Pod and SKU of each entry, sorted by these. Shape (entries,).
    n_pods, n_skus
        How many pods and SKUs there are.
    ticks
        Driving times to each station from each cell, shape (stations, cells).
    """
    n_stations = len(ticks)
    lengths = {
        "weights": 1,
        "skus": n_skus,
        "wanted": n_skus,
        "within": n_skus,
    }
    lengths |= dict.fromkeys(("stations", "turn"), n_stations)
    lengths |= dict.fromkeys(("ages", "front", "pods", "urgent", "gaining", "found", "sends"), n_pods)
    lengths |= dict.fromkeys(("entries", "holders", "bearers"), len(skus))
    lengths |= {"first": n_pods + 1, "first_with": n_skus + 1, "available": n_skus * n_stations}
    account = Account(lengths | {"least": MOST_SECONDS, "numbers": 13}, ticks)
    period = account.period
    period.entries["pod"], period.entries["sku"] = pods, skus
    period.first[:] = np.searchsorted(pods, np.arange(n_pods + 1))
    by_sku = np.argsort(skus, kind="stable")
    period.entries["holder"][by_sku] = np.arange(len(skus))
    period.holders["pod"] = pods[by_sku]
    period.first_with[:] = np.searchsorted(skus[by_sku], np.arange(n_skus + 1))
    return account
