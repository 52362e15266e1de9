// @ts-check
// From the packed text in the page to a run with typed columns. rmfs_commands/replay/columns.py packs it.

import { STEP_X, STEP_Y } from "./motion.mjs";
/** @import { ChargeLine, Decisions, EventName, Events, LegColumn, Legs, Run, Sequence, SkuItems, ToldRun } from "./types.d.ts" */

/**
 * Inflate base64 of a zlib stream, and read the JSON in it.
 * @param {string} text
 * @returns {Promise<ToldRun>}
 */
export async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).json();
}

/** @param {number[]} differences */
function summed(differences) {
  const values = new Float64Array(differences.length);
  let sum = 0;
  for (let i = 0; i < values.length; i++) values[i] = sum += differences[i];
  return values;
}

/** @param {number[]} counts */
function offsets(counts) {
  const values = new Int32Array(counts.length + 1);
  for (let i = 0; i < counts.length; i++) values[i + 1] = values[i] + counts[i];
  return values;
}

/**
 * @param {ToldRun} data
 * @returns {Legs[]}
 */
function unpackLegs(data) {
  const { width } = data.layout;
  const at = offsets(data.legs.n);
  return data.legs.n.map((n, robot) => {
    /** @param {LegColumn} name */
    const cut = (name) => Float64Array.from(data.legs[name].slice(at[robot], at[robot + 1]));
    const [wait, turn, run, gap] = [cut("wait"), cut("turn"), cut("run"), cut("gap")];
    const [towards, metres, whole, jump] = [cut("towards"), cut("metres"), cut("whole"), cut("jump")];
    const [start, x, y] = [new Float64Array(n), new Float64Array(n), new Float64Array(n)];
    let free = 0;
    let cell = data.robots.cell[robot];
    const x0 = cell % width;
    const y0 = Math.floor(cell / width);
    for (let i = 0; i < n; i++) {
      start[i] = free + gap[i];
      free = start[i] + wait[i] + turn[i] + run[i];
      cell += jump[i];
      x[i] = cell % width;
      y[i] = Math.floor(cell / width);
      cell += (STEP_X[towards[i]] + STEP_Y[towards[i]] * width) * metres[i];
    }
    return { n, start, wait, turn, run, towards, metres, whole, x, y, x0, y0, heading0: data.robots.heading[robot] };
  });
}

/**
 * Columns with the times of the events.
 * @template {{ tick: number[] }} Columns
 * @param {Columns} told
 * @returns {Omit<Columns, "tick"> & { tick: Float64Array }}
 */
const timed = (told) => ({ ...told, tick: summed(told.tick) });

/**
 * Columns of what has a beginning and an end.
 * @template {{ tick: number[], start_tick: number[] }} Columns
 * @param {Columns} told
 * @returns {Omit<Columns, "tick" | "start_tick"> & { tick: Float64Array, start_tick: Float64Array }}
 */
function lasting(told) {
  const tick = summed(told.tick);
  return { ...told, tick, start_tick: tick.map((end, i) => end - told.start_tick[i]) };
}

/**
 * @param {ToldRun} data
 * @returns {Events}
 */
function unpackEvents({ events: told, texts }) {
  /** @param {number[]} column */
  const read = (column) => column.map((text) => texts[text]);
  const { decision_made: made, bundle_arrived: bundles, visit_ended: ended } = told;
  const picked = lasting(told.item_picked);
  const robots = new Map(told.visit_started.visit.map((visit, i) => [visit, told.visit_started.robot[i]]));
  return {
    order_arrived: timed(told.order_arrived),
    order_in_stock: timed(told.order_in_stock),
    order_assigned: timed(told.order_assigned),
    trip_decided: timed(told.trip_decided),
    task_assigned: timed(told.task_assigned),
    pod_lifted: lasting(told.pod_lifted),
    pod_stored: lasting(told.pod_stored),
    queue_joined: timed(told.queue_joined),
    visit_started: timed(told.visit_started),
    item_picked: { ...picked, picker_free_tick: picked.tick.map((tick, i) => tick + told.item_picked.picker_free_tick[i]) },
    visit_ended: { ...timed(ended), robot: ended.visit.map((visit) => robots.get(visit) ?? -1) },
    order_cancelled: timed(told.order_cancelled),
    order_completed: timed(told.order_completed),
    packing_assigned: timed(told.packing_assigned),
    part_sent: timed(told.part_sent),
    part_arrived: timed(told.part_arrived),
    part_put: lasting(told.part_put),
    order_consolidated: timed(told.order_consolidated),
    packing_started: timed(told.packing_started),
    order_packed: lasting(told.order_packed),
    bundle_arrived: { ...timed(bundles), name: read(bundles.name) },
    bundle_assigned: timed(told.bundle_assigned),
    bundle_bound: timed(told.bundle_bound),
    bundle_stored: lasting(told.bundle_stored),
    station_opened: timed(told.station_opened),
    station_closed: timed(told.station_closed),
    robots_on_duty: timed(told.robots_on_duty),
    robot_down: timed(told.robot_down),
    robot_up: timed(told.robot_up),
    station_down: timed(told.station_down),
    station_up: timed(told.station_up),
    charger_down: timed(told.charger_down),
    charger_up: timed(told.charger_up),
    robot_sent: timed(told.robot_sent),
    robot_rested: timed(told.robot_rested),
    pod_move_decided: timed(told.pod_move_decided),
    decision_made: { ...timed(made), decides: read(made.decides), rule: read(made.rule), status: read(made.status) },
  };
}

/**
 * The events of all kinds in the order in which they happened.
 * @param {ToldRun} data
 * @param {Events} events
 * @returns {Sequence}
 */
function sequenceOf({ order, events: told }, events) {
  const n = order.length;
  const names = /** @type {EventName[]} */ (Object.keys(told));
  const sequence = { n, names, kind: new Uint8Array(n), index: new Int32Array(n), tick: new Float64Array(n) };
  const next = names.map(() => 0);
  for (let i = 0; i < n; i++) {
    const kind = order.charCodeAt(i) - 97;
    sequence.kind[i] = kind;
    sequence.index[i] = next[kind]++;
    sequence.tick[i] = events[names[kind]].tick[sequence.index[i]];
  }
  return sequence;
}

/**
 * Charge of each robot over time; null without batteries.
 * @param {ToldRun["charges"]} packed
 * @returns {ChargeLine[] | null}
 */
function unpackCharges(packed) {
  if (!packed.n.length) return null;
  const at = offsets(packed.n);
  return packed.n.map((_, robot) => ({
    tick: summed(packed.tick.slice(at[robot], at[robot + 1])),
    charge: Float64Array.from(packed.charge.slice(at[robot], at[robot + 1]), (value) => value / 10000),
  }));
}

/**
 * @param {ToldRun["decisions"]} packed
 * @returns {Decisions | null}
 */
function unpackDecisions(packed) {
  if (!packed) return null;
  return {
    tick: summed(packed.tick),
    decides: packed.decides.map((text) => packed.texts[text]),
    rule: packed.rule.map((text) => packed.texts[text]),
    backlog: packed.backlog,
    at: offsets(packed.parts),
    what: packed.what,
    one: packed.one,
    other: packed.other,
  };
}

/**
 * Make the run that everything else here reads. Cells are `row * width + column`, times ticks of 1 ms.
 * @param {ToldRun} data
 * @returns {Run}
 */
export function unpack(data) {
  const events = unpackEvents(data);
  const linesAt = offsets(data.orders.lines_n);
  const contentsAt = offsets(data.pods.contents_n);
  /**
   * @param {number[]} flat
   * @param {Int32Array} at
   * @param {number} i
   */
  const pairs = (flat, at, i) => {
    /** @type {SkuItems[]} */
    const found = [];
    for (let k = at[i]; k < at[i + 1]; k++) found.push([flat[2 * k], flat[2 * k + 1]]);
    return found;
  };
  return {
    ...data,
    legs: unpackLegs(data),
    events,
    sequence: sequenceOf(data, events),
    decisions: unpackDecisions(data.decisions),
    charges: unpackCharges(data.charges),
    lines: data.orders.name.map((_, i) => pairs(data.orders.lines, linesAt, i)),
    contents: data.pods.name.map((_, i) => pairs(data.pods.contents, contentsAt, i)),
  };
}
