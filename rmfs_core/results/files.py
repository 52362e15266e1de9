"""The old name of `rmfs_commands.results.files`, until 0.3.0."""

import warnings

from rmfs_core.entrypoints import format_module


def __getattr__(name: str) -> object:
    found = getattr(format_module("files"), name)
    warnings.warn("rmfs_core.results.files is rmfs_commands.results.files now", FutureWarning, stacklevel=2)
    return found
