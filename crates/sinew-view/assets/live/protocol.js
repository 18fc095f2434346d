// Messages of the server: a head of sixteen bytes, then the fields of a state in the order of the scene's layout.

/** @import {Machine, Instant} from "../view/types.js" */

/** @typedef {{name: string, type: string, count: number, unit?: string}} Field */
/** @typedef {{name: string, label: string, unit: string, group: string, muscle: number|null, joint: number|null, field: string, index: number, simulated_truth?: boolean}} Signal */

/**
 * The answer to `/scene`.
 * @typedef {Machine & {schema: string, machine: string, source: string, simulated: boolean, period_s: number, paths: string[],
 *   supervisor: {modes: string[], faults: Record<number, {kind: string, part: string, of: string | null}>}, variants: string[], commands: string[], layout: Field[], layout_revision?: number, signals: Signal[],
 *   events: {time_s: number, kind: string, text: string}[], recording: {duration_s: number}|null, notice?: string|null, compare?: string|null, path_name?: string,
 *   requests?: string[], overlays?: string[], fault_kinds?: [string, string][], tension_along?: string}} SceneMessage
 */

/** A state: numbers of every field of the layout. @typedef {Record<string, ArrayLike<number>>} Fields */
/** @typedef {Instant & Fields} State */

export const KIND = { state: 1, scene: 2, event: 3, answer: 4, history: 5 };
export const FLAG = { paused: 1, behind: 2, stale: 4, thinned: 8 };
const MAGIC = 0x564c4e53;
const HEAD = 16;
const VERSION = 1;

/** Bytes of a number, and how it is read. @type {Record<string, [number, (view: DataView, at: number) => number]>} */
const TYPES = {
  u8: [1, (view, at) => view.getUint8(at)],
  i8: [1, (view, at) => view.getInt8(at)],
  u16: [2, (view, at) => view.getUint16(at, true)],
  u32: [4, (view, at) => view.getUint32(at, true)],
  f32: [4, (view, at) => view.getFloat32(at, true)],
  f64: [8, (view, at) => view.getFloat64(at, true)],
};

/** @param {ArrayBuffer} message @returns {{kind: number, revision: number, body: ArrayBuffer}|null} null for what is not of this version */
export function head(message) {
  if (message.byteLength < HEAD) return null;
  const view = new DataView(message), length = view.getUint32(8, true);
  if (view.getUint32(0, true) !== MAGIC || view.getUint16(4, true) !== VERSION || message.byteLength < HEAD + length) return null;
  return { kind: view.getUint16(6, true), revision: view.getUint32(12, true), body: message.slice(HEAD, HEAD + length) };
}

/** Bytes of a state. @param {Field[]} layout */
export function stateBytes(layout) {
  return layout.reduce((sum, field) => sum + (TYPES[field.type]?.[0] ?? NaN) * field.count, 0);
}

/** @param {ArrayBuffer} body @param {Field[]} layout @returns {State|null} null where the length is another */
export function decode(body, layout) {
  if (body.byteLength !== stateBytes(layout)) return null;
  const view = new DataView(body);
  /** @type {Record<string, Float64Array>} */
  const state = {};
  let at = 0;
  for (const { name, type, count } of layout) {
    const [bytes, read] = TYPES[type], values = new Float64Array(count);
    for (let k = 0; k < count; k += 1, at += bytes) values[k] = read(view, at);
    state[name] = values;
  }
  return /** @type {State} */ (/** @type {unknown} */ (state));
}

/** Rows of states one after another. @param {ArrayBuffer} body @param {Field[]} layout @returns {State[]} */
export function decodeRows(body, layout) {
  const bytes = stateBytes(layout), rows = [];
  for (let at = 0; bytes > 0 && at + bytes <= body.byteLength; at += bytes) {
    const row = decode(body.slice(at, at + bytes), layout);
    if (row) rows.push(row);
  }
  return rows;
}

/** @param {ArrayBuffer} body */
export function json(body) {
  return JSON.parse(new TextDecoder().decode(body));
}
