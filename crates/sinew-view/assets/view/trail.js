// Lines of a point: the requested path, and the trail that the end point leaves, faded towards its beginning.
import { Color } from "../vendor/three/three.module.min.js";
import { triple } from "./cables.js";
import { token } from "./palette.js";
import { Ribbon } from "./ribbon.js";

const LINE = `uniform vec3 tone; uniform float fading; uniform float dash;
vec4 shade() {
  float gap = dash > 0.0 ? step(0.4, fract(v_along / dash)) : 1.0;
  if (gap < 0.5) discard;
  return vec4(tone, mix(1.0, 0.9 * v_value + 0.06, fading) * (1.0 - 0.5 * v_side * v_side));
}`;

/** A line of the theme's colour. */
class Line {
  /** @param {number} count @param {string} name of the colour @param {{width: number, fading?: boolean, dash?: number, order?: number}} style `dash` in m */
  constructor(count, name, style) {
    this.name = name;
    this.uniforms = { tone: { value: new Color() }, fading: { value: style.fading ? 1 : 0 }, dash: { value: style.dash ?? 0 } };
    this.ribbon = new Ribbon([count], LINE, this.uniforms, { order: style.order ?? 5, offset: 0.0002, flat: true });
    this.ribbon.uniforms.width.value = this.ribbon.uniforms.chosen_width.value = style.width;
    this.recolour();
  }

  recolour() {
    this.uniforms.tone.value.setRGB(...triple(token(this.name)));
  }
}

/** A path that does not change. */
export class Path extends Line {
  /** @param {number[][]} points @param {string} name of the colour @param {number} [width] @param {number} [dash] */
  constructor(points, name, width = 2.2, dash = 0) {
    super(points.length, name, { width, dash, order: 4.6 });
    const { ribbon } = this;
    points.forEach((p, k) => {
      ribbon.points.set(p, 3 * k);
      ribbon.lengths[k] = k ? ribbon.lengths[k - 1] + Math.hypot(...p.map((v, i) => v - points[k - 1][i])) : 0;
    });
    ribbon.upload();
  }
}

/** What a point has left behind. */
export class Trail extends Line {
  /** @param {number} seconds @param {string} name of the colour */
  constructor(seconds, name) {
    const most = 480;
    super(most, name, { width: 2.6, fading: true });
    this.most = most;
    this.seconds = seconds;
    /** @type {number[][]} Time and place. */
    this.samples = [];
    this.last = -Infinity;
    this.stale = true;
  }

  clear() {
    this.samples.length = 0;
    this.last = -Infinity;
    this.stale = true;
  }

  /** @param {number} time s @param {ArrayLike<number>} at */
  push(time, at) {
    if (time < this.last || time > this.last + 0.5 * this.seconds) this.samples.length = 0;
    if (time === this.last || !Number.isFinite(at[0])) return;
    const step = this.seconds / (this.most - 4), head = this.samples[this.samples.length - 1];
    this.last = time;
    // The newest sample moves along until it is a step ahead of the one before it.
    if (head && this.samples.length > 1 && time - this.samples[this.samples.length - 2][0] < step) head.splice(0, 4, time, at[0], at[1], at[2]);
    else this.samples.push([time, at[0], at[1], at[2]]);
    while (this.samples.length > this.most || (this.samples.length && time - this.samples[0][0] > this.seconds)) this.samples.shift();
    this.stale = true;
  }

  /** Hands the samples to the vertices, if there are new ones. */
  flush() {
    if (!this.stale) return;
    this.stale = false;
    this.write(this.last);
  }

  /** @param {number} time s */
  write(time) {
    const { ribbon, samples } = this;
    samples.forEach((s, k) => {
      ribbon.points[3 * k] = s[1];
      ribbon.points[3 * k + 1] = s[2];
      ribbon.points[3 * k + 2] = s[3];
      ribbon.values[k] = 1 - (time - s[0]) / this.seconds;
    });
    ribbon.show(samples.length);
    ribbon.upload();
  }
}
