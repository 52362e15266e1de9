"""What the header says: layout, what stands where, orders, pods, stations, scenario."""

from __future__ import annotations

from corruptions.raw import STEPS, NotThereError, Raw, kind, next_of, scenario_says

# The header: the layout


@kind
def a_one_way_cell_opened(raw: Raw) -> None:
    """A cell may be left in one more direction, towards a neighbour that is floor."""
    floor = set(raw.cells("1"))
    for cell in sorted(floor):
        for heading, (right, down) in enumerate(STEPS):
            column = cell % raw.width + right
            inside = 0 <= column < raw.width and cell + right + down * raw.width in floor
            if inside and not raw.moves(cell) >> heading & 1:
                raw.set_sign("moves", cell, f"{raw.moves(cell) | 1 << heading:x}")
                return
    raise NotThereError


@kind
def a_cell_closed_where_nobody_drives(raw: Raw) -> None:
    """A cell may be left in one direction less."""
    cell = next_of([cell for cell in raw.cells("1") if raw.moves(cell) and cell not in raw.visited()])
    raw.set_sign("moves", cell, f"{raw.moves(cell) & (raw.moves(cell) - 1):x}")


@kind
def floor_in_place_of_storage(raw: Raw) -> None:
    """A storage location where nothing stands is floor."""
    raw.set_sign("kind", next_of(raw.free_locations()), "1")


@kind
def floor_in_place_of_storage_with_an_empty_pod(raw: Raw) -> None:
    """A blocked storage location is floor, and its pod is gone."""
    raw.set_sign("kind", next_of(raw.header["blocked"]), "1")
    del raw.header["blocked"][0]


@kind
def storage_in_place_of_floor(raw: Raw) -> None:
    """Floor where nobody drives is a storage location."""
    raw.set_sign("kind", next_of([cell for cell in raw.cells("1") if cell not in raw.visited()]), "2")


@kind
def a_wall_in_place_of_storage(raw: Raw) -> None:
    """A storage location where nothing stands is a wall."""
    raw.set_sign("kind", next_of(raw.free_locations()), "0")


@kind
def a_queue_cell_less(raw: Raw) -> None:
    """A station's queue ends one cell earlier."""
    queue = raw.header["layout"]["stations"][0]["queue"]
    if len(queue) < 2:
        raise NotThereError
    queue.pop()


@kind
def a_queue_the_other_way_round(raw: Raw) -> None:
    """The cell next to the station is the entry."""
    queue = raw.header["layout"]["stations"][-1]["queue"]
    if len(queue) < 2:
        raise NotThereError
    queue.reverse()


# The header: what stands where


@kind
def an_empty_pod_elsewhere(raw: Raw) -> None:
    """A blocked location is another one where nothing ever stands."""
    if not raw.header["blocked"]:
        raise NotThereError
    raw.header["blocked"][0] = next_of(raw.free_locations())


@kind
def an_empty_pod_less(raw: Raw) -> None:
    """A blocked location is free."""
    if not raw.header["blocked"]:
        raise NotThereError
    raw.header["blocked"].pop()


@kind
def an_empty_pod_more(raw: Raw) -> None:
    """A free location is blocked."""
    raw.header["blocked"].append(next_of(raw.free_locations()))


@kind
def an_extra_parked_robot(raw: Raw) -> None:
    """A robot that does nothing stands at a free location."""
    raw.header["robots"].append({"cell": next_of(raw.free_locations()), "heading": 1})


@kind
def a_robot_starts_elsewhere(raw: Raw) -> None:
    """The first robot stands somewhere else at the start."""
    raw.header["robots"][0]["cell"] = next_of(raw.free_locations())


@kind
def a_robot_starts_with_another_heading(raw: Raw) -> None:
    """The last robot faces west at the start."""
    raw.header["robots"][-1]["heading"] = (raw.header["robots"][-1]["heading"] + 1) % 4


@kind
def a_pod_that_is_never_fetched_stands_elsewhere(raw: Raw) -> None:
    """A pod that stays where it is stands at another location."""
    fetched = {line["pod"] for line in raw.events if line["e"] == "task_assigned"}
    pods = [pod for i, pod in enumerate(raw.header["pods"]) if i not in fetched and pod["robot"] is None]
    next_of(pods)["cell"] = next_of(raw.free_locations())


@kind
def a_pod_bound_for_a_station_from_the_start(raw: Raw) -> None:
    """A pod that stays where it is counts as on its way."""
    fetched = {line["pod"] for line in raw.events if line["e"] == "task_assigned"}
    next_of([pod for i, pod in enumerate(raw.header["pods"]) if i not in fetched and not pod["bound_for"]])[
        "bound_for"
    ] = [0]


@kind
def a_pod_more(raw: Raw) -> None:
    """A pod with contents stands at a free location."""
    cell = next_of(raw.free_locations())
    pod = {"name": "extra", "contents": [[0, None]], "cell": cell, "robot": None, "bound_for": []}
    raw.header["pods"].append(pod)


# The header: orders, pods, stations


@kind
def an_order_twice_by_name(raw: Raw) -> None:
    """Two orders have one name."""
    raw.header["orders"][1]["name"] = raw.header["orders"][0]["name"]


@kind
def an_order_with_another_name(raw: Raw) -> None:
    """An order has a name that nobody gave it."""
    raw.header["orders"][1]["name"] = "another"


@kind
def a_pod_twice_by_name(raw: Raw) -> None:
    """Two pods have one name."""
    raw.header["pods"][1]["name"] = raw.header["pods"][0]["name"]


@kind
def a_sku_twice_by_name(raw: Raw) -> None:
    """Two SKUs have one name."""
    raw.header["skus"][1] = raw.header["skus"][0]


@kind
def an_order_that_came_later(raw: Raw) -> None:
    """An order arrived a second later, in the header alone."""
    raw.header["orders"][-1]["arrival"] += 1000


@kind
def an_order_that_came_a_tick_earlier(raw: Raw) -> None:
    """An order arrived a tick earlier, in the header and in its event."""
    number = next_of([i for i, order in enumerate(raw.header["orders"]) if order["arrival"] > 0])
    raw.header["orders"][number]["arrival"] -= 1
    raw.one("order_arrived", lambda line: line["order"] == number)["tick"] -= 1


@kind
def an_order_due_later(raw: Raw) -> None:
    """An order has another due time."""
    next_of([order for order in raw.header["orders"] if "due" in order])["due"] += 1000


@kind
def an_order_more_urgent(raw: Raw) -> None:
    """An order has another priority."""
    order = raw.header["orders"][0]
    order["priority"] = order.get("priority", 0) + 1


@kind
def an_order_of_one_more_item(raw: Raw) -> None:
    """A line wants one item more."""
    raw.header["orders"][len(raw.header["orders"]) // 2]["lines"][0][1] += 1


@kind
def an_order_more(raw: Raw) -> None:
    """An order that never arrives."""
    raw.header["orders"].append({"name": "extra", "arrival": 10**9, "lines": [[0, 1]]})


@kind
def a_sku_more_on_a_pod(raw: Raw) -> None:
    """A pod holds what it did not hold."""
    for pod in raw.header["pods"]:
        for sku in range(len(raw.header["skus"])):
            if all(held != sku for held, _ in pod["contents"]):
                pod["contents"].append([sku, 3])
                return
    raise NotThereError


@kind
def other_stock(raw: Raw) -> None:
    """A pod holds many items where it held some, or so many as nobody can count."""
    contents = next_of([pod for pod in raw.header["pods"] if pod["contents"]])["contents"]
    contents[0][1] = 1000 if contents[0][1] is None else contents[0][1] + 1000


@kind
def a_larger_station(raw: Raw) -> None:
    """A station takes one more, in its own line of the header alone."""
    raw.header["stations"][0]["capacity"] += 1


@kind
def larger_stations(raw: Raw) -> None:
    """Each station takes one more, in the scenario, too."""
    table = raw.scenario["stations"]
    name = "order_capacity" if "order_capacity" in table else "item_capacity"
    table[name] = [one + 1 for one in table[name]] if isinstance(table[name], list) else table[name] + 1
    for station in raw.header["stations"]:
        station["capacity"] += 1


@kind
def stations_that_count_otherwise(raw: Raw) -> None:
    """Stations count orders in place of items, or the other way round."""
    for station in raw.header["stations"]:
        station["counts_orders"] = not station["counts_orders"]


@kind
def a_station_with_another_name(raw: Raw) -> None:
    """A station is called otherwise."""
    raw.header["stations"][0]["name"] = "north"


@kind
def another_version(raw: Raw) -> None:
    """The run was recorded by another version, so that nothing can be made anew."""
    raw.header["versions"] = dict.fromkeys(raw.header["versions"], "0.1")


@kind
def a_version_left_out(raw: Raw) -> None:
    """Nobody says which version recorded the run, and something stands elsewhere."""
    del raw.header["versions"]
    an_empty_pod_elsewhere(raw)


@kind
def another_map(raw: Raw) -> None:
    """The text of the map has another sign."""
    if "map" not in raw.header:
        raise NotThereError
    raw.header["map"] = raw.header["map"].replace(".", ">", 1)


@kind
def another_tick_length(raw: Raw) -> None:
    """A tick is two milliseconds."""
    raw.header["tick_s"] = 0.002


@kind
def faster_robots(raw: Raw) -> None:
    """Robots are faster, in the kinematics alone."""
    raw.header["motion"]["top_speed_m_per_s"] += 0.5


@kind
def faster_robots_in_the_scenario_too(raw: Raw) -> None:
    """Robots are faster, and the scenario says so."""
    raw.header["motion"]["top_speed_m_per_s"] += 0.5
    raw.scenario["robots"]["top_speed_m_per_s"] += 0.5


@kind
def slower_lifts(raw: Raw) -> None:
    """Lifting takes longer, and the scenario says so."""
    raw.header["motion"]["lift_s"] += 1.0
    raw.scenario["robots"]["lift_s"] += 1.0


# The header: the scenario

scenario_says("another seed", "", "seed", lambda value: value + 1)
scenario_says("robots count", "robots", "count", lambda value: value + 1)
scenario_says("a shorter pick", "stations", "pick_s", lambda value: value - 1)
scenario_says("a longer handling", "stations", "handle_s", lambda value: value + 1)
scenario_says("a longer queue", "stations", "queue_length", lambda value: value + 1)
scenario_says("a shorter queue", "stations", "queue_length", lambda value: value - 1)
scenario_says("other PP rule", "rules", "pp", lambda value: "sipp" if value == "free-flow" else "free-flow")
scenario_says("other PR rule", "rules", "pr", lambda value: "fixed" if value == "random" else "random")
scenario_says("other POA rule", "rules", "poa", lambda _: "random")
scenario_says("other PPS rule", "rules", "pps", lambda _: "random")
scenario_says("other joint rule", "rules", "poa_pps", lambda _: "split-among-stations")
scenario_says("a warm-up", "run", "warmup_s", lambda value: (value or 0) + 100, given=False)
scenario_says("another limit", "run", "until_s", lambda value: (value or 10**6) + 100, given=False)
scenario_says("fewer empty pods", "layout", "pod_fill", lambda value: value / 2)
scenario_says("a filter", "rules", "filters", lambda _: ["oldest"], given=False)
