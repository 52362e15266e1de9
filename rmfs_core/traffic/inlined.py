"""How the helpers of compiled searches are compiled."""

from __future__ import annotations

from typing import Any

from numba import njit

_OPTIONS: dict[str, Any] = {"cache": True, "forceinline": True, "_nrt": False}

inlined = njit(**_OPTIONS)
"""Compile a helper into the searches that call it.

A search hands a dozen arrays from helper to helper. Calls with so many arguments, and numba's counting of references to
each array (``_nrt``), would take longer than most helpers do. A helper compiled so creates no arrays.
"""
