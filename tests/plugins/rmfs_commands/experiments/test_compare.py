"""Paired comparison: the figures are those of a calculation by hand."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from rmfs_commands.experiments.compare import holm, interval, intervals, summary
from rmfs_core.errors import InputError


def row(rule_set: str, seed: int, value: float | None, instance: str = "one", **more: Any) -> dict[str, Any]:
    """Return the row of a run."""
    return {"instance": instance, "rule_set": rule_set, "seed": seed, "status": "complete", "m": value, **more}


def test_differences_are_paired_by_instance_and_seed() -> None:
    """Differences 1, 2, 3 from 10, 20, 30: mean 2, interval 2 +- 4.3027 / sqrt(3), each a tenth of its baseline."""
    rows = [row("base", seed, 10.0 * seed) for seed in (1, 2, 3)]
    rows += [row("other", seed, 11.0 * seed) for seed in (3, 1, 2)]
    base, other = summary(rows, "base", ["m"]).paired
    assert (base.rule_set, base.mean, base.difference.mean) == ("base", 20.0, None)
    assert (other.pairs, other.left_out, other.mean, other.baseline_mean) == (3, 0, 22.0, 20.0)
    assert other.difference.mean == 2.0
    assert other.difference.high == pytest.approx(2 + 4.302653 / math.sqrt(3), abs=1e-6)
    assert other.difference.low == pytest.approx(2 - 4.302653 / math.sqrt(3), abs=1e-6)
    assert other.relative.mean == pytest.approx(0.1)
    assert other.difference.p == pytest.approx(0.0741799, abs=1e-6)
    assert other.p_holm == other.difference.p


def test_p_values_are_corrected_over_the_rule_sets() -> None:
    """Three rule sets against the baseline: the smallest p-value counts three times, the next twice, the last once."""
    values = {"base": [5.0, 6.0, 7.0, 9.0], "a": [6.0, 8.0, 8.5, 11.0], "b": [5.5, 6.0, 7.5, 9.5], "c": [5, 7, 6, 9.5]}
    rows = [row(name, seed, value) for name, column in values.items() for seed, value in enumerate(column)]
    found = {one.rule_set: one for one in summary(rows, "base", ["m"]).paired}
    p = {name: stats.ttest_rel(values[name], values["base"]).pvalue for name in "abc"}
    assert p["a"] < p["b"] < p["c"]
    assert found["a"].difference.p == pytest.approx(p["a"])
    assert found["a"].p_holm == pytest.approx(3 * p["a"])
    assert found["b"].p_holm == pytest.approx(2 * p["b"])
    assert found["c"].p_holm == pytest.approx(max(p["c"], 2 * p["b"]))
    assert found["base"].p_holm is None


def test_a_front_has_what_none_beats_in_both() -> None:
    """(1, 5), (2, 3) and (4, 2); not (3, 3), which has as much of the one and more of the other, nor the incomplete."""
    figures = {"base": (3.0, 3.0), "a": (2.0, 3.0), "b": (4.0, 2.0), "c": (1.0, 5.0), "d": (5.0, 2.0), "e": (0.0, 0.0)}
    rows = [row(name, 1, m, n=n) for name, (m, n) in figures.items()]
    rows += [row(name, 2, m, n=n) for name, (m, n) in figures.items() if name != "e"]
    comparison = summary(rows, "base", ["m", "n"], fronts=[("m", "n")])
    assert [pair[0].rule_set for pair in comparison.front("one", "m", "n")] == ["c", "a", "b"]


def test_holm_by_hand() -> None:
    """0.01, 0.04, 0.03, 0.005: times 3, 1, 2, 4; the largest is raised to the one before it."""
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.5, 0.6]) == pytest.approx([1.0, 1.0])
    assert holm([]) == []


@given(st.lists(st.floats(0, 1), max_size=8))
def test_holm_lies_between_the_p_value_and_bonferroni(p_values: list[float]) -> None:
    """Corrected values keep their order, and lie between the p-value and its multiple, at most 1."""
    corrected = holm(p_values)
    for p, one in zip(p_values, corrected, strict=True):
        assert p <= one <= min(1.0, p * len(p_values)) or one == pytest.approx(p)
    assert [corrected[i] for i in sorted(range(len(p_values)), key=lambda i: p_values[i])] == sorted(corrected)


def test_one_pair_has_no_interval() -> None:
    """A single pair gives a difference, but neither interval nor p-value; no pair gives nothing."""
    alone = interval([3.0])
    assert (alone.mean, alone.low, alone.high, alone.p) == (3.0, None, None, None)
    assert interval([]).mean is None


@pytest.mark.parametrize("values", [[0.0] * 3, [2.0] * 20, [0.3, 0.1 + 0.2, 0.3], [1.0, 3.0]])
def test_what_tells_nothing_has_no_interval(values: list[float]) -> None:
    """Two values, or any number that are the same but for rounding: neither interval nor p, in no correction."""
    found = interval(values)
    assert (found.low, found.high, found.p) == (None, None, None)
    of_all = intervals([values, [1.0, 2.0, 3.0]])
    assert (of_all[0].low_holm, of_all[0].p_holm) == (None, None)
    assert of_all[1].p_holm == of_all[1].p


def test_nothing_is_more_than_all_less() -> None:
    """Intervals of relative differences end at -100 % where figures are amounts; not where they may be negative."""
    shares = {1: 0.01, 2: 0.6, 3: 0.02, 4: 0.9}
    rows = [row("base", seed, 10.0) for seed in shares] + [row("other", seed, 10.0 * s) for seed, s in shares.items()]
    other = summary(rows, "base", ["m"]).paired[1]
    plain = intervals([[share - 1 for share in shares.values()]])[0]
    assert plain.low is not None
    assert plain.low < -1
    assert (other.relative.low, other.relative.low_holm, other.relative.high) == (-1.0, -1.0, plain.high)
    rows[-1]["m"] = -9.0
    other = summary(rows, "base", ["m"]).paired[1]
    assert other.relative.low is not None
    assert other.relative.low < -1


def test_instance_sets_whose_orders_stay_are_known() -> None:
    """Those with an instance whose orders are the same for every seed; so all together."""
    rows = [row(name, seed, 1.0, at) for name in ("base", "other") for seed in (1, 2) for at in ("day", "drawn")]
    assert summary(rows, "base", ["m"], fixed={"day"}).fixed == ("day", "overall")
    assert summary(rows, "base", ["m"]).fixed == ()


def test_pairs_with_a_side_that_failed_are_left_out_and_counted() -> None:
    """A failed run, one without the figure and one that is missing take their pairs with them; the rest counts."""
    rows = [row("base", seed, 10.0) for seed in range(1, 6)]
    rows += [
        row("other", 1, 12.0),
        row("other", 2, 99.0, status="failed"),
        row("other", 3, None),
        row("other", 4, 14.0),
    ]
    other = summary(rows, "base", ["m"]).paired[1]
    assert (other.pairs, other.left_out, other.mean, other.baseline_mean) == (2, 3, 13.0, 10.0)
    assert other.difference.mean == 3.0


def test_partial_runs_do_not_count() -> None:
    """What a run with orders left has measured until then is no figure of the whole."""
    rows = [row("base", seed, 10.0) for seed in (1, 2, 3)]
    rows += [row("other", seed, 11.0) for seed in (1, 2)] + [row("other", 3, 99.0, status="partial")]
    other = summary(rows, "base", ["m"]).paired[1]
    assert (other.seeds, other.left_out, other.mean, other.difference.mean) == (2, 1, 11.0, 1.0)


def test_overall_has_one_value_a_seed() -> None:
    """Instances share the orders of a seed: two seeds are two values, however many instances there are."""
    of_seed = {1: 1.0, 2: 3.0, 3: 2.0}
    rows = [row("base", seed, 10.0, f"instance {i}") for seed in of_seed for i in range(4)]
    rows += [row("other", seed, 10.0 + of_seed[seed] + i, f"instance {i}") for seed in of_seed for i in range(4)]
    other = summary(rows, "base", ["m"]).of("overall", "m")[1]
    by_hand = stats.ttest_1samp([2.5, 4.5, 3.5], 0.0)
    assert (other.seeds, other.pairs, other.mean) == (3, 12, 13.5)
    assert other.difference.p == pytest.approx(by_hand.pvalue)
    assert other.difference.low == pytest.approx(by_hand.confidence_interval(0.95).low)
    assert other.relative.mean == pytest.approx(0.35)


def test_every_seed_is_of_the_same_instances() -> None:
    """A seed that lacks a pair of one of them is left out; an instance without any pair is left out alone."""
    rows = [row(name, seed, 10.0, instance) for name in ("base", "other") for seed in (1, 2, 3) for instance in "abc"]
    for one in rows:
        one["m"] += 5.0 * (one["rule_set"] == "other") * "abc".index(one["instance"])
        if one["rule_set"] == "other" and (one["instance"] == "c" or (one["instance"], one["seed"]) == ("a", 2)):
            one["status"] = "failed"
    other = summary(rows, "base", ["m"]).of("overall", "m")[1]
    assert (other.seeds, other.pairs, other.left_out) == (2, 4, 5)
    assert (other.mean, other.difference.mean) == (12.5, 2.5)


def test_bounds_for_all_at_once_agree_with_holm() -> None:
    """Wider than alone, by the number of rule sets; where Holm is surer than Bonferroni they end at 0."""
    sure, nearly, unsure = [5.0, 5.1, 5.2, 5.0], [1.0, 2.0, 1.5, 0.6], [1.0, -1.0, 0.5, -0.4]
    found = intervals([sure, nearly, unsure])
    alone = [interval(values) for values in (sure, nearly, unsure)]
    assert [(one.mean, one.low, one.high, one.p) for one in found] == [
        (one.mean, one.low, one.high, one.p) for one in alone
    ]
    wide = stats.t.interval(1 - 0.05 / 3, 3, loc=1.275, scale=stats.sem(nearly))
    assert wide[0] < 0
    assert (found[1].low_holm, found[1].high_holm) == (0.0, pytest.approx(wide[1]))
    assert found[1].p is not None
    assert 0.05 / 3 < found[1].p < 0.05 / 2
    assert found[1].p_holm == pytest.approx(2 * found[1].p)
    assert found[0].low_holm is not None
    assert 0 < found[0].low_holm < (found[0].low or 0)


def different(values: list[float]) -> bool:
    """Whether their spread is more than an error of rounding."""
    return max(values) - min(values) > 1e-6


@given(st.lists(st.lists(st.floats(-10, 10), min_size=3, max_size=6).filter(different), min_size=1, max_size=5))
def test_bounds_and_p_values_never_contradict_each_other(family: list[list[float]]) -> None:
    """0 lies within an interval when its p-value is above 0.05, and not inside when it is not."""
    for one in intervals(family):
        assert one.low is not None
        assert one.low_holm is not None
        assert one.high is not None
        assert one.high_holm is not None
        assert one.p is not None
        assert one.p_holm is not None
        assert (one.low <= 0 <= one.high) == (one.p > 0.05)
        assert (one.low_holm < 0 < one.high_holm) == (one.p_holm > 0.05)


def test_relative_differences_have_a_p_of_their_own() -> None:
    """That of the differences is another one: it may be above 0.05 where the other is below."""
    rows = [row("base", seed, 10.0**seed) for seed in (1, 2, 3, 4)]
    rows += [row("other", seed, 1.1 * 10.0**seed + seed) for seed in (1, 2, 3, 4)]
    other = summary(rows, "base", ["m"]).paired[1]
    assert other.relative.p is not None
    assert other.relative.p == pytest.approx(stats.ttest_1samp([0.2, 0.12, 0.103, 0.1004], 0.0).pvalue)
    assert other.difference.p is not None
    assert other.relative.p < 0.05 < other.difference.p


def test_a_baseline_of_zero_has_no_relative_difference() -> None:
    """A share of nothing is not defined, the difference itself is."""
    rows = [row("base", 1, 0.0), row("base", 2, 4.0), row("other", 1, 1.0), row("other", 2, 5.0)]
    other = summary(rows, "base", ["m"]).paired[1]
    assert other.difference.mean == 1.0
    assert other.relative.mean is None


def test_instance_sets_and_overall() -> None:
    """Each instance is a set of its own, and all together are one more; columns can tell other sets apart."""
    rows = [
        row(name, seed, 10.0 * size + (name == "other") * size, f"orders={size}, skus={skus}", size=size)
        for name in ("base", "other")
        for size in (1, 2)
        for skus in (5, 6)
        for seed in (1, 2)
    ]
    by_instance = summary(rows, "base", ["m"])
    assert len(by_instance.instance_sets) == 5
    assert by_instance.of("overall", "m")[1].pairs == 8
    assert by_instance.of("overall", "m")[1].difference.mean == 1.5
    by_size = summary(rows, "base", ["m"], by=["size"])
    assert by_size.instance_sets == ("size=1", "size=2", "overall")
    assert by_size.of("size=2", "m")[1].pairs == 4
    assert sum(by_size.holds("size=2", one) for one in rows) == 8
    assert all(by_size.holds("overall", one) for one in rows)


def test_how_runs_ended_is_counted() -> None:
    """Complete, partial and failed runs add up; standing still and solves stopped early are counted besides."""
    rows = [
        row("base", 1, 1.0),
        row("base", 2, 1.0, status="partial", solves_stopped_early=3),
        row("base", 3, None, status="failed", error_kind="StandstillError"),
        row("base", 4, None, status="failed", error_kind="RuleError"),
        row("other", 1, 1.0, solves_stopped_early=0),
    ]
    base, other = summary(rows, "base", ["m"]).counted
    assert (base.runs, base.complete, base.partial, base.failed, base.stood_still, base.stopped_early) == (
        4,
        1,
        1,
        2,
        1,
        1,
    )
    assert (other.runs, other.complete, other.failed, other.stopped_early) == (1, 1, 0, 0)


def test_a_baseline_that_is_not_there_is_named() -> None:
    """The nearest rule set is suggested."""
    with pytest.raises(InputError, match="did you mean `base`"):
        summary([row("base", 1, 1.0)], "bse", ["m"])


def test_how_many_times_the_bound() -> None:
    """Of each pair, then the mean over a seed's pairs and over the seeds: 2 and 4, 3 and 3, so 3; the bound is 15."""
    rows = [row("base", seed, 60.0, instance, **{"bound.m": 20.0}) for seed in (1, 2) for instance in ("one", "two")]
    rows += [row("other", 1, 20.0, "one", **{"bound.m": 10.0}), row("other", 1, 40.0, "two", **{"bound.m": 10.0})]
    rows += [row("other", 2, 60.0, "one", **{"bound.m": 20.0}), row("other", 2, 60.0, "two", **{"bound.m": 20.0})]
    comparison = summary(rows, "base", ["m"])
    found = {one.rule_set: (one.bound, one.times_bound) for one in comparison.of("overall", "m")}
    assert found == {"base": (20.0, 3.0), "other": (15.0, 3.0)}
    assert comparison.bounded("m")


def test_a_bound_is_of_all_runs_or_of_none() -> None:
    """Where a run that counts has none, there is no mean; a bound of 0 has no multiples. Failed runs do not count."""
    rows = [row(name, seed, 60.0, **{"bound.m": 20.0}) for name in ("base", "other", "third") for seed in (1, 2, 3)]
    rows[3]["bound.m"] = None
    rows[6]["bound.m"] = 0.0
    found = {one.rule_set: (one.bound, one.times_bound) for one in summary(rows, "base", ["m"]).paired}
    assert found["base"] == (20.0, 3.0)
    assert found["other"] == (None, None)
    assert found["third"] == (pytest.approx(40 / 3), None)
    rows[3]["status"] = "failed"
    assert summary(rows, "base", ["m"]).paired[1].times_bound == 3.0
    assert not summary([row("base", 1, 60.0)], "base", ["m"]).bounded("m")
