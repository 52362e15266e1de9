from corruptions.raw import Line, NotThereError, Raw, changed, doubled, dropped, kind, made

ARRIVED, ASSIGNED, BOUND, STORED = "bundle_arrived", "bundle_assigned", "bundle_bound", "bundle_stored"
for _name, _event in (("arrival", ARRIVED), ("assignment", ASSIGNED), ("choice of a pod", BOUND), ("storing", STORED)):
    dropped(f"a bundle's {_name} dropped", _event)
    dropped(f"the last bundle's {_name} dropped", _event, at=0.99)
    doubled(f"a bundle's {_name} twice", _event)
    changed(f"the {_name} of another bundle", _event, lambda line: {"bundle": line["bundle"] ^ 1})
changed("a bundle that comes a tick later", ARRIVED, lambda line: {"tick": line["tick"] + 1})
changed("a bundle of another sku comes", ARRIVED, lambda line: {"sku": line["sku"] ^ 1})
changed("a bundle with an item more comes", ARRIVED, lambda line: {"items": line["items"] + 1})
changed("a bundle for another station", ASSIGNED, lambda line: {"station": line["station"] ^ 1})
changed("a bundle for another pod", BOUND, lambda line: {"pod": line["pod"] ^ 1})
changed("a bundle stored on another pod", STORED, lambda line: {"pod": line["pod"] ^ 1})
changed("a bundle stored at another station", STORED, lambda line: {"station": line["station"] ^ 1})
changed("a bundle stored in another visit", STORED, lambda line: {"visit": line["visit"] + 1})
changed("a bundle stored a tick faster", STORED, lambda line: {"start_tick": line["start_tick"] + 1})
changed("an item lost in storing", STORED, lambda line: {"items": line["items"] - 1})
changed("another sku stored", STORED, lambda line: {"sku": line["sku"] ^ 1})


@kind
def a_bundle_before_it_is_a_bundle(raw: Raw) -> None:
    i = raw.place(ASSIGNED)
    bundle = raw.events[i]["bundle"]
    raw.move(i, next(at for at, line in enumerate(raw.events) if line["e"] == ARRIVED and line["bundle"] == bundle))


def _with(table: Line, key: str) -> Line:
    if key not in table:
        raise NotThereError(key)
    return table


@kind
def levels_that_are_others(raw: Raw) -> None:
    _with(raw.header, "levels")["levels"][0][0] += 1


made(
    "a station that holds a bundle more",
    lambda raw: _with(raw.header["stations"][-1], "bundle_capacity").update(
        bundle_capacity=_with(raw.header["stations"][-1], "bundle_capacity")["bundle_capacity"] + 1
    ),
)


@kind
def a_replenishment_station_for_picking(raw: Raw) -> None:
    del _with(raw.header["layout"], "replenishing")["replenishing"]


IN_STOCK = "order_in_stock"
dropped("an order that is not said to be in stock", IN_STOCK)
dropped("the last order that is not said to be in stock", IN_STOCK, at=0.99)
doubled("an order that is in stock twice", IN_STOCK)
changed("another order that is in stock", IN_STOCK, lambda line: {"order": line["order"] ^ 1})
changed("an order in stock a tick later", IN_STOCK, lambda line: {"tick": line["tick"] + 1})


@kind
def an_order_in_stock_before_its_bundle_is_stored(raw: Raw) -> None:
    i = raw.place(IN_STOCK)
    raw.move(i, raw.preceding(i, STORED))


@kind
def an_order_in_stock_after_it_was_assigned(raw: Raw) -> None:
    i = raw.place(IN_STOCK)
    order = raw.events[i]["order"]
    raw.move(i, raw.following(i, "order_assigned", lambda line: line["order"] == order) + 1)


@kind
def an_order_assigned_that_waits(raw: Raw) -> None:
    i = raw.place(IN_STOCK)
    order = raw.events[i]["order"]
    to = raw.following(raw.place("order_arrived", lambda line: line["order"] == order), "decision_made")
    raw.move(raw.following(i, "order_assigned", lambda line: line["order"] == order), to)


@kind
def orders_that_do_not_wait(raw: Raw) -> None:
    raw.place(IN_STOCK)
    raw.scenario["rules"]["wait_for_stock"] = False
