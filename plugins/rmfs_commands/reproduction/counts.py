"""How the runs ended: nothing that failed, stood still or was cut short is hidden."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from attrs import frozen

from rmfs_commands.reproduction.estimates import Row, Rows, select

STOOD_STILL = "StandstillError"


@frozen
class Count:
    """Runs of a part with one rule set.

    Parameters
    ----------
    part, rule_set
        Which.
    runs, complete, partial, failed
        Runs in all, and by status.
    stood_still
        Failed runs in which nothing would ever have happened again.
    stopped_early
        Decisions, over all runs, that a limit ended before their proof.
    seconds
        Wall-clock time of the simulations, summed, s.
    """

    part: str
    rule_set: str
    runs: int
    complete: int
    partial: int
    failed: int
    stood_still: int
    stopped_early: int
    seconds: float


def count(parts: Mapping[str, Rows]) -> list[Count]:
    """Return the counts of every part and rule set.

    Parameters
    ----------
    parts
        Rows by the name of the part.
    """
    return [
        _count(part, rule_set, select(rows, rule_set=rule_set))
        for part, rows in parts.items()
        for rule_set in dict.fromkeys(row["rule_set"] for row in rows)
    ]


def _count(part: str, rule_set: str, rows: Rows) -> Count:
    status = [row["status"] for row in rows]
    return Count(
        part=part,
        rule_set=rule_set,
        runs=len(rows),
        complete=status.count("complete"),
        partial=status.count("partial"),
        failed=status.count("failed"),
        stood_still=sum(row["error_kind"] == STOOD_STILL for row in rows),
        stopped_early=sum(row.get("solves_stopped_early") or 0 for row in rows),
        seconds=sum(row.get("wall_s") or 0.0 for row in rows),
    )


def distinct(parts: Mapping[str, Rows]) -> list[Row]:
    """Return every run once, those too that several parts share."""
    return list({row["key"]: row for rows in parts.values() for row in rows}.values())


def unfinished(parts: Mapping[str, Rows]) -> Iterable[tuple[str, Row]]:
    """Yield every run that did not complete, with its part."""
    for part, rows in parts.items():
        for row in rows:
            if row["status"] != "complete":
                yield part, row
