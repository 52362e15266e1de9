// @ts-check
// What the time line shows: throughput, backlog, and the rounds of decisions.

/** @import { Run, Series } from "./types.d.ts" */

const BINS = 120;
const NICE_MINUTES = [1, 2, 5, 10, 15, 30, 60, 120, 240, 480, 1440];

/**
 * Width of a bin: a round number of minutes, so that there are at most about 120; shorter in a run of minutes.
 * @param {number} end
 */
export function binTicks(end) {
  const minutes = end / 60000 / BINS;
  const found = NICE_MINUTES.find((nice) => nice >= minutes) ?? Math.ceil(minutes / 1440) * 1440;
  return minutes < 0.5 ? Math.max(Math.ceil(end / BINS / 5000) * 5000, 5000) : found * 60000;
}

/**
 * The earliest time at which one of some runs begins: in its state, or at 0.
 * @param {Run[]} runs
 */
export function beginOf(runs) {
  return Math.min(...runs.map((run) => run.begin ?? 0));
}

/**
 * Picks per hour in each bin, orders in the backlog at the end of each, and the times of decisions.
 * @param {Run} run
 * @returns {Series}
 */
export function seriesOf(run, end = run.tick, begin = 0) {
  const width = binTicks(end - begin);
  const n = Math.max(Math.ceil((run.tick - begin) / width), 1);
  /** @param {number} tick */
  const bin = (tick) => Math.max(Math.min(Math.floor((tick - begin) / width), n - 1), 0);
  const picks = new Float64Array(n);
  for (const tick of run.events.item_picked.tick) if (tick >= begin) picks[bin(tick)]++;
  const perHour = picks.map((number, i) => (number * 3600000) / Math.max(Math.min(width, run.tick - begin - i * width), 1));
  const change = new Float64Array(n);
  for (const tick of run.events.order_arrived.tick) change[bin(tick)]++;
  const { tick: assigned, complete } = run.events.order_assigned;
  assigned.forEach((tick, i) => complete[i] && change[bin(tick)]--);
  for (const tick of run.events.order_cancelled.tick) change[bin(tick)]--;
  let sum = 0;
  const backlog = change.map((number) => (sum += number));
  const first = Math.max(run.events.order_arrived.tick[0] ?? 0, run.begin ?? 0);
  return { width, perHour, backlog, rounds: roundsOf(run), events: eventsOf(run), first };
}

/**
 * Times at which anything happened besides driving and decisions, each once.
 * @param {Run} run
 */
export function eventsOf({ sequence: { names, kind, tick } }) {
  return Float64Array.from(new Set(tick.filter((_, i) => names[kind[i]] !== "decision_made")));
}

/**
 * The next of some ascending times after another, or the one before it; an infinite number where there is none.
 * @param {Float64Array} times
 * @param {number} tick
 * @param {number} direction
 */
export function nextOf(times, tick, direction) {
  if (direction > 0) return times.find((one) => one > tick) ?? Infinity;
  return times.findLast((one) => one < tick) ?? -Infinity;
}

/**
 * Times at which anything was decided, each once.
 * @param {Run} run
 */
export function roundsOf(run) {
  const ticks = [...run.events.decision_made.tick, ...(run.decisions?.tick ?? [])].sort((a, b) => a - b);
  return Float64Array.from(new Set(ticks));
}
