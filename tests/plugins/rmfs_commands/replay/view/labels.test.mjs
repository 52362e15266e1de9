// Words around the pictures.

import assert from "node:assert/strict";
import { test } from "node:test";
import { edgesFor, levelOf } from "../../../../../plugins/rmfs_commands/replay/view/draw.mjs";
import { brief, numbers, suggestions, thingNamed } from "../../../../../plugins/rmfs_commands/replay/view/labels.mjs";
import { histories, Names } from "../../../../../plugins/rmfs_commands/replay/view/story.mjs";
import { World } from "../../../../../plugins/rmfs_commands/replay/view/world.mjs";
import { packs, replenished, sample } from "./sample.mjs";

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

test("a packing station is found and said", () => {
  const run = packs();
  const packing = { run, names: new Names(run), world: new World(run).go(4000), distance: () => 0 };
  assert.deepEqual(thingNamed(packing, "packing station 1"), { kind: "packing", id: 0 });
  assert.equal(thingNamed(packing, "packing station 2"), null);
  assert.equal(thingNamed(view, "packing station 1"), null);
  assert.ok(suggestions(packing).includes("packing station 1"));
  assert.equal(brief(packing, { kind: "packing", id: 0 }), "packing station 1: 1 box in use, 1 waiting");
  assert.match(numbers(packing), /^1 order, 0 picks, 0 visits, 0 packed, /);
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

const more = replenished();
const richer = (tick) => ({ run: more, names: new Names(more), history: histories(more), world: new World(more).go(tick), distance: () => 0 });

test("bundles have names and are counted", () => {
  assert.deepEqual(thingNamed(richer(0), "bundle second"), { kind: "bundle", id: 1 });
  assert.match(numbers(richer(15000)), /backlog 0, 1 bundle waiting, /);
  assert.ok(suggestions(richer(0)).includes("bundle first"));
});

test("a thing in a few words", () => {
  const said = (tick, kind, id) => brief(richer(tick), { kind, id });
  assert.equal(said(12000, "robot", 0), "robot 1: stands at a charger, 40 % charged");
  assert.equal(said(16000, "station", 0), "station 1, 1 bundle to store, closed");
  assert.equal(said(27000, "station", 0), "station 1");
  assert.equal(said(0, "charger", 5), "charger at row 1, column 6");
  assert.equal(brief({ ...view, history: histories(run) }, { kind: "robot", id: 0 }), "robot 1: stands at station 1 with pod p");
});
