"""Names of metrics for people, with units and meanings, as observers describe them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

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
        What a value is multiplied by to be shown: 100 for a share that is shown in percent.
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


TIMING: tuple[Metric, ...] = (
    Metric("wall_s", "Simulation", "s", 2, "Wall-clock seconds of the simulation."),
    Metric("simulated_s_per_wall_s", "Simulated seconds per second", "", 0, "Simulated time over wall-clock time."),
    Metric("decision_s_first", "Decisions, t = 1", "s", 3, "POA and PPS decisions of the first period."),
    Metric("decision_s_later", "Decisions, t > 1", "s", 3, "POA and PPS decisions of all later periods."),
    Metric("decision_s_per_order", "  per order", "s", 4, "The same per completed order.", of_completed=True),
    Metric("decision_percent_of_simulated", "  of simulated time", "%", 3, "The same as a share of simulated time."),
)
"""Wall-clock figures; they differ from run to run."""


def show(metric: Metric, value: float | None) -> str:
    """Value of a metric for people: rounded, thousands separated, a dash where there is none."""
    if value is None:
        return "-"
    value *= metric.scale
    return f"{value:,}" if isinstance(value, int) else f"{value:,.{metric.digits}f}"


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


def by_heading(names: Collection[str], described: Mapping[str, Metric]) -> dict[str, list[Metric]]:
    """Return the metrics of a run by heading, in the order of description; what nobody describes goes by its name."""
    known = {**described, **{name: Metric(name) for name in names if name not in described}}
    groups: dict[str | None, list[Metric]] = {known[name].group: [] for name in names}
    for metric in known.values():
        if metric.name in names:
            groups[metric.group].append(metric)
    return {heading: metrics for heading, metrics in groups.items() if heading}
