// Which signals a pane of the traces shows: those that follow the selection, and single ones found by search.
import { words } from "./layout.js";

/** @import {Session} from "./session.js" */

/**
 * A line: a signal, its name, the custom property of its colour, and how it is computed.
 * @typedef {{name: string, colour: string, dash?: number[], width?: number, value: (k: number) => number}} LineOf
 * @typedef {{id: string, title: string, unit: string, lines: LineOf[]}} Pane
 */

/** Panes of every machine, and those that are shown at first. @type {[string, string][]} */
const PANES = [
  ["far", "Far tension"], ["near", "Near tension"], ["joint_error", "Joint error"], ["end_point_error", "End-point error"],
  ["joint_angle", "Joint positions"], ["cycle", "Cycle times"],
];
/** Those of a scene: every signal of the muscles that no pane above draws has one of its own. @param {Session["scene"]} scene @returns {[string, string][]} */
export function panes(scene) {
  const own = (scene?.signals ?? []).filter((s) => s.muscle !== null && !DRAWN.includes(s.field)).map((s) => /** @type {[string, string]} */ ([`field:${s.field}`, title(s.label)]));
  return [...PANES, ...new Map(own)];
}
const DRAWN = ["tension_in_n", "tension_out_n", "tension_out_estimated_n", "tension_out_desired_n"];

/** @param {string} label */
function title(label) {
  return label.charAt(0).toUpperCase() + label.slice(1);
}

export const FIRST = ["far", "near", "joint_error", "end_point_error"];
/** Shown at first of a machine that is moved without forces. */
export const MOVED = ["joint_angle"];

const COLOURS = ["--m0", "--m1", "--m2", "--m3", "--m4", "--m5", "--m6", "--m7"];

/** Whether a field is in the layout. @param {Session} session @param {string} field */
function has(session, field) {
  return session.history.rings.has(field);
}

/** A unit as it is read, and the factor to it. @param {string} unit @returns {[string, number]} */
function shown(unit) {
  return unit === "m" ? ["mm", 1000] : unit === "degC" ? ["°C", 1] : [unit || "1", 1];
}

/** @param {Session} session @param {string} id @returns {Pane|null} null for what the source does not have */
export function pane(session, id) {
  const { scene, history, muscle, selection } = session;
  if (!scene) return null;
  const of = (/** @type {string} */ field, /** @type {number} */ index, scale = 1) => (/** @type {number} */ k) => scale * history.value(field, index, k);
  const name = words(scene.muscles[muscle]?.name ?? "");
  const only = (/** @type {(false|LineOf)[]} */ lines) => /** @type {LineOf[]} */ (lines.filter(Boolean));
  const far = () => only([
    has(session, "tension_out_n") && { name: "true (simulated)", colour: "--measured", width: 2.6, value: of("tension_out_n", muscle) },
    has(session, "tension_out_estimated_n") && { name: "estimated", colour: "--accent", width: 1.5, value: of("tension_out_estimated_n", muscle) },
    has(session, "tension_out_desired_n") && { name: "reference", colour: "--warm", dash: [5, 4], width: 1.4, value: of("tension_out_desired_n", muscle) },
    has(session, "tension_out_2") && { name: words(session.compared ?? "second machine"), colour: "--m3", width: 1.4, value: of("tension_out_2", muscle) },
  ]);
  const one = (/** @type {string} */ title, /** @type {string} */ field) => {
    if (!has(session, field) || !scene.muscles.length) return null;
    const [unit, scale] = shown(scene.layout.find((f) => f.name === field)?.unit ?? "");
    return { id, title: `${title}: ${name}`, unit, lines: [{ name: title.toLowerCase(), colour: "--accent", width: 1.5, value: of(field, muscle, scale) }] };
  };
  if (id === "far") return scene.muscles.length && has(session, "tension_in_n") ? { id, title: `Far tension: ${name}`, unit: "N", lines: far() } : null;
  if (id === "near") return one("Near tension", "tension_in_n");
  const field = id.startsWith("field:") ? scene.signals.find((s) => `field:${s.field}` === id) : null;
  if (field) return one(title(field.label), field.field);
  if (id === "joint_error" || id === "joint_angle") {
    const measured = ["joint_true", "joint_estimated"].find((field) => has(session, field)), errors = id === "joint_error";
    const field = errors ? measured : measured ?? "joint_reference";
    const chosen = selection?.kind === "joint" ? [selection.index] : scene.joints.map((_, k) => k).slice(0, 8);
    const angle = chosen.every((k) => scene.joints[k]?.unit !== "m"), scale = angle ? 180 / Math.PI : 1000;
    if (!field || !has(session, "joint_reference") || !chosen.length) return null;
    const [what, all] = errors ? ["Joint error", "Joint errors"] : ["Joint position", "Joint positions"];
    return { id, title: selection?.kind === "joint" ? `${what}: ${words(scene.joints[chosen[0]].name)}` : all, unit: angle ? "deg" : "mm",
      lines: chosen.map((k) => ({ name: words(scene.joints[k].name), colour: COLOURS[k % 8], width: 1.4, value: (s) => scale * (history.value(field, k, s) - (errors ? history.value("joint_reference", k, s) : 0)) })) };
  }
  if (id === "end_point_error") {
    const distance = (/** @type {string} */ field) => (/** @type {number} */ s) => 1000 * Math.hypot(...[0, 1, 2].map((i) => history.value(field, i, s) - history.value("end_point_reference", i, s)));
    if (!has(session, "end_point") || !has(session, "end_point_reference")) return null;
    return { id, title: "End-point error", unit: "mm", lines: only([{ name: session.compared ? "this machine" : "distance from the reference", colour: "--accent", width: 1.5, value: distance("end_point") },
      has(session, "end_point_2") && { name: words(session.compared ?? "second machine"), colour: "--warm", width: 1.5, value: distance("end_point_2") }]) };
  }
  if (id === "cycle") {
    const times = Object.entries({ wake_up_us: "wake-up delay", read_us: "reading", control_us: "control", write_us: "writing" }).filter(([field]) => has(session, field));
    return times.length ? { id, title: "Cycle times", unit: "µs", lines: times.map(([field, label], k) => ({ name: label, colour: COLOURS[k], width: 1.3, value: of(field, 0) })) } : null;
  }
  const signal = scene.signals.find((s) => `signal:${s.name}` === id);
  return signal ? { id, title: words(signal.name.replace(":", ": ")), unit: signal.unit, lines: [{ name: signal.label + (signal.simulated_truth ? " (simulated)" : ""), colour: "--accent", width: 1.5, value: of(signal.field, signal.index) }] } : null;
}
