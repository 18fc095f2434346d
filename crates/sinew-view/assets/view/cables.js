// All cables along their way from the winch through the sheath to the anchor, coloured by the tension along them. Where a
// cable slides, marks run along it; where sliding ends, at the slip front, a light band lies across it.
import { Color } from "../vendor/three/three.module.min.js";
import { TENSION_GLSL, token } from "./palette.js";
import { Ribbon } from "./ribbon.js";

/** @import {Machine, Instant} from "./types.js" */

/** Speed of the marks, their period, both as fractions of the machine's reach. */
const PERIOD = 0.045;
const SPEED = 0.05;

const CABLE = `uniform float highest; uniform float time; uniform float period; uniform vec3 front; uniform vec3 palette[8]; uniform float known; uniform vec3 paper;
${TENSION_GLSL}
vec4 shade() {
  float round = sqrt(max(0.0, 1.0 - v_side * v_side));
  vec3 colour = known > 0.5 ? tension_colour(v_value / highest) : palette[int(v_value + 0.5)];
  if (abs(v_state) > 0.75) {
    // Arrow heads that point and move where the cable slides to.
    float phase = fract(v_along / period - sign(v_state) * (time - 0.22 * abs(v_side)));
    colour = mix(colour, front, 0.6 * smoothstep(0.60, 0.66, phase) * (1.0 - smoothstep(0.86, 0.92, phase)));
  }
  colour *= 0.62 + 0.38 * round;
  // Between a point that slides and one that sticks lies the front.
  colour = mix(colour, front, smoothstep(0.2, 0.3, abs(v_state)) * (1.0 - smoothstep(0.7, 0.8, abs(v_state))));
  // What is not selected steps back.
  return vec4(mix(colour, paper, 0.62 * v_other), 1.0);
}`;

const SHEATH = `uniform vec3 plain;
vec4 shade() { float round = sqrt(max(0.0, 1.0 - v_side * v_side)); return vec4(plain * (0.6 + 0.4 * round), mix(0.16, 0.5, v_side * v_side) * (1.0 - 0.6 * v_other)); }`;

export class Cables {
  /**
   * @param {Machine} machine @param {number[]} [colours] number of the colour of each cable, for machines without tensions
   * @param {boolean} [software] whether no graphics processor draws: what bodies cover is then left out
   */
  constructor(machine, colours = [], software = false) {
    this.colours = colours;
    const counts = machine.muscles.map((muscle) => muscle.points);
    this.total = counts.reduce((a, b) => a + b, 0);
    this.starts = counts.map((_, k) => counts.slice(0, k).reduce((a, b) => a + b, 0));
    this.counts = counts;
    this.uniforms = { highest: { value: 1 }, time: { value: 0 }, period: { value: 0.02 }, front: { value: new Color(1, 1, 1) }, palette: { value: Array.from({ length: 8 }, () => new Color()) }, known: { value: 0 }, paper: { value: new Color() } };
    this.ribbon = new Ribbon(counts, CABLE, this.uniforms, { hidden: !software, order: 4 });
    this.sheathUniforms = { plain: { value: new Color() }, width: { value: 1 }, chosen_width: { value: 1 }, offset: { value: 0.0001 } };
    // The sheath ends where the cable leaves it.
    const sheath = this.ribbon.strips((muscle, k) => k < machine.muscles[muscle].sheath_points - 1);
    const cover = this.ribbon.mesh(SHEATH, { order: 3, flat: true }, false, sheath);
    /** @type {any} */ (cover.material).uniforms = { ...this.ribbon.uniforms, ...this.sheathUniforms };
    const dense = machine.muscles.length > 30;
    this.width = dense ? 2.2 : 3.2;
    this.ribbon.uniforms.width.value = this.width;
    this.ribbon.uniforms.chosen_width.value = this.width + 2.6;
    this.sheathUniforms.width.value = 2.4 * this.width;
    this.sheathUniforms.chosen_width.value = 2.4 * this.width + 2;
    this.meshes = [cover, ...this.ribbon.meshes];
    /** Whether a cable slides, so that its marks move. */
    this.sliding = false;
    this.recolour();
  }

  recolour() {
    this.sheathUniforms.plain.value.setRGB(...triple(token("--rule")));
    this.uniforms.paper.value.setRGB(...triple(token("--paper")));
    this.uniforms.palette.value.forEach((colour, k) => colour.setRGB(...triple(token(`--m${k}`))));
  }

  /** @param {number} muscle index, -1 for none */
  select(muscle) {
    this.ribbon.uniforms.chosen.value = muscle;
  }

  /** @param {number} reach of the machine, m */
  scale(reach) {
    this.uniforms.period.value = PERIOD * reach;
  }

  /**
   * @param {Instant} now
   * @param {number} highest tension of the map, N
   */
  update(now, highest) {
    const { ribbon } = this, { points, values, states, lengths } = ribbon;
    const from = now.cable_points;
    const known = (now.cable_tension?.length ?? 0) >= this.total && Number.isFinite(now.cable_tension?.[0]);
    this.uniforms.known.value = known ? 1 : 0;
    this.uniforms.highest.value = highest;
    this.sliding = false;
    for (let k = 0; k < 3 * this.total; k += 1) points[k] = from[k];
    this.starts.forEach((start, muscle) => {
      for (let i = 0; i < this.counts[muscle]; i += 1) {
        const p = start + i, b = 3 * p;
        lengths[p] = i ? lengths[p - 1] + Math.hypot(points[b] - points[b - 3], points[b + 1] - points[b - 2], points[b + 2] - points[b - 1]) : 0;
        values[p] = known ? /** @type {ArrayLike<number>} */ (now.cable_tension)[p] : (this.colours[muscle] ?? muscle) % 8;
        // Towards the motor: against the way along the cable.
        states[p] = [0, -1, 1][now.cable_sliding?.[p] ?? 0] ?? 0;
        if (states[p]) this.sliding = true;
      }
    });
    ribbon.upload();
  }

  /** Moves the marks. @param {number} seconds */
  animate(seconds) {
    this.uniforms.time.value = (seconds * SPEED) / PERIOD % 1000;
  }
}

/** @param {number[]} rgb @returns {[number, number, number]} */
export function triple([r, g, b]) {
  return [r, g, b];
}
