"""Random streams, one per purpose.

Every stream is spawned from the seed and the name of its purpose alone, so two rule sets that are compared on one
seed see the same orders and pods (common random numbers), and a rule's draws do not shift anyone else's.
"""

from __future__ import annotations

import hashlib
from functools import lru_cache
from typing import Any

import numpy as np


def _sequence(seed: int, purpose: str) -> np.random.SeedSequence:
    digest = hashlib.sha256(purpose.encode("utf-8", "surrogatepass")).digest()
    key = tuple(int.from_bytes(digest[i : i + 4], "big") for i in range(0, 16, 4))
    return np.random.SeedSequence(seed, spawn_key=key)


def stream(seed: int, purpose: str) -> np.random.Generator:
    """Return the generator of ``purpose`` (for example ``"orders"``) for ``seed``."""
    return np.random.default_rng(_sequence(seed, purpose))


def keyed_stream(seed: int, purpose: str, *numbers: int) -> np.random.Generator:
    """Return the generator of one of many things of a purpose, told by up to three numbers: in constant time."""
    counter = np.array((0, *numbers, *(0,) * (3 - len(numbers))), np.uint64)
    return np.random.Generator(np.random.Philox(key=_key(seed, purpose), counter=counter))


@lru_cache(maxsize=64)
def _key(seed: int, purpose: str) -> Any:
    return _sequence(seed, purpose).generate_state(2, np.uint64)


def rule_stream(seed: int, role: str, name: str, place: int | None = None) -> np.random.Generator:
    """Return the generator of the rule ``name`` in a role; ``place`` tells filters of one name apart, from 1."""
    return stream(seed, f"rule {role} {name}{'' if place is None else f' {place}'}")
