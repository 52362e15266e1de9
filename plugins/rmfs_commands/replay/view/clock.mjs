// @ts-check
// Simulated time as a person sees it pass, and as it is written.

export const SPEEDS = [1, 2, 5, 10, 20, 50, 100, 200];

/** Times of 1 ms from `begin` to `end`, that pass `speed` times as fast as those of the person who watches. */
export class Clock {
  /** @param {number} end */
  constructor(end, begin = 0) {
    this.end = end;
    this.begin = begin;
    this.start = begin; // when there is something to see
    this.tick = begin;
    this.speed = 10;
    this.playing = false;
    this.waits = false; // at the end, for more to come
  }

  /**
   * Let time pass.
   * @param {number} milliseconds
   */
  pass(milliseconds) {
    if (!this.playing) return;
    this.seek(this.tick + milliseconds * this.speed);
    if (this.tick >= this.end && !this.waits) this.playing = false;
  }

  /** @param {number} tick */
  seek(tick) {
    this.tick = Math.min(Math.max(tick, this.begin), this.end);
  }

  /** Play or pause; at the end, play from the start. */
  toggle() {
    this.playing = !this.playing;
    if (this.playing && this.tick >= this.end && !this.waits) this.tick = this.start;
  }

  /** @param {number} steps */
  faster(steps) {
    const at = SPEEDS.indexOf(this.speed) + steps;
    this.speed = SPEEDS[Math.min(Math.max(at, 0), SPEEDS.length - 1)];
  }
}

/** @param {number} number */
const two = (number) => String(number).padStart(2, "0");

/**
 * A time as `h:mm:ss`.
 * @param {number} tick
 */
export function clockTime(tick) {
  const seconds = Math.floor(tick / 1000);
  return `${Math.floor(seconds / 3600)}:${two(Math.floor(seconds / 60) % 60)}:${two(seconds % 60)}`;
}

/**
 * A time as someone says it.
 * @param {number} tick
 */
export function spokenTime(tick) {
  const seconds = Math.floor(tick / 1000);
  /** @type {[number, string][]} */
  const parts = [[Math.floor(seconds / 3600), "hour"], [Math.floor(seconds / 60) % 60, "minute"], [seconds % 60, "second"]];
  const said = parts.filter(([number]) => number).map(([number, unit]) => `${number} ${unit}${number === 1 ? "" : "s"}`);
  return said.join(" ") || "the start";
}

/**
 * A length of time, short: `42 s`, `3 min 5 s`, `2 h 5 min`.
 * @param {number} ticks
 */
export function duration(ticks) {
  const seconds = Math.round(ticks / 1000);
  if (seconds < 60) return `${seconds} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min ${seconds % 60} s`;
  return `${Math.floor(seconds / 3600)} h ${Math.floor(seconds / 60) % 60} min`;
}
