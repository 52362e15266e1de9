"""Rows of a table of order lines: read field by field, and left out with a reason where they are no order line."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator

from attrs import field, frozen

from rmfs_commands.convert.headers import plain, told
from rmfs_commands.convert.names import Names
from rmfs_commands.convert.quantities import Quantities
from rmfs_commands.convert.tables import Row
from rmfs_commands.convert.tally import Dropped, Tally
from rmfs_commands.convert.time_formats import Moment, UnusableError, guessed
from rmfs_commands.convert.times import Clock, ClockError
from rmfs_commands.instances.csv_files import MOST_ITEMS_OF_LINE
from rmfs_core.errors import InputError
from rmfs_core.wording import counted, did_you_mean

NO_QUANTITY = "a quantity that is no whole number from 1 on (returns, weights)"
NO_TIME = "no time that can be read"
UNREADABLE = "that cannot be read"
WHOLE_DAY = "a time of arrival that is a date alone"
_IN_PARTS = "; --time-of-day names the column of the time, if there is one"
_OF_FIRST = "; where only the first row of an order has it, --orders with this table, too, gives it to the others"
_LIST = re.compile(r"""^[\[{].*[]}]$|\w["'\s]*[;,|]["'\s]*\w""")
_MOST_PRIORITY = 10**10 - 1

Line = tuple[str, str, int, int, int, int | None, int | None, int | None, int, str | None]
"""Order, SKU, tick, ticks ahead of UTC, items, tick at which it is due, priority, tick of cancellation, row, route."""


@frozen
class Columns:
    """Names of the columns of a table of order lines, or of order headers, which have no SKU.

    None: the table has none. Then every line is one item, arrives at 0, is due whenever, has no priority, is not
    cancelled, and has no route. The time of the day is in a column of its own where ``time`` is the date alone.
    """

    order: str
    sku: str | None
    time: str | None = None
    quantity: str | None = None
    due: str | None = None
    priority: str | None = None
    time_of_day: str | None = None
    cancelled: str | None = None
    route: str | None = None


@frozen
class Choice:
    """Which order lines are kept.

    Parameters
    ----------
    leave_out
        SKUs whose lines are left out.
    most
        Lines of more items are left out.
    first_rows
        Of headers in the table of the lines itself: rows with nothing but an order are none, where others have times.
    """

    leave_out: tuple[str, ...] = ()
    most: int = MOST_ITEMS_OF_LINE
    first_rows: bool = False


@frozen
class Reader:
    """Reads the fields of a table of order lines, and remembers what was found in them."""

    clock: Clock = field(factory=Clock)
    quantities: Quantities = field(factory=Quantities)
    priorities: Quantities = field(factory=Quantities)
    names: Names = field(factory=Names)


class Cleaner:
    """Makes order lines of rows.

    Parameters
    ----------
    columns
        Names of the table's columns.
    reader
        Reads times, numbers and names.
    choice
        Which lines are kept.

    Attributes
    ----------
    rows
        Rows read; those in which no column has anything that counts are counted in ``blank`` alone.
    dropped
        Rows that were left out, by reason.
    emptied
        Fields that were left empty, by reason: due times and priorities that cannot be read.
    whole_days
        Times that are dates without a time of the day.
    lists
        SKUs that look like a list of several, such as ``tea;mug``.
    unused
        Columns of the table of which nothing was read.
    others
        Rows of the table that are not read, by reason.
    lost
        Names of the orders of rows that were left out, and whether these are shortened by it: an order without its
        postage (a SKU to leave out) is whole.
    """

    def __init__(self, columns: Columns, reader: Reader, choice: Choice) -> None:
        self.columns, self.reader, self.choice = columns, reader, choice
        self.rows = self.blank = 0
        self.dropped, self.emptied, self.whole_days, self.others = Tally(), Tally(), Tally(), Tally()
        self.lists, self.unused = Dropped(), list[str]()
        self.lost: list[tuple[str, bool]] = []
        self._missing = {plain(sku) for sku in choice.leave_out}
        self._unwanted = frozenset(self._missing)

    def ask(self, file: str) -> None:
        """Raise an `InputError` with a question where numbers so far may mean two things."""
        self.reader.quantities.ask(file, self.columns.quantity or "")
        self.reader.priorities.ask(file, self.columns.priority or "")
        if question := self.reader.clock.numbers.question():
            raise InputError(f"{file}, {self.columns.time}", question)

    def check_choice(self, skus: Callable[[], Iterable[str]]) -> None:
        """Raise an `InputError` when a SKU that shall be left out was in no row; ``skus`` returns all SKUs."""
        if self._missing:
            name = min(self._missing)
            meant = did_you_mean(name, skus())
            raise InputError("--leave-out-sku", f'no row has the SKU "{name}"{meant}; expected SKUs of the table')

    def left_out(self) -> list[str]:
        """Return the reasons for rows left out so far, as parts of sentences, with what may help."""
        return [part + self._help(reason) for reason, part in self.dropped.parts()]

    def sentences(self, of: str = "", row: str = "row") -> Iterator[str]:
        """Yield sentences on the rows read so far, those left out, and fields left empty."""
        blank = f", and {self.blank:,} without any entry" if self.blank else ""
        yield f"Read {counted(self.rows, row)}{of}{blank}."
        if self.unused:
            yield f"Columns that are not read{of}: {told(self.unused)}."
        for _, part in self.others.parts():
            yield f"Not read{of}: {part}."
        for part in self.left_out():
            yield f"Left out{of}: {part}."
        for part in self.left_empty().values():
            yield f"Left empty{of}: {part}."
        for what, part in self.whole_days.parts():
            hint = _IN_PARTS if what == WHOLE_DAY and self.columns.time_of_day is None else ""
            yield f"Taken as 00:00 of the day{of}: {part}{hint}."
        if self.lists.rows > 1 or any(text[0] in "[{" for _, text in self.lists.examples):
            found = f"{counted(self.lists.rows, 'row')}{self.lists.shown()}"
            yield f"SKUs that look like lists{of}: {found}; each is taken as one SKU: a line needs a row of its own."

    def left_empty(self) -> dict[str, str]:
        """Return for each reason for fields left empty so far a part of a sentence, with what may help."""
        return {reason: part + self._also(reason) for reason, part in self.emptied.parts()}

    def _also(self, reason: str) -> str:
        if not reason.endswith(UNREADABLE):
            return ""
        return guessed([text for _, text in self.emptied.reasons[reason].examples], self.reader.clock.patterns)

    def _help(self, reason: str) -> str:
        """Return which options may read the rows that were left out for a reason."""
        examples = [text for _, text in self.dropped.reasons[reason].examples]
        if reason == NO_TIME:
            return guessed(examples) if any(examples) else _OF_FIRST if self.columns.sku else ""
        return self.reader.quantities.guessed(examples) if reason == NO_QUANTITY else ""

    def lines(self, file: str, rows: Iterable[Row]) -> Iterator[Line]:
        """Yield the order lines of rows of a file, or its headers, as lines of one item without SKU.

        Raises
        ------
        InputError
            When times are of two kinds.
        """
        columns, clean = self.columns, self.reader.names.clean
        for row, fields in rows:
            order, sku, time, amount, due, priority, time_of_day, cancelled, route = map(str.strip, fields)
            of_head = "" if self.choice.first_rows and columns.time else order
            if not any((of_head, sku, time, amount, due, priority, time_of_day, cancelled, route)):
                self.blank += 1
                continue
            self.rows += 1
            if time_of_day:
                time = f"{time} {time_of_day}"
            name, wanted = clean(order), clean(sku)
            items = self.reader.quantities.whole(amount, row) if columns.quantity else 1
            if columns.sku and _LIST.search(wanted):
                self.lists.note(row, wanted)
            if not name:
                self.dropped.note("no order", row, "")
            elif order == columns.order and sku == (columns.sku or ""):
                self.dropped.note("the header again", row, "")
            elif columns.sku and not wanted:
                self._drop("no SKU", row, name, name)
            elif wanted in self._unwanted:
                self._missing.discard(wanted)
                self.dropped.note("a SKU to leave out", row, wanted, chosen=True)
                self.lost.append((name, False))
            elif not items:
                self._drop(NO_QUANTITY, row, amount, name)
            elif items > self.choice.most:
                self.drop_large(row, amount, name)
            elif (moment := self._moment(file, row, name, time)) is not None:
                tick, ahead = moment.tick, moment.ahead
                due_tick = self._later(file, row, columns.due, "a due time", due)
                left = self._later(file, row, columns.cancelled, "a time of cancellation", cancelled)
                urgency = self._priority(row, priority)
                yield name, wanted, tick, ahead, items, due_tick, urgency, left, row, clean(route) or None

    def _drop(self, reason: str, row: int, found: str, name: str, chosen: bool = False) -> None:
        self.dropped.note(reason, row, found, chosen)
        self.lost.append((name, True))

    def drop_large(self, row: int, found: str, name: str) -> None:
        """Leave out a line of an order that has too many items."""
        most = self.choice.most
        self._drop(f"more than {most:,} items in a line", row, found, name, chosen=most < MOST_ITEMS_OF_LINE)

    def _moment(self, file: str, row: int, name: str, text: str) -> Moment | None:
        if self.columns.time is None:
            return Moment(0)
        try:
            moment = self.reader.clock.read(text, row)
        except UnusableError as error:
            self._drop(str(error), row, text, name)
        except ClockError as error:
            raise InputError(f"{file}, row {row}, {self.columns.time}", str(error)) from None
        except (ValueError, OverflowError):
            self._drop(NO_TIME, row, text, name)
        else:
            if moment.whole_day:
                self.whole_days.note(WHOLE_DAY, row, text)
            return moment
        return None

    def _later(self, file: str, row: int, column: str | None, what: str, text: str) -> int | None:
        """Read a time that an order may do without."""
        try:
            moment = self.reader.clock.read(text, row) if text else None
        except UnusableError as error:
            self.emptied.note(str(error).replace("a time", what), row, text)
        except ClockError as error:
            raise InputError(f"{file}, row {row}, {column}", str(error)) from None
        except (ValueError, OverflowError):
            self.emptied.note(f"{what} {UNREADABLE}", row, text)
        else:
            if moment is not None and moment.whole_day:
                self.whole_days.note(f"{what} that is a date alone", row, text)
            return None if moment is None else moment.tick
        return None

    def _priority(self, row: int, text: str) -> int | None:
        if not text:
            return None
        found = self.reader.priorities.whole(text, row)
        if found is None or found > _MOST_PRIORITY:
            self.emptied.note("a priority that is no whole number from 0 on", row, text)
            return None
        return found
