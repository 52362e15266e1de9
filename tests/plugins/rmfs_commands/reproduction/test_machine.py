"""What a reproduction ran on."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest

from rmfs_commands.reproduction import machine as module
from rmfs_commands.reproduction.machine import machine, processor, versions


def test_the_machine_is_named() -> None:
    """Everything that a reader of computing times asks for, and nothing empty."""
    found = machine()
    assert list(found) == ["processor", "cores", "system", "python"]
    assert all(found.values())
    assert platform.python_version() in found["python"]
    assert platform.system() in found["system"]


def test_cores_are_those_that_may_be_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not those that the machine has; where the system does not tell, all of them."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 5, 7}, raising=False)
    assert machine()["cores"] == "3"
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: 12)
    assert machine()["cores"] == "12"
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert machine()["cores"] == "1"


@pytest.mark.parametrize(
    ("text", "platforms", "expected"),
    [
        ("processor : 0\nmodel name\t: Some CPU @ 2 GHz\nmodel name\t: Another\n", "x", "Some CPU @ 2 GHz"),
        ("processor : 0\n", "arm", "arm"),
        (None, "arm", "arm"),
        (None, "", "unknown"),
    ],
)
def test_the_processor_is_called_as_the_system_calls_it(
    text: str | None, platforms: str, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the system's file where there is one, else as Python knows it."""

    def read(path: Path, encoding: str) -> str:
        if text is None:
            raise FileNotFoundError(path)
        return text

    monkeypatch.setattr(Path, "read_text", read)
    monkeypatch.setattr(platform, "processor", lambda: platforms)
    assert processor() == expected


def test_versions_of_what_figures_depend_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Installed ones as they are; one that is missing is said to be."""
    found = versions()
    assert found["numpy"] == version("numpy")
    assert found["rmfs"] == version("rmfs")

    def without_mip(name: str) -> str:
        if name == "mip":
            raise PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(module, "version", without_mip)
    assert versions() == dict.fromkeys(found, "1.0") | {"mip": "not installed"}
