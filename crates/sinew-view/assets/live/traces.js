// Signals over time, one pane under another with a common cursor: zoom by a drag, pause, search, export of what is seen.
import { ink } from "../view/palette.js";
import { button, element, figure, save, tell, words } from "./layout.js";
import { FIRST, MOVED, pane, panes } from "./panes.js";

/** @import {Session} from "./session.js" */
/** @import {Pane} from "./panes.js" */

/** Points of a line; more would only lie on the same pixels. */
const MOST = 700;
/** Seconds that are shown. */
const WINDOWS = [2, 5, 10, 30, 60];
/** Of a chart with the label of its time, pixels. */
const HEIGHT = 106;
/** Steps of the axes: round ones. */
const STEPS = Array.from({ length: 16 }, (_, k) => [1, 2, 5].map((m) => Number(`${m}e${k - 8}`))).flat();
/** Between two drawings, ms. */
const EVERY = 80;

/** @typedef {{id: string, title: string, chart: any, box: HTMLElement, head: HTMLElement, figures: HTMLElement[], key: string, pane: Pane}} Shown */

export class Traces {
  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    this.panes = [...FIRST];
    /** @type {Shown[]} */
    this.shown = [];
    this.window = 10;
    this.paused = false;
    /** Range that was zoomed to, s. @type {[number, number]|null} */
    this.zoomed = null;
    this.drawn = 0;
    this.list = element("div", { class: "panes" });
    this.find = element("input", { type: "search", list: "signal-names", placeholder: "Add a signal", "aria-label": "Add a signal by name", onchange: () => this.add() });
    this.names = element("datalist", { id: "signal-names" });
    this.pauseButton = button("Pause", () => this.pause(), { "aria-pressed": "false" });
    this.width = element("select", { "aria-label": "Time shown", onchange: () => { this.window = Number(this.width.value); this.zoomed = null; this.draw(true); } },
      WINDOWS.map((s) => element("option", { value: s, text: `${s} s`, selected: s === this.window })));
    this.box = element("div", { class: "traces" }, [
      element("div", { class: "trace-tools" }, [this.find, this.names, this.width, this.pauseButton,
        button("CSV", () => this.csv(), { "aria-label": "Save what is shown as CSV" }), button("PNG", () => this.png(), { "aria-label": "Save what is shown as PNG" })]),
      this.list,
    ]);
    this.sync = "signals";
    new ResizeObserver(() => this.size()).observe(this.list);
  }

  /** Names that the search offers. */
  offer() {
    const { scene } = this.session;
    this.names.replaceChildren(...panes(scene).map(([, title]) => element("option", { value: title })), ...(scene?.signals ?? []).map((s) => element("option", { value: words(s.name), label: `${s.group}, ${s.unit}` })));
    if (this.panes.length && !this.panes.some((id) => pane(this.session, id))) this.panes = [...MOVED];
    this.build();
  }

  add() {
    const requested = this.find.value.trim().toLowerCase();
    if (!requested) return;
    const known = panes(this.session.scene).find(([, title]) => title.toLowerCase() === requested), signals = this.session.scene?.signals ?? [];
    const signal = signals.find((s) => words(s.name).toLowerCase() === requested) ?? signals.find((s) => `${words(s.name)} ${s.label}`.toLowerCase().includes(requested));
    const id = known?.[0] ?? (signal ? `signal:${signal.name}` : "");
    if (!id) { this.session.tell("notice", { text: `No signal is called “${this.find.value}”.`, bad: true }); return; }
    if (!this.panes.includes(id)) this.panes.push(id);
    this.find.value = "";
    this.build();
    this.list.lastElementChild?.scrollIntoView({ block: "nearest" });
  }

  /** @param {string} id */
  remove(id) {
    this.panes = this.panes.filter((other) => other !== id);
    this.build();
  }

  pause() {
    this.paused = !this.paused;
    this.pauseButton.textContent = this.paused ? "Continue" : "Pause";
    this.pauseButton.setAttribute("aria-pressed", String(this.paused));
    if (!this.paused) this.zoomed = null;
    this.draw(true);
  }

  recolour() {
    this.shown.forEach(({ chart }) => chart.destroy());
    this.shown = [];
    this.build();
  }

  /** Makes the charts whose lines changed, and keeps the others. */
  build() {
    const requested = this.panes.map((id) => pane(this.session, id)).filter((p) => p !== null);
    const key = (/** @type {Pane} */ p) => JSON.stringify([p.id, p.unit, p.lines.map((l) => [l.name, l.colour])]);
    const kept = new Map(this.shown.map((s) => [s.key, s]));
    const next = requested.map((p) => {
      const old = kept.get(key(p));
      if (old) {
        kept.delete(key(p));
        old.pane = p;
        /** @type {HTMLElement} */ (old.head.firstChild).textContent = `${p.title}, ${p.unit}`;
        return old;
      }
      return this.chart(p, key(p));
    });
    for (const gone of kept.values()) gone.chart.destroy();
    this.shown = next;
    this.list.replaceChildren(...next.map((s) => s.box));
    this.size();
    this.draw(true);
  }

  /** @param {Pane} p @param {string} key @returns {Shown} */
  chart(p, key) {
    const figures = p.lines.map(() => element("b"));
    const values = element("span", { class: "pane-values" }, p.lines.map((line, k) => {
      const key = element("span", { text: `${line.name} `, title: line.name });
      key.style.setProperty("--key", `var(${line.colour})`);
      key.append(figures[k]);
      return key;
    }));
    const head = element("div", { class: "pane-head" }, [element("h2", { text: `${p.title}, ${p.unit}` }), values,
      button("×", () => this.remove(p.id), { "aria-label": `Remove ${p.title}`, class: "quiet" })]);
    const holder = element("div", { class: "pane-chart" }), box = element("div", { class: "pane" }, [head, holder]);
    const soft = ink("--soft"), grid = { stroke: ink("--grid"), width: 1 }, ticks = { show: false }, font = "11px system-ui, sans-serif";
    const chart = onCanvas(this.session.software, () => new /** @type {any} */ (globalThis).uPlot({
      width: 300, height: HEIGHT, legend: { show: false }, padding: [6, 8, 0, 0],
      cursor: { sync: { key: this.sync, setSeries: false }, drag: { x: true, y: false, setScale: false }, points: { size: 5 } },
      scales: { x: { time: false, auto: false }, y: { range: (/** @type {any} */ _u, /** @type {number} */ low, /** @type {number} */ high) => spread(low, high) } },
      axes: [
        { stroke: soft, grid, ticks, font, incrs: STEPS, size: 32, gap: 3, label: "time, s", labelSize: 14, labelGap: 0, labelFont: font, values: (/** @type {any} */ _u, /** @type {number[]} */ at) => at.map((v) => figure(v, 4)) },
        { stroke: soft, grid, ticks, font, size: 46, gap: 4, splits: (/** @type {any} */ _u, /** @type {number} */ _axis, /** @type {number} */ low, /** @type {number} */ high) => round(low, high), values: (/** @type {any} */ _u, /** @type {number[]} */ at) => at.map((v) => figure(v, 4)) },
      ],
      series: [{}, ...p.lines.map((line) => ({ label: line.name, stroke: ink(line.colour), width: line.width ?? 1.4, dash: line.dash, points: { show: false }, spanGaps: false }))],
      hooks: {
        setSelect: [(/** @type {any} */ u) => {
          if (u.select.width < 4) return;
          this.zoom([u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")]);
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        }],
        setCursor: [(/** @type {any} */ u) => this.read(u)],
      },
    }, [[0], ...p.lines.map(() => [null])], holder));
    holder.addEventListener("dblclick", () => this.zoom(null));
    return { id: p.id, title: p.title, chart, box, head, figures, key, pane: p };
  }

  /** @param {[number, number]|null} range s */
  zoom(range) {
    this.zoomed = range;
    if (range && !this.paused) this.pause();
    this.zoomed = range;
    this.draw(true);
  }

  size() {
    const width = this.list.clientWidth;
    if (width < 60) return;
    for (const { chart } of this.shown) if (chart.width !== width) chart.setSize({ width, height: HEIGHT });
  }

  /** Values under the cursor, or the newest. @param {any} chart */
  read(chart) {
    const shown = this.shown.find((s) => s.chart === chart);
    if (!shown) return;
    const index = chart.cursor.idx ?? (chart.data[0].length - 1);
    shown.pane.lines.forEach((_, k) => tell(shown.figures[k], figure(chart.data[k + 1]?.[index] ?? NaN)));
  }

  /** Range of time that is shown, s. @returns {[number, number]} */
  range() {
    const { history } = this.session, end = history.count ? history.time[history.at(history.count - 1)] : 0;
    return this.zoomed ?? [end - this.window, end];
  }

  /** @param {boolean} [now] whether to draw without waiting for the next turn @param {number} [only] number of the one pane to draw */
  draw(now = false, only = -1) {
    const clock = performance.now();
    if (!now && (this.paused || clock - this.drawn < EVERY || !this.box.offsetParent)) return;
    this.drawn = clock;
    const [low, high] = this.range(), { history } = this.session;
    const first = history.from(low), last = Math.max(first, history.from(high + 1e-9)), step = Math.max(1, Math.ceil((last - first) / MOST));
    /** @type {number[]} */
    const samples = [];
    for (let k = first; k < last; k += step) samples.push(k);
    const time = samples.map((k) => history.time[history.at(k)]);
    for (const { chart, pane: p } of only < 0 ? this.shown : this.shown.slice(only, only + 1)) {
      chart.batch(() => {
        chart.setData([time, ...p.lines.map((line) => samples.map((k) => { const v = line.value(k); return Number.isFinite(v) ? v : null; }))], false);
        chart.setScale("x", { min: low, max: high });
      });
      this.read(chart);
    }
  }

  /** What is shown, one row a sample. */
  csv() {
    const [low, high] = this.range(), { history, scene } = this.session, lines = this.shown.flatMap(({ pane: p }) => p.lines.map((line) => ({ name: `${p.title} ${line.name} [${p.unit}]`, value: line.value })));
    const quoted = (/** @type {string} */ s) => `"${s.replaceAll('"', '""')}"`;
    const rows = [["time_s", ...lines.map((line) => quoted(line.name))].join(",")];
    for (let k = history.from(low); k < history.count && history.time[history.at(k)] <= high; k += 1) rows.push([history.time[history.at(k)], ...lines.map((line) => { const v = line.value(k); return Number.isFinite(v) ? v : ""; })].join(","));
    save(`${scene?.machine ?? "signals"}.csv`, new Blob([`${rows.join("\n")}\n`], { type: "text/csv" }));
  }

  /** The panes as one picture. */
  png() {
    const density = devicePixelRatio || 1, width = (this.list.clientWidth || 300) * density, head = 24 * density;
    const out = element("canvas", { width, height: this.shown.reduce((sum, s) => sum + head + s.chart.ctx.canvas.height, 0) }), pen = out.getContext("2d");
    if (!pen) return;
    pen.fillStyle = ink("--card");
    pen.fillRect(0, 0, out.width, out.height);
    let y = 0;
    for (const { chart, pane: p } of this.shown) {
      pen.font = `${12 * density}px system-ui, sans-serif`;
      pen.fillStyle = ink("--ink");
      pen.fillText(`${p.title}, ${p.unit}`, 6 * density, y + 16 * density);
      let x = 6 * density + pen.measureText(`${p.title}, ${p.unit}`).width + 14 * density;
      for (const line of p.lines) {
        pen.fillStyle = ink(line.colour);
        pen.fillText(line.name, x, y + 16 * density);
        x += pen.measureText(line.name).width + 10 * density;
      }
      pen.drawImage(chart.ctx.canvas, 0, y + head);
      y += head + chart.ctx.canvas.height;
    }
    out.toBlob((blob) => blob && save(`${this.session.scene?.machine ?? "signals"}.png`, blob));
  }
}

/**
 * Makes a chart whose canvas, where no graphics processor draws, is kept in memory: through an emulated one it would cost as much as
 * the machine itself.
 * @template T @param {boolean} software @param {() => T} make @returns {T}
 */
function onCanvas(software, make) {
  const canvas = HTMLCanvasElement.prototype, { getContext } = canvas;
  if (software) canvas.getContext = /** @type {any} */ (function (/** @type {any[]} */ kind, /** @type {any} */ options) {
    // @ts-ignore: the canvas is whatever it is called on.
    return getContext.call(this, kind, { ...options, willReadFrequently: true });
  });
  try { return make(); } finally { canvas.getContext = getContext; }
}

/** Round values within a range, two at least. @param {number} low @param {number} high @returns {number[]} */
function round(low, high) {
  /** @type {number[]} */
  let found = [];
  for (let count = 2; found.length < 2 && count <= 64; count *= 2) {
    const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw)), step = power * (/** @type {number} */ ([1, 2, 5, 10].find((m) => m * power >= 0.7 * raw)) ?? 10);
    const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
    found = Array.from({ length: Math.max(0, last - first + 1) }, (_, k) => Number(((first + k) * step).toPrecision(12)));
  }
  return found;
}

/** A range with room above and below; around a constant, a fraction of it. @param {number} low @param {number} high @returns {[number, number]} */
function spread(low, high) {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  const room = high > low ? 0.08 * (high - low) : Math.max(0.02 * Math.abs(high), 0.01);
  return [low - room, high + room];
}
