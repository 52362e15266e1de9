// The page: one clock, one or two views, a panel, and what keys and buttons do.

import { Clock, clockTime, SPEEDS, spokenTime } from "./clock.mjs";
import { paletteOf } from "./draw.mjs";
import { HEATS } from "./heat.mjs";
import { brief, legend, numbers, suggestions, thingNamed } from "./labels.mjs";
import { make, Panel } from "./panel.mjs";
import { setHeat, viewsOf } from "./views.mjs";

const PANEL_EVERY_MS = 200;
const SKIP = { ArrowLeft: -10000, ArrowRight: 10000, PageDown: -600000, PageUp: 600000 };
const $ = (id) => document.getElementById(id);

export class Page {
  constructor(runs) {
    this.end = Math.max(...runs.map((run) => run.tick));
    this.clock = new Clock(this.end);
    const figures = runs.map((run) => this.figure(run));
    this.views = viewsOf(runs, figures, this.end);
    this.selected = null; // { view, kind, id }
    this.heat = "none";
    this.panel = new Panel($("panel"), {
      select: (view, kind, id) => this.select(kind && { view, kind, id }),
      seek: (tick) => this.seek(tick),
    });
    this.views.forEach((view, i) => (figures[i].caption.textContent = caption(view, this.views)));
    this.views.forEach((view, i) => (view.numbers = figures[i].numbers));
    this.drawn = { frames: 0, ms: 0 };
    this.controls();
    this.theme(localTheme());
    this.fromAddress();
    this.lastFrame = this.panelShown = 0;
    new ResizeObserver(() => this.resize()).observe($("views"));
    requestAnimationFrame((now) => this.frame(now));
  }

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

  /** Show runs as far as they have come; the clock, what is selected and how it is looked at stay. */
  renew(runs) {
    this.end = this.clock.end = Math.max(...runs.map((run) => run.tick));
    this.clock.waits = runs.some((run) => run.status === "running");
    const renewed = viewsOf(runs, this.views.map(({ scene, timeline }) => ({ canvas: scene.canvas, timeline: timeline.canvas })), this.end);
    this.views.forEach((view, i) => {
      const { zoom, panX, panY } = view.scene;
      Object.assign(view, renewed[i]);
      Object.assign(view.scene, { zoom, panX, panY });
    });
    $("seek").max = this.end;
    $("end").textContent = clockTime(this.end) + (this.running ? " so far" : "");
    this.setHeat(this.heat);
  }

  /** Nothing more will come. */
  stop(why) {
    this.clock.waits = false;
    this.say(why);
  }

  // What is shown

  frame(now) {
    const passed = Math.min(now - this.lastFrame, 250); // a tab that was away does not leap
    this.lastFrame = now;
    this.clock.pass(passed);
    if (this.clock.playing || this.stale) this.draw(now);
    requestAnimationFrame((next) => this.frame(next));
  }

  draw(now) {
    const begin = performance.now();
    this.stale = false;
    const { tick } = this.clock;
    for (const view of this.views) {
      view.scene.draw(view.world.go(tick), this.selected?.view === view ? this.selected : null);
      view.timeline.draw(tick);
    }
    $("time").textContent = clockTime(tick);
    if (document.activeElement !== $("seek") || this.clock.playing) $("seek").value = tick;
    this.drawn.frames++;
    this.drawn.ms += performance.now() - begin;
    if (Math.abs(now - this.panelShown) > PANEL_EVERY_MS || !this.clock.playing) {
      this.panelShown = now;
      this.panel.show(this.views, this.selected);
      for (const view of this.views) view.numbers.textContent = numbers(view);
      $("seek").setAttribute("aria-valuetext", spokenTime(tick));
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
    $("legend").replaceChildren(...legend(this.views, this.heat, palette));
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

  theme(name) {
    document.documentElement.dataset.theme = name;
    $("theme").textContent = name === "dark" ? "Light" : "Dark";
    this.resize();
  }

  setHeat(name) {
    this.heat = name;
    $("heat").value = name;
    setHeat(this.views, name);
    this.resize();
  }

  // What is done

  seek(tick) {
    this.clock.seek(tick);
    $("seek").value = this.clock.tick;
    this.stale = true;
  }

  toggle() {
    this.clock.toggle();
    this.panelShown = 0;
    this.stale = true;
  }

  speed(speed) {
    this.clock.speed = speed;
    $("speed").value = speed;
  }

  round(direction) {
    const { tick } = this.clock;
    const all = this.views.flatMap((view) => Array.from(view.timeline.series.rounds));
    const next = direction > 0 ? Math.min(...all.filter((one) => one > tick)) : Math.max(...all.filter((one) => one < tick));
    if (Number.isFinite(next)) this.seek(next);
  }

  select(thing) {
    this.selected = thing || null;
    this.stale = true;
    this.draw(performance.now());
    const now = $("panel").querySelector(".now")?.textContent ?? "";
    this.say(thing ? `${thing.view.names[thing.kind](thing.id)}: ${now}` : "The whole run", "unseen");
  }

  find(text) {
    for (const view of this.views) {
      const found = thingNamed(view, text);
      if (found) return this.select({ view, ...found });
    }
    this.say(text ? `${text} is not here; try robot 1, pod 2, station 1 or order 3` : "");
  }

  /** Tell something; unseen, it is for who listens to the page. */
  say(text, how = "") {
    $("said").textContent = text;
    $("said").className = how;
  }

  // Buttons, pointer, keys

  controls() {
    $("speed").append(...SPEEDS.map((speed) => make("option", { value: speed }, `${speed} ×`)));
    $("speed").value = this.clock.speed;
    $("heat").append(...Object.entries(HEATS).map(([name, { label }]) => make("option", { value: name }, label)));
    $("seek").max = this.end;
    $("end").textContent = clockTime(this.end);
    const [first] = this.views;
    $("names").append(...suggestions(first).map((name) => make("option", { value: name })));
    $("play").onclick = () => this.toggle();
    $("before").onclick = () => this.round(-1);
    $("after").onclick = () => this.round(1);
    $("speed").onchange = () => this.speed(Number($("speed").value));
    $("heat").onchange = () => this.setHeat($("heat").value);
    $("theme").onclick = () => this.theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
    $("help").onclick = () => $("keys").showModal();
    $("seek").oninput = () => this.seek(Number($("seek").value));
    $("find").onchange = () => this.find($("find").value);
    $("find").addEventListener("keydown", ({ key }) => key === "Enter" && this.find($("find").value));
    document.addEventListener("keydown", (event) => this.key(event));
    for (const view of this.views) this.pointer(view);
    window.addEventListener("beforeprint", () => this.print(true));
    window.addEventListener("afterprint", () => this.print(false));
  }

  print(begins) {
    const { theme } = document.documentElement.dataset;
    if (begins) [this.before, this.clock.playing] = [theme, false];
    this.theme(begins ? "light" : this.before);
  }

  pointer(view) {
    const { canvas } = view.scene;
    let from = null;
    canvas.onpointerdown = (event) => {
      from = { x: event.clientX, y: event.clientY, panX: view.scene.panX, panY: view.scene.panY, moved: false };
    };
    canvas.onpointermove = (event) => {
      if (!from || !event.buttons) return this.hover(view, event);
      const [dx, dy] = [event.clientX - from.x, event.clientY - from.y];
      if (view.scene.zoom === 1 || Math.hypot(dx, dy) < 4) return undefined;
      from.moved = true;
      const by = view.scene.ratio / view.scene.scale;
      return this.pan(from.panX + dx * by, from.panY + dy * by);
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

  hover(view, event) {
    const found = view.scene.hit(view.world, event.clientX, event.clientY);
    view.scene.canvas.title = found ? brief(view, found) : "";
    view.scene.canvas.style.cursor = found ? "pointer" : view.scene.zoom > 1 ? "grab" : "default";
  }

  zoom(factor) {
    for (const { scene } of this.views) {
      scene.zoom = factor ? Math.min(Math.max(scene.zoom * factor, 1), 8) : 1;
      if (scene.zoom === 1) scene.panX = scene.panY = 0;
      scene.fit();
    }
    this.stale = true;
  }

  pan(x, y) {
    for (const { scene } of this.views) {
      [scene.panX, scene.panY] = [x, y];
      scene.fit();
    }
    this.stale = true;
  }

  key(event) {
    const { target, key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || $("keys").open) return;
    if (target.matches("input:not([type=range]), select")) return;
    if (key === " " && target.matches("button")) return; // it presses the button
    const heats = Object.keys(HEATS);
    const done = {
      " ": () => this.toggle(),
      ",": () => this.round(-1),
      ".": () => this.round(1),
      Home: () => this.seek(0),
      End: () => this.seek(this.end),
      ArrowUp: () => (this.clock.faster(1), this.speed(this.clock.speed)),
      ArrowDown: () => (this.clock.faster(-1), this.speed(this.clock.speed)),
      h: () => this.setHeat(heats[(heats.indexOf(this.heat) + 1) % heats.length]),
      d: () => $("theme").click(),
      "+": () => this.zoom(1.25),
      "-": () => this.zoom(0.8),
      0: () => this.zoom(0),
      "/": () => $("find").focus(),
      "?": () => $("keys").showModal(),
      Escape: () => this.select(null),
    }[key];
    if (done) done();
    else if (key in SKIP) this.seek(this.clock.tick + SKIP[key] * (event.shiftKey ? 6 : 1));
    else return;
    event.preventDefault();
  }

  /** What the address asks for: #t=SECONDS&show=robot 3&heat=waiting&speed=50&theme=dark. */
  fromAddress() {
    const asked = new URLSearchParams(location.hash.slice(1));
    if (asked.has("theme")) this.theme(asked.get("theme") === "dark" ? "dark" : "light");
    if (HEATS[asked.get("heat")]) this.setHeat(asked.get("heat"));
    if (SPEEDS.includes(Number(asked.get("speed")))) this.speed(Number(asked.get("speed")));
    this.seek(Number(asked.get("t") ?? 0) * 1000 || 0);
    if (asked.has("show")) this.find(asked.get("show"));
    this.stale = true;
  }
}

const localTheme = () => (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");

/** Name a view, by what its rules differ in from the other's where there are two. */
function caption(view, views) {
  const other = views.find((one) => one !== view);
  if (!other) return "";
  const different = Object.entries(view.run.rules).filter(([role, rule]) => other.run.rules[role] !== rule);
  const said = different.map(([role, rule]) => `${role} ${rule}`).join(", ");
  return said ? `${view.title} (${said})` : view.title;
}

/** Show what there is to show, or say why it cannot be shown. */
export async function begin(show) {
  try {
    await show();
  } catch (error) {
    $("said").textContent = `This page cannot be shown: ${error.message}`;
    $("said").className = "problem";
    throw error;
  }
}
