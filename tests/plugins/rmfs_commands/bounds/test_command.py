"""`rmfs bound`: a table, JSON, and what is wrong with its input."""

from __future__ import annotations

import json

import pytest

from rmfs_commands.cli.main import main


def code_of(*arguments: str) -> int:
    """Return the exit code of a command line."""
    try:
        main(["bound", *arguments])
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def test_a_table(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Every bound has its metric, its unit and its proof."""
    monkeypatch.setenv("COLUMNS", "120")
    assert code_of("examples/small", "--set", "instance.orders=5") == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.split()[:3] == ["Pod-station", "visits", "2"] and "set cover, optimal" in line for line in lines)
    assert any(line.split()[:6] == ["Turn-over", "time,", "95", "%", "42.70", "s"] for line in lines)
    assert any(line.split()[:4] == ["Makespan", "55.70", "s", "pickers"] for line in lines)


def test_json(capsys: pytest.CaptureFixture[str]) -> None:
    """The same for machines; another seed has other bounds, other rules have the same."""

    def bounds(*arguments: str) -> dict[str, float]:
        assert code_of("examples/small", "--set", "instance.orders=20", "--json", *arguments) == 0
        return {one["metric"]: one["value"] for one in json.loads(capsys.readouterr().out)["bounds"]}

    assert bounds() == bounds("--set", "rules.poa_pps=split-over-time") != bounds("--seed", "2")


def test_no_bound_has_its_reason(capsys: pytest.CaptureFixture[str]) -> None:
    """A dash, and why."""
    assert code_of("examples/small", "--set", "instance.orders=5", "--set", "run.warmup_s=60") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "Visits per order - none: what happens before run.warmup_s does not count" in out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("examples/smal",), "smal"),
        (("examples/small", "--set", "instance.ordrs=5"), "ordrs"),
        (("examples/small", "--set", "instance.pods=1000"), "1000 pods, but the layout has"),
        (("examples/from-csv", "--set", 'instance.pods_at_stations={"1"=["none"]}'), "there is no pod none"),
    ],
)
def test_wrong_input_is_one_sentence(
    arguments: tuple[str, ...], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2, and what is wrong where."""
    assert code_of(*arguments) == 2
    err = capsys.readouterr().err
    assert sentence in err
    assert "Traceback" not in err
