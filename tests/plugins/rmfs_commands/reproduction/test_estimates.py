"""Means over instances and seeds, and their intervals."""

import pytest

from rmfs_commands.reproduction.estimates import estimate, mean_of, metric, relative, select


def test_a_seeds_runs_are_averaged_first() -> None:
    """Seed 1 has the mean 2 and seed 2 the mean 5; the mean is 3.5, its interval t(0.975, 1) x sd / sqrt(2)."""
    found = estimate([(1, 1.0), (1, 3.0), (2, 4.0), (2, 6.0)])
    assert found is not None
    assert found.mean == 3.5
    assert found.half_width == pytest.approx(12.7062 * 1.5, rel=1e-4)
    assert (found.runs, found.expected) == (4, 4)


def test_one_seed_has_no_interval() -> None:
    """There is nothing to tell the spread over seeds from."""
    found = estimate([(1, 1.0), (1, 3.0)])
    assert found is not None and found.half_width is None


def test_missing_values_are_counted_and_left_out() -> None:
    """A run that cannot count shows in what is expected, and in nothing else."""
    found = estimate([(1, 1.0), (1, None), (2, None)])
    assert found is not None
    assert (found.mean, found.runs, found.expected) == (1.0, 1, 3)
    assert estimate([(1, None)]) is None
    assert estimate([]) is None


def test_relative_divides_the_means_of_a_seed(row) -> None:
    """On seed 1 the means over two instances are 2.75 and 1.5; only then seeds are averaged."""
    baseline = [row(seed=1, pile_on=2.0), row(seed=2, pile_on=4.0), row(seed=1, instance="two", pile_on=1.0)]
    others = [
        row("integrated", seed=1, pile_on=3.0),
        row("integrated", seed=2, pile_on=4.0),
        row("integrated", seed=1, instance="two", pile_on=2.5),
    ]
    found = relative(others, baseline, metric("pile_on"))
    assert found is not None
    assert found.mean == (2.75 / 1.5 + 1.0) / 2


def test_relative_leaves_out_instances_without_a_partner(row) -> None:
    """An instance that only one of the two completed would make the means differ for no other reason."""
    baseline = [row(pile_on=2.0), row(instance="two", pile_on=9.0) | {"status": "partial"}]
    others = [row("integrated", pile_on=3.0), row("integrated", instance="two", pile_on=8.0)]
    found = relative(others, baseline, metric("pile_on"))
    assert found is not None
    assert (found.mean, found.runs, found.expected) == (1.5, 1, 2)


@pytest.mark.parametrize("side", ["integrated", "sequential"])
def test_a_pair_with_a_failed_run_does_not_count(row, side: str) -> None:
    """Whichever of the two failed; the pair is still expected."""
    rows = [row(rule_set, seed, pile_on=seed) for rule_set in ("sequential", "integrated") for seed in (1, 2)]
    for one in rows:
        if one["rule_set"] == side and one["seed"] == 2:
            one |= {"status": "failed", "pile_on": 99.0}
    found = relative(select(rows, rule_set="integrated"), select(rows, rule_set="sequential"), metric("pile_on"))
    assert found is not None
    assert (found.mean, found.runs, found.expected) == (1.0, 1, 2)


def test_a_baseline_of_nothing_gives_no_ratio(row) -> None:
    """Its seed is left out, and its runs are not among those that count."""
    rows = [row(seed=seed, pile_on=seed - 1.0) for seed in (1, 2)]
    found = relative(rows, rows, metric("pile_on"))
    assert found is not None
    assert (found.mean, found.runs, found.expected) == (1.0, 1, 2)


def test_a_run_without_a_result_lacks_its_figures(row) -> None:
    """Such a row has labels and status alone, and is no error."""
    lost = {key: row()[key] for key in ("instance", "rule_set", "seed", "error_kind")} | {"status": "failed"}
    found = mean_of([lost, row(seed=2, makespan_s=7.0)], metric("makespan_s"))
    assert found is not None
    assert (found.mean, found.runs, found.expected) == (7.0, 1, 2)
