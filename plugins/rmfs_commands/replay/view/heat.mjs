// @ts-check
// Heat maps of a whole run: figures by cell or by pod.

import { lastUpTo, nowhere, place, STEP_X, STEP_Y } from "./motion.mjs";
import { phaseOf } from "./story.mjs";
/** @import { Heat, HeatKind, HeatName, History, Position, Run } from "./types.d.ts" */

const WAYS = ["to_pod", "to_station", "storing"];

/** @type {{ none: { label: string } } & Record<HeatName, HeatKind>} */
export const HEATS = {
  none: { label: "Open items" },
  waiting: { label: "Waiting", unit: "s", by: "cell", says: "seconds that robots on a way stood in the cell" },
  traffic: { label: "Traffic", unit: "", by: "cell", says: "times that a robot drove into the cell" },
  picks: { label: "Picks by pod", unit: "", by: "pod", says: "items picked from the pod in the whole run" },
  storage: { label: "Time in storage", unit: "%", by: "cell", says: "share of the time that a pod stood at the location" },
};

export const HEAT_NAMES = /** @type {("none" | HeatName)[]} */ (Object.keys(HEATS));

const DOUBLING = [1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1]; // what most cells have is far below the most
const EVEN = [1 / 6, 2 / 6, 3 / 6, 4 / 6, 5 / 6, 1];

/**
 * Upper ends of a heat map's classes: whole numbers, none twice.
 * @param {{ most: number, unit: string }} heat
 */
export function heatEdges({ most, unit }) {
  const edges = (unit === "%" ? EVEN : DOUBLING).map((share) => Math.ceil(share * most));
  return edges.filter((edge, i) => edge !== edges[i - 1]);
}

/**
 * Class of a figure above 0, counted so that the most has the last of six colours.
 * @param {number[]} edges
 * @param {number} value
 */
export function heatClass(edges, value) {
  const at = edges.findIndex((edge) => value <= edge);
  return at < 0 ? EVEN.length - 1 : at + EVEN.length - edges.length;
}

/**
 * The figures of a heat map, and the largest.
 * @param {Run} run
 * @param {History} history
 * @param {HeatName} name
 * @returns {Heat}
 */
export function heatOf(run, history, name) {
  const values = { waiting, traffic, picks, storage }[name](run, history);
  let most = 0;
  for (const value of values) if (value > most) most = value;
  return { ...HEATS[name], values, most };
}

/** @param {Run} run */
function traffic(run) {
  const { width } = run.layout;
  const values = new Float64Array(run.layout.kind.length);
  for (const legs of run.legs) {
    for (let i = 0; i < legs.n; i++) {
      const step = STEP_X[legs.towards[i]] + STEP_Y[legs.towards[i]] * width;
      let cell = legs.y[i] * width + legs.x[i];
      for (let metre = 0; metre < legs.metres[i]; metre++) values[(cell += step)]++;
    }
  }
  return values;
}

/**
 * Spans of a robot without a leg that goes on, cut by what it is at: those on a way without lifting count.
 * @param {Run} run
 * @param {History} history
 * @param {number} robot
 * @param {(here: Position, begin: number, end: number) => void} found
 */
export function waits(run, history, robot, found) {
  const legs = run.legs[robot];
  const { sequence } = run;
  const changes = history.robot[robot].map((at) => sequence.tick[at]);
  for (const at of history.robot[robot]) {
    const name = sequence.names[sequence.kind[at]];
    if (name === "pod_lifted" || name === "pod_stored") changes.push(run.events[name].start_tick[sequence.index[at]]);
  }
  changes.sort((a, b) => a - b);
  const last = changes.at(-1) ?? 0; // what a robot does after its last leg and this is not told
  let rests = 0;
  for (let i = 0; i <= legs.n; i++) {
    const goes = i < legs.n ? legs.start[i] + legs.wait[i] : last;
    const here = place(run, robot, Math.max(rests, 0), nowhere());
    for (let begin = rests; begin < goes; ) {
      const next = changes[lastUpTo(changes, begin) + 1] ?? Infinity;
      const end = Math.min(next, goes);
      const { phase, cell } = phaseOf(run, history, robot, begin, null);
      if (WAYS.includes(phase) && cell === undefined) found(here, begin, end); // who fetches a pod to move it has a cell
      begin = end;
    }
    if (i < legs.n) rests = goes + legs.turn[i] + legs.run[i];
  }
}

/**
 * @param {Run} run
 * @param {History} history
 */
function waiting(run, history) {
  const { width } = run.layout;
  const values = new Float64Array(run.layout.kind.length);
  for (let robot = 0; robot < run.legs.length; robot++) {
    waits(run, history, robot, (here, begin, end) => {
      values[Math.round(here.y) * width + Math.round(here.x)] += (end - begin) / 1000;
    });
  }
  return values;
}

/** @param {Run} run */
function picks(run) {
  const values = new Float64Array(run.pods.name.length);
  for (const pod of run.events.item_picked.pod) values[pod]++;
  return values;
}

/** @param {Run} run */
function storage(run) {
  const values = new Float64Array(run.layout.kind.length);
  /** @type {([number, number] | null)[]} */ // cell and time
  const since = run.pods.cell.map((cell, pod) => (run.pods.robot[pod] < 0 ? [cell, 0] : null));
  const { sequence, events } = run;
  for (let i = 0; i < sequence.n; i++) {
    const name = sequence.names[sequence.kind[i]];
    const k = sequence.index[i];
    if (name === "pod_lifted") {
      const pod = events.pod_lifted.pod[k];
      const stands = since[pod];
      if (stands) values[stands[0]] += sequence.tick[i] - stands[1];
      since[pod] = null;
    } else if (name === "pod_stored") {
      const { pod, cell } = events.pod_stored;
      since[pod[k]] = [cell[k], sequence.tick[i]];
    }
  }
  for (const stands of since) if (stands) values[stands[0]] += run.tick - stands[1];
  return values.map((ticks) => (100 * ticks) / Math.max(run.tick, 1));
}
