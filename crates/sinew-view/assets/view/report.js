// The view in a report: shows the poses, motions and paths that stand as JSON in a figure, without a server.
import { Quaternion } from "../vendor/three/three.module.min.js";
import { View } from "./view.js";
import { VIEWS } from "./camera.js";

/** @import {Machine, Instant} from "./types.js" */

/**
 * A pose: bodies as seven numbers each and branches of every cable, null where they are those of the first pose.
 * @typedef {{bodies: (number[]|null)[], cables: (number[][][]|null)[]}} Pose
 * @typedef {{joint: string, unit: string, at: number[], frames: Pose[]}} Sweep
 * @typedef {{fixed: any, poses: {name: string, scene: Pose}[], sweeps: Sweep[], paths: {class: string, name: string, points: number[][]}[]}} Data
 */

/** Colours of the classes of paths. @type {Record<string, string>} */
const PATH_COLOURS = { measured: "--soft", predicted: "--accent", near: "--near", lowered: "--warm" };
/** Time of a motion from end to end, if its quantity is no time, s. */
const SWEEP = 4;

/** An empty machine, where only paths are shown. */
const NOTHING = { gravity: [0, 0, -9.81], bodies: [], shapes: [], meshes: [], joints: [], muscles: [] };

/** All branches of a pose, one after another. @param {Pose} pose @param {Pose} base @returns {number[][][]} */
function branches(pose, base) {
  return pose.cables.flatMap((cable, k) => cable ?? base.cables[k] ?? []);
}

class Figure {
  /** @param {HTMLElement} figure */
  constructor(figure) {
    this.figure = figure;
    /** @type {Data} */
    this.data = JSON.parse(figure.querySelector("script")?.textContent ?? "{}");
    const { data } = this, base = data.poses[0]?.scene, machine = data.fixed ?? NOTHING;
    /** @type {Pose[]} */
    this.all = [...data.poses.map((p) => p.scene), ...data.sweeps.flatMap((s) => s.frames)];
    // Branches of all muscles as lines of as many points as the longest of any pose.
    const lists = base ? this.all.map((pose) => branches(pose, base)) : [];
    this.counts = (lists[0] ?? []).map((_, k) => Math.max(...lists.map((list) => list[k]?.length ?? 0), 2));
    this.muscleOf = base ? machine.muscles.flatMap((/** @type {any} */ _, /** @type {number} */ k) => (base.cables[k] ?? []).map(() => k)) : [];
    const lines = this.counts.map((points, k) => ({ name: machine.muscles[this.muscleOf[k]].name, points, sheath_points: 0 }));
    const canvas = /** @type {HTMLCanvasElement} */ (figure.querySelector("canvas"));
    this.picked = figure.querySelector(".picked");
    this.view = new View(canvas, { ...machine, muscles: lines, end_point: null }, { select: (found) => this.select(found), colours: this.muscleOf, reduced: true, printed: true });
    this.view.trail.seconds = 1e9;
    for (const path of data.paths) this.view.addPath(path.points, PATH_COLOURS[path.class] ?? "--accent", path.class === "measured" ? 3.2 : 2, path.class === "near" ? 0.01 : 0);
    this.choice = /** @type {HTMLSelectElement|null} */ (figure.querySelector("select"));
    this.slide = /** @type {HTMLElement|null} */ (figure.querySelector(".slide"));
    this.slider = /** @type {HTMLInputElement|null} */ (figure.querySelector("input[type=range]"));
    this.play = /** @type {HTMLButtonElement|null} */ (figure.querySelector(".play"));
    this.playing = false;
    this.tools();
    this.choice?.addEventListener("change", () => this.choose());
    this.slider?.addEventListener("input", () => { this.playing = false; this.show(); });
    this.play?.addEventListener("click", () => this.toggle());
    addEventListener("theme", () => this.view.recolour());
    this.choose();
    if (!base) this.view.take({ body_pose: [], cable_points: [] }, 0);
    // A drawing that stands in for the view is no longer needed on the screen.
    if (figure.previousElementSibling?.matches(".still")) figure.closest("section")?.classList.add("live");
  }

  tools() {
    const tools = this.figure.querySelector(".tools");
    const add = (/** @type {string} */ text, /** @type {string} */ label, /** @type {() => void} */ act) => {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: text });
      button.setAttribute("aria-label", label);
      button.addEventListener("click", act);
      tools?.append(button);
    };
    for (const name of Object.keys(VIEWS)) add(name[0].toUpperCase() + name.slice(1), `View: ${name}`, () => this.view.orbit.view(name));
    add("+", "Zoom in", () => this.view.orbit.zoom(1.3));
    add("−", "Zoom out", () => this.view.orbit.zoom(1 / 1.3));
    add("PNG", "Save the view as PNG", () => this.view.picture((blob) => {
      const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: "view.png" });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    }));
  }

  /** @param {import("./types.js").Selection} found */
  select(found) {
    this.view.select(found);
    const list = found ? { muscle: this.view.machine.muscles, joint: this.view.machine.joints, body: this.view.machine.bodies }[found.kind] : null;
    if (this.picked) this.picked.textContent = list && found ? `Selected: ${list[found.index].name.replaceAll("_", " ")}.` : "";
  }

  /** The motion that is chosen, if any. @returns {Sweep|undefined} */
  get sweep() {
    return this.data.sweeps[Number(this.choice?.value ?? 0) - this.data.poses.length];
  }

  choose() {
    const { sweep } = this;
    this.playing = false;
    this.view.framed = false;
    if (this.slide) this.slide.hidden = !sweep;
    if (sweep && this.slider) {
      this.slider.max = String(sweep.frames.length - 1);
      this.slider.value = String(sweep.unit === "s" ? 0 : (sweep.frames.length - 1) / 2);
    }
    this.show();
  }

  toggle() {
    this.playing = !this.playing;
    if (this.play) this.play.textContent = this.playing ? "Pause" : "Play";
    let last = performance.now();
    const step = (/** @type {number} */ now) => {
      const { sweep, slider } = this;
      if (!this.playing || !sweep || !slider) { if (this.play) this.play.textContent = "Play"; return; }
      const most = sweep.frames.length - 1, seconds = sweep.unit === "s" ? sweep.at[most] - sweep.at[0] : SWEEP;
      const next = Number(slider.value) + ((now - last) / 1000) * (most / Math.max(seconds, 0.5));
      last = now;
      slider.value = String(next >= most ? 0 : next);
      this.show();
      requestAnimationFrame(step);
    };
    if (this.playing) requestAnimationFrame(step);
  }

  /** Shows the chosen pose, between two frames of a motion what lies between them. */
  show() {
    const { sweep, data } = this, base = data.poses[0]?.scene;
    if (!base) return;
    if (!sweep) { this.take(this.instant(data.poses[Number(this.choice?.value ?? 0)]?.scene ?? base)); return; }
    const at = Number(this.slider?.value ?? 0), k = Math.min(Math.floor(at), sweep.frames.length - 1), next = Math.min(k + 1, sweep.frames.length - 1), fraction = at - k;
    const value = sweep.at[k] + fraction * (sweep.at[next] - sweep.at[k]), output = this.slide?.querySelector("output");
    if (output) output.textContent = `${value.toFixed(sweep.unit === "s" ? 2 : 3)} ${sweep.unit}`;
    const [a, b] = [this.instant(sweep.frames[k]), this.instant(sweep.frames[next])];
    this.take(fraction ? between(a, b, fraction) : a);
  }

  /** @param {Instant} now */
  take(now) {
    this.view.take(now, 0);
  }

  /** @param {Pose} pose @returns {Instant} */
  instant(pose) {
    const base = this.data.poses[0].scene;
    // Shorter branches stay at their end.
    const points = branches(pose, base).flatMap((line, k) => Array.from({ length: this.counts[k] }, (_, i) => line[Math.min(i, line.length - 1)] ?? [NaN, NaN, NaN]).flat());
    return { body_pose: pose.bodies.flatMap((body, k) => body ?? base.bodies[k] ?? []), cable_points: points };
  }
}

/** What lies between two instants. @param {Instant} a @param {Instant} b @param {number} fraction @returns {Instant} */
function between(a, b, fraction) {
  const mix = (/** @type {ArrayLike<number>} */ x, /** @type {ArrayLike<number>} */ y) => Array.from(x, (v, k) => v + fraction * (y[k] - v));
  const poses = mix(a.body_pose, b.body_pose), p = new Quaternion(), q = new Quaternion();
  for (let k = 0; k + 6 < poses.length; k += 7) {
    const of = (/** @type {ArrayLike<number>} */ list, /** @type {Quaternion} */ out) => out.set(list[k + 4], list[k + 5], list[k + 6], list[k + 3]);
    const { x, y, z, w } = of(a.body_pose, p).slerp(of(b.body_pose, q), fraction);
    poses.splice(k + 3, 4, w, x, y, z);
  }
  return { body_pose: poses, cable_points: mix(a.cable_points, b.cable_points) };
}

/** Begins a view; null where it cannot be drawn. @param {Element} figure @returns {Figure|null} */
function begin(figure) {
  begun.add(figure);
  seen.unobserve(figure);
  try { return new Figure(/** @type {HTMLElement} */ (figure)); } catch (error) {
    figure.querySelector(".canvas-box")?.replaceChildren(Object.assign(document.createElement("p"), { className: "notice", textContent: `The view cannot be drawn: ${error instanceof Error ? error.message : error}` }));
    return null;
  }
}

// A page may hold more views than a browser draws at once: each begins where it comes into sight.
/** @type {Set<Element>} */
const begun = new Set();
const seen = new IntersectionObserver((entries) => {
  for (const entry of entries) if (entry.isIntersecting) begin(entry.target);
}, { rootMargin: "200px" });
document.querySelectorAll("figure.scene").forEach((figure) => seen.observe(figure));
// Paper has no sight: what has not begun yet begins before it is printed.
addEventListener("beforeprint", () => document.querySelectorAll("figure.scene").forEach((figure) => { if (!begun.has(figure)) begin(figure)?.view.stage.tick(performance.now()); }));
