"""`rmfs benchmark`: the benchmark set, and what is known of it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.options import (
    OutPath,
    WholeNumberRange,
    json_option,
    quiet_option,
    runs_options,
)
from rmfs_commands.cli.screen import new_table, output_console, print_json, say, tell

if TYPE_CHECKING:
    from rich.table import Table

    from rmfs_commands.benchmark.claims import Claim
    from rmfs_commands.benchmark.sets import Frozen
    from rmfs_commands.cli.grids import Grid

names_argument = click.argument("names", metavar="[NAME]...", nargs=-1)
claims_option = click.option(
    "--claims", type=click.Path(path_type=Path), metavar="FILE", help="Your own claims: read besides, or written to."
)
objective_option = click.option(
    "--objective",
    type=click.Choice(["visits", "makespan", "turnover", "packed", "late", "distance"]),
    help="What to make small.",
)


def _table_file(_ctx: click.Context, _param: click.Parameter, file: Path | None) -> Path | None:
    if file is not None and file.suffix not in (".tex", ".csv", ".md"):
        raise click.BadParameter(f"expected a name that ends in .tex, .csv or .md, found {file}")
    return file


table_option = click.option(
    "--table",
    "file",
    type=OutPath(),
    metavar="FILE",
    callback=_table_file,
    help="Write the table there: .tex, .csv or .md.",
)
KEYS = {
    "visits": "pod_station_visits",
    "makespan": "makespan_s",
    "turnover": "turnover_s",
    "packed": "packed_s",
    "late": "late_orders",
    "distance": "distance_m",
}


@click.group(short_help="Frozen instances and their best known values.")
def benchmark() -> None:
    """The benchmark set: frozen instances, best known values, and a search for better ones.

    NAME is an instance, as `list` has them; `start-*` stands for all whose names begin so. `rmfs bench` compares single
    rules instead.
    """


@benchmark.command("list")
@names_argument
@json_option
def list_(names: tuple[str, ...], as_json: bool) -> None:
    """List the instances with each NAME, or all: their sizes, and what each is for."""
    from rmfs_commands.benchmark.sets import benchmark_set
    from rmfs_commands.cli.grids import Grid

    rows = []
    for one in (found := benchmark_set().chosen(names)):
        section, robots = one.scenario.instance, one.scenario.robots.count
        sizes = (f"{number:,}" for number in (section.orders, section.skus, section.pods, robots))
        about = one.about + (", robots in each other's way" if one.roads == "shared" else "")
        rows.append((one.name, *sizes, section.arrivals.process, about))
    if as_json:
        keys = ("name", "about", "roads", "checksum", "seed")
        print_json(
            [dict(zip(keys, (o.name, o.about, o.roads, o.checksum, o.scenario.seed), strict=True)) for o in found]
        )
        return
    columns = ("Instance", "Orders", "SKUs", "Pods", "Robots", "Arrivals", "About")
    _show(Grid("", (), columns, rows, range(1, 5)))


@benchmark.command()
@click.argument("name", metavar="NAME")
@click.option("--out", type=OutPath(), metavar="FILE", help="Where to write it. [default: NAME.toml]")
def write(name: str, out: Path | None) -> None:
    """Write the scenario of the instance NAME, for `rmfs run FILE --trace`; only its rules may be changed."""
    from rmfs_commands.benchmark.sets import benchmark_set
    from rmfs_commands.cli.toml_scenario import to_toml
    from rmfs_commands.results.files import write_text

    one = benchmark_set().find(name)
    file = out or Path(f"{one.name}.toml")
    write_text(file, to_toml(one.scenario, comments=False))
    tell(f"In {file}: {one.name}, {one.about}. Change nothing but [rules].")


@benchmark.command()
@names_argument
@click.option(
    "--rules", "given", multiple=True, metavar="KEY=RULE", help="A rule, or a TOML file with [rules]. Repeatable."
)
@claims_option
@table_option
@runs_options("figures", "rmfs-runs/benchmark")
def run(
    names: tuple[str, ...],
    given: tuple[str, ...],
    claims: Path | None,
    file: Path | None,
    jobs: int | None,
    dask: str | None,
    out: Path | None,
    no_inline_rules: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run one rule set on the instances with each NAME, or on all: `--rules poa_pps=pod-index`.

    The table has the values reached next to the best known ones. DIR has the figures, with all that is needed to reach
    them again (benchmark.json), and the finished runs, so that the same command goes on where it stopped. With
    --claims, each run that is better than what is known is made again with its trace, checked, and added to FILE. Exit
    code 1 when a run failed.
    """
    from tempfile import TemporaryDirectory

    from rmfs_commands.benchmark import claims as all_claims
    from rmfs_commands.benchmark.running import FIGURES_FILE, figures_of, rules_given, run_on
    from rmfs_commands.benchmark.sets import benchmark_set
    from rmfs_commands.benchmark.table import own_grid, write_table
    from rmfs_commands.cli.compiling import compile_searches
    from rmfs_commands.experiments.progress import experiment_display
    from rmfs_commands.results.files import to_json, write_text
    from rmfs_core.errors import RunError

    chosen, notes = benchmark_set(), notes_console(quiet=quiet)
    instances, rules, known = chosen.chosen(names), rules_given(given), _known(claims)
    folder = out or Path("rmfs-runs") / "benchmark"
    for one in {one.roads: one for one in reversed(instances)}.values():
        compile_searches(notes, one.scenario)
    result = run_on(
        instances,
        rules,
        folder / "runs",
        jobs=jobs,
        dask=dask,
        watcher=experiment_display(notes, "benchmark"),
        allow_inline_rules=not no_inline_rules,
    )
    reached = {row["scenario"]: row for row in result.rows}
    figures = figures_of(instances, rules, result, chosen.version)
    write_text(folder / FIGURES_FILE, to_json(figures, indent=2) + "\n")
    better = [one for one in instances if claims is not None and _is_better(reached[one.name], one, known)]
    for one in better:
        with TemporaryDirectory() as traced:
            all_claims.run_rules(one, rules, Path(traced))
            added = _keep(claims, all_claims.check_result(traced, chosen), known)
        say(notes, f"{one.name}: a better value, added to {claims}." if added else f"{one.name}: nothing to add.")
    if claims is not None and not better:
        say(notes, f"Nothing added to {claims}: no value beats the best known one.")
    grid = own_grid(instances, reached, chosen.version)
    if file is not None:
        write_table(grid, file)
    if as_json:
        print_json(figures | {"runs": result.rows})
    elif not quiet and file is None:
        _show(grid)
    if result.failed:
        raise RunError(
            f"{len(result.failed)} of {len(result.rows)} runs failed; the first: {result.failed[0]['error']}"
        )


@benchmark.command()
@click.argument("folder", metavar="RESULT", type=click.Path(path_type=Path))
@claims_option
@json_option
def check(folder: Path, claims: Path | None, as_json: bool) -> None:
    """Say what the run in the folder RESULT may claim.

    Its trace has to be accepted by `rmfs validate` and to start from an instance of the set; all figures are worked out
    from the trace. With --claims, the claim is added to FILE if it is the best in an objective. Exit code 2 where
    nothing can be claimed.
    """
    from attrs import asdict

    from rmfs_commands.benchmark.claims import best_of, check_result
    from rmfs_commands.benchmark.sets import benchmark_set
    from rmfs_commands.benchmark.table import LABELS, told

    chosen = benchmark_set()
    claim = check_result(folder, chosen)
    known = _known(claims)
    best, added = best_of(known, chosen.find(claim.instance)), _keep(claims, claim, known)
    if as_json:
        print_json(asdict(claim))
        return
    budget = "offline" if claim.offline else "each decision in less than a second"
    tell(f"{claim.instance}, {claim.made_by} ({budget}), trace {claim.trace[:19]}...")
    for name, value in claim.metrics.items():
        least = best[name].metrics[name] if name in best else None
        how = f"the best known is {told(name, least)}"
        if least is None or value <= least:
            how = "as the best known" if value == least else "a new best value"
        tell(f"{LABELS[name]}: {told(name, value)}, {how}")
    if claims is not None:
        tell(f"Added to {claims}." if added else f"Not added to {claims}: each value is known, or a better one.")


@benchmark.command()
@names_argument
@objective_option
@claims_option
@table_option
@json_option
def table(names: tuple[str, ...], objective: str | None, claims: Path | None, file: Path | None, as_json: bool) -> None:
    """Show the best known values of each NAME, or of all, with bounds and what reached them.

    Claims of your own file that do not come with the package are marked as unverified: `repeat` verifies one.
    """
    from rmfs_commands.benchmark.sets import benchmark_set
    from rmfs_commands.benchmark.table import best_known, grid_of, plain, write_table

    chosen = benchmark_set()
    instances = chosen.chosen(names)
    found = list(best_known(instances, _known(claims), [KEYS[objective]] if objective else []))
    if file is not None:
        write_table(grid_of(found, chosen.version), file)
    if as_json:
        print_json({"set": chosen.version, "best": plain(found)})
    elif file is None:
        _show(grid_of(found, chosen.version), 6)  # what is left fits no terminal


@benchmark.command()
@click.argument("name", metavar="NAME")
@objective_option
@claims_option
@click.option("--out", type=OutPath(), metavar="DIR", required=True, help="Folder for the run and its trace.")
def repeat(name: str, objective: str | None, claims: Path | None, out: Path) -> None:
    """Make the run of a best known value of NAME again, and check that its trace is the same."""
    from rmfs_commands.benchmark.claims import best_of
    from rmfs_commands.benchmark.claims import repeat as make_again
    from rmfs_commands.benchmark.sets import benchmark_set
    from rmfs_core.errors import InputError

    chosen = benchmark_set()
    key, best = KEYS[objective or "visits"], best_of(_known(claims), chosen.find(name))
    if key not in best:
        raise InputError(name, f"no value of {key} is known")
    claim = make_again(best[key], chosen, out)
    tell(f"The same trace as claimed: {claim.instance}, {key} {claim.metrics[key]:,g}, {claim.made_by}. In {out}")


@benchmark.command()
@click.argument("name", metavar="NAME")
@objective_option
@click.option("--minutes", type=click.FloatRange(0, 10_000), default=1.0, show_default=True, help="Time to search.")
@click.option("--seed", type=WholeNumberRange(min=0), default=1, show_default=True, metavar="N", help="Of the search.")
@click.option("--parameters", is_flag=True, help="Search parameters of rules for static instances, too.")
@claims_option
@click.option("--out", type=OutPath(), metavar="DIR", help="Folder for the best run. [default: rmfs-runs/improve-NAME]")
@quiet_option
def improve(
    name: str,
    objective: str | None,
    minutes: float,
    seed: int,
    parameters: bool,
    claims: Path | None,
    out: Path | None,
    quiet: bool,
) -> None:
    """Search offline for a better value of the instance NAME, for so many minutes.

    Where all orders are there at the start, over whole schedules: annealed under a fast evaluator, then run. Else, or
    with --parameters, over the parameters of the rules that hold the best value, as `rmfs tune` does. What is found is
    a claim like any other: it has its schedule or parameters, so that the run can be made again in no time.
    """
    from rmfs_commands.benchmark.claims import best_of
    from rmfs_commands.benchmark.improving import improve_rules, improve_schedule
    from rmfs_commands.benchmark.sets import benchmark_set
    from rmfs_commands.sizing.notices import Notices

    chosen, notes = benchmark_set(), notes_console(quiet=quiet)
    one, key = chosen.find(name), KEYS[objective or "visits"]
    known = _known(claims)
    folder = out or Path("rmfs-runs") / f"improve-{one.name}"

    def told(text: str) -> None:
        say(notes, text)

    if one.static and not parameters:
        claim = improve_schedule(one, key, minutes, seed, chosen, folder, told)
    else:
        by_rules = best_of([claim for claim in known if claim.made_by != "plan"], one).get(key)
        first = {"poa_pps": "pod-index"} if by_rules is None else by_rules.rules
        claim = improve_rules(one, first, key, minutes, seed, chosen, folder, told, Notices(notes))
    best = best_of(known, one).get(key)
    _keep(claims, claim, known)
    before = "none" if best is None else f"{best.metrics[key]:,g}"
    tell(f"{one.name}: {key} {claim.metrics[key]:,g} by {claim.made_by}; known before: {before}. In {folder}")


def _known(file: Path | None) -> list[Claim]:
    """Return the claims of the package, and those of a file, if it is there."""
    from rmfs_commands.benchmark.claims import read_claims

    return read_claims() + (read_claims(file) if file is not None and file.exists() else [])


def _is_better(row: Mapping[str, Any], one: Frozen, known: Sequence[Claim]) -> bool:
    """Whether a run has a better value of some objective than all that is known."""
    from rmfs_commands.benchmark.claims import best_of

    best = best_of(known, one)
    return any(
        value is not None and (name not in best or value < best[name].metrics[name])
        for name, value in one.reached(row).items()
    )


def _keep(file: Path | None, claim: Claim, known: Sequence[Claim]) -> bool:
    """Add a claim to a file, if there is one and the claim is best in some objective; return whether it is added."""
    from rmfs_commands.benchmark.claims import claim_line, without_beaten
    from rmfs_commands.benchmark.sets import benchmark_set
    from rmfs_commands.results.files import write_text

    if file is None or not any(one is claim for one in without_beaten([*known, claim], benchmark_set())):
        return False
    before = file.read_text("utf-8") if file.exists() else ""
    write_text(file, before + "\n" * (before[-1:] not in ("", "\n")) + claim_line(claim))
    return True


def _show(grid: Grid, columns: int = 20) -> None:
    """Print a grid, its first columns; the last of them may take several lines.

    Where it is too wide, rows with the same first cell stand below it.
    """
    from rich.measure import Measurement

    console, rows = output_console(), [row[:columns] for row in grid.rows]
    shown = _table(grid.title, grid.columns[:columns], rows, grid.right)
    wide = Measurement.get(console, console.options.update(max_width=10_000), shown).maximum > console.width
    if wide and len({first for first, *_ in rows}) < len(rows):
        (first, second, *headings), below = grid.columns[:columns], []
        for name, group in groupby(rows, itemgetter(0)):
            below += [(name, *[""] * len(headings)), *((f"  {one}", *cells) for _, one, *cells in group)]
        shown = _table(grid.title, (f"{first}\n  {second}", *headings), below, [number - 1 for number in grid.right])
    console.print(shown)


def _table(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]], right: Collection[int]) -> Table:
    from rich.text import Text

    table = new_table(title or None)
    for number, heading in enumerate(headings):
        last = number == len(headings) - 1 and number not in right
        table.add_column(heading, justify="right" if number in right else "left", no_wrap=not last)
    for row in rows:
        table.add_row(*map(Text, row))
    return table
