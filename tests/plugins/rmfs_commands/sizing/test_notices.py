"""What is said of single runs."""

from __future__ import annotations

import io
from typing import Any, cast

from rich.console import Console

from rmfs_commands.sizing.notices import Notices


def test_only_what_is_out_of_the_ordinary_is_said() -> None:
    """A run that is computed again, and one whose worker died."""
    text = io.StringIO()
    notices = Notices(Console(file=text, width=40))
    job = cast(Any, "hall, 2 stations, 3 robots, seed 1")
    notices.started(4, 0, 1)
    notices.run_started(job)
    notices.run_dropped(job, "is not as it was stored")
    notices.run_repeated(job, "its worker process died")
    notices.ended()
    assert text.getvalue().splitlines() == [
        f"Computed again: {job}: is not as it was stored",
        f"Repeated: {job}: its worker process died",
    ]
