// @ts-check
// A run that goes on: asked for again and again, until it has ended.

import { inflate, unpack } from "./unpack.mjs";
/** @import { Page } from "./page.mjs" */
/** @import { Run } from "./types.d.ts" */

const EVERY_MS = 1000;
const SOON_MS = 100;

/** @param {number} ms */
const rest = (ms) => new Promise((done) => setTimeout(done, ms));

/** @typedef {(address: string) => Promise<Pick<Response, "ok" | "status" | "text">>} Ask */

/**
 * Ask the server, with the token that stands in the page's own address.
 * @type {Ask}
 */
const asked = (address) => fetch(`${address}&${location.search.slice(1)}`);

/**
 * The run as far as it has come, if it has come farther than a time; null if not.
 * @param {number} after
 * @param {Ask} [ask]
 * @returns {Promise<Run | null>}
 */
export async function news(after, ask = asked) {
  const answer = await ask(`run?after=${after}`);
  if (answer.status === 204) return null;
  if (!answer.ok) throw new Error(`the run answers ${answer.status}`);
  return unpack(await inflate(await answer.text()));
}

/**
 * The run as far as it has come at first.
 * @param {Ask} [ask]
 */
export async function firstNews(ask) {
  for (;;) {
    const run = await news(-1, ask);
    if (run) return run;
    await rest(SOON_MS);
  }
}

/**
 * Give a page what is new, until the run has ended, or nobody answers any more.
 * @param {Pick<Page, "end" | "running" | "renew" | "stop">} page
 * @param {Ask} [ask]
 */
export async function follow(page, ask, every = EVERY_MS) {
  try {
    while (page.running) {
      await rest(every);
      const run = await news(page.end, ask);
      if (run) page.renew([run]);
    }
  } catch {
    page.stop("The run does not answer any more: it was stopped, or has ended. What it told is here.");
  }
}
