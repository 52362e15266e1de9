from corruptions.raw import Raw, add, kind, made, missaid, others, shifted, some, too_early, too_late

ARRIVED, ASSIGNED, BOUND, STORED = "bundle_arrived", "bundle_assigned", "bundle_bound", "bundle_stored"
for _name, _event in (("arrival", ARRIVED), ("assignment", ASSIGNED), ("choice of a pod", BOUND), ("storing", STORED)):
    missaid(f"a bundle's {_name}", _event)
    others(_event, bundle=f"the {_name} of another bundle")
shifted(ARRIVED, 1, tick="a bundle that comes a tick later", items="a bundle with an item more comes")
others(ARRIVED, sku="a bundle of another sku comes")
others(ASSIGNED, station="a bundle for another station")
others(BOUND, pod="a bundle for another pod")
others(STORED, pod="a bundle stored on another pod", station="a bundle stored at another station")
others(STORED, sku="another sku stored")
shifted(STORED, 1, visit="a bundle stored in another visit", start_tick="a bundle stored a tick faster")
shifted(STORED, -1, items="an item lost in storing")
too_early("a bundle before it is a bundle", ASSIGNED, ARRIVED, "bundle")


@kind
def levels_that_are_others(raw: Raw) -> None:
    some(raw.header.get("levels"))[0][0] += 1


@kind
def a_station_that_holds_a_bundle_more(raw: Raw) -> None:
    some(raw.header["stations"][-1].get("bundle_capacity"))
    add(raw.header["stations"][-1], bundle_capacity=1)


made("a replenishment station for picking", lambda raw: some(raw.header["layout"].pop("replenishing", None)))

IN_STOCK = "order_in_stock"
missaid("an order in stock", IN_STOCK)
others(IN_STOCK, order="another order that is in stock")
shifted(IN_STOCK, 1, tick="an order in stock a tick later")
too_early("an order in stock before its bundle is stored", IN_STOCK, STORED)
too_late("an order in stock after it was assigned", IN_STOCK, "order_assigned", "order")


@kind
def an_order_assigned_that_waits(raw: Raw) -> None:
    i = raw.place(IN_STOCK)
    same = raw.alike(i, "order")
    to = raw.following(raw.place("order_arrived", same), "decision_made")
    raw.move(raw.following(i, "order_assigned", same), to)


@kind
def orders_that_do_not_wait(raw: Raw) -> None:
    raw.place(IN_STOCK)
    raw.scenario["rules"]["wait_for_stock"] = False
