"""Orders and pods from CSV files."""

from pathlib import Path

import pytest

from cases import cases
from rmfs_commands.instances.csv_files import read_bundles, read_robots, read_skus
from rmfs_core.errors import InputError
from rmfs_core.world import Instance, OrderData, PodData, read_instance
from saying import said

ORDERS = "order,arrival_s,sku,quantity\n"
PODS = "pod,sku,quantity\n"
DUE = "order,arrival_s,sku,quantity,due_s,priority\n"
DATED = "order,arrival,sku,quantity,due\n"

HEADER = "1: expected a header with the columns order,arrival_s,sku,quantity, found "
WHOLE = "2, quantity: expected a whole number >= 1, "
SECONDS = "expected a number of seconds >= 0, found "
BAD_ORDERS = [
    # no file content, a header without a column, other separators
    ("", HEADER + "none"),
    ("order,arrives,sku,quantity\n", HEADER + "`order,arrives,sku,quantity` without `arrival_s`"),
    (
        "order;arrival_s;sku;quantity\n",
        HEADER + "`order;arrival_s;sku;quantity`: fields are separated by commas, not by semicolons",
    ),
    ("order,arrival_s,sku,quantity,quantity\n", "1, quantity: found this column twice; expected each once"),
    ("\norder\n", HEADER.replace("1:", "2:") + "`order` without `arrival_s`"),
    # a row too short, and one too long
    (ORDERS + "1,0,a\n", "2: expected 4 fields as in the header, found 3"),
    (ORDERS + "1,0,a,1\n1,0,b,1,\n", "3: expected 4 fields as in the header, found 5"),
    # quantities
    *((ORDERS + f"1,0,a,{bad}\n", f'{WHOLE}found "{bad}"') for bad in ("0", "1.5", "", "1_0")),
    (ORDERS + "1,0,a,1000001\n", "2, quantity: found 1,000,001 items; expected at most 1,000,000"),
    (ORDERS + "1,0,a,10000000000\n", f'{WHOLE}of at most ten digits, found "10000000000"'),
    # times
    *((ORDERS + f"1,{bad},a,1\n", f'2, arrival_s: {SECONDS}"{bad}"') for bad in ("-1", "nan", "08:30")),
    (
        ORDERS + "1,2024-03-01,a,1\n",
        '2, arrival_s: expected a number of seconds >= 0, or dates in a column `arrival`, found "2024-03-01"',
    ),
    (ORDERS + "1,2.5,a,1\n2,0,a,1\n1,3,b,1\n", "4, arrival_s: expected 2.5 as in the first row of order 1, found 3"),
    # due times and priorities
    (DUE + "1,0,a,1,soon,\n", f'2, due_s: {SECONDS}"soon"'),
    *(
        (
            DUE + f"1,0,a,1,,{bad}\n",
            f'2, priority: expected a whole number of at most ten digits, or nothing for 0, found "{bad}"',
        )
        for bad in ("-1", "10000000000")
    ),
    (DUE + "1,0,a,1,9,\n1,0,b,1,8,\n", "3, due_s: expected 9 as in the first row of order 1, found 8"),
    (DUE + "1,0,a,1,9,\n1,0,b,1,,\n", "3, due_s: expected 9 as in the first row of order 1, found nothing"),
    (
        DATED + "1,01.03.2024,a,1,\n",
        '2, arrival: expected a time in ISO 8601, such as 2024-03-01T06:30, found "01.03.2024"',
    ),
    (
        DATED + "1,2024-03-01T06:00,a,1,\n2,2024-03-01T07:00Z,a,1,\n",
        '3, arrival: expected an offset from UTC in all times or in none, found "2024-03-01T07:00Z"',
    ),
    # names
    (ORDERS + " ,0,a,1\n", "2, order: expected a name, found nothing"),
    (ORDERS + "1,0,,1\n", "2, sku: expected a name, found nothing"),
    # quotes: one that is never closed, one that another line closes, one that is not doubled
    (ORDERS + '1,0,"a,1\n2,0,b,1\n', "2: found a quote that is never closed; expected another at the end of the field"),
    (ORDERS + '1,0,"a,1\n2,0,"b",1\n', "2: found a quote within a field in quotes (line 3); expected it doubled"),
    (ORDERS + '1,0,"a"b,1\n', "2: found a quote within a field in quotes; expected it doubled"),
]
STOCK = "2, quantity: expected a whole number >= 0, or nothing for an unlimited number, found "
PLACED = "pod,sku,quantity,row,column\n"
BAD_PODS = [
    ("pod,sku\n", "1: expected a header with the columns pod,sku,quantity, found `pod,sku` without `quantity`"),
    *((PODS + f"1,a,{bad}\n", f'{STOCK}"{bad}"') for bad in ("x", "-3")),
    (PODS + "1,,3\n", "2, sku: expected a name, found nothing"),
    (PLACED + "1,a,3,2,x\n", '2, column: expected a whole number >= 1, found "x"'),
    (
        "pod,sku,quantity,row\n",
        "1: expected a header with the columns pod,sku,quantity,row,column, "
        "found `pod,sku,quantity,row` without `column`",
    ),
    (PLACED + "1,a,3,2,5\n2,a,3,2,6\n1,b,3,2,6\n", "4: found row 2, column 6; expected the location of {file}, line 2"),
]


def read(tmp_path: Path, orders: str = ORDERS, pods: str = PODS, start: str | None = None) -> Instance:
    (tmp_path / "orders.csv").write_bytes(orders.encode())
    (tmp_path / "pods.csv").write_bytes(pods.encode())
    return read_instance(tmp_path / "orders.csv", tmp_path / "pods.csv", start)


@cases("table text message", *(("orders", *row) for row in BAD_ORDERS), *(("pods", *row) for row in BAD_PODS))
def test_a_mistake_in_a_table_is_one_sentence(table: str, text: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / f"{table}.csv"
    assert said(InputError, read, tmp_path, **{table: text}) == f"{file}, line {message.replace('{file}', str(file))}"


def test_orders_skus_and_names_are_brought_together(tmp_path: Path) -> None:
    orders = ORDERS + "late,9.5,b,1\nx,0,a,1\nearly,0,a,2\nlate,9.5,a,1\nx,0,b,3\n"
    instance = read(tmp_path, orders)
    assert instance.skus == ("a", "b")
    assert instance.orders == (
        OrderData("x", arrival_tick=0, lines=((0, 1), (1, 3))),
        OrderData("early", arrival_tick=0, lines=((0, 2),)),
        OrderData("late", arrival_tick=9500, lines=((1, 1), (0, 1))),
    )
    instance = read(tmp_path, ORDERS + "1,0,a,1\n1,0,a,2\n", PODS + "p,a,1\np,a,2\nq,a,\nq,a,2\nr,a,2\nr,a,\n")
    assert instance.orders[0].lines == ((0, 3),)
    assert instance.pods == (PodData("p", ((0, 3),)), PodData("q", ((0, None),)), PodData("r", ((0, None),)))
    instance = read(tmp_path, ORDERS + "1,0,A10,1\n1,0,A9,1\n", PODS + "1,10,\n1,9,\n1,A,\n")
    assert instance.skus == ("9", "10", "A", "A9", "A10")
    names = ["", *("0", "00", "1", "02"), "9" * 5000, "1" + "0" * 5000, "A0", "A00", "A1"]
    instance = read(tmp_path, ORDERS + "1,0,0,1\n", PODS + "".join(f"1,{name},\n" for name in reversed(names[1:])))
    assert list(instance.skus) == names[1:]
    orders = '\ufeffsku,customer, quantity ,order,arrival_s\r\n"mug, red",North, 2 ,1,1e1\r\n\r\n'
    instance = read(tmp_path, orders)
    assert instance.skus == ("mug, red",)
    assert instance.orders == (OrderData("1", arrival_tick=10_000, lines=((0, 2),)),)


def test_columns_and_names_are_noted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    orders = "order,arrival_s,sku,quantity,customer,prioritet\n1,0,a,1,north,2\n"
    for _ in range(2):
        assert read(tmp_path, orders).orders[0].priority == 0
    file = tmp_path / "orders.csv"
    assert capsys.readouterr().err == f"{file}: ignored `customer` and `prioritet` (did you mean `priority`?).\n"
    orders = ORDERS + "a,0,x,1\nb,0,x,1\nb,0,z,1\na,0,y,2\nc,0,x,1\nb,0,y,1\na,0,x,1\n"
    for _ in range(2):
        instance = read(tmp_path, orders, PODS + "p,x,5\nq,y,5\np,z,5\n")
    assert [order.name for order in instance.orders] == ["a", "b", "c"]
    assert instance.orders[0].lines == ((0, 2), (1, 2))
    assert capsys.readouterr().err == (
        f"{tmp_path / 'orders.csv'}, line 5: order a appears again after rows of other orders, and its rows are read "
        "as one order; so are those of 1 more order.\n"
        f"{tmp_path / 'pods.csv'}, line 4: pod p appears again after rows of other pods, "
        "and its rows are read as one pod.\n"
    )
    read(tmp_path, ORDERS + "a,0,x,1\na,0,y,1\nb,0,x,1\n", PODS + "p,x,5\np,y,5\nq,x,1\n")
    assert not capsys.readouterr().err


def test_due_times_priorities_and_dates(tmp_path: Path) -> None:
    instance = read(tmp_path, DUE + "1,10,a,1,7200.5,\n2,20,a,1,,3\n3,30,a,1,5,1\n")
    assert [(order.due_tick, order.priority) for order in instance.orders] == [(7_200_500, 0), (None, 3), (5000, 1)]
    assert instance.dated
    assert not read(tmp_path, ORDERS + "1,10,a,1\n").dated
    instance = read(tmp_path, DATED + "1,2024-03-02 00:30,a,1,\n2,2024-03-01T06:00:00.5,a,1,2024-02-29T23:00\n")
    assert [(order.name, order.arrival_tick) for order in instance.orders] == [("2", 21_600_500), ("1", 88_200_000)]
    assert [order.due_tick for order in instance.orders] == [-3_600_000, None]
    rows = DATED + "1,2024-03-01T00:30+02:00,a,1,2024-02-29T23:30Z\n"
    order = read(tmp_path, rows).orders[0]
    assert (order.arrival_tick, order.due_tick) == (1_800_000, 5_400_000)


@cases(
    "column rows found",
    ("arrival_s", "1,1709251200,a,1\n", "1709251200"),  # counted from 1970
    ("arrival", "1,2024-03-01,a,1\n2,2204-03-01,a,1\n", "2204-03-01"),
)
def test_an_arrival_in_another_age_is_refused(tmp_path: Path, column: str, rows: str, found: str) -> None:
    """A run has a row for each hour until then; more than ten years of them are a slip."""
    told, line = said(InputError, read, tmp_path, f"order,{column},sku,quantity\n{rows}"), rows.count("\n") + 1
    assert told.startswith(f"{tmp_path / 'orders.csv'}, line {line}, {column}: found {found}; expected")


def test_dates_count_from_the_start_of_the_scenario(tmp_path: Path) -> None:
    """`instance.start` is time 0; what arrives before is refused with its line. Due dates may stand beside seconds."""
    rows = DATED + "1,2024-03-01T06:30,a,1,2024-03-01T07:00\n"
    order = read(tmp_path, rows, start="2024-03-01T06:00").orders[0]
    assert (order.arrival_tick, order.due_tick) == (1_800_000, 3_600_000)
    assert said(InputError, read, tmp_path, rows, start="2024-03-01T07:00") == (
        f"{tmp_path / 'orders.csv'}, line 2, arrival: found 2024-03-01T06:30; "
        "expected a time within ten years from time 0 (`instance.start`) on"
    )
    seconds = "order,arrival_s,sku,quantity,due\n1,60,a,1,2024-03-01T07:00\n"
    assert read(tmp_path, seconds, start="2024-03-01T06:00").orders[0].due_tick == 3_600_000


@cases(
    "rows arrivals",
    (("1,2024-07-01T04:00:00Z,a,1,", "2,2024-07-01T06:30:00+02:00,a,1,"), [14_400_000, 16_200_000]),
    (("1,2024-07-01T00:30:00+02:00,a,1,", "2,2024-07-01T05:10:00Z,a,1,"), [1_800_000, 25_800_000]),
    # an order due before all, by another clock, and one instant written in two ways
    (("1,2024-07-01T00:30:00+02:00,a,1,2024-06-30T20:00Z", "2,2024-07-01T05:10:00Z,a,1,"), [1_800_000, 25_800_000]),
    (("1,2024-07-01T00:30:00+02:00,a,1,", "1,2024-06-30T22:30:00Z,b,1,"), [81_000_000]),
)
def test_time_zero_does_not_depend_on_the_order_of_rows(tmp_path, rows, arrivals) -> None:
    for sorted_rows in (rows, rows[::-1]):
        orders = read(tmp_path, DATED + "".join(f"{row}\n" for row in sorted_rows)).orders
        assert [order.arrival_tick for order in orders] == arrivals


def test_pods_with_places_or_without_stock(tmp_path: Path) -> None:
    (tmp_path / "orders.csv").write_text(ORDERS + "1,0,a,1\n")
    file = tmp_path / "pods.csv"
    file.write_text("row,column,pod,sku,quantity\n3,4,p,a,\n1,2,q,a,7\n3,4,p,b,\n")
    pods = read_instance(tmp_path / "orders.csv", file).pods
    assert [pod.place for pod in pods] == [(3, 4, f"{file}, line 2"), (1, 2, f"{file}, line 3")]
    assert read(tmp_path, pods=PODS + "p,a,0\nq,a,2\nq,a,0\n").pods == (PodData("p", ()), PodData("q", ((0, 2),)))


def test_files_that_are_none_are_refused(tmp_path: Path) -> None:
    orders, pods = tmp_path / "orders.csv", tmp_path / "pods.csv"
    assert said(InputError, read_instance, orders, pods) == f"{orders}: cannot be read: No such file or directory"
    orders.write_bytes(ORDERS.encode() + b"1,0,gr\xfcn,1\n")
    told = f"{orders}: expected UTF-8 text, found the byte 0xfc; save it as UTF-8 "
    assert said(InputError, read_instance, orders, pods).startswith(told)
    pods.write_text(PODS)
    told = "/dev/zero, line 1: found a field of more than 131,072 characters; expected a shorter one"
    assert said(InputError, read_instance, Path("/dev/zero"), pods) == told
    assert said(InputError, read_instance, tmp_path / "a\0b", pods).endswith("cannot be read: embedded null byte")


BUNDLES, SKUS = "bundle,arrival_s,sku,items\nA,2.5,a,3\n", "sku,size,reorder_point,order_up_to\na,2,,7.5\n"


@cases(
    "of text message",
    (
        read_robots,
        "robot,row\n",
        "1: expected a header with the columns robot,row,column, found `robot,row` without `column`",
    ),
    (read_robots, "robot,row,column\n1,0,2\n", '2, row: expected a whole number >= 1, found "0"'),
    (read_robots, "robot,row,column\n1,1,2\n2,1,\n", '3, column: expected a whole number >= 1, found ""'),
    (read_robots, "robot,row,column\n1,1,2\n3,1,1\n", '3, robot: expected 2, found "3"'),
    (read_bundles, BUNDLES + "B,1,a,0\n", '3, items: expected a whole number >= 1, found "0"'),  # nothing to store
    (read_bundles, BUNDLES + "B,soon,a,1\n", f'3, arrival_s: {SECONDS}"soon"'),
    (read_bundles, BUNDLES + "B,4e8,a,1\n", "3, arrival_s: found 4e8; expected a time within ten years from time 0 on"),
    (read_bundles, BUNDLES + "A,1,a,1\n", "3: found bundle A again; expected each once"),
    (read_bundles, BUNDLES + ",1,a,1\n", "3, bundle: expected a name, found nothing"),
    (read_skus, SKUS + "b,0,,\n", '3, size: expected a whole number >= 1, found "0"'),
    (read_skus, SKUS + "b,1,-1,\n", '3, reorder_point: expected a number from 0 to 1e9, found "-1"'),
    (read_skus, SKUS + "b,1,,lots\n", '3, order_up_to: expected a number from 0 to 1e9, found "lots"'),
    (read_skus, SKUS + "a,1,,\n", "3, sku: found SKU a again; expected each once"),
)
def test_a_mistake_in_robots_bundles_or_skus_is_one_sentence(of, text: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "table.csv"
    file.write_text(text)
    assert said(InputError, of, file) == f"{file}, line {message}"


def test_parameters_of_skus_may_be_left_out(tmp_path: Path) -> None:
    (tmp_path / "skus.csv").write_text("sku,size,order_up_to\na,2,7.5\nb,,\n", encoding="utf-8")
    assert read_skus(tmp_path / "skus.csv") == {"a": {"size": 2.0, "order_up_to": 7.5}, "b": {}}
