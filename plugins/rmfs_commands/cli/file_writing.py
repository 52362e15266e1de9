"""Writing several files into a folder: all of them or none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from rmfs_commands.results.files import AtomicFile, output_folder, staged
from rmfs_core.errors import InputError


def writable_folder(folder: str | Path, names: Iterable[str], *, force: bool) -> Path:
    """Return a folder that can take files of these names; it is made if it is not there.

    Raises
    ------
    InputError
        When a file of such a name is there already and ``force`` is not given, or a folder has the name.
    """
    folder = output_folder(folder)
    there = sorted(name for name in names if (folder / name).exists())
    if there and not force:
        raise InputError(
            ", ".join(str(folder / name) for name in there), "found a file of that name; --force replaces it"
        )
    for name in there:
        if (folder / name).is_dir():
            raise InputError(str(folder / name), "cannot be written: a folder has that name")
    return folder


def write_files(folder: str | Path, files: Mapping[str, bytes], *, force: bool) -> None:
    """Write files.

    Parameters
    ----------
    folder
        Where to; it is made if it is not there.
    files
        Contents by the files' names, which may have folders in them.
    force
        Whether files that are there may be replaced.

    Raises
    ------
    InputError
        When one is there already, or cannot be written.
    """
    folder = writable_folder(folder, files, force=force)
    with staged(folder) as hidden:
        for name, content in files.items():
            with AtomicFile(output_folder((hidden / name).parent) / Path(name).name) as stream:
                stream.write(content)
