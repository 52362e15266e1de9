"""Orders and pods from CSV files."""

from __future__ import annotations

from pathlib import Path

import pytest

from rmfs_core.errors import InputError
from rmfs_core.world import Instance, OrderData, PodData, read_instance

ORDERS = "order,arrival_s,sku,quantity\n"
PODS = "pod,sku,quantity\n"

BAD_ORDERS = [
    # no file content, a header without a column, other separators
    ("", ", line 1: expected a header with the columns order,arrival_s,sku,quantity, found none"),
    (
        "order,arrival,sku,quantity\n",
        ", line 1: expected a header with the columns order,arrival_s,sku,quantity, "
        "found `order,arrival,sku,quantity` without `arrival_s`",
    ),
    (
        "order;arrival_s;sku;quantity\n",
        ", line 1: expected a header with the columns order,arrival_s,sku,quantity, "
        "found `order;arrival_s;sku;quantity` without `order`",
    ),
    # a row too short, and one too long
    (ORDERS + "1,0,a\n", ", line 2: expected 4 fields as in the header, found 3"),
    (ORDERS + "1,0,a,1\n1,0,b,1,\n", ", line 3: expected 4 fields as in the header, found 5"),
    # quantities
    (ORDERS + "1,0,a,0\n", ', line 2, quantity: expected a whole number >= 1, found "0"'),
    (ORDERS + "1,0,a,1.5\n", ', line 2, quantity: expected a whole number >= 1, found "1.5"'),
    (ORDERS + "1,0,a,\n", ', line 2, quantity: expected a whole number >= 1, found ""'),
    (ORDERS + "1,0,a,1_0\n", ', line 2, quantity: expected a whole number >= 1, found "1_0"'),
    # times
    (ORDERS + "1,-1,a,1\n", ', line 2, arrival_s: expected a number of seconds >= 0, found "-1"'),
    (ORDERS + "1,nan,a,1\n", ', line 2, arrival_s: expected a number of seconds >= 0, found "nan"'),
    (ORDERS + "1,08:30,a,1\n", ', line 2, arrival_s: expected a number of seconds >= 0, found "08:30"'),
    (
        ORDERS + "1,2.5,a,1\n2,0,a,1\n1,3,b,1\n",
        ", line 4, arrival_s: expected 2.5 as in the first row of order 1, found 3",
    ),
    # names
    (ORDERS + " ,0,a,1\n", ", line 2, order: expected a name, found nothing"),
    (ORDERS + "1,0,,1\n", ", line 2, sku: expected a name, found nothing"),
    # an open quote
    (ORDERS + '1,0,"a,1\n', ", line 2: this is no valid CSV: unexpected end of data"),
]


def read(tmp_path: Path, orders: str = ORDERS, pods: str = PODS) -> Instance:
    """Write two files and read them."""
    (tmp_path / "orders.csv").write_bytes(orders.encode())
    (tmp_path / "pods.csv").write_bytes(pods.encode())
    return read_instance(tmp_path / "orders.csv", tmp_path / "pods.csv")


@pytest.mark.parametrize(("orders", "message"), BAD_ORDERS)
def test_a_mistake_in_the_orders_is_one_sentence(orders: str, message: str, tmp_path: Path) -> None:
    """A wrong row is refused with file, line, column, what was found and what would be right."""
    with pytest.raises(InputError) as caught:
        read(tmp_path, orders=orders)
    assert str(caught.value) == f"{tmp_path / 'orders.csv'}{message}"


@pytest.mark.parametrize(
    ("pods", "message"),
    [
        (
            "pod,sku\n",
            ", line 1: expected a header with the columns pod,sku,quantity, found `pod,sku` without `quantity`",
        ),
        (
            PODS + "1,a,x\n",
            ', line 2, quantity: expected a whole number >= 1, or nothing for an unlimited number, found "x"',
        ),
        (PODS + "1,,3\n", ", line 2, sku: expected a name, found nothing"),
    ],
)
def test_a_mistake_in_the_pods_is_one_sentence(pods: str, message: str, tmp_path: Path) -> None:
    """The same for the pods file."""
    with pytest.raises(InputError) as caught:
        read(tmp_path, pods=pods)
    assert str(caught.value) == f"{tmp_path / 'pods.csv'}{message}"


def test_orders_are_sorted_by_arrival(tmp_path: Path) -> None:
    """Ids follow the arrival, then the first appearance; rows of an order need not be adjacent."""
    orders = ORDERS + "late,9.5,b,1\nx,0,a,1\nearly,0,a,2\nlate,9.5,a,1\nx,0,b,3\n"
    instance = read(tmp_path, orders)
    assert instance.skus == ("a", "b")
    assert instance.orders == (
        OrderData("x", 0, ((0, 1), (1, 3))),
        OrderData("early", 0, ((0, 2),)),
        OrderData("late", 9500, ((1, 1), (0, 1))),
    )


def test_repeated_skus_are_merged(tmp_path: Path) -> None:
    """A SKU twice in an order or on a pod counts once with both quantities; unlimited swallows any number."""
    instance = read(tmp_path, ORDERS + "1,0,a,1\n1,0,a,2\n", PODS + "p,a,1\np,a,2\nq,a,\nq,a,2\nr,a,2\nr,a,\n")
    assert instance.orders[0].lines == ((0, 3),)
    assert instance.pods == (PodData("p", ((0, 3),)), PodData("q", ((0, None),)), PodData("r", ((0, None),)))


def test_skus_are_in_natural_order(tmp_path: Path) -> None:
    """Numbers in SKU names count as numbers, wherever a SKU comes first."""
    instance = read(tmp_path, ORDERS + "1,0,A10,1\n1,0,A9,1\n", PODS + "1,10,\n1,9,\n1,A,\n")
    assert instance.skus == ("9", "10", "A", "A9", "A10")


def test_exports_of_other_programs_are_read(tmp_path: Path) -> None:
    """A byte order mark, line ends of Windows, columns in any order, further columns, spaces, empty lines: all fine."""
    orders = '\ufeffsku,customer, quantity ,order,arrival_s\r\n"mug, red",North, 2 ,1,1e1\r\n\r\n'
    instance = read(tmp_path, orders)
    assert instance.skus == ("mug, red",)
    assert instance.orders == (OrderData("1", 10_000, ((0, 2),)),)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    """A file that is not there is one sentence too."""
    with pytest.raises(InputError, match=r"orders\.csv: cannot be read: No such file or directory$"):
        read_instance(tmp_path / "orders.csv", tmp_path / "pods.csv")


def test_another_encoding_is_refused(tmp_path: Path) -> None:
    """A file that is no UTF-8 is refused with the byte that says so."""
    (tmp_path / "orders.csv").write_bytes(ORDERS.encode() + b"1,0,gr\xfcn,1\n")
    with pytest.raises(InputError, match=r"orders\.csv: expected UTF-8 text, found the byte 0xfc$"):
        read_instance(tmp_path / "orders.csv", tmp_path / "pods.csv")
