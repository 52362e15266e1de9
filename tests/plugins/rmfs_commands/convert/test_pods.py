"""`rmfs convert pods`, and SKUs on pods."""

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rmfs_core
from calling import exit_code, refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.convert import stock_table
from rmfs_commands.convert.history import merged
from rmfs_commands.convert.lines import Sku
from rmfs_commands.convert.placement import PLACEMENTS, items_on, place
from rmfs_core.scenario import load_scenario

STOCK = "Bin,Article,Qty\nA-1,tea,4\nA-2,mug,3\nA-1,mug,1\nA-3,spoon,0\n"
COLUMNS = ("--pod", "Bin", "--sku", "Article", "--quantity", "Qty")
PODS = "pod,sku,quantity\nA-1,tea,4\nA-1,mug,1\nA-2,mug,3\nA-3,spoon,0\n"


def convert(folder: Path, *options: str, text: str = STOCK) -> Path:
    (folder / "stock.csv").write_text(text, encoding="utf-8")
    main(["convert", "pods", str(folder / "stock.csv"), *COLUMNS, "--out", str(folder / "out"), *options])
    return folder / "out"


def test_only_some_stock_is_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "Bin,Article,Qty,Block\nA-1,tea,4,\nA-1,mug,1,\nA-2,mug,9,damaged\nA-3,spoon,0,\n"
    out = convert(tmp_path, "--only", "Block=", text=text)
    assert (out / "pods.csv").read_text(encoding="utf-8") == "pod,sku,quantity\nA-1,tea,4\nA-1,mug,1\nA-3,spoon,0\n"
    assert 'Not read: 1 row with another Block: row 3 "damaged".\n' in capsys.readouterr().out


def test_orders_run_on_the_stock_of_the_warehouse(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = tmp_path / "lines.csv"
    lines.write_text("o,s\n1,tea\n1,mug\n2,mug\n", encoding="utf-8")
    main(["convert", "orders", str(lines), *f"--order o --sku s --out {tmp_path / 'out'}".split()])
    out = convert(tmp_path)
    assert (out / "pods.csv").read_text(encoding="utf-8") == PODS
    assert f"Wrote {out / 'pods.csv'}: 3 pods, 8 items of 2 SKUs.\n" in (told := capsys.readouterr().out)
    assert f"Wrote {out / 'scenario.toml'}; run it with: rmfs run {out / 'scenario.toml'}\n" in told
    result = rmfs_core.run(out / "scenario.toml")
    assert (result.status, result.metrics["picks"]) == ("complete", 3)


def test_orders_that_want_more_than_the_pods_hold_are_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = tmp_path / "lines.csv"
    lines.write_text("o,s,q\n1,tea,9\n1,mug,4\n2,fork,9\n", encoding="utf-8")
    main(["convert", "orders", str(lines), *f"--order o --sku s --quantity q --out {tmp_path / 'out'}".split()])
    out = convert(tmp_path)
    told = capsys.readouterr().out
    cannot = "it cannot run yet: the pods hold fewer items than the orders want of 2 of 3 SKU"
    assert f"{out}/scenario.toml; {cannot}" in told
    assert "A line has 7.3 items on average, and pickers handle each alone; `stations.line_s`" in told
    assert exit_code("run", str(out / "scenario.toml")) == 2


def test_a_scenario_that_is_there_stays(tmp_path: Path) -> None:
    out = convert(tmp_path)
    (out / "scenario.toml").write_text("mine", encoding="utf-8")
    convert(tmp_path, "--force", text=STOCK.replace("4", "5"))
    assert (out / "scenario.toml").read_text(encoding="utf-8") == "mine"
    assert "A-1,tea,5" in (out / "pods.csv").read_text(encoding="utf-8")
    (tmp_path / "placed").mkdir()
    text = "Bin,Article,Qty,y,x\nA,tea,4,2,3\nB,tea,1,2,4\n"
    placed = convert(tmp_path / "placed", "--row", "y", "--column", "x", text=text)
    assert [file.name for file in placed.iterdir()] == ["pods.csv"]
    assert (placed / "pods.csv").read_text() == "pod,sku,quantity,row,column\nA,tea,4,2,3\nB,tea,1,2,4\n"


@cases(
    "text options sentence",
    (STOCK, ["--row", "y"], "--row: found no --column; expected both, or neither"),
    (STOCK, ["--column", "x"], "--column: found no --row; expected both, or neither"),
    ("Bin,Article,Qty\nA,tea,1\nB,tea,-1\nC,tea,x\n", [], "2 of 3 rows would be left out: 2 rows with a quantity"),
    ("Bin,Article,Qty\nA,tea,-1\n", [], "has no pod that could be kept: 1 row with a quantity that is no whole numbe"),
    ("Bin,Article,Qty\n", [], "has no pod that could be kept: it has no rows"),
    ("Bin,Article,Qty\nA,tea,1\nB,tea,1\nC,tea,1\nD,tea,1\n", [], "row 4: found more than 3 pods; expected at most"),
    *(
        (f"Bin,Article,Qty,y,x\n{rows}\n", ["--row", "y", "--column", "x"], sentence)
        for rows, sentence in (
            ("A,tea,1,1,2\nA,jam,1,1,3", "row 2: found pod 'A' in row 1, column 3; expected row 1, column 2"),
            ("A,tea,1,1,2\nB,jam,1,1,2", "row 2: found pods 'A' and 'B' in row 1, column 2; expected a location"),
            ("A,tea,1,0,2", "row 1: found '0' and '2' as row and column; expected whole numbers from 1 on"),
            ("A,tea,1,,2", "row 1: found nothing and '2' as row and column"),
        )
    ),
    (STOCK, ["--start", "noon"], '--start: expected a time in ISO 8601, such as 2024-03-01T06:30, found "noon"'),
    (
        "Bin,Article,Qty\nA,tea,4\nB,tea,5\n",
        ["--start", "2024-03-01", "--row", "Qty", "--column", "Qty"],
        "--start: pods with locations get no scenario.toml; expected no --start",
    ),
)
def test_what_is_wrong_is_said_in_a_sentence(tmp_path, capsys, monkeypatch, text, options, sentence) -> None:
    monkeypatch.setattr(stock_table, "MOST_PODS", 3)
    assert sentence in refused(capsys, convert, tmp_path, *options, text=text)
    assert not (tmp_path / "out").exists()


def test_pods_of_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = convert(tmp_path, "--decimal", ",", text="Bin,Article,Qty\nB,tea,1.200\nA,jam,3\nB,jam,2\nB, tea ,5\n")
    assert (out / "pods.csv").read_text() == "pod,sku,quantity\nB,tea,1205\nB,jam,2\nA,jam,3\n"
    told = capsys.readouterr().out
    assert told.startswith("Read 4 rows.\nSKUs that a pod repeats: 1 row; quantities are added up.\nWrote ")
    assert "pods.csv: 2 pods, 1,210 items of 2 SKUs.\n" in told
    text = "Bin,Article,Qty,y,x\nA,tea,0,1,2\nB,tea,0,3,4\nB,jam,1,3,4\n"
    convert(tmp_path, "--force", "--row", "y", "--column", "x", text=text)
    assert (out / "pods.csv").read_text() == "pod,sku,quantity,row,column\nA,tea,0,1,2\nB,jam,1,3,4\n"
    assert "Empty: 1 pod." in capsys.readouterr().out
    main(["convert", "pods", str(tmp_path / "stock.csv"), *COLUMNS[:4], "--out", str(out), "--force"])
    assert (out / "pods.csv").read_text() == "pod,sku,quantity\nA,tea,\nB,tea,\nB,jam,\n"
    assert "pods.csv: 2 pods, any number of items of 2 SKUs.\n" in capsys.readouterr().out


def test_each_row_left_out_has_its_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = 'A,tea,4\nA,jam,-2\nA,jam,"1,5"\nA,jam,\n,jam,1\nA,,1\nBin,Article,Qty\nA,jam,9000000000\n,,\n'
    out = convert(tmp_path, "--decimal", ",", "--force", text=f"Bin,Article,Qty\n{rows}")
    assert (out / "pods.csv").read_text() == "pod,sku,quantity\nA,tea,4\n"
    assert [line for line in capsys.readouterr().out.splitlines() if line.startswith(("Read", "Left"))] == [
        "Read 8 rows.",
        'Left out: 3 rows with a quantity that is no whole number from 0 on: row 2 "-2", row 3 "1,5", row 4.',
        "Left out: 1 row with no pod: row 5.",
        'Left out: 1 row with no SKU: row 6 "A".',
        "Left out: 1 row with the header again: row 7.",
        'Left out: 1 row with more than 1,000,000,000 items: row 8 "9000000000".',
    ]


@cases(
    "start zone warning",
    ("2024-03-01T06:00", "", ""),
    ("2024-03-01", "", 'has `instance.start` = "2024-03-01T00:00:00"; expected "2024-03-01T06:00:00"'),
    ("", "", 'has no `instance.start`; expected "2024-03-01T06:00:00"'),
    ("2024-03-01T06:00+01:00", "", ""),  # the table may lack the offset that the scenario has
    ("2024-03-01T06:00+01:00", "--zone UTC", 'expected "2024-03-01T06:00:00+00:00"'),
)
def test_a_scenario_that_stays_with_another_time_0_is_warned_of(tmp_path, capsys, start, zone, warning) -> None:
    out = convert(tmp_path, *(["--start", start] if start else []))
    (tmp_path / "lines.csv").write_text("o,s,t\n1,tea,2024-03-01T07:00\n", encoding="utf-8")
    columns = f"--order o --sku s --time t --start 2024-03-01T06:00 {zone} --out {out}"
    main(["convert", "orders", str(tmp_path / "lines.csv"), *columns.split()])
    told = capsys.readouterr().err
    assert warning in told if warning else not told


def test_time_0_of_orders_with_dates_is_given(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = convert(tmp_path)
    assert "Its time 0 is a midnight; for orders with dates, give --start" in capsys.readouterr().out
    (out / "scenario.toml").unlink()
    convert(tmp_path, "--force", "--start", "2024-03-01T06:00+01:00")
    assert "midnight" not in capsys.readouterr().out
    (out / "orders.csv").write_text("order,arrival_s,sku,quantity\n1,0,tea,1\n", encoding="utf-8")
    assert load_scenario(out / "scenario.toml").instance.start == "2024-03-01T06:00:00+01:00"
    told = refused(capsys, convert, tmp_path, "--force", "--start", "2024-03-01")
    assert "scenario.toml is there already; expected no --start" in told


@given(
    wanted=st.lists(st.integers(0, 50), min_size=1, max_size=30),
    pods=st.integers(1, 12),
    more=st.integers(0, 4),
    placement=st.sampled_from(PLACEMENTS),
    seed=st.integers(0, 3),
)
def test_every_sku_is_somewhere_and_no_pod_is_too_full(wanted, pods, more, placement, seed) -> None:
    skus = [Sku(f"s{i}", lines, 2 * lines) for i, lines in enumerate(sorted(wanted, reverse=True))]
    per_pod = -(-len(skus) // pods) + more
    baskets = [["s0", f"s{len(skus) - 1}"]] if min(wanted) else []
    held = place(skus, [per_pod] * pods, placement, np.random.default_rng(seed), baskets)
    assert {sku for pod in held for sku in pod} == set(range(len(skus)))
    assert all(len(set(pod)) == len(pod) <= per_pod for pod in held)
    items, raised = items_on(skus, held, 3)
    stock = [sum(items[i] for pod in held if i in pod) for i in range(len(skus))]
    assert all(stock[i] >= sku.items for i, sku in enumerate(skus))
    assert raised == sum(items > 3)


def test_where_history_puts_skus() -> None:
    skus = [Sku("fast", 80, 80), *(Sku(f"slow{i}", 5, 5) for i in range(5))]
    held = place(skus, [2] * 16, "popularity", np.random.default_rng(1))
    copies = [sum(i in pod for pod in held) for i in range(6)]
    assert copies[0] in (12, 13)
    assert set(copies[1:]) <= {3, 4}
    assert sum(copies) == 32
    skus = [Sku(name, 10, 10) for name in ("ale", "bun", "nut", "tea")]
    baskets = [["ale", "tea"], ["bun", "nut"]] * 10
    held = place(skus, [2] * 2, "co-purchase", np.random.default_rng(1), baskets)
    assert sorted(held) == [[0, 3], [1, 2]]
    skus = [*(Sku(f"known{i}", 10, 10) for i in range(8)), *(Sku(f"new{i}", 0, 1) for i in range(4))]
    held = place(skus, [3] * 4, "co-purchase", np.random.default_rng(1), [["known0", "known1"], ["known2", "known3"]])
    assert [sum(sku >= 8 for sku in pod) for pod in held] == [1, 1, 1, 1]
    past = [Sku("a", 9, 90), Sku("b", 3, 3)]
    run = [Sku("c", 2, 7), Sku("b", 1, 4)]
    assert merged(run, past) == [Sku("a", 9, 0), Sku("b", 3, 4), Sku("c", 0, 7)]


HISTORY_COLUMNS = ("--order", "o", "--sku", "s", "--quantity", "q", "--time", "t")
FEW_PODS = ("--pods", "6", "--skus-per-pod", "2", "--items", "1")
PAST = "".join(
    f"h{i},{sku},1,2024-03-0{1 + i % 2}T07:0{i}\n"
    for i in range(8)
    for sku in (("ale", "tea") if i % 2 else ("bun", "nut"))
)
TODAY = "r1,ale,1,2024-03-03T06:00\nr1,nut,1,2024-03-03T06:00\nr2,new,5,2024-03-03T06:01\n"


def placed_after(folder: Path, text: str, *options: str) -> list[set[str]]:
    (folder / "lines.csv").write_text("o,s,q,t\n" + text, encoding="utf-8")
    table, out = str(folder / "lines.csv"), str(folder / "out")
    main(["convert", "orders", table, *HISTORY_COLUMNS, *FEW_PODS, "--out", out, *options])
    pods: dict[str, set[str]] = {}
    with (folder / "out" / "pods.csv").open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            pods.setdefault(row["pod"], set()).add(row["sku"])
    return list(pods.values())


@pytest.mark.parametrize("way", ["table", "time"])
def test_pods_hold_what_was_bought_together_before(tmp_path, capsys, way) -> None:
    if way == "table":
        (tmp_path / "past.csv").write_text("o,s,q\n" + "".join(f"{r.rpartition(',')[0]}\n" for r in PAST.splitlines()))
        pods = placed_after(tmp_path, TODAY, "--history", str(tmp_path / "past.csv"))
        source = str(tmp_path / "past.csv")
    else:
        pods = placed_after(tmp_path, PAST + TODAY, "--history-until", "2024-03-03T00:00")
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
    (tmp_path / "past.csv").write_text("o,s,q,t\n" + PAST + TODAY, encoding="utf-8")
    with_them = placed_after(tmp_path, TODAY, "--history", str(tmp_path / "past.csv"), "--placement", "popularity")
    assert "learned from 8 orders of" in (told := capsys.readouterr().out)
    assert "past.csv (and not from 2 that are also run). SKUs without history: 1 of 5, placed anywhere." in told
    (tmp_path / "past.csv").write_text("o,s,q,t\n" + PAST, encoding="utf-8")
    options = ("--history", str(tmp_path / "past.csv"), "--placement", "popularity", "--force")
    assert placed_after(tmp_path, TODAY, *options) == with_them


def test_rows_of_a_history_that_are_left_out_are_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "past.csv").write_text("o,s,q,t\n" + PAST + "h9,tea,-1,\n", encoding="utf-8")
    pods = placed_after(tmp_path, TODAY, "--history", str(tmp_path / "past.csv"), "--leave-out-sku", "new")
    assert all("new" not in pod for pod in pods)
    assert f"Left out of {tmp_path / 'past.csv'}: 1 row with a quantity that is no whole" in capsys.readouterr().out


def test_orders_before_the_time_are_history_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    placed_after(tmp_path, PAST + TODAY, "--history-until", "2024-03-03T00:00", "--from", "2024-03-02T00:00")
    told = capsys.readouterr().out
    assert "Left out: 4 orders with a time outside the chosen span.\n" in told
    assert "Left out: 4 orders with a time before --history-until, which are history.\n" in told
    assert f"learned from 4 orders of {tmp_path / 'lines.csv'} before 2024-03-03T00:00" in told


@pytest.mark.parametrize("placement", ["popularity", "co-purchase"])
def test_a_placement_that_knows_its_orders_says_so(tmp_path, capsys, placement) -> None:
    placed_after(tmp_path, PAST, "--placement", placement)
    sentence = f"The placement ({placement}) knows the orders that it is judged by; --history TABLE or"
    assert sentence in capsys.readouterr().out
    text = (tmp_path / "out" / "scenario.toml").read_text(encoding="utf-8")
    assert sentence in text.partition("\n\n")[0].replace("\n# ", " ")
    placed_after(tmp_path, PAST, "--force")
    assert "The placement" not in capsys.readouterr().out
    assert "placement" not in (tmp_path / "out" / "scenario.toml").read_text(encoding="utf-8")


@cases(
    "options sentence",
    (["--history", "{past}", "--history-until", "2024-03-03T00:00"], "--history-until: found --history, too"),
    (["--history", "{past}", "--placement", "random"], "--history: found --placement random, which learns nothing"),
    (["--history-until", "2024-03-01T00:00"], "--from, --history-until: all orders (10) are outside: from 2024-0"),
    (["--history-until", "2025-03-01T00:00"], "--history-until: all orders (10) are earlier, the last at 2024-0"),
    (["--history-until", "soon"], '--history-until: found "soon"; expected a time such as'),
    (["--history", "{past}"], "past.csv: all its orders (2) are run; expected other orders"),
    (["--history", "{none}"], "none.csv: cannot be read: No such file or directory"),
)
def test_history_that_says_nothing_is_refused(tmp_path, capsys, options, sentence) -> None:
    (tmp_path / "past.csv").write_text("o,s,q,t\n" + TODAY, encoding="utf-8")
    named = [option.format(past=tmp_path / "past.csv", none=tmp_path / "none.csv") for option in options]
    assert sentence in refused(capsys, placed_after, tmp_path, PAST + TODAY, *named)
    assert not list((tmp_path / "out").glob("*"))
