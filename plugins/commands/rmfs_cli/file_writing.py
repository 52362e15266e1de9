"""Writing several files into a folder: all of them or none."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rmfs_core.errors import InputError
from rmfs_core.results.files import AtomicFile, output_folder, staged


def write_files(folder: str | Path, files: Mapping[str, bytes], *, force: bool) -> None:
    """Write files.

    Parameters
    ----------
    folder
        Where to; it is made if it is not there.
    files
        What is in them, by their names, which may have folders in them.
    force
        Whether files that are there may be replaced.

    Raises
    ------
    InputError
        When one is there already, or cannot be written.
    """
    folder = output_folder(folder)
    there = [str(folder / name) for name in sorted(files) if (folder / name).exists()]
    if there and not force:
        raise InputError(", ".join(there), "found a file of that name; --force replaces it")
    for name in files:
        if (folder / name).is_dir():
            raise InputError(str(folder / name), "cannot be written: a folder has that name")
    with staged(folder) as hidden:
        for name, content in files.items():
            with AtomicFile(output_folder((hidden / name).parent) / Path(name).name) as stream:
                stream.write(content)
