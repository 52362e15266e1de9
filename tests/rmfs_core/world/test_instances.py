"""The data that a run starts from, held against the scenario that they shall run in."""

import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from attrs import evolve

from cases import cases
from rmfs_core import run
from rmfs_core.errors import InputError
from rmfs_core.scenario import load_scenario
from rmfs_core.world import Instance, PodData, make_instance
from saying import said


@cases(
    "contents unlimited",
    ([((0, None), (1, None)), ((2, None),)], True),
    ([((0, None), (1, 3)), ((2, None),)], False),  # a single number is enough
    ([((0, 0),)], False),  # none left is a number, too
    ([()], True),
)
def test_stock_is_unlimited_where_no_pod_has_a_number(contents, unlimited) -> None:
    pods = tuple(PodData(str(i), held) for i, held in enumerate(contents))
    assert Instance(("a", "b", "c"), (), pods).unlimited_stock is unlimited


SCENARIO = """\
[instance]
orders_file = "orders.csv"
pods_file = "pods.csv"
pods_at_stations = {at}
[stations]
item_capacity = [2, 3, 2, 1]
oversize = "refuse"
[rules]
poa = "pod-match"
pps = "demand"
"""
SERVED = " (`rmfs convert orders --in-stock` leaves out what stock cannot serve)"
WRONG = [
    (
        "1,0,a,1\n2,0,a,1\n2,0,b,1\n",
        "p,a,\n",
        "{}",
        "{orders}, line 4: order 2 wants SKU b, which is on no pod" + SERVED,
    ),
    (
        "1,0,a,2\n2,0,a,2\n",
        "p,a,1\nq,a,2\n",
        "{}",
        "{orders}, line 3: from order 2 on, the orders want more than all pods hold: SKU a (4 wanted, 3 there); "
        "expected more items on pods, or `instance.replenishment`" + SERVED,
    ),
    (
        "1,0,a,3\n2,0,a,4\n",
        "p,a,\n",
        "{}",
        "{orders}, line 3: order 2 has 4 items, more than any station takes at a time (3); "
        'expected a larger `stations.item_capacity` or `stations.oversize` = "alone"',
    ),
    (
        "1,0,a,1\n",
        "pod1,a,\n",
        '{ 1 = ["pod2"] }',
        "{file}, line 4, instance.pods_at_stations.1: there is no pod pod2 with contents (did you mean `pod1`?)",
    ),
    (
        "1,0,a,1\n",
        "p,a,\n",
        '{ 1 = ["p"], 2 = ["p"] }',
        "{file}, line 4, instance.pods_at_stations.2: pod p already stands at station 1",
    ),
]


def write(folder: Path, orders: str, pods: str, at: str = "{}") -> Path:
    (folder / "orders.csv").write_text("order,arrival_s,sku,quantity\n" + orders, encoding="utf-8")
    (folder / "pods.csv").write_text("pod,sku,quantity\n" + pods, encoding="utf-8")
    file = folder / "scenario.toml"
    file.write_text(SCENARIO.replace("{at}", at), encoding="utf-8")
    return file


@pytest.mark.parametrize(("orders", "pods", "at", "message"), WRONG)
def test_what_cannot_be_run_is_refused(orders: str, pods: str, at: str, message: str, tmp_path: Path) -> None:
    file = write(tmp_path, orders, pods, at)
    expected = message.replace("{orders}", str(tmp_path / "orders.csv")).replace("{file}", str(file))
    assert said(InputError, make_instance, load_scenario(file)) == expected


def test_unlimited_stock_on_one_pod_is_enough(tmp_path: Path) -> None:
    instance = make_instance(load_scenario(write(tmp_path, "1,0,a,3\n2,0,a,3\n", "p,a,1\nq,a,\n", '{ 2 = ["q"] }')))
    assert len(instance.orders) == 2


@pytest.mark.parametrize("setting", ["stations.order_capacity=2", "stations.oversize=alone"])
def test_orders_of_any_size_where_orders_are_counted_or_large_ones_go_alone(tmp_path: Path, setting: str) -> None:
    assert make_instance(load_scenario(write(tmp_path, "1,0,a,9\n", "p,a,\n"), [setting])).orders[0].items == 9
    assert load_scenario("paper-250").stations.oversize == "alone"


def test_generated_orders_that_are_too_large_say_what_to_change() -> None:
    scenario = load_scenario("paper-250", ["stations.item_capacity=2", "stations.oversize=refuse"])
    assert said(InputError, make_instance, scenario).endswith(
        "more, more than any station takes at a time (2); expected a smaller `instance.max_lines`, "
        'a larger `stations.item_capacity` or `stations.oversize` = "alone"'
    )


def test_example_2_is_the_papers() -> None:
    scenario = load_scenario("examples/example-2-sequential")
    instance = make_instance(scenario)
    orders = {order.name: {instance.skus[sku] for sku, _ in order.lines} for order in instance.orders}
    pods = {pod.name: {instance.skus[sku] for sku, _ in pod.contents} for pod in instance.pods}
    assert orders == {"1": set("vab"), "2": set("xab"), "3": set("ucd"), "4": set("ycd")}
    assert pods == {"1": set("xu"), "2": set("yv"), "3": set("vab"), "4": set("ucd")}
    assert scenario.instance.pods_at_stations == {"1": ("1",), "2": ("2",)}
    assert instance.unlimited_stock


ORDERS = "order,arrival_s,sku,quantity\n1,0,a,2\n1,0,b,1\n2,172800,a,6\n"
RULES = '[rules]\npoa = "pod-match"\npps = "demand"\nroa = "first-bundle"\nrps = "emptiest-pod"\n'


def replenished(folder: Path, replenishment: str, skus: str = "", more: str = "") -> Path:
    """Write a scenario with two orders over two days, one pod with an item of a, and a replenishment process."""
    (folder / "orders.csv").write_text(ORDERS, encoding="utf-8")
    (folder / "pods.csv").write_text("pod,sku,quantity\np,a,1\n", encoding="utf-8")
    (folder / "skus.csv").write_text(skus or "sku\n", encoding="utf-8")
    files = 'orders_file = "orders.csv"\npods_file = "pods.csv"\nskus_file = "skus.csv"\n'
    text = f"{RULES}[instance]\n{files}{more}[instance.replenishment]\n{replenishment}"
    (folder / "scenario.toml").write_text(text, encoding="utf-8")
    return folder / "scenario.toml"


@cases(
    "levels skus expected",
    ("reorder_point = 9\norder_up_to = 20", "", ((9, 20), (9, 20))),
    ("reorder_point = 2\norder_up_to = 4", "", ((2, 4), (2, 4))),
    # 8 items of a and 1 of b within two days: 4 and 0.5 a day
    ('unit = "days"\nreorder_point = 2\norder_up_to = 5.1', "", ((8, 21), (1, 3))),
    ("reorder_point = 9\norder_up_to = 20", "sku,reorder_point,order_up_to\nb,1,3\nc,5,6\n", ((9, 20), (1, 3))),
)
def test_reorder_levels(tmp_path: Path, levels: str, skus: str, expected: tuple[tuple[int, int], ...]) -> None:
    file = replenished(tmp_path, f'process = "reorder-point"\n{levels}\n', skus)
    instance = make_instance(load_scenario(file))
    assert instance.levels == expected
    assert instance.restocked
    assert not instance.unlimited_stock


def test_what_a_line_above_the_reorder_point_lacks_is_ordered_when_it_comes(tmp_path: Path) -> None:
    levels = 'process = "reorder-point"\nreorder_point = 2\norder_up_to = 4\nlead_s = 60\n'
    file = replenished(tmp_path, levels, more="pod_capacity = 20\n")
    assert run(file, overrides=["layout.replenishment_west=1"], out=tmp_path / "run").status == "complete"
    lines = (tmp_path / "run" / "bundles.csv").read_text(encoding="utf-8").splitlines()[1:]
    come = Counter[tuple[str, float]]()
    for _, sku, items, arrival_s, *_ in (line.split(",") for line in lines):
        come[sku, float(arrival_s)] += int(items)
    # a: 4 - (1 - 2), since there is one, and order 1 wants two; then 4 - (4 - 6), for order 2
    assert come == {("a", 60.0): 5, ("b", 60.0): 5, ("a", 172_860.0): 6}
    at_once = load_scenario(file, ["rules.wait_for_stock=false"])  # nothing tells of a line of six, so s is 5
    assert make_instance(at_once).levels == ((5, 6), (2, 4))


@cases(
    "levels skus problem",
    ("", "sku,reorder_point,order_up_to\nb,5,3\n", "expected order_up_to > reorder_point, found 3 <= 5 for SKU b"),
    ("", "sku,reorder_point\na,20\n", "expected order_up_to > reorder_point, found 20 <= 20 for SKU a"),
    ("bundle_items = 1", "sku,order_up_to\nb,99981\n", r"found levels of about 100,001 bundles in all; expected"),
    ("bundle_items = 3", "sku,size,order_up_to\nb,20,200000\n", r"found levels of about 100,007 bundles in all"),
)
def test_levels_that_make_no_sense_are_refused(tmp_path: Path, levels: str, skus: str, problem: str) -> None:
    supply = f'process = "reorder-point"\nreorder_point = 9\norder_up_to = 20\n{levels}\n'
    with pytest.raises(InputError, match=problem):
        make_instance(load_scenario(replenished(tmp_path, supply, skus, "pod_capacity = 40\n")))


def test_orders_that_no_process_can_complete_are_refused(tmp_path: Path) -> None:
    (tmp_path / "bundles.csv").write_text("bundle,arrival_s,sku,items\nB,9,a,4\n", encoding="utf-8")
    file = replenished(tmp_path, 'process = "file"\nfile = "bundles.csv"\n')
    with pytest.raises(InputError, match=r"SKU b \(on no pod\) and SKU a \(8 wanted, 5 there\)"):
        make_instance(load_scenario(file))
    (tmp_path / "bundles.csv").write_text("bundle,arrival_s,sku,items\nB,9,a,7\nC,5,b,1\n", encoding="utf-8")
    assert [bundle.name for bundle in make_instance(load_scenario(file)).bundles] == ["C", "B"]
    file = replenished(tmp_path, 'process = "poisson"\nbundles_per_hour = 1\nbundle_items = 1\n')
    assert make_instance(load_scenario(file)).bundles == ()
    levels = 'process = "reorder-point"\nreorder_point = 1\norder_up_to = 2\n'
    file = replenished(tmp_path, levels, "sku,size\na,2\n", "pod_capacity = 11\n")
    with pytest.raises(InputError, match=r"line 4: order 2 wants 6 items of SKU a, and .* have space for 5; expected"):
        make_instance(load_scenario(file))


@cases(
    "capacity skus problem",
    (2, "sku,size\na,3\n", r"found 2; expected at least 21, the size of bundle B \(the largest of 3 that are too"),
    (4, "sku\na\n", r"found 4; expected at least 7, the size of bundle B$"),
    (8, "sku,size\na,2\n", "found 8; expected at least 14, the size of bundle B"),
    (20, "sku,size\nb,21\n", "found 20; expected at least 21, the size of bundle C"),
)
def test_what_no_pod_has_room_for_is_refused(tmp_path: Path, capacity: int, skus: str, problem: str) -> None:
    (tmp_path / "bundles.csv").write_text("bundle,arrival_s,sku,items\nB,9,a,7\nC,5,b,1\n", encoding="utf-8")
    supply = 'process = "file"\nfile = "bundles.csv"\n'
    file = replenished(tmp_path, supply, skus, f"pod_capacity = {capacity}\n")
    with pytest.raises(InputError, match=problem):
        make_instance(load_scenario(file))


SINGLES = """
import pickle
from rmfs_core.randomness import stream
from rmfs_core.world import Instance, OrderData, PodData

def singles(section, seed):
    drawn = stream(seed, "singles").integers(section.skus, size=section.orders).tolist()
    names = tuple(map(str, range(section.skus)))
    orders = tuple(OrderData(str(i), arrival_tick=0, lines=((sku, 1),)) for i, sku in enumerate(drawn))
    return Instance(names, orders, tuple(PodData(name, ((int(name), None),)) for name in names))

def paced(section, seed, *, pace_s, lines=1):
    skus = tuple((sku, 1) for sku in range(lines))
    orders = (OrderData(str(i), arrival_tick=i * 1000 * pace_s, lines=skus) for i in range(section.orders))
    return Instance(tuple("abc"), tuple(orders), (PodData("p", ((0, None), (1, None), (2, None))),))

def at_times(section, seed, *, when="always"):
    due = section.due if when == "always" else None
    return paced(section, seed, pace_s=0 if due is None else 1)

def copied(section, seed):
    copy = pickle.loads(pickle.dumps(section))
    return paced(section, seed, pace_s=int(copy.due.allowance_s))

def fails(section, seed):
    return {}[section.orders]

def fails_deep(section, seed):
    return stream(seed, 5)

def nothing(section, seed):
    return None

def ends(section, seed):
    raise SystemExit(3)

def _made(orders=(OrderData("1", arrival_tick=0, lines=((0, 1),)),), pods=(PodData("p", ((0, None),)),), skus=("A",)):
    return lambda section, seed: Instance(skus, orders, pods)

no_tuple = _made(orders=None)
early = _made((OrderData("1", arrival_tick=-50, lines=((0, 1),)),))
half = _made((OrderData("1", arrival_tick=0.5, lines=((0, 1),)),))
unsorted = _made((OrderData("1", arrival_tick=9, lines=((0, 1),)), OrderData("2", arrival_tick=3, lines=((0, 1),))))
no_sku = _made((OrderData("1", arrival_tick=0, lines=((5, 1),)),))
endless = _made((OrderData("1", arrival_tick=0, lines=((0, 10**30),)),))
too_late = _made((OrderData("1", arrival_tick=10**30, lines=((0, 1),)),))
no_items = _made((OrderData("1", arrival_tick=0, lines=((0, 0),)),))
no_lines = _made((OrderData("1", arrival_tick=0, lines=()),))
same_sku = _made((OrderData("1", arrival_tick=0, lines=((0, 1), (0, 2))),))
same_name = _made((OrderData("1", arrival_tick=0, lines=((0, 1),)),) * 2)
no_name = _made((OrderData(1, arrival_tick=0, lines=((0, 1),)),))
bad_pod = _made(pods=(PodData("p", ((0, 1.5),)),))
twice_on_pod = _made(pods=(PodData("p", ((0, None), (0, None))),))
not_on_list = _made(pods=(PodData("p", ((5, None),)),))
half_due = _made((OrderData("1", arrival_tick=0, lines=((0, 1),), due_tick=1.5),))
half_urgent = _made((OrderData("1", arrival_tick=0, lines=((0, 1),), priority=1.5),))

def beside(section, seed, *, file: "Path"):
    return paced(section, seed, pace_s=int(file.read_text()))

PathCost = str

def typed(section, seed, *, cost: "PathCost", wrong: "no type", files: "list[Path]", one: "Path | None" = None):
    assert (cost, wrong, one) == ("cheap", "w", ""), (cost, wrong, one)
    return paced(section, seed, pace_s=sum(int(file.read_text()) for file in files))
"""
NAMES = "beside typed singles paced at_times copied fails fails_deep nothing ends no_tuple early half"
NAMES += " unsorted no_sku endless too_late no_items no_lines same_sku same_name no_name bad_pod"
NAMES += " twice_on_pod not_on_list half_due half_urgent"
GENERATORS = {name: f"acme_days:{name}" for name in NAMES.split()}
WITH = "returned a wrong Instance:"
LINES = "expected (SKU id, quantity) as int of at least one SKU, each once, and quantities from 1 to 1,000,000"
CONTENTS = "expected (SKU id, items or None) as int of each SKU, each once, and at most 1,000,000,000 items"
TAKES = "besides section and seed it takes `pace_s` and `lines`"
UNREAD = (
    'generator "{}" has made this instance without reading it; expected it left out, or a generator that reads '
    "`section.{}` in each call"
)
ARRIVALS = "as orders are in order of arrival, and at most 2^53"


def test_a_scenario_names_the_generator_of_its_instance(install: Callable[..., None]) -> None:
    install("acme", GENERATORS, group="rmfs.instances", acme_days=SINGLES)
    scenario = load_scenario("examples/small", ["instance.generator=singles"])
    first, second = make_instance(scenario), make_instance(scenario.with_seed(2))
    assert {order.items for order in first.orders} == {1}
    assert len(first.orders) == scenario.instance.orders
    assert first != second
    result = run(scenario)
    assert (result.status, result.versions["acme"]) == ("complete", "1.0")
    assert "acme" not in run("examples/small", overrides=["instance.orders=1"]).versions


def test_a_generator_takes_parameters(install: Callable[..., None], tmp_path: Path) -> None:
    """Texts of the type `Path` are names of files beside the scenario, in lists, too; no others, nor empty ones."""
    install("acme", GENERATORS, group="rmfs.instances", acme_days=SINGLES)
    keys = ["instance.generator=paced", "instance.orders=3", "instance.parameters={pace_s=5, lines=2}"]
    instance = make_instance(load_scenario("examples/small", keys))
    assert [(order.arrival_tick, order.items) for order in instance.orders] == [(0, 2), (5000, 2), (10_000, 2)]
    (tmp_path / "pace.txt").write_text("7", encoding="utf-8")
    typed = "{cost='cheap', wrong='w', files=['pace.txt', 'pace.txt'], one=''}"
    for name, parameters, pace in (("beside", "{file='pace.txt'}", 7000), ("typed", typed, 14_000)):
        keys = [f"instance.generator={name}", f"instance.parameters={parameters}"]
        scenario = load_scenario("examples/small", keys)
        assert make_instance(evolve(scenario, folder=str(tmp_path))).orders[1].arrival_tick == pace
    keys = ["instance.generator=copied", "instance.orders=3", "instance.due={allowance_s=5}"]
    assert make_instance(load_scenario("examples/small", keys)).orders[-1].arrival_tick == 10_000


@cases(
    "keys place problem",
    ([], "generator", f"missing a required argument: 'pace_s'; {TAKES}"),
    (["parameters={pace=5}"], "parameters", f"missing a required argument: 'pace_s'; {TAKES}"),
    (["parameters={pace_s=5, line=1}"], "parameters", f"got an unexpected keyword argument 'line'; {TAKES}"),
    (["parameters={pace_s=5}", "due={allowance_s=60}"], "due", UNREAD.format("paced", "due")),
    (
        ["parameters={pace_s=5}", "arrivals={process='poisson', orders_per_hour=9}"],
        "arrivals",
        UNREAD.format("paced", "arrivals"),
    ),
    (["parameters={pace_s=5}", "items_per_sku=3"], "items_per_sku", UNREAD.format("paced", "items_per_sku")),
    (["generator=at_times", "parameters={when=''}", "due={allowance_s=9}"], "due", UNREAD.format("at_times", "due")),
    (["generator=", "parameters={pace_s=5}"], "parameters", "'pace_s'; besides section and seed it takes nothing"),
)
def test_what_a_generator_does_not_take_is_refused(install, keys, place, problem) -> None:
    install("acme", GENERATORS, group="rmfs.instances", acme_days=SINGLES)
    with pytest.raises(InputError) as caught:
        make_instance(load_scenario("examples/small", [f"instance.{key}" for key in ("generator=paced", *keys)]))
    assert f"instance.{place}" in caught.value.place
    assert caught.value.problem.endswith(problem)


@cases(
    "name problem",
    ("single", 'there is no generator "single" (did you mean `singles`?)'),
    ("fails", 'generator "fails" (acme 1.0) raised KeyError: 50 (AT, line 28)'),
    ("fails_deep", "line 31)"),  # not that of the kernel, in which it is raised
    ("nothing", 'generator "nothing" (acme 1.0) returned None; expected Instance'),
    ("ends", 'generator "ends" (acme 1.0) raised SystemExit: 3 (AT, line 37)'),
    ("no_tuple", f"{WITH} `orders` None; expected a tuple of OrderData"),
    ("early", f"{WITH} `arrival_tick` -50 of order 1; expected an int of at least 0, {ARRIVALS}"),
    ("half", f"{WITH} `arrival_tick` 0.5 of order 1; expected an int of at least 0, {ARRIVALS}"),
    ("unsorted", f"{WITH} `arrival_tick` 3 of order 2; expected an int of at least 9, {ARRIVALS}"),
    ("no_sku", f"{WITH} `lines` ((5, 1),) of order 1; {LINES}"),
    ("endless", f"{WITH} `lines` ((0, {10**30}),) of order 1; {LINES}"),
    ("too_late", f"{WITH} `arrival_tick` {10**30} of order 1; expected an int of at least 0, {ARRIVALS}"),
    ("no_items", f"{WITH} `lines` ((0, 0),) of order 1; {LINES}"),
    ("no_lines", f"{WITH} `lines` () of order 1; {LINES}"),
    ("same_sku", f"{WITH} `lines` ((0, 1), (0, 2)) of order 1; {LINES}"),
    ("same_name", f"{WITH} two or more orders 1; expected each name once"),
    ("no_name", f"{WITH} order 1; expected a name, a str"),
    ("bad_pod", f"{WITH} `contents` ((0, 1.5),) of pod p; {CONTENTS}"),
    ("twice_on_pod", f"{WITH} `contents` ((0, None), (0, None)) of pod p; {CONTENTS}"),
    ("not_on_list", f"{WITH} `contents` ((5, None),) of pod p; {CONTENTS}"),
    ("half_due", f"{WITH} `due_tick` 1.5 of order 1; expected None or an int"),
    ("half_urgent", f"{WITH} `priority` 1.5 of order 1; expected an int"),
)
def test_a_generator_that_cannot_be_had_is_one_sentence(install: Callable[..., None], name: str, problem: str) -> None:
    install("acme", GENERATORS, group="rmfs.instances", acme_days=SINGLES)
    scenario = load_scenario("examples/small", [f"instance.generator={name}"])
    if problem.startswith(WITH):
        problem = f'generator "{name}" (acme 1.0) {problem}'
    text = re.sub(r"\(\S*acme_days\.py,", "(AT,", said(InputError, make_instance, scenario))
    assert text == f"--set instance.generator={name}: {problem}" or (name == "fails_deep" and text.endswith(problem))
