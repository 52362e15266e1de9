// The figures of the time line.

import assert from "node:assert/strict";
import { test } from "node:test";
import { binTicks, nextOf, seriesOf } from "../../../../../plugins/rmfs_commands/replay/view/series.mjs";
import { sample } from "./sample.mjs";

test("bins are round, and about a hundred", () => {
  assert.equal(binTicks(8 * 3600000), 5 * 60000);
  assert.equal(binTicks(3600000), 60000);
  for (const end of [30000, 600000, 3.6e6, 2.9e7, 1e9]) assert.ok(end / binTicks(end) <= 121, String(end));
});

test("picks by the hour, the backlog, and the rounds", () => {
  const run = sample();
  const { width, perHour, backlog, rounds, events, first } = seriesOf(run);
  assert.equal(width, 5000);
  assert.deepEqual([...perHour], [0, 0, 0, 0, 720, 720]);
  assert.deepEqual([...backlog], [0, 1, 1, 1, 1, 1]);
  assert.deepEqual([...rounds], [0]);
  assert.equal(first, run.events.order_arrived.tick[0]);
  const times = new Set(Object.entries(run.events).flatMap(([kind, { tick }]) => (kind === "decision_made" ? [] : [...(tick ?? [])])));
  assert.deepEqual([...events], [...times].sort((a, b) => a - b));
  assert.deepEqual([nextOf(events, -1, 1), nextOf(events, events[1], -1)], [events[0], events[0]]);
  assert.deepEqual([nextOf(events, run.tick, 1), nextOf(events, 0, -1)], [Infinity, -Infinity]);
});

test("as many picks as the run had, whatever the bins", () => {
  const run = sample();
  const { width, perHour } = seriesOf(run, 3600000);
  const hours = perHour.map((value, i) => (value * Math.min(width, run.tick - i * width)) / 3600000);
  assert.equal(hours.reduce((a, b) => a + b), 2);
});
