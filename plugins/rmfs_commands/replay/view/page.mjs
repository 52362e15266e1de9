// @ts-check
// The page: one clock, one or two views, a panel, and what keys and buttons do.

import { Clock, clockTime, SPEEDS, spokenTime } from "./clock.mjs";
import { paletteOf } from "./draw.mjs";
import { HEAT_NAMES, HEATS } from "./heat.mjs";
import { brief, legend, numbers, suggestions, thingNamed } from "./labels.mjs";
import { beginOf, nextOf } from "./series.mjs";
import { make, Panel } from "./panel.mjs";
import { setHeat, viewsOf } from "./views.mjs";
/** @import { Figure, HeatName, Run, Thing, View } from "./types.d.ts" */

const PANEL_EVERY_MS = 200;
/** @type {Record<string, number>} */
const SKIP = { ArrowLeft: -10000, ArrowRight: 10000, PageDown: -600000, PageUp: 600000 };

/**
 * An element of the page.
 * @template {HTMLElement} Kind
 * @param {string} id
 * @param {new () => Kind} kind
 */
function part(id, kind) {
  const element = document.getElementById(id);
  if (!(element instanceof kind)) throw new Error(`it has no ${kind.name} ${id}`);
  return element;
}

/** @param {string} id */
const $ = (id) => part(id, HTMLElement);

export class Page {
  seekBar = part("seek", HTMLInputElement);
  findBox = part("find", HTMLInputElement);
  speedBox = part("speed", HTMLSelectElement);
  heatBox = part("heat", HTMLSelectElement);
  keys = part("keys", HTMLDialogElement);
  /** @type {({ view: View } & Thing) | null} */
  selected = null;
  /** @type {"none" | HeatName} */
  heat = "none";
  drawn = { frames: 0, ms: 0 };
  lastFrame = 0;
  panelShown = 0;
  stale = true;
  themeBefore = "light"; // before the page is printed

  /** @param {Run[]} runs */
  constructor(runs) {
    this.end = Math.max(...runs.map((run) => run.tick));
    this.clock = new Clock(this.end, beginOf(runs));
    const figures = runs.map((run) => this.figure(run));
    this.views = viewsOf(runs, figures, this.end, paletteOf(document.documentElement));
    this.clock.start = Math.min(...this.views.map(({ timeline }) => timeline.series.first));
    this.panel = new Panel($("panel"), {
      select: (view, thing) => this.select(thing && { view, ...thing }),
      seek: (tick) => this.seek(tick),
    });
    for (const view of this.views) view.figure.caption.textContent = caption(view, this.views);
    this.controls();
    this.theme(localTheme());
    this.fromAddress();
    new ResizeObserver(() => this.resize()).observe($("views"));
    requestAnimationFrame((now) => this.frame(now));
  }

  /**
   * @param {Run} run
   * @returns {Figure}
   */
  figure(run) {
    const canvas = make("canvas", { tabindex: "0", role: "img", "aria-label": `The warehouse of ${run.name}. Find a robot, pod, station or order by its name to hear of it.` });
    const timeline = make("canvas", { "aria-hidden": "true" });
    const heading = make("span", {});
    const said = make("span", { class: "numbers" });
    $("views").append(make("figure", {}, make("figcaption", {}, heading, said), canvas));
    $("timelines").append(timeline);
    return { canvas, timeline, caption: heading, numbers: said };
  }

  // A run that goes on

  /** Whether more is to come. */
  get running() {
    return this.clock.waits;
  }

  /**
   * Show runs as far as they have come; the clock, what is selected and how it is looked at stay.
   * @param {Run[]} runs
   */
  renew(runs) {
    this.end = this.clock.end = Math.max(...runs.map((run) => run.tick));
    this.clock.waits = runs.some((run) => run.status === "running");
    const renewed = viewsOf(runs, this.views.map(({ figure }) => figure), this.end, paletteOf(document.documentElement));
    this.views.forEach((view, i) => {
      const { zoom, panX, panY } = view.scene;
      Object.assign(view, renewed[i]);
      Object.assign(view.scene, { zoom, panX, panY });
    });
    this.seekBar.max = String(this.end);
    $("end").textContent = clockTime(this.end) + (this.running ? " so far" : "");
    this.setHeat(this.heat);
  }

  /**
   * Nothing more will come.
   * @param {string} why
   */
  stop(why) {
    this.clock.waits = false;
    this.say(why);
  }

  // What is shown

  /** @param {number} now */
  frame(now) {
    const passed = Math.min(now - this.lastFrame, 250); // a tab that was away does not leap
    this.lastFrame = now;
    this.clock.pass(passed);
    if (this.clock.playing || this.stale) this.draw(now);
    requestAnimationFrame((next) => this.frame(next));
  }

  /** @param {number} now */
  draw(now) {
    const begin = performance.now();
    this.stale = false;
    const { tick } = this.clock;
    for (const view of this.views) {
      view.scene.draw(view.world.go(tick), this.selected?.view === view ? this.selected : null);
      view.timeline.draw(tick);
    }
    $("time").textContent = clockTime(tick);
    if (document.activeElement !== this.seekBar || this.clock.playing) this.seekBar.value = String(tick);
    this.drawn.frames++;
    this.drawn.ms += performance.now() - begin;
    if (Math.abs(now - this.panelShown) > PANEL_EVERY_MS || !this.clock.playing) {
      this.panelShown = now;
      this.panel.show(this.views, this.selected);
      for (const view of this.views) view.figure.numbers.textContent = numbers(view);
      this.seekBar.setAttribute("aria-valuetext", spokenTime(tick));
      $("play").textContent = this.clock.playing ? "Pause" : "Play";
    }
  }

  resize() {
    const palette = paletteOf(document.documentElement);
    this.arrange();
    for (const view of this.views) {
      view.scene.resize(palette);
      view.timeline.resize(palette);
    }
    $("legend").replaceChildren(...legend(this.views, palette));
    this.draw(performance.now());
  }

  /** Two views stand beside each other, or one above the other, whichever makes them larger. */
  arrange() {
    const [{ scene }] = this.views;
    const { clientWidth: width, clientHeight: height } = $("views");
    const beside = Math.min(width / 2 / scene.columns, height / scene.rows);
    const below = Math.min(width / scene.columns, height / 2 / scene.rows);
    $("views").style.flexDirection = this.views.length > 1 && below > beside ? "column" : "";
    for (const { scene: own } of this.views) own.canvas.style.setProperty("--shape", `${own.columns} / ${own.rows}`);
  }

  /** @param {string} name */
  theme(name) {
    document.documentElement.dataset.theme = name;
    $("theme").textContent = name === "dark" ? "Light" : "Dark";
    this.resize();
  }

  /** @param {"none" | HeatName} name */
  setHeat(name) {
    this.heat = name;
    this.heatBox.value = name;
    setHeat(this.views, name);
    this.resize();
  }

  // What is done

  /** @param {number} tick */
  seek(tick) {
    this.clock.seek(tick);
    this.seekBar.value = String(this.clock.tick);
    this.stale = true;
  }

  toggle() {
    this.clock.toggle();
    this.panelShown = 0;
    this.stale = true;
  }

  /** @param {number} speed */
  speed(speed) {
    this.clock.speed = speed;
    this.speedBox.value = String(speed);
  }

  /**
   * Go to the next decision or event, or to the one before.
   * @param {number} direction
   * @param {"rounds" | "events"} what
   */
  step(direction, what) {
    const { tick } = this.clock;
    const next = this.views.map(({ timeline }) => nextOf(timeline.series[what], tick, direction));
    const found = direction > 0 ? Math.min(...next) : Math.max(...next);
    if (Number.isFinite(found)) this.seek(found);
  }

  /** @param {({ view: View } & Thing) | null} thing */
  select(thing) {
    this.selected = thing;
    this.stale = true;
    this.draw(performance.now());
    const now = $("panel").querySelector(".now")?.textContent ?? "";
    this.say(thing ? `${thing.view.names[thing.kind](thing.id)}: ${now}` : "The whole run", "unseen");
  }

  /** @param {string} text */
  find(text) {
    for (const view of this.views) {
      const found = thingNamed(view, text);
      if (found) {
        this.select({ view, ...found });
        return;
      }
    }
    this.say(text ? `${text} is not here; try robot 1, pod 2, station 1 or order 3` : "");
  }

  /**
   * Tell something; unseen, it is for who listens to the page.
   * @param {string} text
   */
  say(text, how = "") {
    $("said").textContent = text;
    $("said").className = how;
  }

  // Buttons, pointer, keys

  controls() {
    this.seekBar.min = String(this.clock.begin);
    this.speedBox.append(...SPEEDS.map((speed) => make("option", { value: speed }, `${speed} ×`)));
    this.speedBox.value = String(this.clock.speed);
    this.heatBox.append(...HEAT_NAMES.map((name) => make("option", { value: name }, HEATS[name].label)));
    this.seekBar.max = String(this.end);
    $("end").textContent = clockTime(this.end);
    const [first] = this.views;
    $("names").append(...suggestions(first).map((name) => make("option", { value: name })));
    $("play").onclick = () => this.toggle();
    $("before").onclick = () => this.step(-1, "rounds");
    $("after").onclick = () => this.step(1, "rounds");
    $("event").onclick = () => this.step(1, "events");
    this.speedBox.onchange = () => this.speed(Number(this.speedBox.value));
    this.heatBox.onchange = () => this.setHeat(heatNamed(this.heatBox.value));
    $("theme").onclick = () => this.theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
    $("help").onclick = () => this.keys.showModal();
    this.seekBar.oninput = () => this.seek(Number(this.seekBar.value));
    this.findBox.onchange = () => this.find(this.findBox.value);
    this.findBox.addEventListener("keydown", ({ key }) => key === "Enter" && this.find(this.findBox.value));
    document.addEventListener("keydown", (event) => this.key(event));
    for (const view of this.views) this.pointer(view);
    window.addEventListener("beforeprint", () => this.print(true));
    window.addEventListener("afterprint", () => this.print(false));
  }

  /** @param {boolean} begins */
  print(begins) {
    const { theme = "light" } = document.documentElement.dataset;
    if (begins) [this.themeBefore, this.clock.playing] = [theme, false];
    this.theme(begins ? "light" : this.themeBefore);
  }

  /** @param {View} view */
  pointer(view) {
    const { canvas } = view.scene;
    /** @type {{ x: number, y: number, panX: number, panY: number, moved: boolean } | null} */
    let from = null;
    canvas.onpointerdown = (event) => {
      from = { x: event.clientX, y: event.clientY, panX: view.scene.panX, panY: view.scene.panY, moved: false };
    };
    canvas.onpointermove = (event) => {
      if (!from || !event.buttons) {
        this.hover(view, event);
        return;
      }
      const [dx, dy] = [event.clientX - from.x, event.clientY - from.y];
      if (view.scene.zoom === 1 || Math.hypot(dx, dy) < 4) return;
      from.moved = true;
      const by = view.scene.ratio / view.scene.scale;
      this.pan(from.panX + dx * by, from.panY + dy * by);
    };
    canvas.onpointerup = (event) => {
      if (from && !from.moved) {
        const found = view.scene.hit(view.world, event.clientX, event.clientY);
        this.select(found && { view, ...found });
      }
      from = null;
    };
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey) return; // the page scrolls
      event.preventDefault();
      this.zoom(event.deltaY < 0 ? 1.15 : 1 / 1.15);
    }, { passive: false });
    view.timeline.canvas.onpointerdown = (event) => this.seek(view.timeline.tickAt(event.clientX));
    view.timeline.canvas.onpointermove = (event) => {
      const tick = view.timeline.tickAt(event.clientX);
      view.timeline.canvas.title = view.timeline.says(tick);
      if (event.buttons) this.seek(tick);
    };
  }

  /**
   * @param {View} view
   * @param {PointerEvent} event
   */
  hover(view, event) {
    const found = view.scene.hit(view.world, event.clientX, event.clientY);
    view.scene.canvas.title = found ? brief(view, found) : "";
    view.scene.canvas.style.cursor = found ? "pointer" : view.scene.zoom > 1 ? "grab" : "default";
  }

  /** @param {number} factor */
  zoom(factor) {
    for (const { scene } of this.views) {
      scene.zoom = factor ? Math.min(Math.max(scene.zoom * factor, 1), 8) : 1;
      if (scene.zoom === 1) scene.panX = scene.panY = 0;
      scene.fit();
    }
    this.stale = true;
  }

  /**
   * @param {number} x
   * @param {number} y
   */
  pan(x, y) {
    for (const { scene } of this.views) {
      [scene.panX, scene.panY] = [x, y];
      scene.fit();
    }
    this.stale = true;
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const { target, key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || this.keys.open) return;
    if (!(target instanceof Element) || target.matches("input:not([type=range]), select")) return;
    if (key === " " && target.matches("button")) return; // it presses the button
    /** @type {Record<string, () => void>} */
    const does = {
      " ": () => this.toggle(),
      ",": () => this.step(-1, "rounds"),
      ".": () => this.step(1, "rounds"),
      n: () => this.step(1, "events"),
      N: () => this.step(-1, "events"),
      Home: () => this.seek(0),
      End: () => this.seek(this.end),
      ArrowUp: () => (this.clock.faster(1), this.speed(this.clock.speed)),
      ArrowDown: () => (this.clock.faster(-1), this.speed(this.clock.speed)),
      h: () => this.setHeat(HEAT_NAMES[(HEAT_NAMES.indexOf(this.heat) + 1) % HEAT_NAMES.length]),
      d: () => $("theme").click(),
      "+": () => this.zoom(1.25),
      "-": () => this.zoom(0.8),
      0: () => this.zoom(0),
      "/": () => this.findBox.focus(),
      "?": () => this.keys.showModal(),
      Escape: () => this.select(null),
    };
    if (key in does) does[key]();
    else if (key in SKIP) this.seek(this.clock.tick + SKIP[key] * (event.shiftKey ? 6 : 1));
    else return;
    event.preventDefault();
  }

  /** What the address asks for: #t=SECONDS&show=robot 3&heat=waiting&speed=50&theme=dark. */
  fromAddress() {
    const asked = new URLSearchParams(location.hash.slice(1));
    if (asked.has("theme")) this.theme(asked.get("theme") === "dark" ? "dark" : "light");
    if (asked.has("heat")) this.setHeat(heatNamed(asked.get("heat")));
    if (SPEEDS.includes(Number(asked.get("speed")))) this.speed(Number(asked.get("speed")));
    this.seek(asked.has("t") ? Number(asked.get("t")) * 1000 || 0 : this.clock.start);
    const show = asked.get("show");
    if (show !== null) this.find(show);
    this.stale = true;
  }
}

/**
 * The heat map of a name; none where there is none of it.
 * @param {string | null} name
 */
const heatNamed = (name) => HEAT_NAMES.find((one) => one === name) ?? "none";

const localTheme = () => (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");

/**
 * Name a view, by what its rules differ in from the other's where there are two.
 * @param {View} view
 * @param {View[]} views
 */
function caption(view, views) {
  const other = views.find((one) => one !== view);
  if (!other) return "";
  const different = Object.entries(view.run.rules).filter(([role, rule]) => other.run.rules[role] !== rule);
  const said = different.map(([role, rule]) => `${role} ${rule}`).join(", ");
  return said ? `${view.title} (${said})` : view.title;
}

/**
 * Show what there is to show, or say why it cannot be shown.
 * @param {() => Promise<void>} show
 */
export async function begin(show) {
  try {
    await show();
  } catch (error) {
    $("said").textContent = `This page cannot be shown: ${error instanceof Error ? error.message : error}`;
    $("said").className = "problem";
    throw error;
  }
}
