"""What a placement learns from: other orders, or the orders that are run, which is said."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

import rmfs_core
from rmfs_commands.cli.main import main
from rmfs_commands.convert.history import Learned, merged
from rmfs_commands.convert.lines import Sku

COLUMNS = ("--order", "o", "--sku", "s", "--quantity", "q", "--time", "t")
PODS = ("--pods", "6", "--skus-per-pod", "2", "--items", "1")
PAST = "".join(
    f"h{i},{sku},1,2024-03-0{1 + i % 2}T07:0{i}\n"
    for i in range(8)
    for sku in (("ale", "tea") if i % 2 else ("bun", "nut"))
)
TODAY = "r1,ale,1,2024-03-03T06:00\nr1,nut,1,2024-03-03T06:00\nr2,new,5,2024-03-03T06:01\n"


def convert(folder: Path, text: str, *options: str) -> list[set[str]]:
    """Convert a table; return the SKUs of each pod."""
    (folder / "lines.csv").write_text("o,s,q,t\n" + text, encoding="utf-8")
    main(["convert", "orders", str(folder / "lines.csv"), *COLUMNS, *PODS, "--out", str(folder / "out"), *options])
    pods: dict[str, set[str]] = {}
    with (folder / "out" / "pods.csv").open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            pods.setdefault(row["pod"], set()).add(row["sku"])
    return list(pods.values())


@pytest.mark.parametrize("way", ["table", "time"])
def test_pods_hold_what_was_bought_together_before(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], way: str
) -> None:
    """Not what the orders of the run buy together; a SKU without history has a pod, and stock for its orders."""
    if way == "table":
        (tmp_path / "past.csv").write_text("o,s,q\n" + "".join(f"{r.rpartition(',')[0]}\n" for r in PAST.splitlines()))
        pods = convert(tmp_path, TODAY, "--history", str(tmp_path / "past.csv"))
        source = str(tmp_path / "past.csv")
    else:
        pods = convert(tmp_path, PAST + TODAY, "--history-until", "2024-03-03T00:00")
        source = f"{tmp_path / 'lines.csv'} before 2024-03-03T00:00"
    assert {"ale", "tea"} in pods
    assert {"bun", "nut"} in pods
    assert {"ale", "nut"} not in pods
    assert any("new" in pod for pod in pods)
    told = capsys.readouterr().out
    learned = f"Placement co-purchase learned from 8 orders of {source}. SKUs without history: 1 of 5, placed anywhere."
    assert learned in told
    scenario = tmp_path / "out" / "scenario.toml"
    comment = "\n".join(row for row in scenario.read_text(encoding="utf-8").splitlines() if row.startswith("#"))
    assert learned in comment.replace("\n# ", " ")
    result = rmfs_core.run(scenario)
    assert (result.status, [order["order"] for order in result.orders]) == ("complete", ["r1", "r2"])


def test_orders_that_are_run_are_not_learned_from(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A history that has them is used without them."""
    (tmp_path / "past.csv").write_text("o,s,q,t\n" + PAST + TODAY, encoding="utf-8")
    with_them = convert(tmp_path, TODAY, "--history", str(tmp_path / "past.csv"), "--placement", "popularity")
    assert "learned from 8 orders of" in (told := capsys.readouterr().out)
    assert "past.csv (and not from 2 that are also run). SKUs without history: 1 of 5, placed anywhere." in told
    (tmp_path / "past.csv").write_text("o,s,q,t\n" + PAST, encoding="utf-8")
    options = ("--history", str(tmp_path / "past.csv"), "--placement", "popularity", "--force")
    assert convert(tmp_path, TODAY, *options) == with_them


def test_rows_of_a_history_that_are_left_out_are_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With the table; a SKU to leave out need not be in it."""
    (tmp_path / "past.csv").write_text("o,s,q,t\n" + PAST + "h9,tea,-1,\n", encoding="utf-8")
    pods = convert(tmp_path, TODAY, "--history", str(tmp_path / "past.csv"), "--leave-out-sku", "new")
    assert all("new" not in pod for pod in pods)
    assert f"Left out of {tmp_path / 'past.csv'}: 1 row with a quantity that is no whole" in capsys.readouterr().out


def test_orders_before_the_time_are_history_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They are not run, and counted; --from leaves out earlier ones altogether."""
    convert(tmp_path, PAST + TODAY, "--history-until", "2024-03-03T00:00", "--from", "2024-03-02T00:00")
    told = capsys.readouterr().out
    assert "Left out: 4 orders with a time outside the chosen span.\n" in told
    assert "Left out: 4 orders with a time before --history-until, which are history.\n" in told
    assert f"learned from 4 orders of {tmp_path / 'lines.csv'} before 2024-03-03T00:00" in told


@pytest.mark.parametrize("placement", ["popularity", "co-purchase"])
def test_a_placement_that_knows_its_orders_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], placement: str
) -> None:
    """In the output and in the scenario; the default does not know them."""
    convert(tmp_path, PAST, "--placement", placement)
    sentence = f"The placement ({placement}) knows the orders that it is judged by; --history TABLE or"
    assert sentence in capsys.readouterr().out
    text = (tmp_path / "out" / "scenario.toml").read_text(encoding="utf-8")
    assert sentence in text.partition("\n\n")[0].replace("\n# ", " ")
    convert(tmp_path, PAST, "--force")
    assert "The placement" not in capsys.readouterr().out
    assert "placement" not in (tmp_path / "out" / "scenario.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--history", "{past}", "--history-until", "2024-03-03T00:00"], "--history-until: found --history, too"),
        (["--history", "{past}", "--placement", "random"], "--history: found --placement random, which learns nothing"),
        (["--history-until", "2024-03-01T00:00"], "--from, --history-until: all orders (10) are outside: from 2024-0"),
        (["--history-until", "2025-03-01T00:00"], "--history-until: all orders (10) are earlier, the last at 2024-0"),
        (["--history-until", "soon"], '--history-until: found "soon"; expected a time such as'),
        (["--history", "{past}"], "past.csv: all its orders (2) are run; expected other orders"),
        (["--history", "{none}"], "none.csv: cannot be read: No such file or directory"),
    ],
)
def test_history_that_says_nothing_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], sentence: str
) -> None:
    """In one sentence; nothing is written."""
    (tmp_path / "past.csv").write_text("o,s,q,t\n" + TODAY, encoding="utf-8")
    named = [option.format(past=tmp_path / "past.csv", none=tmp_path / "none.csv") for option in options]
    with pytest.raises(SystemExit) as stopped:
        convert(tmp_path, PAST + TODAY, *named)
    assert stopped.value.code == 2
    assert sentence in capsys.readouterr().err
    assert not list((tmp_path / "out").glob("*"))


def test_history_needs_pods(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without them it would be ignored."""
    with pytest.raises(SystemExit):
        main(["convert", "orders", "x.csv", *COLUMNS, "--history", "y.csv", "--out", str(tmp_path)])
    assert "--history: found no --pods; expected both" in capsys.readouterr().err


def test_skus_of_both_stand_on_pods() -> None:
    """Order lines are those of the past, items those that the run wants."""
    past = [Sku("a", 9, 90), Sku("b", 3, 3)]
    run = [Sku("c", 2, 7), Sku("b", 1, 4)]
    assert merged(run, past) == [Sku("a", 9, 0), Sku("b", 3, 4), Sku("c", 0, 7)]
    assert Learned("random", None).sentence() is None
