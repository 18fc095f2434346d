// The last minute of all fields but the geometry, in rings of fixed size, so that an hour takes no more memory than a minute.

/** @import {Field, State} from "./protocol.js" */

/** Samples that are kept: a minute at 60 Hz. */
const MOST = 3600;
/** What is drawn, not plotted. */
export const GEOMETRY = /^(body_pose|reference_pose|cable_)/;

export class History {
  /** @param {Field[]} layout */
  constructor(layout) {
    this.most = MOST;
    this.count = 0;
    this.start = 0;
    this.time = new Float64Array(MOST);
    /** @type {Map<string, {count: number, values: Float32Array}>} */
    this.rings = new Map();
    for (const { name, count } of layout) if (!GEOMETRY.test(name) && name !== "time_s") this.rings.set(name, { count, values: new Float32Array(MOST * count) });
    /** Rises where time went back, so that what was derived is derived anew. */
    this.revision = 0;
  }

  /** Number of the ring's place of a sample, the oldest first. @param {number} k */
  at(k) {
    return (this.start + k) % this.most;
  }

  /** Time of the newest sample, s; NaN while there is none. */
  get last() {
    return this.count ? this.time[this.at(this.count - 1)] : NaN;
  }

  /** @param {State} state */
  push(state) {
    const time = state.time_s?.[0] ?? NaN, { last } = this;
    if (!Number.isFinite(time)) return;
    if (time === last) return;
    // A recording was wound back, or the source began anew.
    if (time < last || time > last + 30) this.clear();
    const full = this.count === this.most, at = full ? this.start : this.at(this.count);
    if (full) this.start = (this.start + 1) % this.most;
    else this.count += 1;
    this.time[at] = time;
    for (const [name, { count, values }] of this.rings) {
      const field = state[name];
      for (let k = 0; k < count; k += 1) values[at * count + k] = field ? field[k] : NaN;
    }
  }

  /** Adds what was before the oldest sample. @param {State[]} rows the oldest first */
  prepend(rows) {
    const { time, rings, count, start, most } = this, oldest = count ? time[start] : Infinity;
    const kept = Array.from({ length: count }, (_, k) => {
      const at = (start + k) % most;
      /** @type {Record<string, ArrayLike<number>>} */
      const sample = { time_s: [time[at]] };
      for (const [name, ring] of rings) sample[name] = ring.values.slice(at * ring.count, (at + 1) * ring.count);
      return /** @type {State} */ (/** @type {unknown} */ (sample));
    });
    this.clear();
    for (const row of rows) if ((row.time_s?.[0] ?? NaN) < oldest) this.push(row);
    for (const sample of kept) this.push(sample);
  }

  clear() {
    this.count = this.start = 0;
    this.revision += 1;
  }

  /** First sample not before a time. @param {number} time s */
  from(time) {
    let [low, high] = [0, this.count];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[this.at(middle)] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** A value; NaN where it is not known. @param {string} field @param {number} index @param {number} k */
  value(field, index, k) {
    const ring = this.rings.get(field);
    return ring && index < ring.count ? ring.values[this.at(k) * ring.count + index] : NaN;
  }
}
