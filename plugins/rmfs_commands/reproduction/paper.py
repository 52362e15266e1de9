"""The paper's tables and figures, with the numbers that it gives for them (paper.toml)."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from attrs import Factory, frozen


@frozen
class Range:
    """Where a figure of the paper lies.

    Parameters
    ----------
    low, high
        Ends of the range, both within it.
    printed
        The number that the paper prints; None where its text gives a range.
    """

    low: float
    high: float
    printed: float | None = None


@frozen
class Exhibit:
    """A table, figure or passage of the paper.

    Parameters
    ----------
    name
        Its key in paper.toml.
    label
        Its label in the paper's source.
    item
        Its number in the paper.
    caption, wording
        Its subject, and the paper's words about it.
    values
        The paper's numbers; empty for a picture without numbers.
    rounded_to
        Unit of the last digit printed in a table.
    """

    name: str
    label: str
    item: str
    caption: str
    wording: str
    values: Mapping[str, Any] = Factory(dict)
    rounded_to: float | None = None

    def range(self, *keys: str) -> Range | None:
        """Return the paper's figure under these keys of ``values``, or None where the paper has no number."""
        value: Any = self.values
        for key in keys:
            value = value.get(key) if isinstance(value, Mapping) else None
        if value is None:
            return None
        if isinstance(value, list):
            return Range(*value)
        half = (self.rounded_to or 0.0) / 2
        return Range(value - half, value + half, value)


def load_paper() -> dict[str, Exhibit]:
    """Return every exhibit by its name, in the paper's order."""
    text = Path(__file__).with_name("paper.toml").read_text(encoding="utf-8")
    return {name: Exhibit(name=name, **table) for name, table in tomllib.loads(text).items()}
