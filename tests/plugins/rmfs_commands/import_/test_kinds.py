"""Which format files have, from how they begin."""

from __future__ import annotations

from pathlib import Path

import pytest

from rawsimo_files import keys
from rmfs_commands.import_.kinds import kind_of, sorted_out
from rmfs_core.errors import InputError

OCTILE = "type octile\nheight 1\nwidth 2\nmap\n..\n"
TEXTS = {
    "a.xinst": keys("Instance", {}),
    "a.xsett": keys("SettingConfiguration", {}),
    "a.map": OCTILE,
    "b.map": OCTILE.replace("..\n", ".E\n"),
    "k.map": "1,2\n0\n0\n0\n..\n",
    "s.grid": "Grid size (x, y)\n1,1\n",
    "a.scen": "version 1\n",
    "a.json": '\ufeff {"mapFile": "a.map"}',
    "a.txt": "hello\n",
    "a.html": "<html></html>",
    "broken.xinst": '<?xml version="1.0"?>\n<Instance Name="A & B"></Instance>',
    "empty": "",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with a file of each kind."""
    for name, text in TEXTS.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("a.xinst", "Instance"),
        ("a.map", "octile"),
        ("k.map", "kiva"),
        ("s.grid", "grid"),
        ("a.scen", "scen"),
        ("a.json", "problem"),
    ],
)
def test_a_file_begins_as_its_kind(folder: Path, name: str, kind: str) -> None:
    """Whatever it is called."""
    assert kind_of(folder / name) == kind


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("a.txt", "found none of these"),
        ("a.html", "found an XML file of html"),
        ("broken.xinst", "broken.xinst, line 2: this is no valid XML: not well-formed"),
        ("empty", "found none of these"),
        ("none", "cannot be read: No such file or directory"),
        (".", "cannot be read: Is a directory"),
    ],
)
def test_other_files_are_refused(folder: Path, name: str, found: str) -> None:
    """With what is expected."""
    with pytest.raises(InputError) as caught:
        kind_of(folder / name)
    assert found in str(caught.value)


@pytest.mark.parametrize(
    ("names", "asked", "chosen"),
    [
        (["a.xsett", "a.xinst"], None, "rawsim-o"),
        (["k.map"], None, "rhcr"),
        (["s.grid"], "rhcr", "rhcr"),
        (["a.json"], None, "lorr"),
        (["a.map"], None, "movingai"),
        (["b.map"], None, "lorr"),
        (["a.map"], "lorr", "lorr"),
        (["b.map"], "movingai", "movingai"),
        (["a.map", "a.scen"], None, "movingai"),
    ],
)
def test_files_of_one_instance_have_one_format(folder: Path, names: list[str], asked: str | None, chosen: str) -> None:
    """A map of two formats is MovingAI's, unless it has emitters or another one is asked for."""
    assert sorted_out([folder / name for name in names], asked)[0] == chosen


@pytest.mark.parametrize(
    ("names", "asked", "message"),
    [
        (["a.map", "b.map"], None, "a.map, too, which is of the same kind; expected one of them"),
        (["a.map", "a.xinst"], None, "a.map and a.xinst: found files of different formats, or one missing; expected"),
        (["a.scen"], None, "a.scen: found files of different formats, or one missing"),
        (["k.map"], "lorr", "--format: found files that the League of Robot Runners does not have together; they look"),
        (["a.map", "a.xinst"], "rhcr", "--format: found files that RHCR does not have together"),
    ],
)
def test_files_that_do_not_belong_together_are_refused(
    folder: Path, names: list[str], asked: str | None, message: str
) -> None:
    """Whatever format is asked for."""
    with pytest.raises(InputError) as caught:
        sorted_out([folder / name for name in names], asked)
    assert message in str(caught.value)
