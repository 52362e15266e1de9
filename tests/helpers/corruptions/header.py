"""Corruptions of the header: layout, positions, orders, pods, stations, scenario."""

from corruptions.raw import STEPS, Line, NotThereError, Raw, add, kind, made, next_of, scenario_says, some

# The header: the layout


@kind
def a_one_way_cell_opened(raw: Raw) -> None:
    floor = raw.cells("1")
    for cell in floor:
        for heading, (right, _) in enumerate(STEPS):
            inside = 0 <= cell % raw.width + right < raw.width and cell + raw.step(heading) in floor
            if inside and not raw.moves(cell) >> heading & 1:
                raw.set_sign("moves", cell, f"{raw.moves(cell) | 1 << heading:x}")
                return
    raise NotThereError


@kind
def a_cell_closed_where_nobody_drives(raw: Raw) -> None:
    cell = next_of([cell for cell in raw.cells("1") if raw.moves(cell) and cell not in raw.visited()])
    raw.set_sign("moves", cell, f"{raw.moves(cell) & (raw.moves(cell) - 1):x}")


made("floor instead of storage", lambda raw: raw.set_sign("kind", raw.free_location, "1"))


@kind
def floor_in_place_of_storage_with_an_empty_pod(raw: Raw) -> None:
    raw.set_sign("kind", next_of(raw.header["blocked"]), "1")
    del raw.header["blocked"][0]


made(
    "storage instead of floor",
    lambda raw: raw.set_sign("kind", next_of([cell for cell in raw.cells("1") if cell not in raw.visited()]), "2"),
)
made("a wall instead of storage", lambda raw: raw.set_sign("kind", raw.free_location, "0"))


def long_queue(raw: Raw, station: int) -> list[int]:
    queue: list[int] = raw.header["layout"]["stations"][station]["queue"]
    some(queue[1:])
    return queue


made("a queue cell less", lambda raw: long_queue(raw, 0).pop())
made("a queue the other way round", lambda raw: long_queue(raw, -1).reverse())

# The header: what stands where


@kind
def an_empty_pod_elsewhere(raw: Raw) -> None:
    some(raw.header["blocked"])[0] = raw.free_location


made("an empty pod less", lambda raw: some(raw.header["blocked"]).pop())
made("an empty pod more", lambda raw: raw.header["blocked"].append(raw.free_location))
made("an extra parked robot", lambda raw: raw.header["robots"].append({"cell": raw.free_location, "heading": 1}))
made("a robot starts elsewhere", lambda raw: raw.header["robots"][0].update(cell=raw.free_location))


@kind
def a_robot_starts_with_another_heading(raw: Raw) -> None:
    robot = raw.header["robots"][-1]
    robot["heading"] = (robot["heading"] + 1) % 4


def never_fetched(raw: Raw) -> Line:
    fetched = {line["pod"] for line in raw.events if line["e"] == "task_assigned"}
    pods = (pod for i, pod in enumerate(raw.header["pods"]) if i not in fetched and pod["robot"] is None)
    found: Line = next_of(pods)
    return found


made("a pod that is never fetched stands elsewhere", lambda raw: never_fetched(raw).update(cell=raw.free_location))
made("a pod bound for a station from the start", lambda raw: never_fetched(raw).update(bound_for=[0]))


@kind
def a_pod_more(raw: Raw) -> None:
    cell = raw.free_location
    pod = {"name": "extra", "contents": [[0, None]], "cell": cell, "robot": None, "bound_for": []}
    raw.header["pods"].append(pod)


# The header: orders, pods, stations

made("an order twice by name", lambda raw: raw.header["orders"][1].update(name=raw.header["orders"][0]["name"]))
made("an order with another name", lambda raw: raw.header["orders"][1].update(name="another"))
made("a pod twice by name", lambda raw: raw.header["pods"][1].update(name=raw.header["pods"][0]["name"]))
made("a sku twice by name", lambda raw: raw.header["skus"].__setitem__(1, raw.header["skus"][0]))
made("an order that came later", lambda raw: add(raw.header["orders"][-1], arrival=1000))
made("an order due later", lambda raw: add(next_of(one for one in raw.header["orders"] if "due" in one), due=1000))
made("an order more", lambda raw: raw.header["orders"].append({"name": "extra", "arrival": 10**9, "lines": [[0, 1]]}))
made("a larger station", lambda raw: add(raw.header["stations"][0], capacity=1))
made("a station with another name", lambda raw: raw.header["stations"][0].update(name="north"))
made("another version", lambda raw: raw.header.update(versions=dict.fromkeys(raw.header["versions"], "0.1")))
made("another tick length", lambda raw: raw.header.update(tick_s=0.002))
made("faster robots", lambda raw: add(raw.header["motion"], top_speed_m_per_s=0.5))


@kind
def an_order_that_came_a_tick_earlier(raw: Raw) -> None:
    number = next_of([i for i, order in enumerate(raw.header["orders"]) if order["arrival"] > 0])
    raw.header["orders"][number]["arrival"] -= 1
    raw.one("order_arrived", lambda line: line["order"] == number)["tick"] -= 1


@kind
def an_order_more_urgent(raw: Raw) -> None:
    order = raw.header["orders"][0]
    order["priority"] = order.get("priority", 0) + 1


@kind
def an_order_of_one_more_item(raw: Raw) -> None:
    raw.header["orders"][len(raw.header["orders"]) // 2]["lines"][0][1] += 1


@kind
def a_sku_more_on_a_pod(raw: Raw) -> None:
    for pod in raw.header["pods"]:
        for sku in range(len(raw.header["skus"])):
            if all(held != sku for held, _ in pod["contents"]):
                pod["contents"].append([sku, 3])
                return
    raise NotThereError


@kind
def other_stock(raw: Raw) -> None:
    contents = next_of([pod for pod in raw.header["pods"] if pod["contents"]])["contents"]
    contents[0][1] = 1000 if contents[0][1] is None else contents[0][1] + 1000


@kind
def larger_stations(raw: Raw) -> None:
    table = raw.scenario["stations"]
    name = "order_capacity" if "order_capacity" in table else "item_capacity"
    table[name] = [one + 1 for one in table[name]] if isinstance(table[name], list) else table[name] + 1
    for station in raw.header["stations"]:
        station["capacity"] += 1


@kind
def stations_that_count_otherwise(raw: Raw) -> None:
    for station in raw.header["stations"]:
        station["counts_orders"] = not station["counts_orders"]


@kind
def a_version_left_out(raw: Raw) -> None:
    del raw.header["versions"]
    an_empty_pod_elsewhere(raw)


@kind
def another_map(raw: Raw) -> None:
    raw.header["map"] = some(raw.header.get("map")).replace(".", ">", 1)


@kind
def faster_robots_in_the_scenario_too(raw: Raw) -> None:
    for table in (raw.header["motion"], raw.scenario["robots"]):
        add(table, top_speed_m_per_s=0.5)


@kind
def slower_lifts(raw: Raw) -> None:
    for table in (raw.header["motion"], raw.scenario["robots"]):
        add(table, lift_s=1.0)


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
