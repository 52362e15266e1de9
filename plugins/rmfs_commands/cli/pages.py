"""Reports as one HTML file each: no network, no other files, one look. Their templates extend ``page.html.j2``."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from rmfs_core.errors import InputError


def render(template: Path, **values: Any) -> str:
    """Return the page that a template makes of some values, which are escaped.

    Parameters
    ----------
    template
        Its file. It may extend ``page.html.j2``, which has the styles.
    values
        Values to show, by name.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader([template.parent, Path(__file__).parent]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template.name).render(embedded=embedded, **values)


def check_target(file: Path | None) -> None:
    """Raise `InputError` where a page would replace a file that is none: orders, or the result of a run."""
    if file is None:
        return
    try:
        with file.open("rb") as stream:
            page = stream.read(15).lower().startswith(b"<!doctype html")
    except (FileNotFoundError, IsADirectoryError, NotADirectoryError):  # the last two are refused as it is written
        return
    except OSError as error:
        raise InputError(str(file), f"cannot be written: {error.strerror}; expected the name of a new file") from None
    if not page:
        raise InputError(str(file), "exists, and is no page; expected a new name, or that of a page to replace")


def embedded(svg: bytes) -> str:
    """Return a picture as an address that holds it; an image of its own, so that ids of several SVGs do not clash."""
    return f"data:image/svg+xml;base64,{base64.b64encode(svg).decode('ascii')}"
