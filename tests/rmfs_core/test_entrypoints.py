import os
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cases import cases
from rmfs_core.entrypoints import COMMANDS, RULES, load, offers, origin
from rmfs_core.errors import InputError
from rmfs_core.rules.sources import RuleSources
from saying import said

Install = Callable[..., None]
GROUP = "rmfs.trial"


def test_a_group_is_listed_by_name_without_importing(install: Install) -> None:
    install("acme", {"zebra": "acme_missing:Zebra", "ant": "acme_missing:Ant"}, group=GROUP)
    found = offers(GROUP)
    assert list(found) == ["ant", "zebra"]
    assert [entry.value for entry in found["ant"]] == ["acme_missing:Ant"]
    assert origin(found["ant"][0]) == ("acme", "1.0")
    assert "acme_missing" not in sys.modules
    assert not found.keys() & (offers(RULES).keys() | offers(COMMANDS).keys())


def test_what_is_offered_is_imported(install: Install) -> None:
    install("acme", {"seven": "acme_seven:VALUES.seven"}, group=GROUP, acme_seven="class VALUES:\n    seven = [7]\n")
    assert load(offers(GROUP)["seven"], "here", "number") == [7]


@cases(
    "source cause",
    ("", "AttributeError: module 'acme_broken' has no attribute 'Thing'"),
    ("import acme_nowhere", "ModuleNotFoundError: No module named 'acme_nowhere'"),
    ("raise ValueError('two\\n  lines')", "ValueError: two lines"),
    ("raise SystemExit", "SystemExit"),
    ("raise BaseException('all')", "BaseException: all"),
)
def test_what_cannot_be_imported_is_one_sentence(install: Install, source: str, cause: str) -> None:
    install("acme", {"thing": "acme_broken:Thing"}, group=GROUP, acme_broken=source)
    assert said(InputError, load, offers(GROUP)["thing"], "rules.poa", "rule") == (
        f'rules.poa: rule "thing" (acme 1.0) cannot be imported from acme_broken:Thing: {cause}'
    )


def test_a_name_of_several_distributions_is_refused(install: Install) -> None:
    for name in ("bolt", "acme", "acme_two"):
        install(name, {"thing": f"{name}_missing:Thing"}, group=GROUP)
    assert said(InputError, load, offers(GROUP)["thing"], "rmfs thing", "command") == (
        'rmfs thing: command "thing" is offered by acme 1.0, acme_two 1.0 and bolt 1.0; expected one of them: '
        "`acme:thing`, `acme_two:thing` or `bolt:thing`"
    )
    assert [entry.value for entry in offers(GROUP)["bolt:thing"]] == ["bolt_missing:Thing"]


def test_what_is_installed_meanwhile_is_found(install: Install, tmp_path: Path) -> None:
    install("acme", {"thing": "acme_missing:Thing"}, group=GROUP)
    assert offers(GROUP)["thing"][0] is offers(GROUP)["thing"][0]
    offers(GROUP).clear()
    metadata = tmp_path / "acme" / "acme_two-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: acme_two\nVersion: 2.0\n", encoding="utf-8")
    (metadata / "entry_points.txt").write_text(f"[{GROUP}]\nother = acme_two:Other\n", encoding="utf-8")
    later = (tmp_path / "acme").stat().st_mtime_ns + 1_000_000_000  # clocks of file systems are coarse
    os.utime(tmp_path / "acme", ns=(later, later))
    assert list(offers(GROUP)) == ["other", "thing"]
    assert origin(offers(GROUP)["other"][0]) == ("acme_two", "2.0")


def test_threads_may_import_a_package_and_its_module_at_once(install: Install, tmp_path: Path) -> None:
    install("acme", {"whole": "acme_parts:Part", "part": "acme_parts.part:Part"})
    package = tmp_path / "acme" / "acme_parts"
    package.mkdir()
    (package / "__init__.py").write_text("import time\ntime.sleep(0.2)\nfrom acme_parts.part import Part\n")
    (package / "part.py").write_text("from acme_parts import screw\nclass Part: pass\n")
    (package / "screw.py").write_text("")
    (tmp_path / "rule.py").write_text("from acme_parts.part import Part\n")
    offers(RULES)  # read before, so that the threads import

    def found(name: str) -> object:
        time.sleep(0.05 * (name != "whole"))  # while the package is being made
        return RuleSources(str(tmp_path)).find(name, "rules.poa").target

    with ThreadPoolExecutor(3) as threads:
        assert len({*threads.map(found, ("whole", "part", "./rule.py:Part"))}) == 1
