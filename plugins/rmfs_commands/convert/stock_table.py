"""Stock of a warehouse: rows of a table, cleaned and brought together by pod."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from attrs import astuple, define, field, frozen

from rmfs_commands.convert.names import Names
from rmfs_commands.convert.quantities import Quantities
from rmfs_commands.convert.tables import Row, Table
from rmfs_commands.convert.tally import Tally, why_none
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import MOST_ITEMS, MOST_PODS
from rmfs_core.wording import counted, shown_short

NO_QUANTITY = "a quantity that is no whole number from 0 on"
_MOST_PLACE = 10**9


@frozen
class StockColumns:
    """Names of the columns of a table of stock; None: the table has none.

    Without a quantity there is no end of any SKU; without row and column pods stand anywhere.
    """

    pod: str
    sku: str
    quantity: str | None = None
    row: str | None = None
    column: str | None = None


@define
class PodStock:
    """Contents of a pod: its place (row and column) and where that was read, and the items of each SKU."""

    place: tuple[int, int] | None
    first: int
    items: dict[str, int | None] = field(factory=dict)


class StockTable:
    """The stock of a table.

    Parameters
    ----------
    columns
        Names of its columns.
    quantities
        Reads quantities.

    Attributes
    ----------
    file
        Where the table is.
    pods
        Stock by name of the pod, as they first come.
    rows, joined
        Rows read, and rows that were added to another row of the same pod and SKU.
    dropped, others
        Rows that were left out, and those that are not read, by reason.
    """

    def __init__(self, columns: StockColumns, quantities: Quantities) -> None:
        self.columns, self.quantities = columns, quantities
        self.file = "the table"
        self.names, self.places = Names(), Quantities()
        self.pods: dict[str, PodStock] = {}
        self.rows = self.joined = 0
        self.dropped, self.others = Tally(), Tally()

    def read(self, table: Table) -> None:
        """Take in a table.

        Raises
        ------
        InputError
            When the file cannot be read, lacks a column, has a pod in two places or two in one, or no pod.
        """
        self.file, self.others = (file := str(table.file)), table.others
        columns = self.columns
        self._add(file, table.rows(astuple(columns)))
        self.quantities.ask(file, columns.quantity or "")
        if not self.pods:
            raise InputError(file, f"has no pod that could be kept: {why_none(self.others, self.left_out())}")
        self._check_places(file)

    def _add(self, file: str, rows: Iterable[Row]) -> None:
        columns = self.columns
        for row, fields in rows:
            pod_text, sku_text, amount, *at = map(str.strip, fields)
            if not (pod_text or sku_text or amount):
                continue
            self.rows += 1
            name, sku = self.names.clean(pod_text), self.names.clean(sku_text)
            items = self.quantities.whole(amount, row) if columns.quantity else None
            if not name:
                self.dropped.note("no pod", row, "")
            elif pod_text == columns.pod and sku_text == columns.sku:
                self.dropped.note("the header again", row, "")
            elif not sku:
                self.dropped.note("no SKU", row, name)
            elif columns.quantity and items is None:
                self.dropped.note(NO_QUANTITY, row, amount)
            elif items is not None and items > MOST_ITEMS:
                self.dropped.note(f"more than {MOST_ITEMS:,} items", row, amount)
            else:
                self._keep(file, row, name, sku, items, self._place(file, row, at))

    def _keep(self, file: str, row: int, name: str, sku: str, items: int | None, place: tuple[int, int] | None) -> None:
        if name not in self.pods and len(self.pods) == MOST_PODS:
            raise InputError(f"{file}, row {row}", f"found more than {MOST_PODS:,} pods; expected at most that many")
        pod = self.pods.setdefault(name, PodStock(place, row))
        if place != pod.place:
            found = f"found pod {shown_short(name)} in {_where(place)}"
            raise InputError(f"{file}, row {row}", f"{found}; expected {_where(pod.place)}, as in row {pod.first}")
        self.joined += sku in pod.items
        held = pod.items.get(sku, 0)
        pod.items[sku] = None if items is None or held is None else held + items

    def _place(self, file: str, row: int, texts: list[str]) -> tuple[int, int] | None:
        if self.columns.row is None:
            return None
        found = [self.places.whole(text, row) for text in texts]
        if found[0] and found[1] and max(found[0], found[1]) <= _MOST_PLACE:
            return found[0], found[1]
        shown = " and ".join(shown_short(text) if text else "nothing" for text in texts)
        raise InputError(f"{file}, row {row}", f"found {shown} as row and column; expected whole numbers from 1 on")

    def _check_places(self, file: str) -> None:
        taken: dict[tuple[int, int], str] = {}
        for name, pod in self.pods.items():
            if pod.place is not None and (other := taken.setdefault(pod.place, name)) != name:
                found = f"found pods {shown_short(other)} and {shown_short(name)} in {_where(pod.place)}"
                raise InputError(f"{file}, row {pod.first}", f"{found}; expected a location of its own for each")

    def lines(self) -> Iterator[tuple[object, ...]]:
        """Yield the rows of ``pods.csv``, its header first; a pod without items keeps a row, and its place."""
        placed = self.columns.row is not None
        yield ("pod", "sku", "quantity", *(("row", "column") if placed else ()))
        for name, pod in self.pods.items():
            held = {sku: items for sku, items in pod.items.items() if items != 0}
            for sku, items in (held or dict.fromkeys([*pod.items][:1], 0)).items():
                yield (name, sku, "" if items is None else items, *(pod.place or ()))

    def sentences(self) -> Iterator[str]:
        """Yield sentences on the table: the rows left out, and those kept."""
        yield f"Read {counted(self.rows, 'row')}."
        for _, part in self.others.parts():
            yield f"Not read: {part}."
        for part in self.left_out():
            yield f"Left out: {part}."
        if self.names.respelled:
            yield (
                f"Names with accents apart from their letters (NFD): {self.names.respelled:,}; "
                "they are spelled as one sign (NFC)."
            )
        if self.joined:
            yield f"SKUs that a pod repeats: {counted(self.joined, 'row')}; quantities are added up."
        empty = sum(not any(items != 0 for items in pod.items.values()) for pod in self.pods.values())
        if empty:
            yield f"Empty: {counted(empty, 'pod')}."

    def left_out(self) -> list[str]:
        """Return the reasons for rows left out, as parts of sentences, with what may help."""
        return [part + self._help(reason) for reason, part in self.dropped.parts()]

    def _help(self, reason: str) -> str:
        """Return which option may read the rows that were left out for a reason."""
        examples = [text for _, text in self.dropped.reasons[reason].examples]
        return self.quantities.guessed(examples) if reason == NO_QUANTITY else ""

    def held(self) -> dict[str, float]:
        """Return the items of each SKU on all pods; infinite of one that never runs out."""
        found: dict[str, float] = {}
        for pod in self.pods.values():
            for sku, items in pod.items.items():
                found[sku] = found.get(sku, 0) + (math.inf if items is None else items)
        return found

    def total(self) -> str:
        """Return how much there is, for a sentence."""
        skus = {sku for pod in self.pods.values() for sku, items in pod.items.items() if items != 0}
        items = sum(held or 0 for pod in self.pods.values() for held in pod.items.values())
        amount = counted(items, "item") if self.columns.quantity else "any number of items"
        return f"{counted(len(self.pods), 'pod')}, {amount} of {counted(len(skus), 'SKU')}"


def _where(place: tuple[int, int] | None) -> str:
    return f"row {place[0]}, column {place[1]}" if place else "no location"
