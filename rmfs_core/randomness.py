"""Random streams, one per purpose.

Every stream is spawned from the seed and the name of its purpose alone, so two rule sets that are compared on one
seed see the same orders and pods (common random numbers), and a rule's draws do not shift anyone else's.
"""

from __future__ import annotations

import hashlib

import numpy as np


def stream(seed: int, purpose: str) -> np.random.Generator:
    """Return the generator of ``purpose`` (for example ``"orders"`` or ``"rule pr"``) for ``seed``."""
    digest = hashlib.sha256(purpose.encode()).digest()
    key = tuple(int.from_bytes(digest[i : i + 4], "big") for i in range(0, 16, 4))
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
