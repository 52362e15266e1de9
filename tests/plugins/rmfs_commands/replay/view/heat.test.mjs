// Heat maps: figures of a whole run.

import assert from "node:assert/strict";
import { test } from "node:test";
import { heatClass, heatEdges, heatOf } from "../../../../../plugins/rmfs_commands/replay/view/heat.mjs";
import { histories } from "../../../../../plugins/rmfs_commands/replay/view/story.mjs";
import { replenished, sample } from "./sample.mjs";

const run = sample();
const heat = (name) => heatOf(run, histories(run), name);
const there = ({ values }) => Object.fromEntries([...values].flatMap((value, i) => (value ? [[i, value]] : [])));

test("traffic counts each cell that a robot drove into", () => {
  assert.deepEqual(there(heat("traffic")), { 1: 1, 2: 1, 3: 1, 4: 1, 10: 1, 11: 1 });
});

test("waiting counts robots on a way that stand; not lifting, queueing or serving", () => {
  // Before the first leg. What the robot does after its last visit is not told: the run ends.
  assert.deepEqual(there(heat("waiting")), { 0: 0.8 });
});

test("waiting is what robots.csv counts: not who rests, charges or moves a pod", () => {
  const more = replenished();
  // On its way to the station it has no leg any more; before its first leg it moved pod p.
  assert.deepEqual(there(heatOf(more, histories(more), "waiting")), { 11: 1.8 });
});

test("picks by pod, and the share of time in storage", () => {
  assert.deepEqual(there(heat("picks")), { 0: 2 });
  const storage = heat("storage").values;
  assert.equal(storage[1], 100);
  assert.ok(Math.abs(storage[0] - (100 * 2200) / 30000) < 1e-9);
});

test("classes double, shares are even, and no two classes end alike", () => {
  assert.deepEqual(heatEdges({ most: 320, unit: "s" }), [10, 20, 40, 80, 160, 320]);
  assert.deepEqual(heatEdges({ most: 100, unit: "%" }), [17, 34, 50, 67, 84, 100]);
  assert.deepEqual(heatEdges({ most: 3, unit: "" }), [1, 2, 3]);
  assert.deepEqual([1, 2, 3].map((value) => heatClass([1, 2, 3], value)), [3, 4, 5]);
  assert.equal(heatClass([1, 2, 3], 99), 5);
});
