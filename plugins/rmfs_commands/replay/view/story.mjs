// What robots, pods, stations and orders do, did, and why.

import { clockTime, duration } from "./clock.mjs";
import { lastUpTo } from "./motion.mjs";
import { ORDER } from "./world.mjs";

const OF = {
  robot: [
    "task_assigned", "pod_move_decided", "pod_lifted", "queue_joined", "visit_started", "visit_ended", "pod_stored", "robot_sent",
    "robot_rested",
  ],
  pod: [
    "trip_decided", "bundle_bound", "task_assigned", "pod_move_decided", "pod_lifted", "queue_joined", "visit_started",
    "bundle_stored", "visit_ended", "pod_stored",
  ],
  station: ["station_opened", "station_closed", "order_assigned", "bundle_assigned", "visit_started", "bundle_stored", "visit_ended"],
  order: ["order_arrived", "order_assigned", "item_picked", "order_completed"],
  bundle: ["bundle_arrived", "bundle_assigned", "bundle_bound", "bundle_stored"],
};

/** For each robot, pod, station, order and bundle the events that concern it, as places in the run's sequence. */
export function histories(run) {
  const { sequence, events } = run;
  const visitors = new Map();
  const { visit, robot } = events.visit_started;
  visit.forEach((number, i) => visitors.set(number, robot[i]));
  events.visit_ended.robot = Array.from(events.visit_ended.visit, (number) => visitors.get(number) ?? -1);
  const counts = { robot: run.legs.length, pod: run.pods.name.length, station: run.stations.name.length, order: run.orders.name.length, bundle: run.events.bundle_arrived?.name.length ?? 0 };
  const found = {};
  for (const [kind, names] of Object.entries(OF)) {
    const lists = Array.from({ length: counts[kind] }, () => []);
    const told = sequence.names.map((name) => (names.includes(name) ? events[name][kind] : null));
    for (let i = 0; i < sequence.n; i++) {
      const column = told[sequence.kind[i]];
      if (column) lists[column[sequence.index[i]]]?.push(i);
    }
    found[kind] = lists;
  }
  return found;
}

/** A number of things in words. */
export const plural = (number, one, many = `${one}s`) => `${number} ${number === 1 ? one : many}`;

/** A share in words. */
export const percent = (share) => `${Math.round(100 * share)} %`;

/** Names of things, as a person says them. */
export class Names {
  constructor(run) {
    this.run = run;
  }

  robot = (id) => `robot ${id + 1}`;
  pod = (id) => `pod ${this.run.pods.name[id]}`;
  station = (id) => `station ${this.run.stations.name[id]}`;
  order = (id) => `order ${this.run.orders.name[id]}`;
  sku = (id) => `SKU ${this.run.skus[id]}`;
  bundle = (id) => `bundle ${this.run.events.bundle_arrived.name[id]}`;
  charger = (cell) => `charger at ${this.cell(cell)}`;
  rest = (cell) => (isCharger(this.run, cell) ? `the charger at ${this.cell(cell)}` : this.cell(cell));
  cell = (cell) => `row ${Math.floor(cell / this.run.layout.width) + 1}, column ${(cell % this.run.layout.width) + 1}`;
}

const isCharger = (run, cell) => run.layout.kind[cell] === "5";

/** Tell an event as someone for whom it is of a `kind` of thing would. */
export function tell(run, names, place, kind) {
  const { sequence, events } = run;
  const name = sequence.names[sequence.kind[place]];
  const e = events[name];
  const i = sequence.index[place];
  const isRobot = kind === "robot";
  const pod = () => (kind === "pod" ? "" : ` ${names.pod(e.pod[i])}`);
  switch (name) {
    case "order_arrived":
      return "arrived";
    case "order_assigned": {
      const lines = `${plural(e.items[i], "item")} in period ${e.period[i]}`;
      return kind === "station" ? `given ${names.order(e.order[i])}, ${lines}` : `assigned to ${names.station(e.station[i])}: ${lines}`;
    }
    case "item_picked":
      return `${names.sku(e.sku[i])} picked from ${names.pod(e.pod[i])} at ${names.station(e.station[i])}`;
    case "order_completed":
      return "complete";
    case "trip_decided":
      return `sent to ${names.station(e.station[i])}`;
    case "task_assigned":
      return isRobot ? `told to fetch${pod()}` : `${names.robot(e.robot[i])} comes for it`;
    case "pod_lifted":
      return isRobot ? `lifted${pod()}` : `lifted by ${names.robot(e.robot[i])} at ${names.cell(e.cell[i])}`;
    case "queue_joined":
      return `joined the queue of ${names.station(e.station[i])}`;
    case "visit_started":
      return kind === "station" ? `pod ${run.pods.name[e.pod[i]]} came` : `stood at ${names.station(e.station[i])}`;
    case "bundle_arrived":
      return `arrived: ${e.items[i]} × ${names.sku(e.sku[i])}`;
    case "bundle_assigned":
      return kind === "station" ? `given ${names.bundle(e.bundle[i])}` : `assigned to ${names.station(e.station[i])}`;
    case "bundle_bound":
      return kind === "pod" ? `is to hold ${names.bundle(e.bundle[i])}` : `is to be stored on ${names.pod(e.pod[i])}`;
    case "bundle_stored": {
      const on = kind === "pod" ? `at ${names.station(e.station[i])}` : `on ${names.pod(e.pod[i])}`;
      return kind === "bundle" ? `stored ${on}` : `${names.bundle(e.bundle[i])} stored ${on}: ${e.items[i]} × ${names.sku(e.sku[i])}`;
    }
    case "station_opened":
      return "opened";
    case "station_closed":
      return "closed: takes no new orders";
    case "pod_move_decided":
      return isRobot ? `told to carry${pod()} to ${names.cell(e.cell[i])}` : `${names.robot(e.robot[i])} comes to carry it to ${names.cell(e.cell[i])}`;
    case "robot_sent":
      return `sent to ${names.rest(e.cell[i])}`;
    case "robot_rested":
      return `came to ${names.rest(e.cell[i])}`;
    case "visit_ended": {
      const picks = plural(e.picks[i], "pick");
      return kind === "station" ? `pod ${run.pods.name[e.pod[i]]} left after ${picks}` : `left ${names.station(e.station[i])} after ${picks}`;
    }
    case "pod_stored":
      return isRobot ? `stored${pod()} at ${names.cell(e.cell[i])}` : `stored at ${names.cell(e.cell[i])}`;
    default:
      return name;
  }
}

/** What a robot is at: `phase`, the pod and the station it is about, and since when. */
export function phaseOf(run, history, robot, tick, world) {
  const { sequence, events } = run;
  const list = history.robot[robot];
  const at = lastIn(sequence, list, tick);
  const next = list[at + 1];
  const nextName = next === undefined ? "" : sequence.names[sequence.kind[next]];
  const acting = Boolean(events[nextName]?.start_tick) && events[nextName].start_tick[sequence.index[next]] <= tick;
  if (at < 0) {
    const pod = world ? world.robotPod[robot] : -1;
    return { phase: pod < 0 ? "idle" : "queue", pod, station: pod < 0 ? -1 : (run.pods.bound_for[pod][0] ?? -1), since: 0 };
  }
  const name = sequence.names[sequence.kind[list[at]]];
  const i = sequence.index[list[at]];
  const e = events[name];
  const found = { phase: "idle", pod: e.pod?.[i] ?? -1, station: -1, since: sequence.tick[list[at]] };
  const move = name === "pod_move_decided" ? list[at] : name === "pod_lifted" ? movedBy(sequence, list[at - 1]) : -1;
  if (move >= 0) found.cell = events.pod_move_decided.cell[sequence.index[move]];
  if (name === "task_assigned" || name === "pod_move_decided") found.phase = acting ? "lifting" : "to_pod";
  else if (name === "pod_lifted" && move >= 0) found.phase = acting ? "setting_down" : "moving";
  else if (name === "pod_lifted") found.phase = "to_station";
  else if (name === "robot_sent") [found.phase, found.cell] = ["to_rest", e.cell[i]];
  else if (name === "robot_rested") [found.phase, found.cell] = [run.charges && isCharger(run, e.cell[i]) ? "charging" : "idle", e.cell[i]];
  else if (name === "queue_joined") [found.phase, found.station] = ["queue", e.station[i]];
  else if (name === "visit_started") [found.phase, found.station] = ["station", e.station[i]];
  else if (name === "visit_ended") {
    found.station = e.next_station[i];
    found.phase = found.station >= 0 ? "to_station" : acting ? "setting_down" : "storing";
  } else found.pod = -1;
  if (found.phase === "to_station" && found.station < 0) found.station = stationAhead(run, list, at);
  return found;
}

/** The place of an event if it has a robot carry a pod elsewhere without a visit, else -1. */
const movedBy = (sequence, place) => (place !== undefined && sequence.names[sequence.kind[place]] === "pod_move_decided" ? place : -1);

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

function stationAhead(run, list, at) {
  const next = list[at + 1];
  if (next === undefined) return -1;
  const { station } = run.events[run.sequence.names[run.sequence.kind[next]]];
  return station ? station[run.sequence.index[next]] : -1;
}

/** Place of the last event of a history by a time; -1 when none has happened. */
export const lastOf = (run, list, tick) => lastIn(run.sequence, list, tick);

/** Say what a robot does. */
export function doing(names, phase, waits) {
  const to = phase.station < 0 ? "" : ` to ${names.station(phase.station)}`;
  const said = {
    idle: () => "idle",
    to_pod: () => `on its way to ${names.pod(phase.pod)}`,
    lifting: () => `lifts ${names.pod(phase.pod)}`,
    to_station: () => `carries ${names.pod(phase.pod)}${to}`,
    moving: () => `carries ${names.pod(phase.pod)} to ${names.cell(phase.cell)}, without a visit`,
    to_rest: () => `on its way to ${names.rest(phase.cell)}`,
    charging: () => "stands at a charger",
    queue: () => `queues${phase.station < 0 ? "" : ` at ${names.station(phase.station)}`} with ${names.pod(phase.pod)}`,
    station: () => `stands at ${names.station(phase.station)} with ${names.pod(phase.pod)}`,
    storing: () => `takes ${names.pod(phase.pod)} to storage`,
    setting_down: () => `sets ${names.pod(phase.pod)} down`,
  }[phase.phase]();
  return waits ? `${said}; stands still, for others or for room` : said;
}

/** Whether a robot that is where `here` says waits on a way. After its last leg nobody knows: the run ends. */
export const waitsOn = (phase, here, legs) =>
  !here.moving && here.leg + 1 < legs.n && ["to_pod", "to_station", "storing", "moving", "to_rest"].includes(phase.phase);

/** Say how far an order has come. */
export function orderStatus(run, names, world, order) {
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
    default:
      return "complete";
  }
}

/** Say how far a bundle has come. */
export function bundleStatus(names, world, id) {
  const bundle = world.bundles[id];
  if (!bundle) return "has not arrived yet";
  if (bundle.station < 0) return "waits for a station";
  if (bundle.stored) return `stored on ${names.pod(bundle.pod)}`;
  return `at ${names.station(bundle.station)}, ${bundle.pod < 0 ? "waits for a pod" : `to be stored on ${names.pod(bundle.pod)}`}`;
}

// Why

/** What decisions are about, by their code: which thing it is that they are for, and what they say of it and the other. */
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

/** The last decision about a thing by a time, with the sentence that says why, or null. */
export function why(run, names, kind, id, tick) {
  const recorded = run.decisions && lastRecorded(run, kind, id, tick);
  const made = lastMade(run, kind, id, tick);
  if (!recorded && !made) return null;
  const decided = recorded ?? made;
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

const round = (value) => String(Math.round(value * 1000) / 1000);

function lastRecorded(run, kind, id, tick) {
  const { decisions: d } = run;
  const names = new Names(run);
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

function lastMade(run, kind, id, tick) {
  const names = new Names(run);
  const { decision_made: made, order_assigned: parts, trip_decided: trips, bundle_assigned: given, bundle_bound: bound } = run.events;
  if (kind === "bundle") {
    const stored = bound.bundle.lastIndexOf(id);
    const told = stored >= 0 && bound.tick[stored] <= tick ? bound : given;
    return lastOfBundle(made, told, id, tick, names);
  }
  const told = kind === "order" ? parts : kind === "pod" ? trips : null;
  if (!told) return null;
  for (let i = lastUpTo(told.tick, tick); i >= 0; i--) {
    if (told[kind][i] !== id) continue;
    const of = kind === "order" ? "POA" : run.stations.capacity[told.station[i]] ? "PPS" : "RPS";
    for (let k = lastUpTo(made.tick, told.tick[i]); k >= 0 && made.tick[k] === told.tick[i]; k--) {
      if (!made.decides[k].includes(of) || (kind === "order" && made.period[k] !== parts.period[i])) continue;
      const said = `${names[kind](id)} goes to ${names.station(told.station[i])}`;
      return asMade(made, k, said);
    }
    return null;
  }
  return null;
}

function lastOfBundle(made, told, id, tick, names) {
  const i = told.bundle.indexOf(id);
  if (i < 0 || told.tick[i] > tick) return null;
  const of = told.pod ? "RPS" : "ROA";
  for (let k = lastUpTo(made.tick, told.tick[i]); k >= 0 && made.tick[k] === told.tick[i]; k--) {
    if (!made.decides[k].includes(of)) continue;
    return asMade(made, k, told.pod ? DECIDED[STORED_ON][1](names, id, told.pod[i]) : `${names.bundle(id)} goes to ${names.station(told.station[i])}`);
  }
  return null;
}

const asMade = (made, k, said) => ({
  tick: made.tick[k], decides: made.decides[k], rule: made.rule[k], backlog: made.backlog[k], said,
  status: made.status[k], objective: made.objective[k], bound: made.bound[k],
});

/** How long ago something was, for people. */
export const ago = (tick, then) => (tick >= then ? `for ${duration(tick - then)}` : `in ${duration(then - tick)}`);
