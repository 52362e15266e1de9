"""What follows a run does something at events of some kinds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rmfs_core.events import Event

Handlers = Mapping[type[Event], Callable[[Any], None]]
"""What is done at each kind of event."""
