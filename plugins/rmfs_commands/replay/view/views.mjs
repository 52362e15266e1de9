// A run with everything that shows it: its canvas, its legend figures, its time line.

import { edgesFor, Scene } from "./draw.mjs";
import { heatEdges, heatOf } from "./heat.mjs";
import { seriesOf } from "./series.mjs";
import { histories, Names } from "./story.mjs";
import { Timeline } from "./timeline.mjs";
import { World } from "./world.mjs";
import { lastUpTo } from "./motion.mjs";

const SAMPLES = 24;

/** Largest number of open items that any pod has at some times of a run. */
export function mostOpen(world, end) {
  let most = 0;
  for (let i = 0; i <= SAMPLES; i++) {
    for (const number of world.go((end * i) / SAMPLES).openItems()) if (number > most) most = number;
  }
  world.go(0);
  return most;
}

/** Ends of all legs of all robots with the metres driven until then. */
function odometer(run) {
  const ends = run.legs.flatMap((legs) => Array.from(legs.start, (start, i) => [start + legs.wait[i] + legs.turn[i] + legs.run[i], legs.metres[i]]));
  ends.sort((a, b) => a[0] - b[0]);
  const [ticks, metres] = [new Float64Array(ends.length), new Float64Array(ends.length)];
  let sum = 0;
  ends.forEach(([tick, driven], i) => ([ticks[i], metres[i]] = [tick, (sum += driven)]));
  return (tick) => {
    const i = lastUpTo(ticks, tick);
    return i < 0 ? 0 : metres[i];
  };
}

/** Make the views of runs; the same colour means the same in each. */
export function viewsOf(runs, elements, end) {
  const worlds = runs.map((run) => new World(run));
  const edges = edgesFor(Math.max(...runs.map((run, i) => mostOpen(worlds[i], run.tick)), 1));
  return runs.map((run, i) => {
    const history = histories(run);
    const letter = runs.length > 1 ? "AB"[i] : "";
    return {
      run, history, edges, letter, heats: new Map(),
      title: letter ? `${letter}: ${run.name}` : run.name,
      names: new Names(run),
      world: worlds[i],
      scene: new Scene(elements[i].canvas, run, history, edges),
      timeline: new Timeline(elements[i].timeline, seriesOf(run, end), end, letter),
      distance: odometer(run),
    };
  });
}

/** Show a heat map in all views, on one scale; "none" shows none. */
export function setHeat(views, name) {
  for (const view of views) {
    if (name !== "none" && !view.heats.has(name)) view.heats.set(name, heatOf(view.run, view.history, name));
    view.scene.heat = name === "none" ? null : { ...view.heats.get(name) };
  }
  const most = Math.max(...views.map((view) => view.scene.heat?.most ?? 0));
  for (const view of views) {
    if (view.scene.heat) view.scene.heat.edges = heatEdges({ ...view.scene.heat, most });
    if (view.scene.palette) view.scene.fit();
  }
}
