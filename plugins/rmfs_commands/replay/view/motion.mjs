// @ts-check
// Where robots are: the formulas of rmfs_core.motion.Motion, and the legs of a trace.

/** @import { ChargeLine, Motion, Position, Run } from "./types.d.ts" */

/**
 * Seconds of a straight run from rest to rest.
 * @param {Motion} motion
 * @param {number} metres
 */
export function runSeconds(motion, metres) {
  const { acceleration: a, speed: v } = motion;
  return metres >= (v * v) / a ? metres / v + v / a : 2 * Math.sqrt(metres / a);
}

/**
 * Metres from the start, `seconds` after the start of a run over `metres`.
 * @param {Motion} motion
 * @param {number} metres
 * @param {number} seconds
 */
export function metresAt(motion, metres, seconds) {
  const { acceleration: a, speed: v } = motion;
  const total = runSeconds(motion, metres);
  const ramp = Math.min(v / a, total / 2);
  if (seconds <= ramp) return (a * seconds ** 2) / 2;
  if (seconds >= total - ramp) return metres - (a * Math.max(total - seconds, 0) ** 2) / 2;
  return (a * ramp ** 2) / 2 + v * (seconds - ramp);
}

/**
 * Index of the last of `n` ascending values that is not above `value`; -1 when all are.
 * @param {ArrayLike<number>} values
 * @param {number} value
 */
export function lastUpTo(values, value, n = values.length) {
  let low = 0;
  let high = n;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/**
 * Charge at a time on a line of points.
 * @param {ChargeLine} line
 * @param {number} tick
 */
export function between({ tick: ticks, charge }, tick) {
  const i = lastUpTo(ticks, tick);
  if (i < 0 || i + 1 >= ticks.length) return charge[Math.max(i, 0)];
  return charge[i] + ((charge[i + 1] - charge[i]) * (tick - ticks[i])) / (ticks[i + 1] - ticks[i]);
}

/** Columns and rows of a step in each heading. */
export const STEP_X = [1, 0, -1, 0];
export const STEP_Y = [0, -1, 0, 1];

/** @returns {Position} */
export const nowhere = () => ({ x: 0, y: 0, heading: 0, moving: false, leg: -1 });

/**
 * Say where a robot is: column, row and heading (quarters of a turn, 0 east, 1 north) go to `out.x`, `out.y`,
 * `out.heading`; `out.moving` says whether it drives or turns, `out.leg` which leg it is on (-1: none yet).
 * @param {Run} run
 * @param {number} robot
 * @param {number} tick
 * @param {Position} out
 */
export function place(run, robot, tick, out) {
  const legs = run.legs[robot];
  const i = lastUpTo(legs.start, tick);
  out.leg = i;
  out.moving = false;
  if (i < 0) {
    out.x = legs.x0;
    out.y = legs.y0;
    out.heading = legs.heading0;
    return out;
  }
  const before = i ? legs.towards[i - 1] : legs.heading0;
  const towards = legs.towards[i];
  let since = tick - legs.start[i] - legs.wait[i];
  out.x = legs.x[i];
  out.y = legs.y[i];
  if (since < 0) {
    out.heading = before;
    return out;
  }
  if (since < legs.turn[i]) {
    const quarters = ((towards - before + 6) % 4) - 2; // the shorter way round
    out.heading = before + (quarters * since) / legs.turn[i];
    out.moving = true;
    return out;
  }
  since -= legs.turn[i];
  out.heading = towards;
  out.moving = since < legs.run[i];
  let metres = legs.metres[i];
  if (out.moving || legs.whole[i] !== metres) {
    metres = metresAt(run.motion, legs.whole[i], Math.min(since, legs.run[i]) / 1000);
  }
  out.x += STEP_X[towards] * metres;
  out.y += STEP_Y[towards] * metres;
  return out;
}
