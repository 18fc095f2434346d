// Lines of many points as strips that face the camera, all lines in one draw call: two vertices a point, moved apart across
// the direction of the line by the vertex shader. No instances: software renderers draw these one at a time.
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, GreaterDepth, Mesh, ShaderMaterial, Vector2 } from "../vendor/three/three.module.min.js";

const VERTEX = `
attribute vec3 ahead; attribute vec4 of; attribute vec2 line;
uniform vec2 size; uniform float width; uniform float chosen; uniform float chosen_width; uniform float offset; uniform float least;
varying float v_side; varying float v_value; varying float v_along; varying float v_state; varying float v_other;
void main() {
  vec4 here = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  vec4 there = projectionMatrix * modelViewMatrix * vec4(position + ahead, 1.0);
  vec2 way = (there.xy / there.w - here.xy / here.w) * size;
  float span = length(way);
  vec2 direction = span > 1e-6 ? way / span : vec2(1.0, 0.0);
  float breadth = max(least, abs(line.x - chosen) < 0.5 ? chosen_width : width);
  here.xy += vec2(-direction.y, direction.x) * line.y * breadth / size * here.w;
  here.z -= offset * here.w;
  v_other = chosen > -0.5 && abs(line.x - chosen) > 0.5 ? 1.0 : 0.0;
  v_side = line.y; v_value = of.x; v_state = of.y; v_along = of.z;
  gl_Position = here;
}`;

const VARYINGS = "uniform float faint; varying float v_side; varying float v_value; varying float v_along; varying float v_state; varying float v_other;";

export class Ribbon {
  /**
   * @param {number[]} counts points of each line
   * @param {string} fragment declares its uniforms and `vec4 shade()`
   * @param {Record<string, {value: unknown}>} uniforms
   * @param {{hidden?: boolean, order?: number, offset?: number, flat?: boolean}} [options] `hidden`: drawn faintly where a body covers
   *   it, too; `flat`: writes no depth
   */
  constructor(counts, fragment, uniforms, options = {}) {
    const total = Math.max(2, counts.reduce((a, b) => a + b, 0));
    this.counts = counts;
    this.total = total;
    /** Of every point: place, m, value, state, length along the line, m; written by the owner. */
    this.points = new Float32Array(3 * total);
    this.values = new Float32Array(total);
    this.states = new Float32Array(total);
    this.lengths = new Float32Array(total);
    const attribute = (/** @type {number} */ size) => new BufferAttribute(new Float32Array(2 * total * size), size).setUsage(DynamicDrawUsage);
    this.vertex = { position: attribute(3), ahead: attribute(3), of: attribute(4) };
    const line = new Float32Array(4 * total);
    let at = 0;
    counts.forEach((count, index) => { for (let k = 0; k < count; k += 1, at += 1) line.set([index, -1, index, 1], 4 * at); });
    this.line = new BufferAttribute(line, 2);
    this.geometry = this.strips((_, k, count) => k < count - 1);
    this.uniforms = { size: { value: new Vector2(1, 1) }, width: { value: 3 }, chosen: { value: -1 }, chosen_width: { value: 3 }, offset: { value: options.offset ?? 0.0004 }, faint: { value: 1 }, least: { value: 1 }, ...uniforms };
    this.meshes = options.hidden ? [this.mesh(fragment, options, true), this.mesh(fragment, options)] : [this.mesh(fragment, options)];
  }

  /** Geometry of the segments that are requested. @param {(line: number, k: number, count: number) => boolean} requested whether point k is joined with the next */
  strips(requested) {
    const geometry = new BufferGeometry(), index = [];
    for (const [name, attribute] of Object.entries(this.vertex)) geometry.setAttribute(name, attribute);
    geometry.setAttribute("line", this.line);
    let at = 0;
    for (const [line, count] of this.counts.entries()) for (let k = 0; k < count; k += 1, at += 1) {
      if (k < count - 1 && requested(line, k, count)) index.push(2 * at, 2 * at + 1, 2 * at + 2, 2 * at + 2, 2 * at + 1, 2 * at + 3);
    }
    geometry.setIndex(index);
    return geometry;
  }

  /** @param {string} fragment @param {{order?: number, flat?: boolean}} options @param {boolean} [behind] drawn only where something covers it */
  mesh(fragment, options, behind = false, geometry = this.geometry) {
    const made = new Mesh(geometry, new ShaderMaterial({
      uniforms: behind ? { ...this.uniforms, faint: { value: 0.25 } } : this.uniforms,
      vertexShader: VERTEX,
      fragmentShader: `${VARYINGS}\n${fragment}\nvoid main() { vec4 colour = shade(); gl_FragColor = vec4(colour.rgb, colour.a * faint); }`,
      transparent: true, depthWrite: !behind && !options.flat, side: 2, ...(behind ? { depthFunc: GreaterDepth } : {}),
    }));
    made.frustumCulled = false;
    made.renderOrder = (options.order ?? 2) - (behind ? 0.5 : 0);
    return made;
  }

  /** Shows the first points of a single line only. @param {number} points */
  show(points) {
    this.geometry.setDrawRange(0, 6 * Math.max(0, points - 1));
  }

  /** Hands what was written into the arrays to the vertices. */
  upload() {
    const { points, values, states, lengths } = this, position = this.vertex.position.array, ahead = this.vertex.ahead.array, of = this.vertex.of.array;
    let at = 0;
    for (const count of this.counts) for (let k = 0; k < count; k += 1, at += 1) {
      const before = 3 * (k ? at - 1 : at), after = 3 * (k < count - 1 ? at + 1 : at), p = 3 * at, v = 6 * at, o = 8 * at;
      for (let i = 0; i < 3; i += 1) {
        position[v + i] = position[v + 3 + i] = points[p + i];
        ahead[v + i] = ahead[v + 3 + i] = 0.5 * (points[after + i] - points[before + i]);
      }
      // A line that is shorter than its points rests at its end, and keeps its direction.
      if (k && !ahead[v] && !ahead[v + 1] && !ahead[v + 2]) for (let i = 0; i < 6; i += 1) ahead[v + i] = ahead[v + i - 6];
      of[o] = of[o + 4] = values[at];
      of[o + 1] = of[o + 5] = states[at];
      of[o + 2] = of[o + 6] = lengths[at];
    }
    for (const attribute of Object.values(this.vertex)) attribute.needsUpdate = true;
  }

  /** Size of the canvas in CSS pixels, in which widths are given, and the least width. @param {number} w @param {number} h @param {number} least */
  resize(w, h, least) {
    this.uniforms.size.value.set(w, h);
    this.uniforms.least.value = least;
  }
}
