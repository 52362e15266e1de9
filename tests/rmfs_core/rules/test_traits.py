"""What a rule's class declares besides its decisions."""

from __future__ import annotations
