// @ts-check
// The page of a run that goes on, which asks for it.

import { firstNews, follow } from "./live.mjs";
import { begin, Page } from "./page.mjs";

begin(async () => {
  const run = await firstNews();
  window.replay = new Page([run]);
  window.replay.renew([run]);
  window.replay.toggle();
  follow(window.replay);
});
