// Time that passes, and how it is written.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Clock, clockTime, duration, SPEEDS, spokenTime } from "../../../../../plugins/rmfs_commands/replay/view/clock.mjs";

test("time passes as fast as is said, while it plays", () => {
  const clock = new Clock(100000);
  clock.pass(1000);
  assert.equal(clock.tick, 0);
  clock.toggle();
  clock.speed = 20;
  clock.pass(1000);
  assert.equal(clock.tick, 20000);
});

test("it stops at the end, and begins anew from there", () => {
  const clock = new Clock(5000);
  clock.toggle();
  clock.pass(1000);
  assert.deepEqual([clock.tick, clock.playing], [5000, false]);
  clock.toggle();
  assert.deepEqual([clock.tick, clock.playing], [0, true]);
  clock.start = 3000;
  clock.pass(1000);
  clock.toggle();
  assert.equal(clock.tick, 3000);
});

test("no time is before the start or after the end", () => {
  const clock = new Clock(5000);
  clock.seek(-7);
  assert.equal(clock.tick, 0);
  clock.seek(9999);
  assert.equal(clock.tick, 5000);
});

test("speeds go from 1 to 200, a step at a time", () => {
  const clock = new Clock(1);
  for (let i = 0; i < 20; i++) clock.faster(1);
  assert.equal(clock.speed, 200);
  clock.faster(-1);
  assert.equal(clock.speed, 100);
  for (let i = 0; i < 20; i++) clock.faster(-1);
  assert.equal(clock.speed, SPEEDS[0]);
});

test("times are written for people", () => {
  assert.equal(clockTime(3725999), "1:02:05");
  assert.equal(spokenTime(3661000), "1 hour 1 minute 1 second");
  assert.equal(spokenTime(0), "the start");
  assert.deepEqual([42000, 185000, 7500000].map(duration), ["42 s", "3 min 5 s", "2 h 5 min"]);
});

test("where more is to come it waits at the end, and does not begin anew", () => {
  const clock = new Clock(5000);
  clock.waits = true;
  clock.toggle();
  clock.pass(1000);
  assert.deepEqual([clock.tick, clock.playing], [5000, true]);
  clock.toggle();
  clock.toggle();
  assert.deepEqual([clock.tick, clock.playing], [5000, true]);
  clock.end = 9000;
  clock.pass(100);
  assert.equal(clock.tick, 6000);
});
