"""``rmfs size``: the fewest robots and stations, or packers and boxes, for a turn-over time."""

from __future__ import annotations

import math
import re
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rmfs_commands.cli.completion import SetCommand
from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.options import NumberRange, WholeNumberRange, scenario_argument, scenario_name, search_options
from rmfs_commands.cli.screen import output_console, print_json, say

if TYPE_CHECKING:
    from rmfs_commands.sizing.sizing import Answer
    from rmfs_commands.sizing.target import Target

MOST_SEEDS = 1_000
ABOVE_0 = NumberRange(min=0, min_open=True)


class RangeType(click.ParamType):  # type: ignore[type-arg]  # which only the newest click takes
    """``4-40``, or ``4`` for no other number."""

    name = "range"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        """Return the two ends."""
        found = re.fullmatch(r"(\d{1,6})(?:-(\d{1,6}))?", value)
        least, most = (int(found[1]), int(found[2] or found[1])) if found else (0, 0)
        if not 1 <= least <= most:
            self.fail(f"expected a number from 1 on, or two such as 2-6, found {value}", param, ctx)
        return least, most


@click.command(cls=SetCommand, short_help="Find the fewest robots and stations, or packers and boxes.")
@scenario_argument
@click.option("--p95", type=ABOVE_0, metavar="S", help="Most seconds of turn-over, 95th percentile.")
@click.option("--mean", type=ABOVE_0, metavar="S", help="Most seconds of turn-over, mean.")
@click.option("--most", metavar="METRIC=X", help="Most of another metric, such as `late_percent=2`.")
@click.option(
    "--stations", type=RangeType(), metavar="A-B", help="Numbers of stations. [default: 1 to twice the scenario's]"
)
@click.option(
    "--robots", type=RangeType(), metavar="A-B", help="Numbers of robots. [default: 1 to four times the scenario's]"
)
@click.option(
    "--packers",
    type=RangeType(),
    metavar="A-B",
    help="Numbers of packers at each packing station, instead of stations. [default: 1 to twice the scenario's]",
)
@click.option(
    "--boxes",
    type=RangeType(),
    metavar="A-B",
    help="Numbers of boxes, instead of robots. [default: 1 to four times the scenario's]",
)
@click.option(
    "--robot-cost", type=NumberRange(min=0), metavar="X", help="Cost of a robot or box, to say what is cheapest."
)
@click.option("--station-cost", type=NumberRange(min=0), metavar="X", help="Cost of a station or packer.")
@click.option(
    "--seeds",
    type=WholeNumberRange(2, MOST_SEEDS),
    default=16,
    show_default=True,
    metavar="N",
    help="Most runs of one size, each with a seed of its own.",
)
@click.option(
    "--confidence",
    type=NumberRange(50, 100, min_open=True, max_open=True),
    default=95.0,
    show_default=True,
    metavar="PERCENT",
    help="Confidence with which a size passes or fails.",
)
@click.option(
    "--robust",
    is_flag=True,
    help="Give the answer once more with times that spread, and robots and stations that fail.",
)
@search_options("size")
def size(
    scenario: str,
    p95: float | None,
    mean: float | None,
    most: str | None,
    stations: tuple[int, int] | None,
    robots: tuple[int, int] | None,
    packers: tuple[int, int] | None,
    boxes: tuple[int, int] | None,
    robot_cost: float | None,
    station_cost: float | None,
    seeds: int,
    confidence: float,
    robust: bool,
    overrides: tuple[str, ...],
    seed: int | None,
    jobs: int | None,
    dask: str | None,
    out: Path | None,
    no_inline_rules: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Find the fewest robots and stations, or packers and boxes, with which SCENARIO keeps a time: `--p95 900`.

    For each number of stations the fewest robots are sought, by runs with the same seeds for every size: four runs,
    then twice as many, and so on, until the mean over the seeds is known to be at most what was asked for, or more.
    With `--packers` or `--boxes` packers and boxes are sought in the same way, for a time to packed.
    Every finished run is kept in DIR/runs, so that an interrupted search goes on where it stopped. The answer is
    printed and written to DIR: answer.json, candidates.csv. Exit code 1 when a run failed.
    """
    from rmfs_commands.cli.checking import load_checked
    from rmfs_commands.cli.compiling import compile_searches
    from rmfs_commands.experiments.running import open_workers
    from rmfs_commands.sizing import report
    from rmfs_commands.sizing.notices import Notices
    from rmfs_commands.sizing.searching import BOXES, ROBOTS
    from rmfs_commands.sizing.sizing import size as search
    from rmfs_core.errors import RunError
    from rmfs_core.rules import RuleSet
    from rmfs_core.scenario import located
    from rmfs_core.wording import counted

    if (robot_cost is None) != (station_cost is None):
        raise click.UsageError("expected --robot-cost and --station-cost together, or neither")
    costs = None if robot_cost is None or station_cost is None else (robot_cost, station_cost)
    packs = packers is not None or boxes is not None
    if packs and (stations is not None or robots is not None):
        raise click.UsageError("expected --stations and --robots, or --packers and --boxes")
    loaded = load_checked(scenario, overrides, seed)
    times = ("packed_p95_s", "packed_s") if packs else ("turnover_p95_s", "turnover_s")
    target = _target(p95, mean, most, confidence, range(loaded.seed, loaded.seed + seeds), times)
    with located(loaded):
        rules = RuleSet.load(loaded.rules, loaded.folder, allow_inline=not no_inline_rules)
    things, notes = BOXES if packs else ROBOTS, notes_console(quiet=quiet)
    for file in rules.inline_files:
        say(notes, f"Loading code from {file}.")
    name = scenario_name(scenario)
    folder = out or Path("rmfs-runs") / f"size-{name}"
    compile_searches(notes, loaded)
    answers: list[Answer] = []
    try:
        with closing(open_workers(jobs, dask)) as workers:
            for which, store in report.asked(loaded, folder, robust=robust, notes=notes):
                answer = search(
                    which,
                    name,
                    target,
                    store=store,
                    workers=workers,
                    stations=stations,
                    robots=robots,
                    packers=packers,
                    boxes=boxes,
                    watcher=Notices(notes),
                    tell=lambda one: say(
                        notes, f"{things.counted(one.first, one.second)}: {report.verdict_of(one, target)}"
                    ),
                    allow_inline_rules=not no_inline_rules,
                )
                answers.append(answer)
    except KeyboardInterrupt:
        say(notes, f"Finished runs are kept in {folder / report.RUNS_FOLDER}; the same command goes on from there.")
        raise
    report.write_answers(answers, costs, folder)
    if as_json:
        print_json(report.content_of_all(answers, costs))
    else:
        console = output_console(quiet=quiet)
        report.print_answers(console, answers, costs)
        say(console, f"\nIn {folder}: {', '.join(report.files_of(answers))}")
    if failed := sum(answer.failed for answer in answers):
        raise RunError(f"{counted(failed, 'run')} failed; {folder / report.ANSWER_FILE} says why.")


def _target(
    p95: float | None,
    mean: float | None,
    most: str | None,
    confidence: float,
    seeds: range,
    times: tuple[str, str],
) -> Target:
    """Return what is asked for; ``times`` are the metrics of the 95th percentile and of the mean."""
    from rmfs_commands.sizing.target import Target

    if sum(option is not None for option in (p95, mean, most)) != 1:
        raise click.UsageError("expected one of --p95, --mean and --most")
    metric, limit = (times[0], p95) if mean is None else (times[1], mean)
    if most is not None:
        metric, _, text = most.partition("=")
        metric = metric.strip()
        try:
            limit = float(text)
        except ValueError:
            limit = math.nan
    if limit is None or not math.isfinite(limit) or not metric:
        found = f"{most}" if most is not None else f"{limit}"
        raise click.UsageError(f"expected a number, as in --p95 900 or --most late_percent=2, found {found}")
    return Target(metric, limit, confidence / 100, tuple(seeds))
