// What there is in some warehouses only.

import assert from "node:assert/strict";
import { test } from "node:test";
import { featuresOf } from "../../../../../plugins/rmfs_commands/replay/view/features.mjs";
import { packs, replenished, sample } from "./sample.mjs";

test("what a run has is seen from its layout, its stations and its events", () => {
  const none = { bundles: false, storing: false, chargers: false, maintenance: false, down: false, closed: false, moves: false, packing: false };
  assert.deepEqual(featuresOf(sample()), none);
  assert.deepEqual(featuresOf(replenished()), { bundles: true, storing: true, chargers: true, maintenance: false, down: false, closed: true, moves: true, packing: false });
  assert.equal(featuresOf(packs()).packing, true);
});
