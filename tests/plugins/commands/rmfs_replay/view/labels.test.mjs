// Words around the pictures.

import assert from "node:assert/strict";
import { test } from "node:test";
import { edgesFor, levelOf } from "../../../../../plugins/commands/rmfs_replay/view/draw.mjs";
import { numbers, suggestions, thingNamed } from "../../../../../plugins/commands/rmfs_replay/view/labels.mjs";
import { Names } from "../../../../../plugins/commands/rmfs_replay/view/story.mjs";
import { World } from "../../../../../plugins/commands/rmfs_replay/view/world.mjs";
import { sample } from "./sample.mjs";

const run = sample();
const view = { run, names: new Names(run), world: new World(run).go(20042), distance: () => 1234 };

test("things are found by their names", () => {
  assert.deepEqual(thingNamed(view, "Robot 1"), { kind: "robot", id: 0 });
  assert.deepEqual(thingNamed(view, " orders second "), { kind: "order", id: 1 });
  assert.deepEqual(thingNamed(view, "pod q"), { kind: "pod", id: 1 });
  for (const text of ["robot 2", "robot x", "order third", "first", ""]) assert.equal(thingNamed(view, text), null, text);
});

test("every suggestion is found", () => {
  const all = suggestions(view);
  assert.equal(all.length, 1 + 1 + 2 + 2);
  assert.ok(all.every((text) => thingNamed(view, text)));
});

test("the figures of a view in a line", () => {
  assert.equal(numbers(view), "0 orders, 1 pick, 1 visit, backlog 1, 1.2 km");
  const later = { ...view, world: new World(run).go(99999) };
  assert.match(numbers(later), /1\.2 km, ended at 0:00:30$/);
});

test("classes of open items reach to the most, whatever it is", () => {
  assert.deepEqual(edgesFor(59), [0, 8, 15, 30, 59]);
  assert.deepEqual(edgesFor(2), [0, 1, 2]);
  assert.deepEqual([0, 1, 8, 9, 59, 60].map((number) => levelOf(edgesFor(59), number)), [0, 1, 1, 2, 4, 4]);
});
