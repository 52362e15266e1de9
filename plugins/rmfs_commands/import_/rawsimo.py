"""From the files of RAWSim-O to those of a scenario."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from rmfs_commands.import_.notes import Imported, Notes
from rmfs_commands.import_.replenishing import Deliveries, Supply, chosen_rules, levels, storable
from rmfs_commands.import_.settings import DEFAULT_SIZE, OrderList, Setting, read_order_list, read_setting, read_skus
from rmfs_commands.import_.stock import Contents, Orders, drawn_contents, drawn_orders, stock_of, stored_bundles
from rmfs_commands.import_.warehouses import Picking, Warehouse, commonest, read_instance_file, read_layout_file
from rmfs_commands.import_.xml_reading import document
from rmfs_commands.results.files import to_csv
from rmfs_core.errors import InputError
from rmfs_core.scenario.tomltext import toml_text, toml_value

RULES = {"poa": "pod-match", "pps": "demand", "pr": "nearest", "ta": "balanced"}
"""The rules that RAWSim-O and rmfs have been compared under, with `whca-n` in windows of 20 s."""


def import_rawsimo(files: Mapping[str, Path]) -> Imported:
    """Read the files of an instance.

    Parameters
    ----------
    files
        The files by the kinds of their outermost elements: ``Instance`` or ``LayoutConfiguration``, and perhaps
        ``SettingConfiguration``, ``SimpleItemGeneratorConfiguration``, ``OrderList``, ``ControlConfiguration``.

    Raises
    ------
    InputError
        When a file is wrong, or one that is needed is missing.
    """
    notes = Notes()
    if "Instance" in files and "LayoutConfiguration" in files:
        raise InputError(str(files["LayoutConfiguration"]), f"found {files['Instance']}, too; expected one warehouse")
    if "Instance" in files:
        warehouse = read_instance_file(files["Instance"], notes)
    elif "LayoutConfiguration" in files:
        warehouse = read_layout_file(files["LayoutConfiguration"], notes)
    else:
        given = next(iter(files.values()))
        raise InputError(str(given), "found no warehouse; expected an .xinst or .xlayo next to it")
    if warehouse.robots > (locations := warehouse.read["storage locations"]):
        file = files.get("Instance", files.get("LayoutConfiguration"))
        raise InputError(
            str(file), f"found {warehouse.robots:,} bots; expected at most one a storage location, {locations:,}"
        )
    has_setting = "SettingConfiguration" in files
    refilled = bool(warehouse.storing)
    setting = read_setting(files["SettingConfiguration"], notes, refilled=refilled) if has_setting else None
    contents, orders, supply = _stock(files, warehouse, setting, notes)
    configuration = document(files["ControlConfiguration"]) if "ControlConfiguration" in files else None
    if configuration is not None:
        what = "configuration of controllers (.xconf)" + (", except for replenishment" if supply else "")
        notes.add(what, 1, "pod-match, demand, nearest, balanced and whca-n")
    written = {} if warehouse.text_map is None else {"map.txt": warehouse.text_map}
    if warehouse.robot_places:
        written["robots.csv"] = _places(warehouse.robot_places)
    read = dict(warehouse.read)
    if orders:
        empty = sum(not pod for pod in contents) if supply is None else 0
        notes.add("pods without contents", empty, "pods that stand in the way")
        read |= {"orders": len(orders), "order lines": sum(len(lines) for _, lines in orders)}
        read["SKUs on pods"] = sum(map(len, contents))
        written["pods.csv"] = _pods(warehouse, contents, orders[0][1][0][0], refilled=supply is not None)
        written["orders.csv"] = _orders(orders)
        written |= supply.files() if supply else {}
    else:
        notes.add("pods whose contents no file says", len(warehouse.pods), "random contents and locations")
    idle = 0 if supply else len(warehouse.storing)
    notes.add("input stations without bundles", idle, "stations at which nothing is stored")
    fills = setting is not None and setting.mode == "Fill" and "OrderList" not in files
    backlog = setting.backlog if setting is not None and fills else None
    tables = _tables(warehouse, setting, bool(orders), backlog, notes)
    if supply:
        tables["instance"] |= supply.instance_keys(warehouse.pod_capacity, contents, notes)
        tables["stations"] |= supply.station_keys(warehouse.storing, notes)
        tables["rules"] |= chosen_rules(configuration, notes)
    written["scenario.toml"] = _scenario(warehouse.name, setting.seed if setting else 1, tables)
    return Imported("RAWSim-O", read, dict(sorted(written.items())), "run {}/scenario.toml", notes)


def _stock(
    files: Mapping[str, Path], warehouse: Warehouse, setting: Setting | None, notes: Notes
) -> tuple[Contents, Orders, Supply | None]:
    """Return what is on pods, what is ordered, and what refills pods; nothing where no file says."""
    inputs, capacity = len(warehouse.storing), warehouse.pod_capacity
    if "OrderList" in files or (setting is not None and setting.mode == "Fixed"):
        listed = read_order_list(_referred("OrderList", files, setting), notes)
        if not warehouse.pods:
            raise InputError(str(files.get("Instance", files.get("LayoutConfiguration"))), "found orders, but no pod")
        contents, coming = stored_bundles(listed, capacity, notes, later=inputs > 0)
        weights = {sku: listed.weights.get(sku, DEFAULT_SIZE) for sku in _named(listed)}
        supply = Supply(weights, max(items for _, _, items in coming), coming) if coming else None
        return contents, listed.orders, supply
    kind = "SimpleItemGeneratorConfiguration"
    if setting is None or not warehouse.pods:
        if kind in files:
            raise InputError(str(files[kind]), "found SKUs, but no setting of orders; expected an .xsett and pods")
        return [], [], None
    file = _referred(kind, files, setting)
    skus = read_skus(file, setting.weight, setting.bundle, notes)
    skus = storable(skus, capacity, str(file), notes) if inputs else skus
    contents = drawn_contents(setting, skus, capacity, str(file))
    stock = stock_of(contents)
    supply = deliveries = None
    if inputs and setting.mode == "Fill":
        supply = levels(setting, skus, sum(capacity), stock, notes)
    elif inputs:
        deliveries = Deliveries(setting, skus, inputs, sum(capacity), stock)
    items_per_s = sum(1 / station.handle_s for station in warehouse.picking)
    limit = None if supply else stock
    orders = drawn_orders(setting, skus, limit, len(warehouse.picking), items_per_s, notes, deliveries)
    if deliveries is not None and deliveries.bundles:
        supply = deliveries.supply()
    if not orders:
        raise InputError(str(file), "found no order that the pods' stock and the time of the run allow; expected more")
    notes.add("contents of pods that RAWSim-O draws at the start", len(contents), "drawn here, by the setting's seed")
    return contents, orders, supply


def _named(listed: OrderList) -> list[str]:
    """Return the SKUs of a list, of which orders, bundles or weights tell."""
    ordered = (sku for _, lines in listed.orders for sku, _ in lines)
    return list(dict.fromkeys([*listed.weights, *(sku for _, sku, _ in listed.bundles), *ordered]))


def _referred(kind: str, files: Mapping[str, Path], setting: Setting | None) -> Path:
    """Return a file that was given, or else the one that a setting names: next to it, or in a folder of resources."""
    if kind in files:
        return files[kind]
    assert setting is not None
    file = files["SettingConfiguration"]
    if setting.refers_to is None:
        raise InputError(str(file), "names no file of SKUs or orders; expected an .xgenc or .xitem next to it")
    name = setting.refers_to.replace("\\", "/").rpartition("/")[2]
    for folder in (file.parent, *file.absolute().parents):
        for inner in ("", "Resources", "resources", "Material/Resources"):
            if os.path.isfile(folder / inner / name):  # noqa: PTH113 (false for a name too long, too)
                return folder / inner / name
    found = f"names {name[:80]}, which is not next to it nor in a folder `Resources`"
    raise InputError(str(file), f"{found}; expected it there")


def _places(places: Sequence[tuple[int, int]]) -> str:
    rows = [{"robot": i, "row": row, "column": column} for i, (row, column) in enumerate(places, 1)]
    return to_csv(("robot", "row", "column"), rows)


def _pods(warehouse: Warehouse, contents: Contents, any_sku: str, *, refilled: bool) -> str:
    places: Sequence[tuple[int, int] | None] = warehouse.places or [None] * len(warehouse.pods)
    columns = ("pod", "sku", "quantity", *(("row", "column") if warehouse.places else ()))
    rows: list[dict[str, object]] = []
    for name, pod, place in zip(warehouse.pods, contents, places, strict=True):
        row, column = place or (None, None)
        held = pod or ({any_sku: 0} if place or refilled else {})  # without items it is there all the same
        rows += [{"pod": name, "sku": sku, "quantity": held[sku], "row": row, "column": column} for sku in held]
    return to_csv(columns, rows)


def _orders(orders: Orders) -> str:
    rows = [
        {"order": f"o{i}", "arrival_s": _number(arrival), "sku": sku, "quantity": items}
        for i, (arrival, lines) in enumerate(orders, 1)
        for sku, items in lines
    ]
    return to_csv(("order", "arrival_s", "sku", "quantity"), rows)


def _number(value: float) -> float | int:
    """Return a number to milliseconds, whole where it is."""
    rounded = round(value, 3)
    return int(rounded) if rounded == int(rounded) else rounded


def _tables(
    warehouse: Warehouse, setting: Setting | None, with_orders: bool, backlog: int | None, notes: Notes
) -> dict[str, dict[str, object]]:
    """Return the sections of the scenario."""
    moving, layout = warehouse.moving, warehouse.layout
    if warehouse.text_map is not None:
        locations = warehouse.text_map.count("#")
        layout = {**layout, "pod_fill": max(int(len(warehouse.pods) / locations * 10_000), 1) / 10_000}
    instance: dict[str, object] = {"orders_file": "orders.csv", "pods_file": "pods.csv"}
    if with_orders and backlog is not None:
        instance["arrivals"] = {"process": "refill", "backlog": backlog}
    if not with_orders:
        instance = {"pods": max(1, len(warehouse.pods))}
    robots: dict[str, object] = {"count": warehouse.robots}
    if warehouse.robot_places:
        robots["file"] = "robots.csv"
    robots |= {
        "acceleration_m_per_s2": moving.acceleration,
        "top_speed_m_per_s": moving.speed,
        "full_turn_s": moving.full_turn_s,
        "lift_s": moving.lift_s,
    }
    tables: dict[str, dict[str, object]] = {
        "instance": instance,
        "layout": layout,
        "robots": robots,
        "stations": _stations(warehouse.picking, warehouse.queue_length, notes),
        "rules": {**RULES, "pp": {"rule": "whca-n", "window_s": 20}},
    }
    if setting is not None:
        tables["run"] = {"until_s": _number(setting.until_s)}
        if setting.warmup_s:
            tables["run"]["warmup_s"] = _number(setting.warmup_s)
    return tables


def _scenario(warehouse: str, seed: int, tables: Mapping[str, Mapping[str, object]]) -> str:
    lines = [f"# {_comment(warehouse)}, imported from RAWSim-O.", "", f"seed = {seed}"]
    for name, table in tables.items():
        lines += ["", f"[{name}]", *(f"{key} = {toml_value(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"


def _stations(picking: Sequence[Picking], queue_length: int | None, notes: Notes) -> dict[str, object]:
    usual = commonest((station.handle_s, station.pick_s) for station in picking)
    others = sum((station.handle_s, station.pick_s) != usual for station in picking)
    notes.add("output stations that pick slower or quicker than most", others, "as most")
    orders = [station.orders for station in picking]
    section: dict[str, object] = {"order_capacity": orders[0] if len(set(orders)) == 1 else orders}
    if queue_length is not None:
        section["queue_length"] = queue_length
    return section | {"pick_s": usual[1], "handle_s": usual[0], "release": "handled"}


def _comment(name: str) -> str:
    """Return a name as it may stand in a comment."""
    return toml_text(name)[1:-1]
