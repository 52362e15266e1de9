"""What a warehouse shall keep."""

from __future__ import annotations

from attrs import frozen

from rmfs_core.results.catalogue import Metric, show
from rmfs_details.catalogue import MEASURES, METRICS

KNOWN = {metric.name: metric for group in METRICS.values() for metric in group} | {one.name: one for one in MEASURES}
"""Metrics of every run, by name."""


@frozen
class Target:
    """A metric, whose mean over seeds shall be at most ``most``.

    Parameters
    ----------
    metric
        A figure of result.json, the less the better.
    most
        The limit.
    confidence
        With which a size is found to keep it, or not to.
    seeds
        The most seeds, in the order in which they are taken.
    """

    metric: str
    most: float
    confidence: float = 0.95
    seeds: tuple[int, ...] = tuple(range(1, 17))

    @property
    def described(self) -> Metric:
        """The metric for people; of what somebody's observer measures only the name is known."""
        return KNOWN.get(self.metric) or Metric(self.metric, self.metric, "", 3, "")

    @property
    def label(self) -> str:
        """What tables call it."""
        return self.described.label.strip()

    def shown(self, value: float) -> str:
        """Return one of its values without the unit."""
        return show(self.described, float(value))

    def with_unit(self, value: float) -> str:
        """Return one of its values."""
        return f"{self.shown(value)} {self.described.unit}".rstrip()
