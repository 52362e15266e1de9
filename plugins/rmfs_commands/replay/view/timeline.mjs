// @ts-check
// The time line: picks per hour as bars, backlog as a line, decisions as ticks; where the clock is.

import { clockTime } from "./clock.mjs";
import { penOf } from "./draw.mjs";
/** @import { Palette, Series } from "./types.d.ts" */

const TOP = 17;
const BOTTOM = 9;

/** Draws the series of one run; what does not change is drawn once. */
export class Timeline {
  ratio = 1; // pixels of the canvas in one of the page
  width = 0; // in those of the page
  height = 0;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Series} series
   * @param {number} end
   * @param {string} label
   * @param {Palette} palette
   */
  constructor(canvas, series, end, label, palette, begin = 0) {
    this.canvas = canvas;
    this.series = series;
    this.end = end;
    this.begin = begin;
    this.label = label;
    this.palette = palette;
    this.still = document.createElement("canvas");
    this.mostPicks = series.perHour.reduce((a, b) => Math.max(a, b), 0);
    this.mostBacklog = series.backlog.reduce((a, b) => Math.max(a, b), 0);
  }

  /** @param {Palette} palette */
  resize(palette) {
    const { clientWidth, clientHeight } = this.canvas;
    if (!clientWidth || !clientHeight) return;
    this.ratio = window.devicePixelRatio || 1;
    this.width = clientWidth;
    this.height = clientHeight;
    this.palette = palette;
    for (const canvas of [this.canvas, this.still]) {
      canvas.width = Math.round(this.width * this.ratio);
      canvas.height = Math.round(this.height * this.ratio);
    }
    this.drawStill();
  }

  /** @param {number} tick */
  toX = (tick) => (Math.max(tick - this.begin, 0) / Math.max(this.end - this.begin, 1)) * this.width;

  drawStill() {
    const { series, palette: p, height } = this;
    const pen = penOf(this.still);
    pen.scale(this.ratio, this.ratio);
    pen.clearRect(0, 0, this.width, height);
    const floor = height - BOTTOM;
    const tall = floor - TOP;
    pen.fillStyle = p.levels[1];
    series.perHour.forEach((value, i) => {
      const x = this.toX(this.begin + i * series.width);
      const bar = (value / Math.max(this.mostPicks, 1)) * tall;
      pen.fillRect(x, floor - bar, Math.max(this.toX(this.begin + series.width) - 1, 1), bar);
    });
    pen.beginPath();
    pen.strokeStyle = p.ink;
    pen.lineWidth = 1.5;
    pen.lineJoin = "round";
    series.backlog.forEach((value, i) => {
      pen.lineTo(this.toX(Math.min(this.begin + (i + 1) * series.width, this.end)), floor - (value / Math.max(this.mostBacklog, 1)) * tall);
    });
    pen.stroke();
    pen.fillStyle = p.soft;
    pen.globalAlpha = series.rounds.length > this.width ? 0.35 : 0.7;
    for (const tick of series.rounds) pen.fillRect(this.toX(tick), floor + 3, 1, BOTTOM - 3);
    pen.globalAlpha = 1;
    pen.fillStyle = p.line;
    pen.fillRect(0, floor, this.width, 1);
    this.drawLabels(pen);
  }

  /** @param {CanvasRenderingContext2D} pen */
  drawLabels(pen) {
    const { palette: p } = this;
    pen.font = "12px system-ui, sans-serif";
    pen.textBaseline = "top";
    let x = 0;
    /**
     * @param {string} text
     * @param {string} colour
     * @param {string} [mark]
     */
    const say = (text, colour, mark) => {
      if (mark) {
        pen.fillStyle = mark;
        pen.fillRect(x, 4, 9, 9);
        x += 13;
      }
      pen.fillStyle = colour;
      pen.fillText(text, x, 2);
      x += pen.measureText(text).width + 14;
    };
    if (this.label) say(this.label, p.ink);
    say(`picks per hour, up to ${Math.round(this.mostPicks)}`, p.soft, p.levels[1]);
    say(`backlog, up to ${this.mostBacklog}`, p.soft, p.ink);
    if (this.width > 560) say("decisions below", p.soft);
  }

  /** @param {number} tick */
  draw(tick) {
    if (!this.width) return;
    const pen = penOf(this.canvas);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.still, 0, 0);
    pen.fillStyle = this.palette.ink;
    pen.fillRect(Math.min(this.toX(tick), this.width - 2) * this.ratio, TOP * this.ratio, 2 * this.ratio, this.canvas.height);
  }

  /**
   * Time under a point of the page.
   * @param {number} clientX
   */
  tickAt(clientX) {
    const box = this.canvas.getBoundingClientRect();
    return this.begin + ((clientX - box.left) / box.width) * (this.end - this.begin);
  }

  /**
   * What the time line says at a time, for people.
   * @param {number} tick
   */
  says(tick) {
    const bin = Math.min(Math.floor((tick - this.begin) / this.series.width), this.series.perHour.length - 1);
    return `${clockTime(tick)}: ${Math.round(this.series.perHour[bin])} picks per hour, backlog ${this.series.backlog[bin]}`;
  }
}
