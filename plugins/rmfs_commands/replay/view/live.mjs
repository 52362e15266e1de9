// A run that goes on: asked for again and again, until it has ended.

import { inflate, unpack } from "./unpack.mjs";

const EVERY_MS = 1000;
const SOON_MS = 100;

const rest = (ms) => new Promise((done) => setTimeout(done, ms));

/** The run as far as it has come, if it has come farther than a time; null if not. */
export async function news(after, ask = (address) => fetch(address)) {
  const answer = await ask(`run?after=${after}`);
  if (answer.status === 204) return null;
  if (!answer.ok) throw new Error(`the run answers ${answer.status}`);
  return unpack(await inflate(await answer.text()));
}

/** The run as far as it has come at first. */
export async function firstNews(ask) {
  for (;;) {
    const run = await news(-1, ask);
    if (run) return run;
    await rest(SOON_MS);
  }
}

/** Give a page what is new, until the run has ended, or nobody answers any more. */
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
