// @ts-check
// The page of recorded runs, which has them in it.

import { begin, Page } from "./page.mjs";
import { inflate, unpack } from "./unpack.mjs";

begin(async () => {
  const packed = [...document.querySelectorAll("script.run")];
  window.replay = new Page(await Promise.all(packed.map(async ({ textContent }) => unpack(await inflate(textContent.trim())))));
});
