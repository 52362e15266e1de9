// A run that goes on: asked for until it has ended, or does not answer.

import assert from "node:assert/strict";
import { test } from "node:test";
import { deflateSync } from "node:zlib";
import { firstNews, follow, news } from "../../../../../plugins/rmfs_commands/replay/view/live.mjs";
import { packed } from "./sample.mjs";

const answer = (run) => ({ status: 200, ok: true, text: async () => deflateSync(JSON.stringify(run)).toString("base64") });
const nothing = { status: 204, ok: true };

function page() {
  return {
    end: 5, running: true, runs: [], said: null,
    renew([run]) {
      this.runs.push(run);
      this.end = run.tick;
      this.running = run.status === "running";
    },
    stop(why) {
      this.running = false;
      this.said = why;
    },
  };
}

test("what is new is asked for by the time that is known", async () => {
  const asked = [];
  const found = await news(7, async (address) => (asked.push(address), answer(packed())));
  assert.deepEqual([asked, found.name], [["run?after=7"], packed().name]);
  assert.equal(await news(7, async () => nothing), null);
});

test("at first it is asked until there is anything", async () => {
  const answers = [nothing, nothing, answer(packed())];
  assert.equal((await firstNews(async () => answers.shift())).tick, packed().tick);
  assert.equal(answers.length, 0);
});

test("a page is given what is new until the run has ended", async () => {
  const shown = page();
  const answers = [answer({ ...packed(), status: "running", tick: 9 }), nothing, answer({ ...packed(), status: "complete", tick: 10 })];
  const asked = [];
  await follow(shown, async (address) => (asked.push(address), answers.shift()), 0);
  assert.deepEqual(shown.runs.map(({ tick }) => tick), [9, 10]);
  assert.deepEqual(asked, ["run?after=5", "run?after=9", "run?after=9"]);
  assert.equal(shown.said, null);
});

test("a run that does not answer any more is said, and what it told stays", async () => {
  const shown = page();
  await follow(shown, async () => { throw new TypeError("Failed to fetch"); }, 0);
  assert.match(shown.said, /does not answer/);
  const refused = page();
  await follow(refused, async () => ({ status: 403, ok: false }), 0);
  assert.match(refused.said, /does not answer/);
});
