"""Names of metrics for people, with units and meanings, as observers describe them."""

from __future__ import annotations

from collections.abc import Iterable

from attrs import Factory, frozen

from rmfs_core.errors import InputError
from rmfs_core.wording import shown_short


@frozen
class Metric:
    """A metric.

    Parameters
    ----------
    name
        Its key in ``metrics`` or ``timing`` of result.json.
    label, unit, digits
        How a table shows it: the name where there is no label; no unit for a plain number; integers without digits.
    meaning
        One sentence.
    group
        Under which heading the summary of a run shows it; None: not there.
    scale
        Factor by which a value is multiplied to be shown: 100 for a share that is shown in percent.
    of_completed
        Whether it is a figure per completed order: what it would be with the orders that ``run.until_s`` leaves open is
        not known, so that comparisons mark it.
    """

    name: str
    label: str = Factory(lambda self: self.name, takes_self=True)
    unit: str = ""
    digits: int = 2
    meaning: str = ""
    group: str | None = "Observers"
    scale: int = 1
    of_completed: bool = False

    def __attrs_post_init__(self) -> None:
        texts = (self.name, self.label, self.unit, self.meaning, self.group or "")
        if not all(isinstance(text, str) and text.isprintable() for text in texts) or self.digits not in range(16):
            raise ValueError(f"expected texts of one line and 0 to 15 digits, found {shown_short(self)}")


def described_by(observers: Iterable[object]) -> dict[str, Metric]:
    """Return the metrics that observers describe in their attribute ``measures``, by name; who is first counts."""
    found: dict[str, Metric] = {}
    for observer in observers:
        try:
            measures = getattr(observer, "measures", ())
        except Exception as error:
            measures = error
        if not isinstance(measures, tuple | list) or not all(isinstance(one, Metric) for one in measures):
            place, expected = f"class {type(observer).__name__}", "a tuple of rmfs_core.results.catalogue.Metric"
            raise InputError(place, f"expected `measures` to be {expected}, found {shown_short(measures)}")
        for metric in measures:
            found.setdefault(metric.name, metric)
    return found
