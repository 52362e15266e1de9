"""Recorder ``acme-log``."""

from __future__ import annotations

from rmfs import Question, RunInfo, hookimpl
from rmfs_commands.results.files import write_text


class Log:
    """Writes which rule was asked how often."""

    file = "acme-log.txt"

    def __init__(self) -> None:
        self.asked: dict[str, int] = {}

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Take down where to write."""
        assert run.out is not None
        self.path = run.out / self.file

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        """Count."""
        self.asked[question.rule] = self.asked.get(question.rule, 0) + 1

    @hookimpl
    def run_ended(self) -> None:
        """Write."""
        write_text(self.path, "".join(f"{rule} {number}\n" for rule, number in sorted(self.asked.items())))
