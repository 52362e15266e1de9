"""How the runs of a part ended."""

from rmfs_commands.reproduction.counts import count, unfinished


def test_nothing_is_hidden(row) -> None:
    """Failed runs, those that stood still, and decisions that a limit ended are counted by rule set."""
    lost = {key: row("integrated", seed=3)[key] for key in ("instance", "rule_set", "seed")}
    rows = [
        row(solves_stopped_early=2),
        row(seed=2, status="partial"),
        row("integrated", seed=2, status="failed", error="nobody moves", error_kind="StandstillError"),
        lost | {"status": "failed", "error": "the worker died", "error_kind": "WorkerDiedError"},
    ]
    sequential, integrated = count({"instances": rows})
    assert (sequential.runs, sequential.complete, sequential.partial, sequential.failed) == (2, 1, 1, 0)
    assert (sequential.stopped_early, sequential.seconds) == (2, 3.0)
    assert (integrated.runs, integrated.complete, integrated.failed, integrated.stood_still) == (2, 0, 2, 1)
    assert [(part, one["rule_set"], one["seed"]) for part, one in unfinished({"instances": rows})] == [
        ("instances", "sequential", 2),
        ("instances", "integrated", 2),
        ("instances", "integrated", 3),
    ]
