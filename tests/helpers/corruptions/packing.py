from corruptions.raw import NotThereError, Raw, changed, kind, missaid, others, scenario_says, shifted

BOUND, SENT, COME, PUT = "packing_assigned", "part_sent", "part_arrived", "part_put"
TOGETHER, BEGUN, PACKED = "order_consolidated", "packing_started", "order_packed"
for _name, _event in (
    ("choice of a packing station", BOUND),
    ("sending of a part", SENT),
    ("arrival of a part", COME),
    ("putting of a part", PUT),
    ("consolidation", TOGETHER),
    ("beginning to pack", BEGUN),
    ("packing", PACKED),
):
    missaid(f"a {_name}", _event)
    others(_event, packing=f"a {_name} elsewhere", order=f"a {_name} of another order")
    if _event != BOUND:
        shifted(_event, -1, tick=f"a {_name} a tick early")
for _name, _event in (("sent", SENT), ("come", COME), ("put", PUT)):
    shifted(_event, 1, items=f"a part {_name} with an item more", tote=f"a part {_name} in another tote")
others(SENT, station="a part sent by another station")
shifted(PUT, 1, start_tick="a part put a tick faster")
shifted(PACKED, 1, start_tick="an order packed a tick faster")
changed("a box for an order that is not split", BOUND, lambda _: {"box": 1}, lambda line: line["box"] is None)
changed("a split order without a box", BOUND, lambda _: {"box": None}, lambda line: line["box"] is not None)
changed("a box that there is not", BOUND, lambda _: {"box": 99}, lambda line: line["box"] is not None)
for _key in ("tote_s", "put_s", "pack_s", "pack_item_s", "conveyor_s"):
    scenario_says(f"another {_key} of packing", "packing", _key, lambda value: value + 1)
scenario_says("fewer packers", "packing", "packers", lambda _: 0)
scenario_says("fewer boxes", "packing", "boxes", lambda value: value - 1)


@kind
def a_box_that_two_orders_have(raw: Raw) -> None:
    taken = []
    for line in raw.events:
        if line["e"] == BOUND and line["box"] is not None:
            other = [one for one in taken if one["packing"] == line["packing"]]
            if other:
                line["box"] = other[-1]["box"]
                return
            taken.append(line)
        elif line["e"] == PACKED:
            taken = [one for one in taken if one["order"] != line["order"]]
    raise NotThereError


@kind
def an_order_packed_before_its_last_part(raw: Raw) -> None:
    order = raw.one(TOGETHER)["order"]
    last = raw.places(PUT, lambda line: line["order"] == order)[-1]
    begun = raw.place(BEGUN, lambda line: line["order"] == order)
    raw.move(begun, last)


@kind
def another_packer_at_work(raw: Raw) -> None:
    """As many begin to pack at once as there are, and one more."""
    begun = raw.place(BEGUN, lambda line: raw.scenario["packing"]["packers"] == 1)
    order, packing = raw.events[begun]["order"], raw.events[begun]["packing"]
    other = raw.following(begun, BEGUN, lambda line: line["order"] != order and line["packing"] == packing)
    raw.move(other, begun + 1)
    moved = raw.events[begun + 1]
    done = raw.one(PACKED, lambda line: line["order"] == moved["order"])
    ticks = done["tick"] - done["start_tick"]
    done["start_tick"] = moved["tick"]
    done["tick"] = moved["tick"] + ticks
    raw.events.sort(key=lambda line: line["tick"])
