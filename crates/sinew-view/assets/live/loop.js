// Far tension over near tension of the selected muscle, drawn live: the cable's hysteresis, between the lines on which the
// whole cable slides by the capstan law: near tension times or divided by exp(mu times the angle of bend), plus the pretension.
import { ink } from "../view/palette.js";
import { element, figure, tell } from "./layout.js";

/** @import {Session} from "./session.js" */

/** Seconds that are shown. */
const SHOWN = 12;
const MOST = 700;

export class Loop {
  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    this.canvas = element("canvas", { role: "img", "aria-label": "Far tension over near tension of the selected muscle" });
    this.legend = element("p", { class: "keys" });
    this.box = element("figure", { class: "loop-figure" }, [element("figcaption", { text: "Near and far tension" }), this.canvas, this.legend]);
    this.caption = /** @type {HTMLElement} */ (this.box.firstChild);
    this.recolour();
  }

  recolour() {
    this.colours = Object.fromEntries(["accent", "measured", "soft", "line", "grid", "rule", "tint", "ink", "card", "warm"].map((name) => [name, ink(`--${name}`)]));
    this.legend.replaceChildren(...[["accent", "estimated"], ["measured", "true (simulated)"]].map(([colour, name]) => {
      const key = element("span", { text: name });
      key.style.setProperty("--key", `var(--${colour})`);
      return key;
    }), element("span", { class: "area-key", text: "between the lines of sliding" }));
  }

  draw() {
    const { scene, history, muscle } = this.session, { canvas } = this, c = /** @type {Record<string, string>} */ (this.colours);
    const w = canvas.clientWidth, h = canvas.clientHeight, pen = canvas.getContext("2d", { willReadFrequently: this.session.software });
    if (scene) this.box.hidden = !history.rings.has("tension_in_n");
    if (!scene || !pen || !w || !h) return;
    const density = devicePixelRatio || 1;
    if (canvas.width !== Math.round(w * density) || canvas.height !== Math.round(h * density)) [canvas.width, canvas.height] = [Math.round(w * density), Math.round(h * density)];
    pen.setTransform(density, 0, 0, density, 0, 0);
    pen.clearRect(0, 0, w, h);
    const named = scene.muscles[muscle];
    tell(this.caption, `Near and far tension: ${named?.name.replaceAll("_", " ") ?? ""}`);
    const end = history.count, from = end ? history.from(history.time[history.at(end - 1)] - SHOWN) : 0, step = Math.max(1, Math.ceil((end - from) / MOST));
    /** @type {number[][]} */
    const points = [];
    let highest = 0;
    for (let k = from; k < end; k += step) {
      const row = [history.value("tension_in_n", muscle, k), history.value("tension_out_estimated_n", muscle, k), history.value("tension_out_n", muscle, k)];
      points.push(row);
      for (const v of row) if (v > highest) highest = v;
    }
    const nice = (/** @type {number} */ x) => { const p = 10 ** Math.floor(Math.log10(x)); return p * (/** @type {number} */ ([1, 2, 4, 8, 10].find((m) => m * p >= x)) ?? 10); };
    const limit = nice(Math.max(1, 1.08 * highest));
    const [left, right, top, bottom] = [42, 12, 8, 34];
    const X = (/** @type {number} */ v) => left + ((w - left - right) * v) / limit, Y = (/** @type {number} */ v) => h - bottom - ((h - top - bottom) * v) / limit;
    pen.font = "11.5px system-ui, sans-serif";
    pen.lineWidth = 1;
    pen.textBaseline = "middle";
    const steps = limit / 10 ** Math.floor(Math.log10(limit)) === 1 ? 5 : 4;
    for (let k = 0; k <= steps; k += 1) {
      const v = (k * limit) / steps;
      pen.strokeStyle = k ? c.grid : c.rule;
      pen.beginPath(); pen.moveTo(left, Y(v)); pen.lineTo(w - right, Y(v)); pen.moveTo(X(v), top); pen.lineTo(X(v), h - bottom); pen.stroke();
      pen.fillStyle = c.soft;
      pen.textAlign = "right"; pen.fillText(figure(v), left - 6, Y(v));
      pen.textAlign = "center"; if (k) pen.fillText(figure(v), X(v), h - bottom + 11);
    }
    pen.fillStyle = c.ink;
    pen.textAlign = "right"; pen.fillText("near tension, N", w - right, h - 7);
    pen.textAlign = "left"; pen.fillText("far tension, N", left + 6, top + 7);
    pen.save();
    pen.beginPath(); pen.rect(left, top, w - left - right, h - top - bottom); pen.clip();
    const ratio = named?.sheath ? Math.exp(named.sheath.mu * named.sheath.bend_rad) : NaN, offset = named?.sheath?.pretension_n ?? 0;
    if (ratio > 1) {
      pen.fillStyle = c.tint; pen.strokeStyle = c.rule;
      pen.beginPath(); pen.moveTo(X(0), Y(offset)); pen.lineTo(X(limit), Y(offset + limit / ratio)); pen.lineTo(X(limit), Y(offset + limit * ratio)); pen.closePath();
      pen.globalAlpha = 0.8; pen.fill(); pen.globalAlpha = 1;
      pen.setLineDash([4, 4]);
      for (const slope of [1 / ratio, ratio]) { pen.beginPath(); pen.moveTo(X(0), Y(offset)); pen.lineTo(X(limit), Y(offset + limit * slope)); pen.stroke(); }
      pen.setLineDash([]);
    }
    pen.lineJoin = "round";
    for (const [column, colour, width] of /** @type {[number, string, number][]} */ ([[2, c.measured, 2.4], [1, c.accent, 1.4]])) {
      pen.strokeStyle = colour; pen.lineWidth = width; pen.globalAlpha = column === 2 ? 0.45 : 1;
      pen.beginPath();
      let drawing = false;
      for (const row of points) {
        if (!Number.isFinite(row[0] + row[column])) { drawing = false; continue; }
        if (drawing) pen.lineTo(X(row[0]), Y(row[column])); else pen.moveTo(X(row[0]), Y(row[column]));
        drawing = true;
      }
      pen.stroke();
      pen.globalAlpha = 1;
    }
    const last = points[points.length - 1];
    if (last && Number.isFinite(last[0] + last[1])) {
      pen.fillStyle = c.accent; pen.strokeStyle = c.card; pen.lineWidth = 1.5;
      pen.beginPath(); pen.arc(X(last[0]), Y(last[1]), 4.5, 0, 2 * Math.PI); pen.fill(); pen.stroke();
    }
    pen.restore();
  }
}
