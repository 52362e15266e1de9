"""Orders that pods complete, kept from call to call; test_completing.py has what orders take from each other."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Order, Pod, WarehouseView
from rmfs_rules.helpers.pod_completing import KeptCompleted
from rmfs_rules.helpers.pod_sending import KeptPods


def completes(pod: Pod, order: Order) -> bool:
    """Whether a pod has enough for all that is open of an order."""
    return all(line.sku in pod.contents and pod.free_items(line.sku) >= line.quantity for line in order.open_lines)


@settings(max_examples=60)
@given(
    st.lists(st.dictionaries(st.sampled_from("abcde"), st.integers(1, 3), min_size=1), min_size=1, max_size=12),
    st.lists(st.dictionaries(st.sampled_from("abcde"), st.integers(1, 5), min_size=1), min_size=1, max_size=5),
    st.booleans(),
    st.data(),
)
def test_numbers_are_those_of_a_look_at_each_pod_and_order(
    orders: list[dict[str, int]], pods: list[dict[str, int]], finite: bool, data: st.DataObject
) -> None:
    """Whatever leaves the backlog, in part or at once, and whatever becomes of what the pods have free."""
    named = {str(i): order for i, order in enumerate(orders)}
    held = {str(i): pod if finite else list(pod) for i, pod in enumerate(pods)}
    world = small_world(named, {**held, "rest": dict.fromkeys("abcde", 99) if finite else list("abcde")})  # type: ignore[arg-type]
    view, kept, pods_now = WarehouseView(world), KeptCompleted(), KeptPods()
    for _ in range(4):
        pods_now.update(view)
        plain = [sum(completes(pod, order) for order in view.backlog) for pod in view.pods]
        assert kept.alone(view, pods_now).tolist() == plain
        for order in data.draw(st.lists(st.sampled_from(view.backlog), max_size=3)) if view.backlog else ():
            skus = [line.sku for line in order.open_lines]
            if skus:
                world.assign(
                    order, world.stations[0], data.draw(st.lists(st.sampled_from(skus), min_size=1, unique=True))
                )
        for pod in data.draw(st.lists(st.sampled_from(world.pods), max_size=2, unique=True)):
            if not pod.bound_for:
                world.bind(pod, world.stations[0])


def test_another_warehouse() -> None:
    """What was known of one is forgotten in the next."""
    kept, pods_now = KeptCompleted(), KeptPods()
    for number in (300, 2):
        view = WarehouseView(small_world({str(i): ["a"] for i in range(number)}, {"p": ["a"], "q": ["b"]}))
        pods_now.update(view)
        assert kept.alone(view, pods_now).tolist() == [number, 0]
