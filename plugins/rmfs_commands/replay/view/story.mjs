// @ts-check
// What robots, pods, stations and orders do, did, and why.

import { clockTime } from "./clock.mjs";
import { lastUpTo } from "./motion.mjs";
import { ORDER } from "./world.mjs";
/** @import { Decisions, EventColumns, EventName, History, Kind, Legs, Phase, Position, Run, Sequence, Thing } from "./types.d.ts" */
/** @import { World } from "./world.mjs" */

/** @type {Record<Kind, EventName[]>} */
const OF = {
  robot: [
    "task_assigned", "pod_move_decided", "pod_lifted", "queue_joined", "visit_started", "visit_ended", "pod_stored", "robot_sent",
    "robot_rested", "robot_down", "robot_up",
  ],
  pod: [
    "trip_decided", "bundle_bound", "task_assigned", "pod_move_decided", "pod_lifted", "queue_joined", "visit_started",
    "bundle_stored", "visit_ended", "pod_stored",
  ],
  station: [
    "station_opened", "station_closed", "station_down", "station_up", "order_assigned", "bundle_assigned", "visit_started",
    "bundle_stored", "visit_ended",
  ],
  order: [
    "order_arrived", "order_assigned", "packing_assigned", "item_picked", "order_completed", "order_cancelled", "part_sent",
    "part_arrived", "part_put", "order_consolidated", "packing_started", "order_packed",
  ],
  bundle: ["bundle_arrived", "bundle_assigned", "bundle_bound", "bundle_stored"],
};

/**
 * The columns of a kind of events, as far as several kinds have them.
 * @param {Run} run
 * @param {EventName} name
 * @returns {EventColumns}
 */
const columnsOf = ({ events }, name) => events[name];

/**
 * For each robot, pod, station, order and bundle the events that concern it, as indices of the run's sequence.
 * @param {Run} run
 * @returns {History}
 */
export function histories(run) {
  const { sequence } = run;
  /**
   * @param {Kind} kind
   * @param {number} length
   */
  const of = (kind, length) => {
    const lists = Array.from({ length }, () => /** @type {number[]} */ ([]));
    const told = sequence.names.map((name) => (OF[kind].includes(name) ? columnsOf(run, name)[kind] : null));
    for (let i = 0; i < sequence.n; i++) {
      const column = told[sequence.kind[i]];
      if (column) lists[column[sequence.index[i]]]?.push(i);
    }
    return lists;
  };
  return {
    robot: of("robot", run.legs.length),
    pod: of("pod", run.pods.name.length),
    station: of("station", run.stations.name.length),
    order: of("order", run.orders.name.length),
    bundle: of("bundle", run.events.bundle_arrived.name.length),
  };
}

/**
 * A number of things in words.
 * @param {number} number
 * @param {string} one
 */
export const plural = (number, one) => `${number} ${number === 1 ? one : `${one}s`}`;

/**
 * A share in words.
 * @param {number} share
 */
export const percent = (share) => `${Math.round(100 * share)} %`;

/** Names of things, as a person says them. */
export class Names {
  /** @param {Run} run */
  constructor(run) {
    this.run = run;
  }

  /** @param {number} id */
  robot = (id) => `robot ${id + 1}`;
  /** @param {number} id */
  pod = (id) => `pod ${this.run.pods.name[id]}`;
  /** @param {number} id */
  station = (id) => `station ${this.run.stations.name[id]}`;
  /** @param {number} id */
  order = (id) => `order ${this.run.orders.name[id]}`;
  /** @param {number} id */
  sku = (id) => `SKU ${this.run.skus[id]}`;
  /** @param {number} id */
  bundle = (id) => `bundle ${this.run.events.bundle_arrived.name[id]}`;
  /** @param {number} id */
  packing = (id) => `packing station ${id + 1}`;
  /** @param {number} cell */
  charger = (cell) => `charger at ${this.cell(cell)}`;
  /** @param {number} cell */
  rest = (cell) => (isCharger(this.run, cell) ? `the charger at ${this.cell(cell)}` : this.cell(cell));
  /** @param {number} cell */
  cell = (cell) => `row ${Math.floor(cell / this.run.layout.width) + 1}, column ${(cell % this.run.layout.width) + 1}`;
}

/**
 * @param {Run} run
 * @param {number} cell
 */
const isCharger = (run, cell) => run.layout.kind[cell] === "5";

/**
 * Tell an event as someone for whom it is of a `kind` of thing would.
 * @param {Run} run
 * @param {Names} names
 * @param {number} at its index in the sequence
 * @param {Kind} kind
 */
export function tell(run, names, at, kind) {
  const { sequence, events } = run;
  const name = sequence.names[sequence.kind[at]];
  const i = sequence.index[at];
  const isRobot = kind === "robot";
  switch (name) {
    case "order_arrived":
      return "arrived";
    case "order_assigned": {
      const e = events.order_assigned;
      const lines = `${plural(e.items[i], "item")} in period ${e.period[i]}`;
      return kind === "station" ? `given ${names.order(e.order[i])}, ${lines}` : `assigned to ${names.station(e.station[i])}: ${lines}`;
    }
    case "item_picked": {
      const e = events.item_picked;
      return `${names.sku(e.sku[i])} picked from ${names.pod(e.pod[i])} at ${names.station(e.station[i])}`;
    }
    case "order_completed":
      return "complete";
    case "order_cancelled":
      return "cancelled";
    case "packing_assigned": {
      const e = events.packing_assigned;
      return `bound for packing station ${e.packing[i] + 1}${e.box[i] < 0 ? "" : `, box ${e.box[i] + 1}`}`;
    }
    case "part_sent": {
      const e = events.part_sent;
      return `tote ${e.tote[i]} left ${names.station(e.station[i])}: ${plural(e.items[i], "item")}`;
    }
    case "part_arrived":
      return `tote ${events.part_arrived.tote[i]} came to packing station ${events.part_arrived.packing[i] + 1}`;
    case "part_put":
      return `tote ${events.part_put.tote[i]} put into the box`;
    case "order_consolidated":
      return "all of it in the box";
    case "packing_started":
      return "packing began";
    case "order_packed":
      return "packed";
    case "trip_decided": {
      const e = events.trip_decided;
      return `sent to ${names.station(e.station[i])}`;
    }
    case "task_assigned": {
      const e = events.task_assigned;
      return isRobot ? `told to fetch ${names.pod(e.pod[i])}` : `${names.robot(e.robot[i])} comes for it`;
    }
    case "pod_lifted": {
      const e = events.pod_lifted;
      return isRobot ? `lifted ${names.pod(e.pod[i])}` : `lifted by ${names.robot(e.robot[i])} at ${names.cell(e.cell[i])}`;
    }
    case "queue_joined": {
      const e = events.queue_joined;
      return `joined the queue of ${names.station(e.station[i])}`;
    }
    case "visit_started": {
      const e = events.visit_started;
      return kind === "station" ? `pod ${run.pods.name[e.pod[i]]} came` : `stood at ${names.station(e.station[i])}`;
    }
    case "bundle_arrived": {
      const e = events.bundle_arrived;
      return `arrived: ${e.items[i]} × ${names.sku(e.sku[i])}`;
    }
    case "bundle_assigned": {
      const e = events.bundle_assigned;
      return kind === "station" ? `given ${names.bundle(e.bundle[i])}` : `assigned to ${names.station(e.station[i])}`;
    }
    case "bundle_bound": {
      const e = events.bundle_bound;
      return kind === "pod" ? `is to hold ${names.bundle(e.bundle[i])}` : `is to be stored on ${names.pod(e.pod[i])}`;
    }
    case "bundle_stored": {
      const e = events.bundle_stored;
      const on = kind === "pod" ? `at ${names.station(e.station[i])}` : `on ${names.pod(e.pod[i])}`;
      return kind === "bundle" ? `stored ${on}` : `${names.bundle(e.bundle[i])} stored ${on}: ${e.items[i]} × ${names.sku(e.sku[i])}`;
    }
    case "station_opened":
      return "opened";
    case "station_closed":
      return "closed: takes no new orders";
    case "robot_down":
      return events.robot_down.planned[i] ? "out of service: maintenance" : "out of service: it failed";
    case "station_down":
      return "out of service: it failed";
    case "robot_up":
    case "station_up":
      return "in service again";
    case "pod_move_decided": {
      const e = events.pod_move_decided;
      return isRobot ? `told to carry ${names.pod(e.pod[i])} to ${names.cell(e.cell[i])}` : `${names.robot(e.robot[i])} comes to carry it to ${names.cell(e.cell[i])}`;
    }
    case "robot_sent": {
      const e = events.robot_sent;
      return `sent to ${names.rest(e.cell[i])}`;
    }
    case "robot_rested": {
      const e = events.robot_rested;
      return `came to ${names.rest(e.cell[i])}`;
    }
    case "visit_ended": {
      const e = events.visit_ended;
      const picks = plural(e.picks[i], "pick");
      return kind === "station" ? `pod ${run.pods.name[e.pod[i]]} left after ${picks}` : `left ${names.station(e.station[i])} after ${picks}`;
    }
    case "pod_stored": {
      const e = events.pod_stored;
      return isRobot ? `stored ${names.pod(e.pod[i])} at ${names.cell(e.cell[i])}` : `stored at ${names.cell(e.cell[i])}`;
    }
    default:
      return name;
  }
}

/**
 * What a robot is at.
 * @param {Run} run
 * @param {History} history
 * @param {number} robot
 * @param {number} tick
 * @param {World | null} world
 * @returns {Phase}
 */
export function phaseOf(run, history, robot, tick, world) {
  const { sequence, events } = run;
  const list = history.robot[robot];
  const at = lastIn(sequence, list, tick);
  const acting = at + 1 < list.length && startOf(run, list[at + 1]) <= tick;
  if (at < 0) {
    const pod = world ? world.robotPod[robot] : -1;
    return { phase: pod < 0 ? "idle" : "queue", pod, station: pod < 0 ? -1 : (run.pods.bound_for[pod][0] ?? -1), since: 0 };
  }
  const name = sequence.names[sequence.kind[list[at]]];
  const i = sequence.index[list[at]];
  const e = columnsOf(run, name);
  /** @type {Phase} */
  const found = { phase: "idle", pod: e.pod?.[i] ?? -1, station: -1, since: sequence.tick[list[at]] };
  const move = name === "pod_move_decided" ? list[at] : name === "pod_lifted" ? movedBy(sequence, list[at - 1]) : -1;
  if (move >= 0) found.cell = events.pod_move_decided.cell[sequence.index[move]];
  if (name === "task_assigned" || name === "pod_move_decided") found.phase = acting ? "lifting" : "to_pod";
  else if (name === "pod_lifted" && move >= 0) found.phase = acting ? "setting_down" : "moving";
  else if (name === "pod_lifted") found.phase = "to_station";
  else if (name === "robot_sent") [found.phase, found.cell] = ["to_rest", events.robot_sent.cell[i]];
  else if (name === "robot_rested") {
    found.cell = events.robot_rested.cell[i];
    found.phase = run.charges && isCharger(run, found.cell) ? "charging" : "idle";
  } else if (name === "queue_joined") [found.phase, found.station] = ["queue", events.queue_joined.station[i]];
  else if (name === "visit_started") [found.phase, found.station] = ["station", events.visit_started.station[i]];
  else if (name === "visit_ended") {
    found.station = events.visit_ended.next_station[i];
    found.phase = found.station >= 0 ? "to_station" : acting ? "setting_down" : "storing";
  } else found.pod = -1;
  if (found.phase === "to_station" && found.station < 0) found.station = stationAhead(run, list, at);
  return found;
}

/**
 * When an event began; never for one that takes no time.
 * @param {Run} run
 * @param {number} at
 */
const startOf = (run, at) => columnsOf(run, run.sequence.names[run.sequence.kind[at]]).start_tick?.[run.sequence.index[at]] ?? Infinity;

/**
 * The index of an event if it has a robot carry a pod elsewhere without a visit, else -1.
 * @param {Sequence} sequence
 * @param {number | undefined} at
 */
const movedBy = (sequence, at) => (at !== undefined && sequence.names[sequence.kind[at]] === "pod_move_decided" ? at : -1);

/**
 * @param {Sequence} sequence
 * @param {number[]} list
 * @param {number} tick
 */
function lastIn(sequence, list, tick) {
  let low = 0;
  let high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sequence.tick[list[middle]] <= tick) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/**
 * @param {Run} run
 * @param {number[]} list
 * @param {number} at
 */
function stationAhead(run, list, at) {
  const next = list[at + 1];
  if (next === undefined) return -1;
  const { station } = columnsOf(run, run.sequence.names[run.sequence.kind[next]]);
  return station ? station[run.sequence.index[next]] : -1;
}

/**
 * Where in a history the last event by a time is; -1 when none has happened.
 * @param {Run} run
 * @param {number[]} list
 * @param {number} tick
 */
export const lastOf = (run, list, tick) => lastIn(run.sequence, list, tick);

/**
 * Say what a robot does.
 * @param {Names} names
 * @param {Phase} phase
 * @param {boolean} waits
 */
export function doing(names, phase, waits) {
  const { cell = -1 } = phase;
  const to = phase.station < 0 ? "" : ` to ${names.station(phase.station)}`;
  const said = {
    idle: () => "idle",
    to_pod: () => `on its way to ${names.pod(phase.pod)}`,
    lifting: () => `lifts ${names.pod(phase.pod)}`,
    to_station: () => `carries ${names.pod(phase.pod)}${to}`,
    moving: () => `carries ${names.pod(phase.pod)} to ${names.cell(cell)}, without a visit`,
    to_rest: () => `on its way to ${names.rest(cell)}`,
    charging: () => "stands at a charger",
    queue: () => `queues${phase.station < 0 ? "" : ` at ${names.station(phase.station)}`} with ${names.pod(phase.pod)}`,
    station: () => `stands at ${names.station(phase.station)} with ${names.pod(phase.pod)}`,
    storing: () => `takes ${names.pod(phase.pod)} to storage`,
    setting_down: () => `sets ${names.pod(phase.pod)} down`,
  }[phase.phase]();
  return waits ? `${said}; waits for other robots or a queue cell` : said;
}

/**
 * Whether a robot that is where `here` says waits on a way. After its last leg nobody knows: the run ends.
 * @param {Phase} phase
 * @param {Position} here
 * @param {Legs} legs
 */
export const waitsOn = (phase, here, legs) =>
  !here.moving && here.leg + 1 < legs.n && ["to_pod", "to_station", "storing", "moving", "to_rest"].includes(phase.phase);

/**
 * Say how far an order has come.
 * @param {Names} names
 * @param {World} world
 * @param {number} order
 */
export function orderStatus(names, world, order) {
  const left = world.left[order];
  const open = plural(left, "item");
  const at = world.stations.flatMap((station, i) => (station.open.has(order) ? [names.station(i)] : []));
  switch (world.orders[order]) {
    case ORDER.ABSENT:
      return "has not arrived yet";
    case ORDER.WAITING:
      return `waits in the backlog: ${open}`;
    case ORDER.PARTLY:
      return `partly assigned: ${world.unassigned[order]} of ${open} left to assign${at.length ? `, at ${at.join(", ")}` : ""}`;
    case ORDER.ASSIGNED:
      return `at ${at.join(", ")}: ${open} to pick`;
    case ORDER.CANCELLED:
      return "cancelled";
    default:
      return world.run.packing ? packedStatus(names, world, order) : "complete";
  }
}

/**
 * Say how far an order is that is picked.
 * @param {Names} names
 * @param {World} world
 * @param {number} order
 */
function packedStatus(names, world, order) {
  const pack = world.packs.get(order);
  if (!pack) return "packed";
  const where = names.packing(pack.station);
  if (pack.begun) return `is being packed at ${where}`;
  return pack.box < 0 ? `picked, bound for ${where}` : `picked, ${plural(pack.items, "item")} in box ${pack.box + 1} at ${where}`;
}

/**
 * Say how far a bundle has come.
 * @param {Names} names
 * @param {World} world
 * @param {number} id
 */
export function bundleStatus(names, world, id) {
  const bundle = world.bundles[id];
  if (!bundle) return "has not arrived yet";
  if (bundle.station < 0) return "waits for a station";
  if (bundle.stored) return `stored on ${names.pod(bundle.pod)}`;
  return `at ${names.station(bundle.station)}, ${bundle.pod < 0 ? "waits for a pod" : `to be stored on ${names.pod(bundle.pod)}`}`;
}

// Why

/**
 * What decisions are about, by their code: which thing it is that they are for, and what they say of it and the other.
 * @type {[Kind, (n: Names, one: number, other: number) => string][]}
 */
const DECIDED = [
  ["order", (n, one, other) => `${n.order(one)} goes to ${n.station(other)}`],
  ["pod", (n, one, other) => `${n.pod(one)} goes to ${n.station(other)}`],
  ["robot", (n, one, other) => `${n.robot(one)} fetches ${n.pod(other)}`],
  ["bundle", (n, one, other) => `${n.bundle(one)} goes to ${n.station(other)}`],
  ["bundle", (n, one, other) => `${n.bundle(one)} is stored on ${n.pod(other)}`],
  ["robot", (n, one, other) => `${n.robot(one)} goes to ${n.rest(other)}`],
  ["pod", (n, one, other) => `${n.pod(one)} is carried to ${n.cell(other)}`],
  ["pod", (n, one, other) => `${n.pod(one)} is stored at ${n.cell(other)}`],
];
const ON_BUNDLES = ["ROA", "ROA+RPS"];
const STORED_ON = 4;

/**
 * A decision about a thing: what it said; the number of one that was recorded, how the solve of one in the trace ended.
 * @typedef {{ tick: number, decides: string, rule: string, backlog: number, said: string }} Decided
 * @typedef {Decided & { number: number }} Recorded
 * @typedef {Decided & { status: string, objective: number | null, bound: number | null }} InTrace
 */

/**
 * The last decision about a thing by a time, with the sentence that says why, or null.
 * @param {Run} run
 * @param {Names} names
 * @param {Thing["kind"]} kind
 * @param {number} id
 * @param {number} tick
 */
export function why(run, names, kind, id, tick) {
  const recorded = run.decisions && lastRecorded(run.decisions, names, kind, id, tick);
  const made = lastMade(run, names, kind, id, tick);
  const decided = recorded ?? made;
  if (!decided) return null;
  const about = run.about[decided.rule];
  const lines = [`${decided.decides} by ${decided.rule} at ${clockTime(decided.tick)}: ${decided.said}.`];
  if (about) lines.push(`${decided.rule}: ${about}`);
  if (ON_BUNDLES.includes(decided.decides)) lines.push(`${plural(decided.backlog, "bundle")} waited for a station.`);
  else if (decided.backlog >= 0 && decided.decides !== "RPS") lines.push(`It saw ${plural(decided.backlog, "order")} in the backlog.`);
  if (made && made.status && made.status !== "decided") {
    const bound = made.bound === null ? "" : `, bound ${round(made.bound)}`;
    lines.push(`The solve ended ${made.status}${made.objective === null ? "" : `: objective ${round(made.objective)}${bound}`}.`);
  }
  return { lines, number: recorded ? recorded.number : 0, tick: decided.tick };
}

/** @param {number} value */
const round = (value) => String(Math.round(value * 1000) / 1000);

/**
 * @param {Decisions} d
 * @param {Names} names
 * @param {Thing["kind"]} kind
 * @param {number} id
 * @param {number} tick
 * @returns {Recorded | null}
 */
function lastRecorded(d, names, kind, id, tick) {
  for (let k = lastUpTo(d.tick, tick); k >= 0; k--) {
    for (let p = d.at[k]; p < d.at[k + 1]; p++) {
      const [what, one, other] = [d.what[p], d.one[p], d.other[p]];
      const [about, words] = DECIDED[what];
      const holds = what === STORED_ON && kind === "pod" && other === id;
      if (!(about === kind && one === id) && !holds) continue;
      const said = words(names, one, other);
      return { tick: d.tick[k], decides: d.decides[k], rule: d.rule[k], backlog: d.backlog[k], said, number: k + 1 };
    }
  }
  return null;
}

/**
 * @param {Run} run
 * @param {Names} names
 * @param {Thing["kind"]} kind
 * @param {number} id
 * @param {number} tick
 * @returns {InTrace | null}
 */
function lastMade(run, names, kind, id, tick) {
  const { order_assigned: parts, trip_decided: trips, bundle_assigned: given, bundle_bound: bound } = run.events;
  if (kind === "order") {
    const i = lastAbout(parts.tick, parts.order, id, tick);
    return i < 0 ? null : madeAt(run, parts.tick[i], "POA", `${names.order(id)} goes to ${names.station(parts.station[i])}`, parts.period[i]);
  }
  if (kind === "pod") {
    const i = lastAbout(trips.tick, trips.pod, id, tick);
    if (i < 0) return null;
    const of = run.stations.capacity[trips.station[i]] ? "PPS" : "RPS";
    return madeAt(run, trips.tick[i], of, `${names.pod(id)} goes to ${names.station(trips.station[i])}`);
  }
  if (kind !== "bundle") return null;
  const stored = lastAbout(bound.tick, bound.bundle, id, tick);
  if (stored >= 0) return madeAt(run, bound.tick[stored], "RPS", DECIDED[STORED_ON][1](names, id, bound.pod[stored]));
  const i = lastAbout(given.tick, given.bundle, id, tick);
  return i < 0 ? null : madeAt(run, given.tick[i], "ROA", `${names.bundle(id)} goes to ${names.station(given.station[i])}`);
}

/**
 * Index of the last event by a time that is about a thing; -1 for none.
 * @param {Float64Array} ticks
 * @param {number[]} column the things that the events are about
 * @param {number} id
 * @param {number} tick
 */
function lastAbout(ticks, column, id, tick) {
  const last = lastUpTo(ticks, tick);
  return last < 0 ? -1 : column.lastIndexOf(id, last);
}

/**
 * The last decision of a kind at a time, and in a period where one is given.
 * @param {Run} run
 * @param {number} tick
 * @param {string} of
 * @param {string} said
 * @param {number} [period]
 * @returns {InTrace | null}
 */
function madeAt(run, tick, of, said, period) {
  const made = run.events.decision_made;
  for (let k = lastUpTo(made.tick, tick); k >= 0 && made.tick[k] === tick; k--) {
    if (!made.decides[k].includes(of) || (period !== undefined && made.period[k] !== period)) continue;
    return {
      tick, decides: made.decides[k], rule: made.rule[k], backlog: made.backlog[k], said,
      status: made.status[k], objective: made.objective[k], bound: made.bound[k],
    };
  }
  return null;
}

/**
 * How much of its capacity a station uses; a large order, of more items than any station takes, is alone at its station.
 * @param {number} used
 * @param {number} capacity
 * @param {string} unit
 */
export function loadSaid(used, capacity, unit) {
  if (used <= capacity) return `${used} of ${capacity} ${unit}`;
  return `${used} ${unit} of a large order, alone at the station; otherwise at most ${capacity}`;
}
