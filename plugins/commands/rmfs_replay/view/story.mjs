// What robots, pods, stations and orders do, did, and why.

import { clockTime, duration } from "./clock.mjs";
import { lastUpTo } from "./motion.mjs";
import { ORDER } from "./world.mjs";

const OF = {
  robot: ["task_assigned", "pod_lifted", "queue_joined", "visit_started", "visit_ended", "pod_stored"],
  pod: ["trip_decided", "task_assigned", "pod_lifted", "queue_joined", "visit_started", "visit_ended", "pod_stored"],
  station: ["order_assigned", "visit_started", "visit_ended"],
  order: ["order_arrived", "order_assigned", "item_picked", "order_completed"],
};

/** For each robot, pod, station and order the events that concern it, as places in the run's sequence. */
export function histories(run) {
  const { sequence, events } = run;
  const visitors = new Map();
  const { visit, robot } = events.visit_started;
  visit.forEach((number, i) => visitors.set(number, robot[i]));
  events.visit_ended.robot = Array.from(events.visit_ended.visit, (number) => visitors.get(number) ?? -1);
  const counts = { robot: run.legs.length, pod: run.pods.name.length, station: run.stations.name.length, order: run.orders.name.length };
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
  cell = (cell) => `row ${Math.floor(cell / this.run.layout.width) + 1}, column ${(cell % this.run.layout.width) + 1}`;
}

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
  const acting = nextName.startsWith("pod_") && events[nextName].start_tick[sequence.index[next]] <= tick;
  if (at < 0) {
    const pod = world ? world.robotPod[robot] : -1;
    return { phase: pod < 0 ? "idle" : "queue", pod, station: pod < 0 ? -1 : (run.pods.bound_for[pod][0] ?? -1), since: 0 };
  }
  const name = sequence.names[sequence.kind[list[at]]];
  const i = sequence.index[list[at]];
  const e = events[name];
  const found = { phase: "idle", pod: e.pod[i], station: -1, since: sequence.tick[list[at]] };
  if (name === "task_assigned") found.phase = acting ? "lifting" : "to_pod";
  else if (name === "pod_lifted") found.phase = "to_station";
  else if (name === "queue_joined") [found.phase, found.station] = ["queue", e.station[i]];
  else if (name === "visit_started") [found.phase, found.station] = ["station", e.station[i]];
  else if (name === "visit_ended") {
    found.station = e.next_station[i];
    found.phase = found.station >= 0 ? "to_station" : acting ? "setting_down" : "storing";
  } else found.pod = -1;
  if (found.phase === "to_station" && found.station < 0) found.station = stationAhead(run, list, at);
  return found;
}

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
    queue: () => `queues${phase.station < 0 ? "" : ` at ${names.station(phase.station)}`} with ${names.pod(phase.pod)}`,
    station: () => `stands at ${names.station(phase.station)} with ${names.pod(phase.pod)}`,
    storing: () => `takes ${names.pod(phase.pod)} to storage`,
    setting_down: () => `sets ${names.pod(phase.pod)} down`,
  }[phase.phase]();
  return waits ? `${said}; stands still, for others or for room` : said;
}

/** Whether a robot that is where `here` says waits on a way. After its last leg nobody knows: the run ends. */
export const waitsOn = (phase, here, legs) =>
  !here.moving && here.leg + 1 < legs.n && ["to_pod", "to_station", "storing"].includes(phase.phase);

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

// Why

const WHAT = { order: [0, 0], pod: [1, 0], robot: [2, 0] };

/** The last decision about a thing by a time, with the sentence that says why, or null. */
export function why(run, names, kind, id, tick) {
  const recorded = run.decisions && lastRecorded(run, kind, id, tick);
  const made = lastMade(run, kind, id, tick);
  if (!recorded && !made) return null;
  const decided = recorded ?? made;
  const about = run.about[decided.rule];
  const lines = [`${decided.decides} by ${decided.rule} at ${clockTime(decided.tick)}: ${decided.said}.`];
  if (about) lines.push(`${decided.rule}: ${about}`);
  if (decided.backlog >= 0) lines.push(`It saw ${plural(decided.backlog, "order")} in the backlog.`);
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
  if (!WHAT[kind]) return null;
  for (let k = lastUpTo(d.tick, tick); k >= 0; k--) {
    for (let p = d.at[k]; p < d.at[k + 1]; p++) {
      const [what, one, other] = [d.what[p], d.one[p], d.other[p]];
      const hit =
        (kind === "order" && what === 0 && one === id) ||
        (kind === "pod" && (what === 1 || what === 3) && one === id) ||
        (kind === "robot" && what === 2 && one === id);
      if (!hit) continue;
      const said = [
        () => `${names.order(one)} goes to ${names.station(other)}`,
        () => `${names.pod(one)} goes to ${names.station(other)}`,
        () => `${names.robot(one)} fetches ${names.pod(other)}`,
        () => `${names.pod(one)} is stored at ${names.cell(other)}`,
      ][what]();
      return { tick: d.tick[k], decides: d.decides[k], rule: d.rule[k], backlog: d.backlog[k], said, number: k + 1 };
    }
  }
  return null;
}

function lastMade(run, kind, id, tick) {
  const names = new Names(run);
  const { decision_made: made, order_assigned: parts, trip_decided: trips } = run.events;
  const told = kind === "order" ? parts : kind === "pod" ? trips : null;
  if (!told) return null;
  for (let i = lastUpTo(told.tick, tick); i >= 0; i--) {
    if (told[kind][i] !== id) continue;
    const of = kind === "order" ? "POA" : "PPS";
    for (let k = lastUpTo(made.tick, told.tick[i]); k >= 0 && made.tick[k] === told.tick[i]; k--) {
      if (!made.decides[k].includes(of) || (kind === "order" && made.period[k] !== parts.period[i])) continue;
      const said = `${names[kind](id)} goes to ${names.station(told.station[i])}`;
      const { backlog, status, objective, bound } = made;
      return {
        tick: made.tick[k], decides: made.decides[k], rule: made.rule[k], backlog: backlog[k], said,
        status: status[k], objective: objective[k], bound: bound[k],
      };
    }
    return null;
  }
  return null;
}

/** How long ago something was, for people. */
export const ago = (tick, then) => (tick >= then ? `for ${duration(tick - then)}` : `in ${duration(then - tick)}`);
