// @ts-check
// The warehouse on a canvas. What never moves is drawn once, on a canvas of its own.

import { heatClass } from "./heat.mjs";
import { lastUpTo, nowhere, place, STEP_X, STEP_Y } from "./motion.mjs";
import { phaseOf, waitsOn } from "./story.mjs";
/** @import { Heat, History, Palette, Position, Run, Thing, ToldPacking } from "./types.d.ts" */
/** @import { World } from "./world.mjs" */

const [WALL, STORAGE, QUEUE, STATION, CHARGER, MAINTENANCE] = [0, 2, 3, 4, 5, 6];
const BOLT = [[0.58, 0.1], [0.24, 0.56], [0.46, 0.56], [0.4, 0.9], [0.76, 0.42], [0.53, 0.42]]; // the sign of a charger in its cell
const MARGIN = 1;
const BESIDE = 3.2; // columns for the open orders of stations on an edge
const CHIPS = 5; // in a row
const MOST_CHIPS = 15;
const FULL = 2 * Math.PI;
const STRIP = 1.7; // rows for a packing station, beneath the map

/**
 * Edges of the classes that open items are shown in: a pod with `edges[i]` or fewer is of class i.
 * @param {number} most
 */
export function edgesFor(most) {
  return [0, Math.ceil(most / 8), Math.ceil(most / 4), Math.ceil(most / 2), most].filter((edge, i, all) => edge > (all[i - 1] ?? -1));
}

/**
 * @param {number[]} edges
 * @param {number} number
 */
export function levelOf(edges, number) {
  const level = edges.findIndex((edge) => number <= edge);
  return level < 0 ? edges.length - 1 : level;
}

/**
 * What draws on a canvas.
 * @param {HTMLCanvasElement} canvas
 */
export function penOf(canvas) {
  const pen = canvas.getContext("2d");
  if (!pen) throw new Error("this browser cannot draw");
  return pen;
}

/**
 * The colours of the page's theme, by the names that style.css gives them.
 * @param {Element} element
 * @returns {Palette}
 */
export function paletteOf(element) {
  const style = getComputedStyle(element);
  /** @param {string} name */
  const colour = (name) => style.getPropertyValue(`--${name}`).trim();
  return {
    ink: colour("ink"), soft: colour("soft"), line: colour("line"), card: colour("card"), accent: colour("accent"),
    floor: colour("floor"), place: colour("place"), lane: colour("lane"), empty: colour("empty"), bundle: colour("bundle"),
    robot: colour("robot"), idle: colour("idle"), work: colour("work"), rest: colour("rest"), wait: colour("wait"),
    charge: colour("charge"), moved: colour("moved"),
    levels: [0, 1, 2, 3, 4].map((level) => colour(`level-${level}`)),
    heats: [0, 1, 2, 3, 4, 5].map((level) => colour(`heat-${level}`)),
  };
}

/** Draws one run on one canvas, and knows what is where on it. */
export class Scene {
  ratio = 1; // pixels of the canvas in one of the page
  scale = 0; // pixels of the canvas in a cell; 0 before it has a size
  left = 0;
  top = 0;
  zoom = 1;
  panX = 0;
  panY = 0;
  /** @type {(Heat & { edges: number[] }) | null} */
  heat = null;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Run} run
   * @param {History} history
   * @param {number[]} edges
   * @param {Palette} palette
   */
  constructor(canvas, run, history, edges, palette) {
    this.canvas = canvas;
    this.run = run;
    this.history = history;
    this.edges = edges;
    this.palette = palette;
    this.context = penOf(canvas);
    this.still = document.createElement("canvas");
    this.places = run.legs.map(nowhere);
    this.picking = stationPicks(run);
    this.itemsOf = run.lines.map((lines) => lines.reduce((sum, [, quantity]) => sum + quantity, 0));
    const { width, queues } = run.layout;
    const columns = queues.map(([cell]) => cell % width);
    this.west = columns.some((column) => column < width / 2) ? BESIDE : MARGIN;
    this.east = columns.some((column) => column >= width / 2) ? BESIDE : MARGIN;
    this.columns = width + this.west + this.east;
    this.rows = run.layout.height + 2 * MARGIN + STRIP * (run.packing?.stations ?? 0);
  }

  /**
   * Take the size that the canvas has on the page.
   * @param {Palette} palette
   */
  resize(palette) {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth, clientHeight } = this.canvas;
    if (!clientWidth || !clientHeight) return;
    this.ratio = ratio;
    this.canvas.width = Math.round(clientWidth * ratio);
    this.canvas.height = Math.round(clientHeight * ratio);
    this.palette = palette;
    this.fit();
  }

  /** Work out the scale, and draw what does not move. */
  fit() {
    const { width, height } = this.canvas;
    this.scale = Math.min(width / this.columns, height / this.rows) * this.zoom;
    this.left = (width - this.columns * this.scale) / 2 + (this.west + this.panX) * this.scale;
    this.top = (height - this.rows * this.scale) / 2 + (MARGIN + this.panY) * this.scale;
    this.still.width = width;
    this.still.height = height;
    this.drawStill(penOf(this.still));
  }

  // Pixel of the canvas that a column or row begins at.

  /** @param {number} column */
  toX = (column) => this.left + column * this.scale;
  /** @param {number} row */
  toY = (row) => this.top + row * this.scale;

  /**
   * Column and row of the centre of a cell under a point of the page, as numbers with fractions.
   * @param {number} clientX
   * @param {number} clientY
   */
  cellAt(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    const x = ((clientX - box.left) * this.ratio - this.left) / this.scale - 0.5;
    const y = ((clientY - box.top) * this.ratio - this.top) / this.scale - 0.5;
    return { x, y };
  }

  /** @param {CanvasRenderingContext2D} pen */
  drawStill(pen) {
    const { palette: p, scale: s } = this;
    const { kind, width } = this.run.layout;
    const blocked = new Set(this.run.blocked);
    pen.clearRect(0, 0, this.still.width, this.still.height);
    for (let cell = 0; cell < kind.length; cell++) {
      const what = Number(kind[cell]);
      if (what === WALL) continue;
      const [x, y] = [this.toX(cell % width), this.toY(Math.floor(cell / width))];
      pen.fillStyle = what === QUEUE || what === STATION ? p.lane : p.floor;
      this.tile(pen, cell);
      if (what === STORAGE || what === CHARGER || what === MAINTENANCE) {
        pen.fillStyle = p.place;
        pen.fillRect(x + 0.06 * s, y + 0.06 * s, 0.88 * s, 0.88 * s);
      }
      if (what === CHARGER) {
        pen.beginPath();
        for (const [right, down] of BOLT) pen.lineTo(x + right * s, y + down * s);
        pen.fillStyle = p.charge;
        pen.fill();
      }
      if (what === MAINTENANCE) { // a cross
        pen.fillStyle = p.charge;
        pen.fillRect(x + 0.36 * s, y + 0.12 * s, 0.28 * s, 0.76 * s);
        pen.fillRect(x + 0.12 * s, y + 0.36 * s, 0.76 * s, 0.28 * s);
      }
    }
    for (const cell of this.run.layout.packing ?? []) {
      pen.fillStyle = p.lane;
      this.tile(pen, cell);
      pen.fillStyle = p.bundle;
      pen.fillRect(this.toX(cell % width) + 0.25 * s, this.toY(Math.floor(cell / width)) + 0.25 * s, 0.5 * s, 0.5 * s);
    }
    if (this.heat?.by === "cell") this.drawHeat(pen, this.heat);
    pen.strokeStyle = p.empty;
    pen.lineWidth = Math.max(s * 0.05, 1);
    for (const cell of blocked) {
      const [x, y] = [this.toX(cell % width), this.toY(Math.floor(cell / width))];
      pen.strokeRect(x + 0.2 * s, y + 0.2 * s, 0.6 * s, 0.6 * s);
    }
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {Heat & { edges: number[] }} heat
   */
  drawHeat(pen, { values, edges }) {
    for (let cell = 0; cell < values.length; cell++) {
      if (!values[cell]) continue;
      pen.fillStyle = this.palette.heats[heatClass(edges, values[cell])];
      this.tile(pen, cell);
    }
  }

  /**
   * Fill a cell, to whole pixels: no seam shows between two.
   * @param {CanvasRenderingContext2D} pen
   * @param {number} cell
   */
  tile(pen, cell) {
    const { width } = this.run.layout;
    const [column, row] = [cell % width, Math.floor(cell / width)];
    const [x, y] = [Math.round(this.toX(column)), Math.round(this.toY(row))];
    pen.fillRect(x, y, Math.round(this.toX(column + 1)) - x, Math.round(this.toY(row + 1)) - y);
  }

  /**
   * Draw everything as it is at the time of `world`.
   * @param {World} world
   * @param {Thing | null} selected
   */
  draw(world, selected) {
    const pen = this.context;
    if (!this.scale) return;
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.still, 0, 0);
    this.drawPods(pen, world);
    for (let robot = 0; robot < this.places.length; robot++) place(this.run, robot, world.tick, this.places[robot]);
    if (selected?.kind === "robot") this.drawWay(pen, selected.id, world.tick);
    this.drawStations(pen, world);
    if (this.run.packing) for (let i = 0; i < this.run.packing.stations; i++) this.drawPacking(pen, world, this.run.packing, i);
    const { width } = this.run.layout;
    for (const cell of world.chargersDown) this.strike(pen, this.toX((cell % width) + 0.5), this.toY(Math.floor(cell / width) + 0.5));
    this.drawRobots(pen, world);
    if (selected) this.drawSelected(pen, world, selected);
  }

  /**
   * @param {number} pod
   * @param {Int32Array} open
   */
  podColour(pod, open) {
    if (this.heat?.by === "pod") {
      const { values, edges } = this.heat;
      return values[pod] ? this.palette.heats[heatClass(edges, values[pod])] : this.palette.levels[0];
    }
    return this.palette.levels[Math.min(levelOf(this.edges, open[pod]), 4)];
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {World} world
   */
  drawPods(pen, world) {
    const open = world.openItems();
    const { width } = this.run.layout;
    const s = this.scale;
    const faint = this.heat?.by === "cell";
    pen.globalAlpha = faint ? 0.25 : 1;
    for (let pod = 0; pod < open.length; pod++) {
      const cell = world.podCell[pod];
      if (cell < 0) continue;
      pen.fillStyle = this.podColour(pod, open);
      pen.fillRect(this.toX(cell % width) + 0.12 * s, this.toY(Math.floor(cell / width)) + 0.12 * s, 0.76 * s, 0.76 * s);
    }
    pen.globalAlpha = 1;
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {World} world
   */
  drawRobots(pen, world) {
    const { palette: p, scale: s } = this;
    const open = world.openItems();
    for (let robot = 0; robot < this.places.length; robot++) {
      const here = this.places[robot];
      const [x, y] = [this.toX(here.x + 0.5), this.toY(here.y + 0.5)];
      const pod = world.robotPod[robot];
      const phase = phaseOf(this.run, this.history, robot, world.tick, world);
      if (pod >= 0) {
        pen.fillStyle = this.podColour(pod, open);
        pen.fillRect(x - 0.43 * s, y - 0.43 * s, 0.86 * s, 0.86 * s);
        const moved = phase.cell !== undefined; // it has no visit before it
        if (phase.cell !== undefined) this.drawGoal(pen, here, phase.cell);
        pen.strokeStyle = moved ? p.moved : p.ink;
        pen.lineWidth = Math.max((moved ? 0.1 : 0.05) * s, 1);
        pen.setLineDash(moved ? [0.18 * s, 0.12 * s] : []);
        pen.strokeRect(x - 0.43 * s, y - 0.43 * s, 0.86 * s, 0.86 * s);
        pen.setLineDash([]);
      }
      const size = (pod >= 0 ? 0.27 : 0.34) * s;
      pen.beginPath();
      pen.arc(x, y, size, 0, FULL);
      pen.fillStyle = world.robotsDown.has(robot) ? p.rest : phase.phase === "idle" || phase.phase === "charging" ? p.idle : waitsOn(phase, here, this.run.legs[robot]) ? p.wait : p.robot;
      pen.fill();
      const angle = (-here.heading * Math.PI) / 2;
      pen.beginPath();
      pen.moveTo(x, y);
      pen.lineTo(x + Math.cos(angle) * size * 1.3, y + Math.sin(angle) * size * 1.3);
      pen.strokeStyle = p.card;
      pen.lineWidth = Math.max(0.11 * s, 1.5);
      pen.stroke();
      if (phase.phase === "charging") this.drawCharge(pen, x, y, world.charge(robot) ?? 0);
    }
  }

  /**
   * A ring around a robot at a charger, closed when the battery is full.
   * @param {CanvasRenderingContext2D} pen
   * @param {number} x
   * @param {number} y
   * @param {number} share
   */
  drawCharge(pen, x, y, share) {
    const s = this.scale;
    pen.lineWidth = Math.max(0.13 * s, 2);
    /** @type {[string, number][]} */
    const rings = [[this.palette.rest, 1], [this.palette.charge, share]];
    for (const [colour, part] of rings) {
      pen.beginPath();
      pen.arc(x, y, 0.44 * s, -FULL / 4, -FULL / 4 + part * FULL);
      pen.strokeStyle = colour;
      pen.stroke();
    }
  }

  /**
   * Where a pod is carried without a visit, and a line there.
   * @param {CanvasRenderingContext2D} pen
   * @param {Position} here
   * @param {number} cell
   */
  drawGoal(pen, here, cell) {
    const { scale: s, palette: p } = this;
    const { width } = this.run.layout;
    const [column, row] = [cell % width, Math.floor(cell / width)];
    pen.strokeStyle = p.moved;
    pen.lineWidth = Math.max(0.06 * s, 1);
    pen.setLineDash([0.18 * s, 0.18 * s]);
    pen.strokeRect(this.toX(column) + 0.12 * s, this.toY(row) + 0.12 * s, 0.76 * s, 0.76 * s);
    pen.globalAlpha = 0.5;
    pen.beginPath();
    pen.moveTo(this.toX(here.x + 0.5), this.toY(here.y + 0.5));
    pen.lineTo(this.toX(column + 0.5), this.toY(row + 0.5));
    pen.stroke();
    pen.globalAlpha = 1;
    pen.setLineDash([]);
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {World} world
   */
  drawStations(pen, world) {
    const { palette: p, scale: s, run } = this;
    const { width } = run.layout;
    run.layout.queues.forEach(([cell], i) => {
      const [column, row] = [cell % width, Math.floor(cell / width)];
      const [x, y] = [this.toX(column), this.toY(row)];
      const outward = column < width / 2 ? -1 : 1;
      pen.strokeStyle = p.soft;
      pen.lineWidth = Math.max(0.08 * s, 1);
      pen.strokeRect(x + 0.04 * s, y + 0.04 * s, 0.92 * s, 0.92 * s);
      // The picker beside it, at work or not, with the station's name.
      const px = x + (outward > 0 ? 1.55 : -0.55) * s;
      const py = y + 0.5 * s;
      pen.beginPath();
      if (run.stations.capacity[i] || !run.stations.bundle_capacity[i]) pen.arc(px, py, 0.46 * s, 0, FULL);
      else pen.rect(px - 0.44 * s, py - 0.44 * s, 0.88 * s, 0.88 * s); // it does nothing but store bundles
      pen.fillStyle = this.isPicking(i, world.tick) ? p.work : p.rest;
      pen.fill();
      if (world.closed.has(i)) this.strike(pen, px, py);
      pen.fillStyle = this.isPicking(i, world.tick) ? p.card : p.ink;
      pen.font = `600 ${Math.max(0.6 * s, 8)}px system-ui, sans-serif`;
      pen.textAlign = "center";
      pen.textBaseline = "middle";
      if (s > 11 * this.ratio) pen.fillText(run.stations.name[i], px, py + 0.03 * s);
      this.drawChips(pen, world, i, x, y, outward);
    });
  }

  /**
   * A line across what is closed or out of service, of the size of a cell.
   * @param {CanvasRenderingContext2D} pen
   * @param {number} x
   * @param {number} y
   */
  strike(pen, x, y) {
    const s = this.scale;
    pen.beginPath();
    pen.moveTo(x - 0.46 * s, y + 0.46 * s);
    pen.lineTo(x + 0.46 * s, y - 0.46 * s);
    pen.strokeStyle = this.palette.wait;
    pen.lineWidth = Math.max(0.12 * s, 1.5);
    pen.stroke();
  }

  /**
   * Each open order of a station is a chip, fuller with more items to pick; each bundle one, hollow until it has a pod.
   * @param {CanvasRenderingContext2D} pen
   * @param {World} world
   * @param {number} station
   * @param {number} x
   * @param {number} y
   * @param {number} outward
   */
  drawChips(pen, world, station, x, y, outward) {
    const { palette: p, scale: s } = this;
    const step = 0.48 * s;
    const { open, bundles } = world.stations[station];
    const chips = Array.from(open.values(), (items) => ({ colour: p.accent, alpha: Math.min(0.35 + 0.2 * items, 1), full: true }));
    for (const id of bundles) chips.push({ colour: p.bundle, alpha: 1, full: world.bundles[id].pod >= 0 });
    chips.slice(0, MOST_CHIPS).forEach(({ colour, alpha, full }, i) => {
      const across = (i % CHIPS) * step;
      const cx = outward > 0 ? x + 1.1 * s + across : x - 0.48 * s - across;
      const cy = y + 1.1 * s + Math.floor(i / CHIPS) * step;
      const line = Math.max(0.08 * s, 1);
      pen.globalAlpha = alpha;
      [pen.fillStyle, pen.strokeStyle, pen.lineWidth] = [colour, colour, line];
      if (full) pen.fillRect(cx, cy, 0.38 * s, 0.38 * s);
      else pen.strokeRect(cx + line / 2, cy + line / 2, 0.38 * s - line, 0.38 * s - line);
    });
    pen.globalAlpha = 1;
  }

  /**
   * A packing station beneath the map: its packers, its boxes, and the totes there and on their way.
   * @param {CanvasRenderingContext2D} pen
   * @param {World} world
   * @param {ToldPacking} packing
   * @param {number} id
   */
  drawPacking(pen, world, packing, id) {
    const { palette: p, scale: s } = this;
    const { x, y } = this.packingAt(id);
    const [px, py] = [this.toX(x + 0.5), this.toY(y + 0.5)];
    const { coming, waiting, packing: packed } = world.packing[id];
    const putting = world.putting(id);
    pen.beginPath();
    pen.arc(px, py, 0.55 * s, 0, FULL);
    pen.fillStyle = putting + packed ? p.work : p.rest;
    pen.fill();
    pen.fillStyle = putting + packed ? p.card : p.ink;
    pen.font = `600 ${Math.max(0.55 * s, 8)}px system-ui, sans-serif`;
    [pen.textAlign, pen.textBaseline] = ["center", "middle"];
    if (s > 9 * this.ratio) pen.fillText(`P${id + 1}`, px, py + 0.03 * s);
    const [step, size, line] = [0.48 * s, 0.38 * s, Math.max(0.06 * s, 1)];
    const most = Math.max(Math.floor((this.run.layout.width - 3) / 0.48), 1);
    const left = px + 0.85 * s;
    /** @param {number} i @param {number} number @param {number} top */
    const rest = (i, number, top) => {
      [pen.fillStyle, pen.textAlign] = [p.soft, "left"];
      pen.fillText(`+${number}`, left + i * step + 0.1 * s, top + size / 2);
    };
    const held = world.boxes(id);
    const numbers = [...new Set([...held.keys(), ...Array(packing.boxes).keys()])].sort((a, b) => a - b);
    const top = py - 0.55 * s;
    numbers.slice(0, most).forEach((box, i) => {
      const order = held.get(box);
      const x = left + i * step;
      if (order !== undefined) {
        const share = Math.min((world.packs.get(order)?.items ?? 0) / Math.max(this.itemsOf[order], 1), 1);
        pen.fillStyle = p.accent;
        pen.fillRect(x, top + size * (1 - share), size, size * share);
      }
      [pen.strokeStyle, pen.lineWidth] = [order === undefined ? p.empty : p.accent, line];
      pen.strokeRect(x + line / 2, top + line / 2, size - line, size - line);
    });
    if (numbers.length > most) rest(most, numbers.length - most, top);
    const totes = [...Array(putting + packed).fill(p.work), ...Array(waiting - putting + coming).fill(p.bundle)];
    const below = py + 0.12 * s;
    totes.slice(0, most).forEach((colour, i) => {
      const x = left + i * step;
      [pen.fillStyle, pen.strokeStyle, pen.lineWidth] = [colour, colour, line];
      if (i < packed + waiting) pen.fillRect(x, below, size, size);
      else pen.strokeRect(x + line / 2, below + line / 2, size - line, size - line);
    });
    if (totes.length > most) rest(most, totes.length - most, below);
  }

  /**
   * Column and row of a packing station's sign beneath the map.
   * @param {number} id
   */
  packingAt(id) {
    return { x: 0.2, y: this.run.layout.height + 0.6 + STRIP * id };
  }

  /**
   * @param {number} station
   * @param {number} tick
   */
  isPicking(station, tick) {
    const { start, free } = this.picking[station];
    const i = lastUpTo(start, tick);
    return i >= 0 && tick < free[i];
  }

  /**
   * Whether what a picker is at is to store a bundle.
   * @param {number} station
   * @param {number} tick
   */
  isStoring(station, tick) {
    const { start, stores } = this.picking[station];
    return this.isPicking(station, tick) && stores[lastUpTo(start, tick)];
  }

  /**
   * The way of a robot until it has something else to do.
   * @param {CanvasRenderingContext2D} pen
   * @param {number} robot
   * @param {number} tick
   */
  drawWay(pen, robot, tick) {
    const legs = this.run.legs[robot];
    const here = this.places[robot];
    const list = this.history.robot[robot];
    const next = list.find((at) => this.run.sequence.tick[at] > tick);
    const until = next === undefined ? Infinity : this.run.sequence.tick[next];
    pen.beginPath();
    pen.moveTo(this.toX(here.x + 0.5), this.toY(here.y + 0.5));
    for (let i = Math.max(here.leg, 0); i < legs.n && legs.start[i] < until; i++) {
      const x = legs.x[i] + STEP_X[legs.towards[i]] * legs.metres[i];
      const y = legs.y[i] + STEP_Y[legs.towards[i]] * legs.metres[i];
      pen.lineTo(this.toX(x + 0.5), this.toY(y + 0.5));
    }
    pen.strokeStyle = this.palette.robot;
    pen.lineWidth = Math.max(0.14 * this.scale, 2);
    pen.lineJoin = "round";
    pen.globalAlpha = 0.55;
    pen.stroke();
    pen.globalAlpha = 1;
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {World} world
   * @param {Thing} selected
   */
  drawSelected(pen, world, { kind, id }) {
    const s = this.scale;
    pen.strokeStyle = this.palette.ink;
    pen.lineWidth = Math.max(0.1 * s, 2);
    for (const { x, y } of this.whereIs(world, kind, id)) {
      pen.beginPath();
      pen.arc(this.toX(x + 0.5), this.toY(y + 0.5), 0.78 * s, 0, FULL);
      pen.stroke();
    }
  }

  /**
   * Where a thing is; an order is at the stations that have lines of it.
   * @param {World} world
   * @param {Thing["kind"]} kind
   * @param {number} id
   * @returns {{ x: number, y: number }[]}
   */
  whereIs(world, kind, id) {
    const { width, queues } = this.run.layout;
    /** @param {number} cell */
    const centre = (cell) => ({ x: cell % width, y: Math.floor(cell / width) });
    if (kind === "robot") return [this.places[id]];
    if (kind === "station") return [centre(queues[id][0])];
    if (kind === "charger") return [centre(id)];
    if (kind === "packing") return [this.packingAt(id), ...(this.run.layout.packing ? [centre(this.run.layout.packing[id])] : [])];
    if (kind === "bundle") {
      const { station, pod, stored } = world.bundles[id] ?? { station: -1, pod: -1, stored: false };
      return stored ? this.whereIs(world, "pod", pod) : station < 0 ? [] : [centre(queues[station][0])];
    }
    if (kind === "order") {
      const pack = world.packs.get(id);
      return [...world.stations.flatMap((one, i) => (one.open.has(id) ? [centre(queues[i][0])] : [])), ...(pack ? [this.packingAt(pack.station)] : [])];
    }
    return [world.podCell[id] < 0 ? this.places[world.podRobot[id]] : centre(world.podCell[id])];
  }

  /**
   * What is under a point of the page: a robot before a pod before a charger before a station with its queue.
   * @param {World} world
   * @param {number} clientX
   * @param {number} clientY
   * @returns {Thing | null}
   */
  hit(world, clientX, clientY) {
    const { x, y } = this.cellAt(clientX, clientY);
    const robot = this.places.findIndex((here) => Math.hypot(here.x - x, here.y - y) < 0.45);
    if (robot >= 0) return { kind: "robot", id: robot };
    const { width, height } = this.run.layout;
    const [column, row] = [Math.round(x), Math.round(y)];
    const cell = column >= 0 && column < width && row >= 0 && row < height ? row * width + column : -1;
    const pod = world.podCell.indexOf(cell);
    if (cell >= 0 && pod >= 0) return { kind: "pod", id: pod };
    if (cell >= 0 && Number(this.run.layout.kind[cell]) === CHARGER) return { kind: "charger", id: cell };
    const strip = Math.floor((y - this.packingAt(0).y) / STRIP + 0.5);
    if (x > -1 && x < width && strip >= 0 && strip < (this.run.packing?.stations ?? 0)) return { kind: "packing", id: strip };
    const packing = cell >= 0 ? (this.run.layout.packing ?? []).indexOf(cell) : -1;
    if (packing >= 0) return { kind: "packing", id: packing };
    /** @param {number[]} cells */
    const near = ([own]) => Math.abs((own % width) - x) < 2 && Math.abs(Math.floor(own / width) - y) < 0.8;
    const station = this.run.layout.queues.findIndex((cells) => cells.includes(cell) || near(cells));
    return station >= 0 ? { kind: "station", id: station } : null;
  }
}

/**
 * Begin and end of each time that a picker handles an item or stores a bundle, by station.
 * @param {Run} run
 */
function stationPicks(run) {
  const { item_picked: picked, bundle_stored: stored } = run.events;
  const found = run.stations.name.map(() => /** @type {{ start: number, free: number, stores: boolean }[]} */ ([]));
  picked.station.forEach((id, i) => found[id].push({ start: picked.start_tick[i], free: picked.picker_free_tick[i], stores: false }));
  stored.station.forEach((id, i) => found[id].push({ start: stored.start_tick[i], free: stored.tick[i], stores: true }));
  return found.map((spans) => {
    spans.sort((a, b) => a.start - b.start);
    return { start: spans.map(({ start }) => start), free: spans.map(({ free }) => free), stores: spans.map(({ stores }) => stores) };
  });
}
