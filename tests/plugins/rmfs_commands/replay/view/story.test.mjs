// What things do, did, and why.

import assert from "node:assert/strict";
import { test } from "node:test";
import { bundleStatus, doing, histories, loadSaid, Names, orderStatus, phaseOf, tell, waitsOn, why } from "../../../../../plugins/rmfs_commands/replay/view/story.mjs";
import { World } from "../../../../../plugins/rmfs_commands/replay/view/world.mjs";
import { packs, replenished, sample } from "./sample.mjs";

const run = sample();
const names = new Names(run);
const history = histories(run);
const at = (tick) => phaseOf(run, history, 0, tick, new World(run).go(tick));

test("what a robot is at", () => {
  const phases = [0, 2200, 10417, 13042, 27042].map((tick) => at(tick).phase);
  assert.deepEqual(phases, ["lifting", "to_station", "queue", "station", "storing"]);
  assert.deepEqual(at(5000), { phase: "to_station", pod: 0, station: 0, since: 2200 });
  assert.equal(doing(names, at(5000), false), "carries pod p to station 1");
  assert.equal(doing(names, at(27042), true), "takes pod p to storage; waits for other robots or a queue cell");
});

test("a robot on a way that does not move waits; one in a queue queues", () => {
  const [legs] = run.legs;
  assert.ok(waitsOn(at(2500), { moving: false, leg: 0 }, legs));
  assert.ok(!waitsOn(at(2500), { moving: true, leg: 0 }, legs));
  assert.ok(!waitsOn(at(10417), { moving: false, leg: 1 }, legs));
  assert.ok(!waitsOn(at(27042), { moving: false, leg: 2 }, legs)); // its last leg: what comes is not told
});

test("histories tell what concerns each", () => {
  const told = (kind, id) => history[kind][id].map((place) => tell(run, names, place, kind));
  assert.deepEqual(told("robot", 0), [
    "told to fetch pod p", "lifted pod p", "joined the queue of station 1", "stood at station 1", "left station 1 after 2 picks",
  ]);
  assert.deepEqual(told("pod", 0).slice(0, 3), ["sent to station 1", "robot 1 comes for it", "lifted by robot 1 at row 1, column 1"]);
  assert.deepEqual(told("station", 0), ["given order first, 3 items in period 1", "pod p came", "pod p left after 2 picks"]);
  assert.deepEqual(told("order", 0).slice(0, 3), [
    "arrived", "assigned to station 1: 3 items in period 1", "SKU a picked from pod p at station 1",
  ]);
  assert.deepEqual(told("pod", 1), []);
});

test("how far an order has come", () => {
  const status = (order, tick) => orderStatus(names, new World(run).go(tick), order);
  assert.equal(status(1, 0), "has not arrived yet");
  assert.equal(status(1, 5000), "waits in the backlog: 1 item");
  assert.equal(status(0, 20042), "at station 1: 2 items to pick");
  const packing = packs();
  const packed = (tick) => orderStatus(names, new World(packing).go(tick), 0);
  assert.equal(packed(7000), "picked, 1 item in box 2 at packing station 1");
  assert.deepEqual([packed(8000), packed(9000)], ["is being packed at packing station 1", "packed"]);
});

test("why: the decision that the trace tells of", () => {
  assert.deepEqual(why(run, names, "pod", 0, 9000), {
    lines: [
      "PPS by demand at 0:00:00: pod p goes to station 1.",
      "demand: Send the pod whose contents are wanted most.",
      "It saw 0 orders in the backlog.",
    ],
    number: 0,
    tick: 0,
  });
  const order = why(run, names, "order", 0, 9000);
  assert.equal(order.lines.at(-1), "The solve ended optimal: objective 4.5, bound 3.");
  assert.equal(why(run, names, "order", 1, 9000), null);
});

test("why: the recorded decision says more, and its number", () => {
  const recorded = { tick: [0, 0], decides: ["PPS", "TA"], rule: ["demand", "nearest"], backlog: [4, 4], at: [0, 1, 2], what: [1, 2], one: [0, 0], other: [0, 0] };
  const found = why({ ...run, decisions: recorded }, names, "robot", 0, 100);
  assert.deepEqual(found.lines, ["TA by nearest at 0:00:00: robot 1 fetches pod p.", "It saw 4 orders in the backlog."]);
  assert.equal(found.number, 2);
  assert.equal(why({ ...run, decisions: recorded }, names, "pod", 0, 100).number, 1);
});

const more = replenished();
const moreNames = new Names(more);
const moreHistory = histories(more);
const robotAt = (tick) => phaseOf(more, moreHistory, 0, tick, new World(more).go(tick));

test("what a robot is at that has no order", () => {
  assert.deepEqual([0, 3000, 7000, 9000, 12000, 17000].map((tick) => robotAt(tick).phase), [
    "lifting", "moving", "setting_down", "to_rest", "charging", "lifting",
  ]);
  assert.equal(doing(moreNames, robotAt(3000), false), "carries pod p to row 1, column 4, without a visit");
  assert.equal(doing(moreNames, robotAt(9000), false), "on its way to the charger at row 1, column 6");
  assert.equal(robotAt(19000).cell, undefined); // what it carries to a station is not moved
  assert.ok(waitsOn(robotAt(3000), { moving: false, leg: 0 }, more.legs[0]));
});

test("a robot at a charger is idle where there are no batteries", () => {
  assert.equal(phaseOf({ ...more, charges: null }, moreHistory, 0, 12000, null).phase, "idle");
});

test("histories of bundles, and of what stores, closes, rests and is moved", () => {
  const told = (kind, id) => moreHistory[kind][id].map((place) => tell(more, moreNames, place, kind));
  assert.deepEqual(told("bundle", 0), ["arrived: 4 × SKU a", "assigned to station 1", "is to be stored on pod q", "stored on pod q"]);
  assert.deepEqual(told("station", 0), [
    "closed: takes no new orders", "given bundle first", "pod q came", "bundle first stored on pod q: 4 × SKU a", "opened",
  ]);
  assert.deepEqual(told("pod", 1), [
    "is to hold bundle first", "sent to station 1", "robot 1 comes for it", "lifted by robot 1 at row 1, column 2",
    "joined the queue of station 1", "stood at station 1", "bundle first stored at station 1: 4 × SKU a",
  ]);
  assert.equal(told("pod", 0)[0], "robot 1 comes to carry it to row 1, column 4");
  assert.deepEqual(told("robot", 0).slice(0, 5), [
    "told to carry pod p to row 1, column 4", "lifted pod p", "stored pod p at row 1, column 4",
    "sent to the charger at row 1, column 6", "came to the charger at row 1, column 6",
  ]);
});

test("how far a bundle has come", () => {
  const status = (tick) => bundleStatus(moreNames, new World(more).go(tick), 0);
  assert.deepEqual([0, 14000, 15000, 16000, 26000].map(status), [
    "has not arrived yet", "waits for a station", "at station 1, waits for a pod", "at station 1, to be stored on pod q", "stored on pod q",
  ]);
});

test("why: decisions about bundles, robots and pods that are moved", () => {
  const first = (kind, id, tick, run = more) => why(run, moreNames, kind, id, tick)?.lines;
  assert.deepEqual(first("bundle", 0, 15000), ["ROA by first-bundle at 0:00:15: bundle first goes to station 1.", "2 bundles waited for a station."]);
  assert.deepEqual(first("bundle", 0, 16000), ["RPS by emptiest-pod at 0:00:16: bundle first is stored on pod q."]);
  assert.equal(first("pod", 1, 16000)[0], "RPS by emptiest-pod at 0:00:16: pod q goes to station 1.");
  assert.equal(first("bundle", 1, 16000), undefined);
  const decisions = {
    tick: [0, 9000, 15000, 16000], decides: ["repositioning", "idle", "ROA", "RPS"], rule: ["cache", "rest", "first-bundle", "emptiest-pod"],
    backlog: [0, 0, 2, 1], at: [0, 1, 2, 3, 4], what: [6, 5, 3, 4], one: [0, 0, 0, 0], other: [3, 5, 0, 1],
  };
  const recorded = (kind, id) => first(kind, id, 16000, { ...more, decisions })[0];
  assert.equal(recorded("pod", 0), "repositioning by cache at 0:00:00: pod p is carried to row 1, column 4.");
  assert.equal(recorded("robot", 0), "idle by rest at 0:00:09: robot 1 goes to the charger at row 1, column 6.");
  assert.equal(recorded("bundle", 0), "RPS by emptiest-pod at 0:00:16: bundle first is stored on pod q.");
  assert.equal(recorded("pod", 1), "RPS by emptiest-pod at 0:00:16: bundle first is stored on pod q.");
});

test("a large order is said to be alone at its station, not to be more than fits", () => {
  assert.equal(loadSaid(93, 100, "items"), "93 of 100 items");
  assert.equal(loadSaid(553, 100, "items"), "553 items of a large order, alone at the station; otherwise at most 100");
});
