// @ts-check
// A run with everything that shows it: its canvas, its legend figures, its time line.

import { edgesFor, Scene } from "./draw.mjs";
import { heatEdges, heatOf } from "./heat.mjs";
import { beginOf, seriesOf } from "./series.mjs";
import { histories, Names } from "./story.mjs";
import { Timeline } from "./timeline.mjs";
import { World } from "./world.mjs";
import { lastUpTo } from "./motion.mjs";
/** @import { Figure, HeatName, Palette, Run, View } from "./types.d.ts" */

const SAMPLES = 24;

/**
 * Largest number of open items that any pod has at some times of a run.
 * @param {World} world
 * @param {number} end
 */
export function mostOpen(world, end) {
  let most = 0;
  for (let i = 0; i <= SAMPLES; i++) {
    for (const number of world.go((end * i) / SAMPLES).openItems()) if (number > most) most = number;
  }
  world.go(0);
  return most;
}

/**
 * How many metres all robots have driven by a time.
 * @param {Run} run
 * @returns {(tick: number) => number}
 */
function odometer(run) {
  const ends = run.legs.flatMap((legs) => Array.from(legs.start, (start, i) => ({ tick: start + legs.wait[i] + legs.turn[i] + legs.run[i], driven: legs.metres[i] })));
  ends.sort((a, b) => a.tick - b.tick);
  const [ticks, metres] = [new Float64Array(ends.length), new Float64Array(ends.length)];
  let sum = 0;
  ends.forEach(({ tick, driven }, i) => ([ticks[i], metres[i]] = [tick, (sum += driven)]));
  return (tick) => {
    const i = lastUpTo(ticks, tick);
    return i < 0 ? 0 : metres[i];
  };
}

/**
 * Make the views of runs; the same colour means the same in each.
 * @param {Run[]} runs
 * @param {Figure[]} figures
 * @param {number} end
 * @param {Palette} palette
 * @returns {View[]}
 */
export function viewsOf(runs, figures, end, palette) {
  const begin = beginOf(runs);
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
      scene: new Scene(figures[i].canvas, run, history, edges, palette),
      timeline: new Timeline(figures[i].timeline, seriesOf(run, end, begin), end, letter, palette, begin),
      figure: figures[i],
      distance: odometer(run),
    };
  });
}

/**
 * The figures of a heat map in a view, which keeps them.
 * @param {View} view
 * @param {HeatName} name
 */
function heatIn({ run, history, heats }, name) {
  const heat = heats.get(name) ?? heatOf(run, history, name);
  heats.set(name, heat);
  return heat;
}

/**
 * Show a heat map in all views, on one scale; "none" shows none.
 * @param {View[]} views
 * @param {"none" | HeatName} name
 */
export function setHeat(views, name) {
  const heats = name === "none" ? [] : views.map((view) => heatIn(view, name));
  const most = Math.max(...heats.map((heat) => heat.most));
  views.forEach(({ scene }, i) => {
    scene.heat = name === "none" ? null : { ...heats[i], edges: heatEdges({ unit: heats[i].unit, most }) };
    if (scene.scale) scene.fit();
  });
}
