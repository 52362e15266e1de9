"""`rmfs cite`: what to cite."""

from __future__ import annotations

import click

from rmfs_commands.cli import completion
from rmfs_commands.cli.options import json_option, no_inline_option
from rmfs_commands.cli.screen import print_json, tell


@click.command(short_help="Print BibTeX of the rules a run used.")
@click.argument("what", metavar="WHAT...", nargs=-1, required=True, shell_complete=completion.scenarios)
@json_option
@no_inline_option
def cite(what: tuple[str, ...], as_json: bool, no_inline_rules: bool) -> None:
    """Print BibTeX entries of rmfs and of the sources of rules.

    WHAT is the folder of a run, a comparison or `rmfs benchmark run`, a scenario or experiment (a file, or the name of
    a shipped one), a rule (the name of an installed one, or ./file.py:Class), or `benchmark`, the set of `rmfs
    benchmark`. Of a file with rules and nothing else, such as `rmfs tune` writes, the rules that it names are cited.
    Comments above an entry say which rules name this source, and what they take from it. Rules of your own are cited by
    the section "References" of their docstrings.
    """
    from attrs import asdict

    from rmfs_commands.cite.sources import cited

    found = cited(what, allow_inline=not no_inline_rules)
    if as_json:
        print_json([{**asdict(one.reference), "rules": dict(one.rules)} for one in found])
        return
    for one in found:
        for rule, note in one.rules.items():
            told = f"{rule}: {note}" if note else rule
            tell(f"% {told.replace('@', '(at)')}")  # BibTeX knows no comments: a @ begins an entry anywhere
        tell(one.reference.bibtex())
