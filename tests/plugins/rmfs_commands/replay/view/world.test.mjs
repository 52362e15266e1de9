// The warehouse at any time, forwards and backwards.

import assert from "node:assert/strict";
import { test } from "node:test";
import { ORDER, World } from "../../../../../plugins/rmfs_commands/replay/view/world.mjs";
import { cancelled, packs, replenished, sample } from "./sample.mjs";

const plain = (world) => ({
  pods: [...world.podCell], carried: [...world.robotPod], orders: [...world.orders], open: [...world.openItems()],
  stations: world.stations.map(({ line, visit, open, items }) => ({ line: [...line], visit, open: [...open], items })),
  counts: [world.backlog, world.done, world.picks, world.visits],
});

test("orders arrive, are assigned, and are picked", () => {
  const world = new World(sample());
  assert.deepEqual([...world.go(0).orders], [ORDER.ASSIGNED, ORDER.ABSENT]);
  assert.deepEqual([...world.openItems()], [2, 1]);
  assert.deepEqual([...world.go(5000).openItems()], [3, 1]); // the second order wants an a, too
  assert.equal(world.backlog, 1);
  assert.deepEqual([...world.go(20042).stations[0].open], [[0, 2]]);
  assert.deepEqual([...world.openItems()], [2, 1]);
  assert.deepEqual([world.picks, world.visits, world.done], [1, 1, 0]);
});

test("a cancelled order waits no more, and nothing is wanted for it", () => {
  const world = new World(cancelled());
  assert.deepEqual([world.go(27999).backlog, world.demand[0], world.cancelled], [1, 1, 0]);
  assert.deepEqual([world.go(28000).backlog, world.demand[0], world.cancelled], [0, 0, 1]);
  assert.equal(world.orders[1], ORDER.CANCELLED);
  assert.deepEqual([world.go(27999).backlog, world.cancelled], [1, 0]);
});

test("a pod is in storage, carried, in line, at the station", () => {
  const world = new World(sample());
  assert.equal(world.go(2199).podCell[0], 0);
  assert.deepEqual([world.go(2200).podCell[0], world.robotPod[0]], [-1, 0]);
  assert.deepEqual(world.go(10417).stations[0].line, [0]);
  assert.deepEqual(world.go(13042).stations[0].visit, { pod: 0, robot: 0 });
  assert.deepEqual(world.go(27042).stations[0].line, []);
});

test("going back is as having never gone on", () => {
  const run = sample();
  const world = new World(run);
  for (const tick of [30000, 20042, 5000, 13041, 0, 27042, 2200]) {
    assert.deepEqual(plain(world.go(tick)), plain(new World(run).go(tick)), String(tick));
  }
});

test("no more items are wanted of a pod than it has", () => {
  const run = sample();
  run.lines[0][1][1] = 5;
  assert.equal(new World(run).go(0).openItems()[1], 1);
});

test("bundles wait, are given to stations, and become items on pods", () => {
  const world = new World(replenished());
  assert.deepEqual([...world.go(14000).waitingBundles], [0, 1]);
  assert.deepEqual([...world.go(15000).waitingBundles], [1]);
  assert.deepEqual([...world.stations[0].bundles], [0]);
  assert.equal(world.stock[1].get(0), undefined);
  world.go(26000);
  assert.deepEqual([world.stock[1].get(0), world.stock[1].get(1), world.stations[0].bundles.size], [4, 1, 0]);
  assert.deepEqual(world.go(0).bundles, []);
});

test("stations close and open, robots go off duty, pods are moved, batteries run down and are charged", () => {
  const world = new World(replenished());
  assert.deepEqual([world.go(0).closed.has(0), world.onDuty, world.moves], [true, 1, 1]);
  assert.deepEqual([world.go(27000).closed.has(0), world.onDuty, world.podCell[0]], [false, 0, 3]);
  assert.deepEqual([0, 6000, 12000, 14000, 16000, 30000].map((tick) => world.go(tick).charge(0)), [1, 0.7, 0.4, 0.5, 0.6, 0.6]);
  assert.equal(new World(sample()).charge(0), null);
});

test("totes come, wait, and are put into boxes; orders are packed", () => {
  const world = new World(packs());
  const at = (tick) => [world.go(tick).packing[0], world.putting(0), [...world.boxes(0)], world.packs.get(0)?.items];
  assert.deepEqual(at(1000), [{ coming: 1, waiting: 0, packing: 0, packed: 0 }, 0, [[1, 0]], 0]);
  assert.deepEqual(at(4000), [{ coming: 0, waiting: 2, packing: 0, packed: 0 }, 1, [[1, 0]], 0]); // one of them is being put
  assert.deepEqual(at(7000), [{ coming: 0, waiting: 1, packing: 0, packed: 0 }, 1, [[1, 0]], 1]);
  assert.deepEqual(at(8000), [{ coming: 0, waiting: 0, packing: 1, packed: 0 }, 0, [[1, 0]], 3]);
  assert.deepEqual(at(9000), [{ coming: 0, waiting: 0, packing: 0, packed: 1 }, 0, [], undefined]);
  assert.deepEqual(at(2000)[0], { coming: 2, waiting: 0, packing: 0, packed: 0 });
  assert.equal(new World(packs(true)).go(2500).boxes(0).size, 0);
});
