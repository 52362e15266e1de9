"""Claims: what a run reached on an instance of the set, and what makes the run again."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from attrs import asdict, frozen

from rmfs_commands.benchmark.plans import REPLAY, Replay, plan_of
from rmfs_commands.benchmark.sets import BenchmarkSet, Frozen, benchmark_set, checksum_of, known_bounds
from rmfs_commands.experiments.keys import digest_of
from rmfs_commands.results.files import to_json
from rmfs_commands.trace import read_trace, trace_file
from rmfs_commands.trace.json_lines import read_json_lines
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.checking import check_trace, read_result
from rmfs_commands.validation.details import recompute_details
from rmfs_commands.validation.metrics import recompute
from rmfs_commands.validation.packed import recompute_packing
from rmfs_core import Result, entrypoints, run
from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE
from rmfs_core.scenario.rulenames import check_rule_name, is_inline
from rmfs_core.scenario.structuring import KeyProblem
from rmfs_core.wording import counted

FILE = "best.jsonl"
ONLINE_S = 1.0
"""Wall-clock seconds that each decision of a rule may take; where one takes longer, the claim is marked offline."""


@frozen
class Claim:
    """A run and its figures.

    Parameters
    ----------
    instance
        Name of the instance.
    metrics
        Figures by objective, as its trace amounts to them.
    rules
        Its rules, tables by key: with them `repeat` makes the run again. A plan is a parameter of the rule `REPLAY`.
    trace
        SHA-256 of the trace's lines behind its header.
    offline
        Whether a decision took `ONLINE_S` or longer, or nobody knows; a plan is always made offline.
    versions
        Of all that took part in the run.
    """

    instance: str
    metrics: Mapping[str, float]
    rules: Mapping[str, Any]
    trace: str
    offline: bool
    versions: Mapping[str, str]

    @property
    def made_by(self) -> str:
        """The rules that assign orders and pods, in short."""
        joint = self.rules.get("poa_pps")
        if joint is not None:
            return "plan" if _name(joint) == REPLAY else _name(joint)
        return " + ".join(_name(self.rules[key]) for key in ("poa", "pps"))

    @property
    def digest(self) -> str:
        """First digits of the SHA-256 of the rules as written."""
        return digest_of(self.rules)


def _name(rule: Any) -> str:
    return str(rule["rule"] if isinstance(rule, Mapping) else rule)


def read_claims(file: Path | None = None) -> list[Claim]:
    """Return the claims of a file; of the one that comes with the package, if left out.

    Nothing is run: `repeat` tells whether a claim is true.

    Raises
    ------
    InputError
        When the file cannot be read, or a line of it is no claim, or one that cannot be true.
    """
    path = file or Path(__file__).with_name(FILE)
    found = []
    try:
        lines = path.read_text("utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"cannot be read: {getattr(error, 'strerror', None) or error}") from error
    for number, line in enumerate(lines, start=1):
        try:
            claim = Claim(**json.loads(line))
            _check_claim(claim)
        except (ValueError, TypeError, KeyError) as error:
            expected = "expected a claim, as `rmfs benchmark check RESULT --claims FILE` writes it"
            raise InputError(f"{path}, line {number}", expected) from error
        _check_bounds(claim, f"{path}, line {number}")
        if file is not None:
            _check_rules(claim, f"{path}, line {number}")
        found.append(claim)
    return found


def _check_claim(claim: Claim) -> None:
    """Raise ValueError where a value of a claim is of no use."""
    figures, rules = claim.metrics, claim.rules
    numbers = figures.values() if isinstance(figures, Mapping) else [None]
    if not all(type(value) in (int, float) and math.isfinite(value) for value in numbers):
        raise ValueError("expected numbers as `metrics`")
    if not isinstance(claim.instance, str) or not isinstance(claim.versions, Mapping):
        raise TypeError("expected the name of an instance, and versions by name")
    if not isinstance(claim.trace, str) or not isinstance(claim.offline, bool):
        raise TypeError("expected a digest as `trace`, and true or false as `offline`")
    if not isinstance(rules, Mapping) or not ("poa_pps" in rules or {"poa", "pps"} <= rules.keys()):
        raise ValueError("expected rules that assign orders and pods")
    if not all(isinstance(rule["rule"] if isinstance(rule, Mapping) else rule, str) for rule in _each(rules)):
        raise ValueError("expected rules by name, or tables of rules")


def _each(rules: Mapping[str, Any]) -> list[Any]:
    """Return all rules of a claim; some keys have a list of them."""
    return [one for given in rules.values() for one in (given if isinstance(given, list) else [given])]


def _check_rules(claim: Claim, place: str) -> None:
    """Refuse rules that are not installed."""
    for name in map(_name, _each(claim.rules)):
        if name == "remote" or is_inline(name):
            problem = f'rule "{name}" would run code that is not installed; expected installed rules in a claim'
            raise InputError(place, problem)
        if name != REPLAY:
            try:
                check_rule_name(name, Path(), entrypoints.offers(entrypoints.RULES))
            except KeyProblem as error:
                raise InputError(place, error.problem) from error


def _check_bounds(claim: Claim, place: str) -> None:
    """Refuse what no run can reach."""
    if claim.instance not in benchmark_set().instances:
        raise InputError(place, f'there is no instance "{claim.instance}"; `rmfs benchmark list` has all names')
    bounds = known_bounds().get(claim.instance, {})
    for name, value in claim.metrics.items():
        if value < bounds.get(name, 0.0) - 1e-9:
            problem = f"claims {name} {value:,.10g} of {claim.instance}"
            raise InputError(place, f"{problem}; no run can have less than {bounds.get(name, 0):,.10g}")


def claim_line(claim: Claim) -> str:
    """Return a claim as a line of a file of claims."""
    return to_json(asdict(claim)) + "\n"


def best_of(claims: Iterable[Claim], instance: Frozen) -> dict[str, Claim]:
    """Return the claim with the least of each objective of an instance; of equal ones the first, none offline first."""
    own = [claim for claim in claims if claim.instance == instance.name]
    own.sort(key=lambda claim: claim.offline)
    return {
        objective: min(having, key=lambda claim: claim.metrics[objective])
        for objective in instance.objectives
        if (having := [claim for claim in own if objective in claim.metrics])
    }


def without_beaten(claims: Sequence[Claim], chosen: BenchmarkSet) -> list[Claim]:
    """Return the claims that are best in some objective, by instance."""
    kept = []
    for instance in chosen.instances.values():
        best = list(best_of(claims, instance).values())
        kept += [claim for claim in claims if any(claim is one for one in best)]
    return kept


def check_result(path: str | Path, chosen: BenchmarkSet) -> Claim:
    """Return what the run in a folder may claim.

    Its trace has to be accepted by `rmfs validate`, and to start from an instance of the set; all figures are worked
    out from the trace.

    Raises
    ------
    InputError
        When the folder has no trace, the run is of no instance of the set, or its trace is not accepted.
    """
    file = trace_file(path)
    trace = read_trace(file)
    instance = _instance_of(file, trace, chosen)
    if trace.status != "complete":
        raise InputError(str(file), f"the run ended as {trace.status}; expected a complete one")
    for key, what in (("floor", "is a real day"), ("state", "begins in a state")):  # `validate` checks less of these
        if getattr(trace, key) is not None:
            raise InputError(f"{file}, line 1, {key}", f"the run {what}; expected one simulated from time 0")
    pods, robots = ([one["cell"] for one in many] for many in (trace.pods, trace.robots))
    if (found := checksum_of(trace.instance, pods, robots, trace.blocked)) != instance.checksum:
        expected = f"expected {instance.checksum[:19]}... of {instance.name}"
        raise InputError(str(file), f"starts from {found[:19]}..., {expected}")
    report = check_trace(file, collisions=instance.roads == "shared")
    if report.faults:
        faults = counted(len(report.faults), "fault")
        raise InputError(str(file), f"`rmfs validate` finds {faults}, the first: {report.faults[0].sentence}")
    rules = {key: value for key, value in trace.scenario["rules"].items() if value not in (None, [], ())}
    result = read_result(file.parent / RESULT_FILE)
    versions = trace.versions if result is None else result["versions"]
    seconds = _seconds(file.parent / "periods.csv")
    offline = seconds is None or seconds >= ONLINE_S or _name(rules.get("poa_pps", "")) == REPLAY
    return Claim(instance.name, _figures(trace, instance), rules, trace_digest(file), offline, dict(versions))


def _instance_of(file: Path, trace: Trace, chosen: BenchmarkSet) -> Frozen:
    seed = trace.scenario.get("seed")
    found = [one for one in chosen.instances.values() if one.scenario.seed == seed]
    problem = f"no instance has the seed {seed}"
    for one in found:
        told = one.problem_with(trace.scenario)
        if told is None:
            return one
        problem = f"{one.name} has its seed, but {told}"
    raise InputError(str(file), f"is no run of an instance of the set: {problem}")


def _figures(trace: Trace, instance: Frozen) -> dict[str, float]:
    found = recompute(trace) | recompute_details(trace)
    if instance.scenario.packing is not None:
        found |= recompute_packing(trace)
    return {name: value for name in instance.objectives if (value := found[name]) is not None}


def _seconds(file: Path) -> float | None:
    """Return how long the longest decision of a run took; None where its table is not there."""
    if not file.exists():
        return None
    with file.open(newline="", encoding="utf-8") as table:
        return max((float(row["seconds"]) for row in csv.DictReader(table)), default=0.0)


def trace_digest(file: Path) -> str:
    """Return the SHA-256 of all events of a trace; its header, which names versions, does not count."""
    found = hashlib.sha256()
    for number, (_, line) in enumerate(read_json_lines(file)):
        if number:
            found.update(json.dumps(line, separators=(",", ":")).encode() + b"\n")
    return f"sha256:{found.hexdigest()}"


def run_rules(instance: Frozen, rules: Mapping[str, Any], out: Path | None = None) -> Result:
    """Run an instance with rules; with a folder, record the trace there.

    Raises
    ------
    InputError
        When rules are wrong, or a plan is.
    """
    joint = rules.get("poa_pps")
    objects = {}
    if joint is not None and _name(joint) == REPLAY:
        objects = {"poa_pps": Replay(plan_of(joint, instance.scenario, f"plan of {instance.name}"))}
        rules = {key: value for key, value in rules.items() if key != "poa_pps"}
    return run(instance.with_rules(rules), rules=objects, out=out, record=("trace",) if out else ())


def repeat(claim: Claim, chosen: BenchmarkSet, out: Path) -> Claim:
    """Make the run of a claim again, and return what it may claim now.

    Raises
    ------
    InputError
        When its trace or its figures are others, which says the versions that it was made with.
    """
    run_rules(chosen.find(claim.instance), claim.rules, out)
    found = check_result(out, chosen)
    if found.trace != claim.trace or dict(found.metrics) != dict(claim.metrics):
        made = ", ".join(f"{name} {claim.versions.get(name, '?')}" for name in ("rmfs", "numpy"))
        here = ", ".join(f"{name} {version(name)}" for name in ("rmfs", "numpy"))
        problem = f"the claim of {claim.made_by} is made with {made}; here, with {here}, the run is another one"
        raise InputError(claim.instance, f"{problem}: {dict(found.metrics)}")
    return found
