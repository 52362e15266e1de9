"""Files that are whole or not there, JSON and CSV: what the entry point ``files`` of ``rmfs.formats`` leads to."""

from __future__ import annotations

from rmfs_core.entrypoints import format_module


def __getattr__(name: str) -> object:
    return getattr(format_module("files"), name)


def __dir__() -> list[str]:
    return dir(format_module("files"))
