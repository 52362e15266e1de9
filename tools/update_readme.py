"""Write the tables of rules and scenario keys into README.md, from the classes themselves.

Usage: python tools/update_readme.py [--check]
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs

from rmfs_cli.description import Parameter, installed_rules
from rmfs_core.scenario.model import Scenario

README = Path(__file__).resolve().parent.parent / "README.md"


def keys_table() -> str:
    """Return the table of scenario keys."""
    rows = ["| key | default | unit | meaning |", "|---|---|---|---|"]
    rows += [f"| `{path}` | {default} | {unit} | {doc} |" for path, default, unit, doc in _keys(Scenario, "")]
    return "\n".join(rows)


def _keys(section: type[Any], prefix: str) -> Iterator[tuple[str, str, str, str]]:
    attrs.resolve_types(section)
    fields = [f for f in attrs.fields(section) if "doc" in f.metadata]
    for f in sorted(fields, key=lambda f: attrs.has(f.type) and f.type.__name__ != "RuleChoice"):
        path = prefix + f.name
        if attrs.has(f.type) and f.type.__name__ != "RuleChoice":
            yield from _keys(f.type, path + ".")
        else:
            yield path, _default(f), f.metadata["unit"] or "", f.metadata["doc"].replace("|", r"\|")


def _default(f: attrs.Attribute[Any]) -> str:
    default: Any = f.default
    default = default.factory() if hasattr(default, "factory") else default
    default = getattr(default, "rule", default)
    if default in (attrs.NOTHING, None, (), {}):
        return ""
    return f"`{json.dumps(default)}`"


def rules_table() -> str:
    """Return the table of the rules that this distribution ships."""
    rows = ["| rule | decides | what it does | parameters | reference |", "|---|---|---|---|---|"]
    for rule in installed_rules():
        if rule.distribution == "rmfs":
            parameters = ", ".join(_parameter(parameter) for parameter in rule.parameters)
            references = ", ".join(_link(number) for number in rule.short_references().splitlines())
            cells = (f"`{rule.name}`", ", ".join(rule.decides), rule.summary, parameters, references)
            rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


def _parameter(parameter: Parameter) -> str:
    if parameter.required:
        return f"`{parameter.name}` (required)"
    return f"`{parameter.name}` = {json.dumps(parameter.default)} {parameter.unit}".rstrip()


def _link(number: str) -> str:
    arxiv = number.lower().startswith("arxiv:")
    address = f"https://arxiv.org/abs/{number[6:]}" if arxiv else f"https://doi.org/{number}"
    return f"[{number}]({address})"


def updated(text: str) -> str:
    """Return the README with fresh tables."""
    for name, table in (("rules", rules_table()), ("keys", keys_table())):
        begin, end = f"<!-- {name}: begin (tools/update_readme.py) -->\n", f"<!-- {name}: end -->"
        before, rest = text.split(begin)
        text = before + begin + table + "\n" + end + rest.split(end, 1)[1]
    return text


def main() -> int:
    """Update README.md; with --check only say whether it is up to date."""
    old = README.read_text(encoding="utf-8")
    new = updated(old)
    if "--check" in sys.argv[1:]:
        if old != new:
            print("README.md is out of date: run python tools/update_readme.py", file=sys.stderr)
        return int(old != new)
    README.write_text(new, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
