"""Random streams, one per purpose.

Every stream is spawned from the seed and the name of its purpose alone, so two rule sets that are compared on one
seed see the same orders and pods (common random numbers), and a rule's draws do not shift anyone else's.
"""

from __future__ import annotations

import hashlib

import numpy as np


def stream(seed: int, purpose: str) -> np.random.Generator:
    """Return the generator of ``purpose`` (for example ``"orders"``) for ``seed``."""
    digest = hashlib.sha256(purpose.encode("utf-8", "surrogatepass")).digest()
    key = tuple(int.from_bytes(digest[i : i + 4], "big") for i in range(0, 16, 4))
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def rule_stream(seed: int, role: str, name: str, place: int | None = None) -> np.random.Generator:
    """Return the generator of the rule ``name`` in a role; ``place`` tells filters of one name apart, from 1."""
    return stream(seed, f"rule {role} {name}{'' if place is None else f' {place}'}")
