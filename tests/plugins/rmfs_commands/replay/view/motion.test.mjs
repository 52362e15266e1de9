// Where robots are, by the formulas of the trace's description.

import assert from "node:assert/strict";
import { test } from "node:test";
import { lastUpTo, metresAt, place, runSeconds } from "../../../../../plugins/rmfs_commands/replay/view/motion.mjs";
import { sample } from "./sample.mjs";

const MOTION = { acceleration: 1, speed: 1.5 };

test("a short run is a triangle, a long one a trapezium", () => {
  assert.equal(runSeconds(MOTION, 1), 2);
  assert.equal(runSeconds(MOTION, 9), 9 / 1.5 + 1.5);
});

test("a run begins and ends at rest, and is half done at half time", () => {
  for (const metres of [1, 2, 3, 40]) {
    const total = runSeconds(MOTION, metres);
    assert.equal(metresAt(MOTION, metres, 0), 0);
    assert.equal(metresAt(MOTION, metres, total), metres);
    assert.ok(Math.abs(metresAt(MOTION, metres, total / 2) - metres / 2) < 1e-9);
    assert.ok(metresAt(MOTION, metres, 0.1) < 0.0051);
  }
  assert.equal(metresAt(MOTION, 9, 1.5), 1.125);
  assert.equal(metresAt(MOTION, 9, 2.5), 2.625);
});

test("the last value up to another is found", () => {
  assert.equal(lastUpTo([1, 3, 3, 7], 0), -1);
  assert.equal(lastUpTo([1, 3, 3, 7], 3), 2);
  assert.equal(lastUpTo([1, 3, 3, 7], 99), 3);
  assert.equal(lastUpTo([], 1), -1);
});

test("a leg is standing, turning, driving, resting", () => {
  const run = sample();
  const at = (tick) => place(run, 0, tick, {});
  assert.deepEqual(at(0), { leg: -1, moving: false, x: 0, y: 0, heading: 1 });
  assert.deepEqual(at(2900), { leg: 0, moving: false, x: 0, y: 0, heading: 1 });
  assert.deepEqual(at(3000 + 312.5), { leg: 0, moving: true, x: 0, y: 0, heading: 0.5 }); // half way from north to east
  assert.equal(at(3625 + 1000).x, 0.5);
  assert.deepEqual(at(7792), { leg: 1, moving: true, x: 4, y: 0, heading: 0 });
  assert.equal(at(7792 + 312.5).heading, -0.5); // from east to south by the shorter way
  assert.deepEqual(at(30000), { leg: 2, moving: false, x: 5, y: 1, heading: 0 });
});

test("a leg that the end cuts off goes on between its cells", () => {
  const run = sample();
  const legs = run.legs[0];
  legs.whole[2] = 5;
  legs.run[2] = 1800;
  const end = place(run, 0, 30000, {});
  assert.equal(end.x, 4 + metresAt(MOTION, 5, 1.8));
  assert.equal(end.moving, false);
});
