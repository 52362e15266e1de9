"""Notes of what has no counterpart."""

from __future__ import annotations

from rmfs_commands.import_.notes import Note, Notes


def test_nothing_is_noted_of_nothing() -> None:
    """What is not in the file needs no counterpart; the rest stays in its order."""
    notes = Notes()
    notes.add("elevators", 0)
    notes.add("semaphores", 2)
    notes.add("bots", 1, "robots")
    assert notes.taken == [Note("semaphores", 2, "left out"), Note("bots", 1, "robots")]
