"""Parameters of rules, each in one place: default, check, meaning and unit."""

from __future__ import annotations

from typing import Any

from attrs import Attribute, field, validators

from rmfs_core.rules.parameters import MOST

NOT_NEGATIVE, POSITIVE, AT_LEAST_1 = validators.ge(0), validators.gt(0), validators.ge(1)
SHARE, SHARE_ABOVE_0 = validators.and_(NOT_NEGATIVE, validators.le(1)), validators.and_(POSITIVE, validators.le(1))


def finite(_rule: object, checked: Attribute[Any], value: float) -> None:
    """Refuse, as scenarios do, a number that rules cannot count with: infinite, NaN, or too large."""
    if not abs(value) < MOST:
        raise ValueError(f"expected a finite number below {MOST:g} as {checked.name}, found {value:g}")


def parameter(default: Any, check: Any, doc: str, unit: str | None = None, **more: Any) -> Any:
    """Return a field of a rule's class that a scenario can set.

    Parameters
    ----------
    default
        Its value when a scenario gives none; `attrs.NOTHING` where a scenario has to.
    check
        One or several validators of attrs; None: every value of its type will do.
    doc, unit
        Its meaning and its unit, as ``rmfs rules`` and the reference page show them.
    more
        More metadata.
    """
    told = {"doc": doc, **more} if unit is None else {"unit": unit, "doc": doc, **more}
    return field(default=default, validator=check, metadata=told)
