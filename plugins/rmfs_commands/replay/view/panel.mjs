// @ts-check
// What is beside the warehouse: the run as a whole, or the thing that was clicked.

import { clockTime, duration } from "./clock.mjs";
import { bundleStatus, doing, lastOf, loadSaid, orderStatus, percent, phaseOf, plural, tell, waitsOn, why } from "./story.mjs";
import { featuresOf } from "./features.mjs";
import { ORDER } from "./world.mjs";
/** @import { Child, Row, Thing, View } from "./types.d.ts" */
/** @import { World } from "./world.mjs" */

const NEAR = 24; // entries of a history that are shown,
const BEFORE = 6; // so many of them before the last one
const OLDEST = 8;

/**
 * Make an element with children: texts and elements.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, string | number | null | (() => void)>} [attributes] null leaves one out; a function is called on an event
 * @param {Child[]} children
 */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name.slice(2), value);
    else if (value !== null) element.setAttribute(name, String(value));
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

/** @param {string} text */
const capital = (text) => text[0].toUpperCase() + text.slice(1);

/** Shows one view's run; `select` and `seek` are called when something in it is clicked. */
export class Panel {
  shown = "";

  /**
   * @param {HTMLElement} element
   * @param {{ select: (view: View, thing: Thing | null) => void, seek: (tick: number) => void }} done
   */
  constructor(element, { select, seek }) {
    this.element = element;
    this.select = select;
    this.seek = seek;
  }

  /**
   * Show a thing that is selected, or the runs.
   * @param {View[]} views
   * @param {({ view: View } & Thing) | null} selected
   */
  show(views, selected) {
    const content = selected ? this.thing(selected.view, selected) : this.overview(views);
    const key = content.map((element) => element.outerHTML).join("");
    if (key === this.shown) return; // nothing new: what has the focus keeps it
    this.shown = key;
    const focus = document.activeElement?.closest("#panel [data-key]")?.getAttribute("data-key");
    this.element.replaceChildren(...content);
    const again = focus && this.element.querySelector(`[data-key="${CSS.escape(focus)}"]`);
    if (again instanceof HTMLElement) again.focus();
  }

  /**
   * @param {View} view
   * @param {Thing["kind"]} kind
   * @param {number} id
   */
  link(view, kind, id, text = view.names[kind](id)) {
    const attributes = { type: "button", class: "link", "data-key": `${view.letter}${kind}:${id}`, onclick: () => this.select(view, { kind, id }) };
    return make("button", attributes, text);
  }

  /**
   * The run as a whole; of two, their figures beside each other.
   * @param {View[]} views
   */
  overview(views) {
    const columns = views.map((view) => new Map(this.figures(view)));
    const rows = new Set(columns.flatMap((column) => [...column.keys()]));
    /** @type {Row[]} */
    const cells = [...rows].map((name) => [name, ...columns.map((column) => column.get(name) ?? "–")]);
    if (views.length === 1) return [make("h2", {}, "The run"), facts(cells), ...limits(views[0]), ...this.parts(views[0]), ...whole(views)];
    cells.shift(); // what differs in the rules stands above each view
    const table = compared(views, cells);
    return [make("h2", {}, "The runs"), table, ...views.flatMap(limits), ...whole(views), ...views.flatMap((view) => this.parts(view))];
  }

  /**
   * @param {View} view
   * @returns {[string, Node | string][]}
   */
  figures(view) {
    const { world, run } = view;
    const rules = Object.entries(run.rules).map(([role, rule]) => make("span", {}, `${role} ${rule}`));
    const has = featuresOf(run);
    const charges = run.legs.map((_, robot) => world.charge(robot) ?? 1);
    /** @type {(told: boolean, name: string, value: string) => [string, string][]} */
    const where = (told, name, value) => (told ? [[name, value]] : []);
    return [
      ["Rules", make("span", { class: "links" }, ...rules)],
      ["Complete", `${world.done} of ${run.orders.name.length} orders${world.cancelled ? `, ${world.cancelled} cancelled` : ""}`],
      ["Backlog", String(world.backlog)],
      ["Picks", String(world.picks)],
      ["Visits", String(world.visits)],
      ["Picks per visit", world.visits ? (world.picks / world.visits).toFixed(2) : "–"],
      ["Driven", `${(view.distance(world.tick) / 1000).toFixed(1)} km`],
      ["Robots", this.robots(view)],
      ...where(has.packing, "Packed", `${world.packing.reduce((sum, { packed }) => sum + packed, 0)} of ${run.orders.name.length} orders`),
      ...where(run.charges !== null, "Lowest charge", percent(Math.min(...charges))),
      ...where(has.moves, "Pods moved", String(world.moves)),
      ...where(has.bundles, "Bundles", `${world.waitingBundles.size} waiting, ${world.stored} of ${world.bundles.length} stored`),
    ];
  }

  /** @param {View} view */
  parts(view) {
    const { backlog } = view.world;
    const of = view.letter && ` of ${view.letter}`;
    return [
      make("h3", {}, `Stations${of}`),
      this.stations(view),
      ...this.packingStations(view),
      make("h3", {}, backlog ? `Oldest of ${plural(backlog, "order")} in the backlog${of}` : `Backlog${of}`),
      this.oldest(view),
      ...this.waitingBundles(view),
    ];
  }

  /** @param {View} view */
  waitingBundles(view) {
    const waiting = view.world.waitingBundles;
    if (!waiting.size) return [];
    const links = [...waiting].slice(0, OLDEST).map((id) => this.link(view, "bundle", id));
    return [make("h3", {}, `Oldest of ${plural(waiting.size, "bundle")} waiting${view.letter && ` of ${view.letter}`}`), make("p", { class: "links" }, ...links)];
  }

  /** @param {View} view */
  robots(view) {
    const counts = new Map();
    view.scene.places.forEach((here, robot) => {
      const phase = phaseOf(view.run, view.history, robot, view.world.tick, view.world);
      const names = { to_pod: "fetch", lifting: "fetch", to_station: "bring", queue: "queue", station: "serve", storing: "store", setting_down: "store", idle: "idle", moving: "move", to_rest: "rest", charging: "charge" };
      const off = phase.phase === "idle" && robot >= view.world.onDuty;
      const down = view.world.robotsDown.has(robot);
      const name = down ? "out of service" : off ? "off duty" : waitsOn(phase, here, view.run.legs[robot]) ? "wait" : names[phase.phase];
      counts.set(name, (counts.get(name) ?? 0) + 1);
    });
    const order = ["fetch", "bring", "queue", "serve", "store", "move", "rest", "charge", "wait", "idle", "off duty", "out of service"];
    const said = order.filter((name) => counts.has(name)).map((name) => make("span", {}, `${counts.get(name)} ${name}`));
    return make("span", { class: "links" }, ...said);
  }

  /** @param {View} view */
  stations(view) {
    const { bundles } = featuresOf(view.run);
    const rows = view.world.stations.map((station, i) =>
      make("tr", {},
        make("td", {}, this.link(view, "station", i, view.run.stations.name[i])),
        make("td", {}, String(station.open.size)),
        make("td", {}, String(station.items)),
        bundles ? make("td", {}, String(station.bundles.size)) : null,
        make("td", {}, String(Math.max(station.line.length - (station.visit ? 1 : 0), 0))),
        make("td", {}, this.picker(view, i)),
      ),
    );
    const titles = ["Station", "Orders", "Items", ...(bundles ? ["Bundles"] : []), "Queue", "Picker"];
    const head = titles.map((text) => make("th", { scope: "col" }, text));
    return make("table", { class: bundles ? "dense" : null }, make("thead", {}, make("tr", {}, ...head)), make("tbody", {}, ...rows));
  }

  /** @param {View} view */
  packingStations(view) {
    const { world, run, letter } = view;
    if (!run.packing) return [];
    const { boxes, packers, sorters } = run.packing;
    const rows = world.packing.map(({ coming, waiting, packing, packed }, i) => {
      const putting = world.putting(i);
      const values = [`${world.boxes(i).size}/${boxes}`, coming, waiting - putting, `${packing + putting}/${packers + sorters}`, packed];
      return make("tr", {}, make("td", {}, this.link(view, "packing", i, String(i + 1))), ...values.map((value) => make("td", {}, String(value))));
    });
    const head = ["Packing", "Boxes", "Coming", "Waiting", "At work", "Packed"].map((text) => make("th", { scope: "col" }, text));
    return [make("h3", {}, `Packing stations${letter && ` of ${letter}`}`), make("table", { class: "dense" }, make("thead", {}, make("tr", {}, ...head)), make("tbody", {}, ...rows))];
  }

  /**
   * What a station's picker does, in a word.
   * @param {View} view
   * @param {number} id
   */
  picker({ world, scene }, id) {
    const { items, bundles } = world.stations[id];
    if (scene.isPicking(id, world.tick)) return scene.isStoring(id, world.tick) ? "stores" : "picks";
    if (world.stationsDown.has(id)) return "out of service";
    if (items || bundles.size) return "waits";
    return world.closed.has(id) ? "closed" : "idle";
  }

  /** @param {View} view */
  oldest(view) {
    const { orders } = view.world;
    const found = [];
    for (let i = 0; i < orders.length && found.length < OLDEST; i++) {
      if (orders[i] === ORDER.WAITING || orders[i] === ORDER.PARTLY) found.push(i);
    }
    if (!found.length) return make("p", { class: "soft" }, "none");
    return make("p", { class: "links" }, ...found.map((i) => this.link(view, "order", i)));
  }

  /**
   * @param {View} view
   * @param {Thing} thing
   */
  thing(view, { kind, id }) {
    const { names, world } = view;
    const back = make("button", { type: "button", class: "link back", "data-key": "back", onclick: () => this.select(view, null) }, "← whole run");
    const of = view.letter && ` of ${view.letter}`;
    const head = [back, make("h2", {}, `${capital(names[kind](id))}${of}`)];
    return [...head, ...this[kind](view, id, world), ...this.why(view, kind, id), ...this.history(view, kind, id)];
  }

  /**
   * @param {View} view
   * @param {number} id
   * @param {World} world
   */
  robot(view, id, world) {
    const phase = phaseOf(view.run, view.history, id, world.tick, world);
    const here = view.scene.places[id];
    const charge = world.charge(id);
    const said = doing(view.names, phase, waitsOn(phase, here, view.run.legs[id]));
    return [
      make("p", { class: "now" }, `${capital(said)}.`),
      facts([
        ["Since", `${clockTime(phase.since)}, ${duration(world.tick - phase.since)} ago`],
        ["At", view.names.cell(Math.round(here.y) * view.run.layout.width + Math.round(here.x))],
        charge === null ? null : ["Charge", percent(charge)],
        world.robotsDown.has(id) ? ["Service", "out: it takes no tasks until it is repaired"] : null,
        id >= world.onDuty ? ["Duty", "off: it takes no tasks"] : null,
        phase.pod >= 0 ? ["Pod", this.link(view, "pod", phase.pod, view.run.pods.name[phase.pod])] : null,
        phase.station >= 0 ? ["Station", this.link(view, "station", phase.station, view.run.stations.name[phase.station])] : null,
      ]),
    ];
  }

  /**
   * @param {View} view
   * @param {number} id
   * @param {World} world
   */
  pod(view, id, world) {
    const robot = world.podRobot[id];
    const open = world.openItems()[id];
    const where = robot < 0 ? `Stands at ${view.names.cell(world.podCell[id])}` : `Carried by robot ${robot + 1}`;
    const contents = [...world.stock[id]].map(([sku, number]) => {
      const left = number < 0 ? "" : `, ${number} left`;
      return `${view.run.skus[sku]} (${world.demand[sku]} wanted${left})`;
    });
    const shown = contents.length > 12 ? [...contents.slice(0, 12), `and ${contents.length - 12} more`] : contents;
    return [
      make("p", { class: "now" }, `${where}.`),
      facts([
        ["Open items", String(open)],
        ["SKUs", shown.join(", ")],
        robot >= 0 ? ["Robot", this.link(view, "robot", robot, String(robot + 1))] : null,
      ]),
    ];
  }

  /**
   * @param {View} view
   * @param {number} id
   * @param {World} world
   */
  station(view, id, world) {
    const station = world.stations[id];
    const picks = view.scene.isPicking(id, world.tick);
    const queued = station.line.filter((pod) => pod !== station.visit?.pod);
    const { capacity, counts_orders, bundle_capacity } = view.run.stations;
    const worker = capacity[id] ? "The picker" : "The worker";
    const waits = station.visit ? "A pod is there" : `${worker} waits for a pod`;
    const nothing = capacity[id] ? "Nothing is to be picked" : "Nothing is to be stored";
    const busy = view.scene.isStoring(id, world.tick) ? `${worker} stores a bundle` : `${worker} handles an item`;
    const said = picks ? busy : station.items || station.bundles.size ? waits : nothing;
    /** @type {Row | null} */
    const down = world.stationsDown.has(id) ? ["Service", "out: it has failed"] : null;
    /** @type {Row | null} */
    const closed = world.closed.has(id) ? ["Closed", "takes no new orders"] : null;
    /** @param {number[]} ids */
    const pods = (ids) => (ids.length ? make("span", { class: "links" }, ...ids.map((pod) => this.link(view, "pod", pod, view.run.pods.name[pod]))) : "none");
    const orders = [...station.open].map(([order, items]) => this.link(view, "order", order, `${view.run.orders.name[order]} (${items})`));
    const bundles = [...station.bundles].map((bundle) => this.link(view, "bundle", bundle, `${view.run.events.bundle_arrived.name[bundle]}${world.bundles[bundle].pod < 0 ? " (no pod yet)" : ""}`));
    /** @param {HTMLElement[]} found */
    const links = (found) => (found.length ? make("span", { class: "links" }, ...found) : "none");
    const unit = counts_orders[id] ? "orders" : "items";
    return [
      make("p", { class: "now" }, `${said}.`),
      facts([
        down,
        closed,
        capacity[id] ? ["Load", loadSaid(unit === "orders" ? station.open.size : station.items, capacity[id], unit)] : null,
        bundle_capacity[id] ? ["Room", `${plural(station.bundles.size, "bundle")} of ${bundle_capacity[id]}`] : null,
        ["Pod there", pods(station.visit ? [station.visit.pod] : [])],
        ["Queue", pods(queued)],
        capacity[id] ? ["Open orders", links(orders)] : null,
        bundle_capacity[id] ? ["Bundles", links(bundles)] : null,
      ]),
    ];
  }

  /**
   * @param {View} view
   * @param {number} id
   * @param {World} world
   */
  bundle(view, id, world) {
    const { sku, items } = view.run.events.bundle_arrived;
    const bundle = world.bundles[id];
    return [
      make("p", { class: "now" }, `${capital(bundleStatus(view.names, world, id))}.`),
      facts([
        ["Holds", `${items[id]} × ${view.run.skus[sku[id]]}`],
        bundle && bundle.station >= 0 ? ["Station", this.link(view, "station", bundle.station, view.run.stations.name[bundle.station])] : null,
        bundle && bundle.pod >= 0 ? ["Pod", this.link(view, "pod", bundle.pod, view.run.pods.name[bundle.pod])] : null,
      ]),
    ];
  }

  /**
   * @param {View} view
   * @param {number} id
   * @param {World} world
   */
  packing(view, id, world) {
    const { boxes, packers, sorters } = view.run.packing ?? { boxes: 0, packers: 0, sorters: 0 };
    const { coming, waiting, packing, packed } = world.packing[id];
    const putting = world.putting(id);
    const held = [...world.boxes(id).values()];
    const orders = held.map((order) => this.link(view, "order", order, `${view.run.orders.name[order]} (${world.packs.get(order)?.items} of ${view.scene.itemsOf[order]})`));
    return [
      make("p", { class: "now" }, `${packing} being packed, ${putting} being put into boxes.`),
      facts([
        ["At work", `${packing + putting} of ${packers + sorters}`],
        ["Waiting", String(waiting - putting)],
        ["On conveyors", plural(coming, "tote")],
        ["Packed", plural(packed, "order")],
        ["Boxes", `${held.length} of ${boxes} in use`],
        ["Items in them", orders.length ? make("span", { class: "links" }, ...orders) : "none"],
      ]),
    ];
  }

  /**
   * @param {View} view
   * @param {number} id
   * @param {World} world
   */
  charger(view, id, world) {
    const { width } = view.run.layout;
    const there = view.scene.places.findIndex((here) => !here.moving && here.y * width + here.x === id);
    /** @type {[string, string] | null} */
    const down = world.chargersDown.has(id) ? ["Service", "out: it has failed"] : null;
    if (there < 0) return [make("p", { class: "now" }, down ? "Out of service." : "Free.")];
    const charge = world.charge(there);
    return [
      make("p", { class: "now" }, `${capital(view.names.robot(there))} stands there.`),
      facts([["Robot", this.link(view, "robot", there, String(there + 1))], charge === null ? null : ["Charge", percent(charge)], down]),
    ];
  }

  /**
   * @param {View} view
   * @param {number} id
   * @param {World} world
   */
  order(view, id, world) {
    const { run, names } = view;
    const due = run.orders.due?.[id];
    const status = orderStatus(names, world, id);
    const pack = world.packs.get(id);
    return [
      make("p", { class: "now" }, `${capital(status)}.`),
      facts([
        ["Lines", run.lines[id].map(([sku, quantity]) => `${quantity} × ${run.skus[sku]}`).join(", ")],
        due === undefined || due === null ? null : ["Due", clockTime(due)],
        pack ? ["Packing", this.link(view, "packing", pack.station, String(pack.station + 1))] : null,
        pack && pack.box >= 0 ? ["Box", `${pack.box + 1}, ${plural(pack.items, "item")} in it`] : null,
      ]),
    ];
  }

  /**
   * @param {View} view
   * @param {Thing["kind"]} kind
   * @param {number} id
   */
  why(view, kind, id) {
    const found = why(view.run, view.names, kind, id, view.world.tick);
    if (!found) return [];
    const more = found.number ? make("p", { class: "soft" }, "More: ", make("code", {}, `rmfs explain ${view.run.name} --decision ${found.number}`)) : null;
    return [make("h3", {}, "Why"), ...found.lines.map((line) => make("p", {}, line)), ...(more ? [more] : [])];
  }

  /**
   * @param {View} view
   * @param {Thing["kind"]} kind
   * @param {number} id
   */
  history(view, kind, id) {
    if (kind === "charger" || kind === "packing") return [];
    const list = view.history[kind][id] ?? [];
    if (!list.length) return [];
    const now = lastOf(view.run, list, view.world.tick);
    const begin = Math.max(Math.min(now - BEFORE, list.length - NEAR), 0);
    const rows = list.slice(begin, begin + NEAR).map((at, i) => {
      const tick = view.run.sequence.tick[at];
      const attributes = { class: begin + i > now ? "later" : begin + i === now ? "last" : null, "aria-current": begin + i === now ? "step" : null };
      const jump = make("button", { type: "button", class: "link", "data-key": `at:${at}`, onclick: () => this.seek(tick) }, clockTime(tick));
      return make("li", attributes, jump, make("span", {}, tell(view.run, view.names, at, kind)));
    });
    return [make("h3", {}, `History${list.length > NEAR ? `, ${begin + 1} to ${begin + rows.length} of ${list.length}` : ""}`), make("ol", { class: "history" }, ...rows)];
  }
}

/**
 * What became of the runs at their ends, from their results.
 * @param {View[]} views
 */
function whole(views) {
  const columns = views.map(({ run }) => new Map(/** @type {[string, string][]} */ ([["Seed", String(run.seed)], ["Ends", `${clockTime(run.tick)}, ${run.status}`], ...run.metrics])));
  const names = new Set(columns.flatMap((column) => [...column.keys()]));
  /** @type {Row[]} */
  const rows = [...names].map((name) => [name, ...columns.map((column) => column.get(name) ?? "–")]);
  return [make("h3", {}, views.length > 1 ? "At their ends" : "At its end"), views.length > 1 ? compared(views, rows) : facts(rows)];
}

/**
 * What limits a run, and what one more of it brings, as its summary says.
 * @param {View} view
 */
function limits({ run, letter }) {
  if (!run.says.length) return [];
  return [make("h3", {}, `What limits it${letter && ` in ${letter}`}`), ...run.says.map((said) => make("p", {}, said))];
}

/**
 * @param {View[]} views
 * @param {Row[]} rows
 */
function compared(views, rows) {
  const head = ["", ...views.map((view) => view.letter)].map((text) => make("th", { scope: "col" }, text));
  const body = rows.map(([name, ...values]) => make("tr", {}, make("th", { scope: "row" }, name), ...values.map((value) => make("td", {}, value))));
  return make("table", { class: "compare" }, make("thead", {}, make("tr", {}, ...head)), make("tbody", {}, ...body));
}

/** @param {(Row | null)[]} rows */
function facts(rows) {
  const cells = rows.flatMap((row) => (row ? [make("dt", {}, row[0]), make("dd", {}, row[1])] : []));
  return make("dl", {}, ...cells);
}
