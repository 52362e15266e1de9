// A run of half a minute, as rmfs_commands/replay/columns.py packs it: one robot brings a pod to the only station.
//
//   p q . . . .      p, q: pods in storage; the robot stands beneath p
//   . . . . < S      <: queue, S: station

import { unpack } from "../../../../../plugins/rmfs_commands/replay/view/unpack.mjs";

const KINDS = {
  order_arrived: ["order"],
  order_in_stock: ["order"],
  order_assigned: ["order", "station", "skus", "items", "period", "complete"],
  trip_decided: ["pod", "station"],
  task_assigned: ["robot", "pod"],
  pod_lifted: ["start_tick", "robot", "pod", "cell"],
  pod_stored: ["start_tick", "robot", "pod", "cell"],
  queue_joined: ["robot", "pod", "station"],
  visit_started: ["visit", "robot", "pod", "station"],
  item_picked: ["start_tick", "picker_free_tick", "visit", "station", "pod", "order", "sku"],
  visit_ended: ["visit", "pod", "station", "picks", "next_station"],
  order_cancelled: ["order"],
  order_completed: ["order"],
  packing_assigned: ["order", "packing", "box"],
  part_sent: ["order", "packing", "station", "tote", "items"],
  part_arrived: ["order", "packing", "tote", "items"],
  part_put: ["start_tick", "order", "packing", "tote", "items"],
  order_consolidated: ["order", "packing"],
  packing_started: ["order", "packing"],
  order_packed: ["start_tick", "order", "packing"],
  bundle_arrived: ["bundle", "name", "sku", "items"],
  bundle_assigned: ["bundle", "station"],
  bundle_bound: ["bundle", "pod"],
  bundle_stored: ["start_tick", "visit", "station", "pod", "bundle", "sku", "items"],
  station_opened: ["station"],
  station_closed: ["station"],
  robots_on_duty: ["number"],
  robot_down: ["robot", "planned"],
  robot_up: ["robot"],
  station_down: ["station"],
  station_up: ["station"],
  charger_down: ["cell"],
  charger_up: ["cell"],
  robot_sent: ["robot", "cell"],
  robot_rested: ["robot", "cell"],
  pod_move_decided: ["robot", "pod", "cell"],
  decision_made: ["period", "decides", "rule", "backlog", "assignments", "trips", "status", "objective", "bound", "stopped_early"],
};

const EVENTS = [
  [0, "order_arrived", 0],
  [0, "order_assigned", 0, 0, [0, 1], 3, 1, 1],
  [0, "decision_made", 1, 0, 1, 1, 1, 0, 2, 4.5, 3, 0],
  [0, "trip_decided", 0, 0],
  [0, "decision_made", 1, 3, 4, 0, 0, 1, 5, null, null, 0],
  [0, "task_assigned", 0, 0],
  [2200, "pod_lifted", 0, 0, 0, 0],
  [5000, "order_arrived", 1],
  [10417, "queue_joined", 0, 0, 0],
  [13042, "visit_started", 1, 0, 0, 0],
  [20042, "item_picked", 13042, 26042, 1, 0, 0, 0, 0],
  [27042, "item_picked", 26042, 29000, 1, 0, 0, 0, 0],
  [27042, "visit_ended", 1, 0, 0, 2, -1],
];
const TEXTS = ["POA", "pod-match", "optimal", "PPS", "demand", "decided"];
const LEGS = [
  // start, wait, turn, run, towards, metres
  [2200, 800, 625, 4167, 0, 4],
  [7792, 0, 625, 2000, 3, 1],
  [10417, 0, 625, 2000, 0, 1],
];

function packedEvents(told) {
  const events = {};
  for (const [name, fields] of Object.entries(KINDS)) {
    const columns = { tick: [], ...Object.fromEntries(fields.map((field) => [field, []])) };
    if (fields.includes("skus")) columns.skus_n = [];
    let last = 0;
    for (const [tick, kind, ...values] of told) {
      if (kind !== name) continue;
      columns.tick.push(tick - last);
      last = tick;
      fields.forEach((field, i) => {
        const value = values[i];
        if (field === "skus") {
          columns.skus.push(...value);
          columns.skus_n.push(value.length);
        } else columns[field].push(field === "start_tick" ? tick - value : field === "picker_free_tick" ? value - tick : value);
      });
    }
    events[name] = columns;
  }
  return events;
}

/** The kinds of events in their order, as letters. */
const order = (told) => told.map(([, kind]) => String.fromCharCode(97 + Object.keys(KINDS).indexOf(kind))).join("");

function packedLegs() {
  let free = 0;
  const gap = LEGS.map(([start, wait, turn, run]) => {
    const found = start - free;
    free = start + wait + turn + run;
    return found;
  });
  const column = (i) => LEGS.map((leg) => leg[i]);
  return { n: [LEGS.length], gap, wait: column(1), turn: column(2), run: column(3), towards: column(4), metres: column(5), whole: column(5), jump: [0, 0, 0] };
}

/** The run as the page is told it. */
export function packed() {
  return {
    name: "sample", status: "partial", tick: 30000, seed: 1,
    rules: { POA: "pod-match", PPS: "demand" },
    about: { demand: "Send the pod whose contents are wanted most." },
    metrics: [],
    says: [],
    layout: { width: 6, height: 2, kind: "221111111134", queues: [[11, 10]] },
    motion: { acceleration: 1, speed: 1.5 },
    skus: ["a", "b"],
    orders: { name: ["first", "second"], lines_n: [2, 1], lines: [0, 2, 1, 1, 0, 1] },
    pods: { name: ["p", "q"], contents_n: [1, 1], contents: [0, -1, 1, 1], cell: [0, 1], robot: [-1, -1], bound_for: [[], []] },
    robots: { cell: [0], heading: [1] },
    stations: { name: ["1"], capacity: [15], counts_orders: [false], bundle_capacity: [0] },
    packing: null,
    blocked: [],
    legs: packedLegs(),
    events: packedEvents(EVENTS),
    order: order(EVENTS),
    texts: TEXTS,
    charges: { n: [], tick: [], charge: [] },
    decisions: null,
  };
}

export const sample = () => unpack(packed());

const CANCELLED = [...EVENTS, [28000, "order_cancelled", 1]];
/** The same with the second order cancelled at the end. */
export const cancelled = () => unpack({ ...packed(), events: packedEvents(CANCELLED), order: order(CANCELLED) });

// The same place with a charger (5) and a station that stores bundles, without orders: the robot moves pod p, rests at the
// charger, and brings pod q, on which a bundle of SKU a is stored.

const MORE_EVENTS = [
  [0, "station_closed", 0],
  [0, "pod_move_decided", 0, 0, 3],
  [2200, "pod_lifted", 0, 0, 0, 0],
  [9000, "pod_stored", 6800, 0, 0, 3],
  [9000, "robot_sent", 0, 5],
  [12000, "robot_rested", 0, 5],
  [14000, "bundle_arrived", 0, 6, 0, 4],
  [14000, "bundle_arrived", 1, 7, 1, 2],
  [15000, "bundle_assigned", 0, 0],
  [15000, "decision_made", 0, 8, 9, 2, 1, 0, 5, null, null, 0],
  [16000, "bundle_bound", 0, 1],
  [16000, "trip_decided", 1, 0],
  [16000, "decision_made", 0, 10, 11, 1, 0, 1, 5, null, null, 0],
  [16000, "task_assigned", 0, 1],
  [18200, "pod_lifted", 16000, 0, 1, 1],
  [20000, "queue_joined", 0, 1, 0],
  [20000, "visit_started", 1, 0, 1, 0],
  [26000, "bundle_stored", 20000, 1, 0, 1, 0, 0, 4],
  [27000, "station_opened", 0],
  [27000, "robots_on_duty", 0],
];

/** The run as the page is told it. */
export function packedReplenished() {
  return {
    ...packed(),
    orders: { name: [], lines_n: [], lines: [] },
    rules: { ROA: "first-bundle", RPS: "emptiest-pod" },
    layout: { width: 6, height: 2, kind: "222115111134", queues: [[11, 10]] },
    pods: { name: ["p", "q"], contents_n: [1, 1], contents: [0, 3, 1, 1], cell: [0, 1], robot: [-1, -1], bound_for: [[], []] },
    stations: { name: ["1"], capacity: [0], counts_orders: [false], bundle_capacity: [2] },
    events: packedEvents(MORE_EVENTS),
    order: order(MORE_EVENTS),
    texts: [...TEXTS, "first", "second", "ROA", "first-bundle", "RPS", "emptiest-pod"],
    charges: { n: [3], tick: [0, 12000, 4000], charge: [10000, 4000, 6000] },
  };
}

export const replenished = () => unpack(packedReplenished());

// The same place with a packing station: order 0 comes in two totes and is put into box 1, order 1 has no box.

const PACKING_EVENTS = [
  [0, "order_arrived", 0],
  [0, "order_arrived", 1],
  [0, "packing_assigned", 0, 0, 1],
  [0, "packing_assigned", 1, 0, -1],
  [1000, "part_sent", 0, 0, 0, 1, 1],
  [2000, "part_sent", 0, 0, 0, 2, 2],
  [2500, "order_completed", 0],
  [3000, "part_arrived", 0, 0, 1, 1],
  [4000, "part_arrived", 0, 0, 2, 2],
  [7000, "part_put", 3000, 0, 0, 1, 1],
  [8000, "part_put", 7000, 0, 0, 2, 2],
  [8000, "order_consolidated", 0, 0],
  [8000, "packing_started", 0, 0],
  [9000, "order_packed", 8000, 0, 0],
];

/** The run; an order has its box until it is packed, or picked. */
export const packs = (until_picked = false) =>
  unpack({
    ...packed(),
    events: packedEvents(PACKING_EVENTS),
    order: order(PACKING_EVENTS),
    packing: { stations: 1, boxes: 2, packers: 1, sorters: 0, until_picked },
  });
