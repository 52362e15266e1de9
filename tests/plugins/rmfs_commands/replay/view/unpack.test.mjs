// Unpacking: differences become times, counts places.

import assert from "node:assert/strict";
import { test } from "node:test";
import { deflateSync } from "node:zlib";
import { inflate, unpack } from "../../../../../plugins/rmfs_commands/replay/view/unpack.mjs";
import { packed, sample } from "./sample.mjs";

test("what was compressed is read", async () => {
  const text = deflateSync(JSON.stringify(packed())).toString("base64");
  assert.deepEqual(await inflate(text), packed());
});

test("times are those of the events", () => {
  const { events, sequence } = sample();
  assert.deepEqual([...events.item_picked.tick], [20042, 27042]);
  assert.deepEqual([...events.item_picked.start_tick], [13042, 26042]);
  assert.deepEqual([...events.item_picked.picker_free_tick], [26042, 29000]);
  assert.deepEqual([...sequence.tick].slice(-3), [20042, 27042, 27042]);
  assert.equal(sequence.names[sequence.kind[12]], "visit_ended");
});

test("texts, lines and contents are what they stand for", () => {
  const run = sample();
  assert.deepEqual(run.events.decision_made.rule, ["pod-match", "demand"]);
  assert.deepEqual(run.lines, [[[0, 2], [1, 1]], [[0, 1]]]);
  assert.deepEqual(run.contents, [[[0, -1]], [[1, 1]]]);
});

test("a leg begins where and when the last one ended", () => {
  const [legs] = sample().legs;
  assert.deepEqual([...legs.start], [2200, 7792, 10417]);
  assert.deepEqual([...legs.x], [0, 4, 4]);
  assert.deepEqual([...legs.y], [0, 0, 1]);
});

test("a jump in a trace that is not sound is shown as it is", () => {
  const data = packed();
  data.legs.jump[1] = 1;
  assert.equal(unpack(data).legs[0].x[1], 5);
});
