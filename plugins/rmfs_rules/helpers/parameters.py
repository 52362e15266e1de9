"""Parameters of rules, each in one place: default, check, meaning and unit."""

from __future__ import annotations

from typing import Any

from attrs import field


def parameter(default: Any, check: Any, doc: str, unit: str | None = None, **more: Any) -> Any:
    """Return a field of a rule's class that a scenario can set.

    Parameters
    ----------
    default
        Its value when a scenario gives none; `attrs.NOTHING` where a scenario has to.
    check
        One or several validators of attrs; None: every value of its type will do.
    doc, unit
        What it means, and its unit, as ``rmfs rules`` and the reference page show them.
    more
        More metadata.
    """
    told = {"doc": doc, **more} if unit is None else {"unit": unit, "doc": doc, **more}
    return field(default=default, validator=check, metadata=told)
