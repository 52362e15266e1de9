"""Changes from one state to the next: JSON Merge Patch (RFC 7396), https://www.rfc-editor.org/rfc/rfc7396."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def difference(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, Any]:
    """Return the patch that turns one object into another. A value of ``after`` that is new must not be null."""
    patch: dict[str, Any] = {name: None for name in before if name not in after}
    for name, value in after.items():
        old = before.get(name)
        if old is value is not None:
            continue
        if isinstance(old, Mapping) and isinstance(value, Mapping):
            if within := difference(old, value):
                patch[name] = within
        elif name not in before or old != value:
            patch[name] = value
    return patch


def patched(before: Mapping[str, Any], patch: Mapping[str, Any]) -> dict[str, Any]:
    """Return an object with a patch applied. What does not change is shared with ``before``."""
    after = dict(before)
    for name, value in patch.items():
        if value is None:
            after.pop(name, None)
        elif isinstance(value, Mapping):
            old = before.get(name)
            after[name] = patched(old if isinstance(old, Mapping) else {}, value)
        else:
            after[name] = value
    return after
