// From the packed text in the page to a run with typed columns. rmfs_commands/replay/columns.py packs it.

import { STEP_X, STEP_Y } from "./motion.mjs";

/** Inflate base64 of a zlib stream, and read the JSON in it. */
export async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).json();
}

function summed(differences) {
  const values = new Float64Array(differences.length);
  let sum = 0;
  for (let i = 0; i < values.length; i++) values[i] = sum += differences[i];
  return values;
}

function offsets(counts) {
  const values = new Int32Array(counts.length + 1);
  for (let i = 0; i < counts.length; i++) values[i + 1] = values[i] + counts[i];
  return values;
}


function unpackLegs(data) {
  const { width } = data.layout;
  const at = offsets(data.legs.n);
  return data.legs.n.map((n, robot) => {
    const cut = (name) => Float64Array.from(data.legs[name].slice(at[robot], at[robot + 1]));
    const [wait, turn, run, towards, metres, whole] = ["wait", "turn", "run", "towards", "metres", "whole"].map(cut);
    const [gap, jump] = [cut("gap"), cut("jump")];
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

function unpackEvents(data) {
  const names = Object.keys(data.events);
  const events = {};
  for (const name of names) {
    const columns = { ...data.events[name] };
    columns.tick = summed(columns.tick);
    if (columns.start_tick) columns.start_tick = columns.tick.map((tick, i) => tick - columns.start_tick[i]);
    if (columns.picker_free_tick) {
      columns.picker_free_tick = columns.tick.map((tick, i) => tick + columns.picker_free_tick[i]);
    }
    if (columns.skus_n) columns.skus_at = offsets(columns.skus_n);
    for (const key of ["decides", "rule", "status", "name"]) {
      if (columns[key]) columns[key] = columns[key].map((text) => data.texts[text]);
    }
    events[name] = columns;
  }
  const n = data.order.length;
  const sequence = { n, names, kind: new Uint8Array(n), index: new Int32Array(n), tick: new Float64Array(n) };
  const next = names.map(() => 0);
  for (let i = 0; i < n; i++) {
    const kind = data.order.charCodeAt(i) - 97;
    sequence.kind[i] = kind;
    sequence.index[i] = next[kind]++;
    sequence.tick[i] = events[names[kind]].tick[sequence.index[i]];
  }
  return { events, sequence };
}

/** Charge of each robot over time, as shares: straight lines from point to point; null without batteries. */
function unpackCharges(packed) {
  if (!packed?.n.length) return null;
  const at = offsets(packed.n);
  return packed.n.map((_, robot) => ({
    tick: summed(packed.tick.slice(at[robot], at[robot + 1])),
    charge: Float64Array.from(packed.charge.slice(at[robot], at[robot + 1]), (value) => value / 10000),
  }));
}

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

/** Make the run that everything else here reads. Cells are `row * width + column`, times ticks of 1 ms. */
export function unpack(data) {
  const linesAt = offsets(data.orders.lines_n);
  const contentsAt = offsets(data.pods.contents_n);
  const pairs = (flat, at, i) => {
    const found = [];
    for (let k = at[i]; k < at[i + 1]; k++) found.push([flat[2 * k], flat[2 * k + 1]]);
    return found;
  };
  return {
    ...data,
    legs: unpackLegs(data),
    ...unpackEvents(data),
    decisions: unpackDecisions(data.decisions),
    charges: unpackCharges(data.charges),
    lines: data.orders.name.map((_, i) => pairs(data.orders.lines, linesAt, i)),
    contents: data.pods.name.map((_, i) => pairs(data.pods.contents, contentsAt, i)),
  };
}
