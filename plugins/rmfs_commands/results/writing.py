"""Results in files and in a notebook: the entry point ``results`` of the group ``rmfs.formats``."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from html import escape
from os.path import realpath  # which ends where links lead round
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rmfs_commands.instances.overrides import data_files
from rmfs_commands.instances.tables import TABLE_FILES
from rmfs_commands.results.figures import by_heading, show
from rmfs_commands.results.files import (
    json_ready,
    output_folder,
    removed_if_empty,
    staged,
    to_csv,
    to_json,
    write_text,
)
from rmfs_commands.results.recorders import files_of, files_of_results, load_recorder
from rmfs_commands.results.timing import timing  # noqa: F401 (the kernel looks for it here)
from rmfs_core import entrypoints
from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE
from rmfs_core.results.catalogue import Metric
from rmfs_core.rules.parameters import plain
from rmfs_core.scenario import Scenario, scenario_to_dict

if TYPE_CHECKING:
    from rmfs_core.results import Result


def content(result: Result) -> dict[str, Any]:
    """Return the content of result.json: everything but the tables."""
    found: dict[str, Any] = {
        "scenario": json_ready(scenario_to_dict(result.scenario)),
        "seed": result.seed,
        "versions": result.versions,
        "status": result.status,
    }
    if result.error is not None:
        found["error"] = result.error
    if result.notes:
        found["notes"] = result.notes
    if result.summary:
        found["summary"] = {_ready(name): _ready(value) for name, value in result.summary.items()}
    return found | {"metrics": result.metrics, "timing": result.timing}


def _ready(value: object) -> Any:
    """Return what an observer has put into the summary; of what JSON cannot have, what is plain of it, or its type."""
    for kept in (json_ready, plain):
        with suppress(Exception):  # whatever it is, the run is not lost for it
            to_json(ready := kept(value)).encode()
            return ready
    return f"<{type(value).__name__}>"


def save(result: Result, folder: str | Path) -> None:
    """Write result.json and the tables, all of them or none; `Result.save`."""
    with staged(output_folder(folder)) as path:
        for name, text in (table_files(result) | {RESULT_FILE: to_json(content(result), indent=2) + "\n"}).items():
            write_text(path / name, text)


def table_files(result: Result) -> dict[str, str]:
    """Return the text of each table by the name of its file."""
    given = [(name, columns, getattr(result, table)) for table, (name, columns) in TABLE_FILES.items()]
    return {name: to_csv([*(rows[0] if rows else columns)], rows) for name, columns, rows in given}


@contextmanager
def writing(
    out: str | Path, scenario: Scenario, standing: Iterable[object]
) -> Iterator[Callable[[Iterable[object]], Path]]:
    """Let a run write results into a folder, all at the end of the block if it ends well.

    Yields what returns a folder to write into, given recorders and observers with their files; ``standing`` are the
    observers of every run. What recorders and observers of an earlier run have left is deleted.

    Raises
    ------
    InputError
        When the folder cannot be written to, or results, or these files, would replace what is no result.
    """
    again, folders = os.path.exists(Path(out) / RESULT_FILE), list[Path]()  # noqa: PTH110 (also of a name too long)
    with ExitStack() as stack:
        stack.enter_context(removed_if_empty(out))

        def folder_for(observers: Iterable[object]) -> Path:
            folders.append(stack.enter_context(staged(_folder_for_results(out, scenario, files_of(observers)))))
            return folders[-1]

        yield folder_for
        written = {file.name for folder in folders for file in folder.iterdir()}
    if again:
        _delete_left_over(Path(out), written, files_of(standing))


def _folder_for_results(out: str | Path, scenario: Scenario, files: Sequence[str]) -> Path:
    """Return the output folder, unless results, or the files of recorders, would replace what is no result."""
    folder = output_folder(out)
    names = [*(name for name, _ in TABLE_FILES.values()), *files]
    for path, given in data_files(scenario).items():
        if realpath(Path(scenario.folder) / given) in [realpath(folder / name) for name in names]:
            key = ".".join(path)
            raise InputError(str(folder), f"results would replace `{key}`, {given}; expected another folder")
    for name in names:
        if (folder / name).is_dir():
            raise InputError(str(folder / name), "cannot be written: a folder has that name")
    foreign = [name for name in names if (folder / name).exists()]
    if foreign and not (folder / RESULT_FILE).exists():
        found = f"found a file {foreign[0]} that no run of rmfs has written"
        raise InputError(str(folder), f"{found}; expected a folder for results alone")
    return folder


def _delete_left_over(folder: Path, written: Iterable[str], of_observers: Iterable[str]) -> None:
    """Delete what recorders and observers of an earlier run have left in a folder of results.

    The files ``written`` now stay. Recorders are imported only where the folder holds a file that could be theirs.
    """
    foreign = {file.name for file in folder.iterdir() if file.is_file()} - {*files_of_results(), *written}
    for file in foreign.intersection(of_observers):
        with suppress(OSError):
            (folder / file).unlink()
        foreign.remove(file)
    for name in entrypoints.offers(entrypoints.RECORDERS) if foreign else ():
        with suppress(InputError, OSError):  # a recorder that cannot be had left nothing; what is no file is not ours
            file = load_recorder(name).file
            if file in foreign:
                (folder / file).unlink()


def html(result: Result) -> str:
    """Return status and metrics as tables for a notebook: one for each heading."""
    tables = ""
    for heading, metrics in by_heading(result.metrics, result.described).items():
        head = f'<tr><th colspan="3" style="text-align:left">{escape(heading)}</th></tr>'
        tables += f"<table>{head}{''.join(_row(metric, result.metrics[metric.name]) for metric in metrics)}</table>"
    head = f"<b>{escape(result.status)}</b>, seed {escape(str(result.seed))}"
    if result.error or result.notes:
        head += f": {escape(' '.join([result.error or '', *result.notes]).strip())}"
    return f'<div>{head}<div style="display:flex;flex-wrap:wrap;align-items:start;gap:0 2em">{tables}</div></div>'


def _row(metric: Metric, value: Any) -> str:
    shown = show(metric, value) if isinstance(value, int | float | None) else str(value)
    label, shown, unit = map(escape, (metric.label.replace("  ", "\u2003"), shown, metric.unit * (value is not None)))
    return f'<tr><td style="text-align:left">{label}</td><td style="text-align:right">{shown}</td><td>{unit}</td></tr>'
