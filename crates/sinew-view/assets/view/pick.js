// What lies under a pointer: cables and joints by their distance on the screen, then bodies by their shapes.
import { Raycaster, Vector2, Vector3 } from "../vendor/three/three.module.min.js";

/** @import {Selection} from "./types.js" */
/** @import {View} from "./view.js" */

/** Distance at which a line counts as hit, CSS pixels. */
const NEAR = 9;

/** @param {View} view @param {PointerEvent|MouseEvent} event @returns {[number, number]} CSS pixels in the canvas */
export function place(view, event) {
  const box = view.stage.canvas.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
}

/** Where a point of the world appears, CSS pixels. @param {View} view @param {Vector3} point @returns {[number, number]} */
export function project(view, point) {
  const { canvas, camera } = view.stage, p = point.clone().project(camera);
  return [(0.5 + 0.5 * p.x) * canvas.clientWidth, (0.5 - 0.5 * p.y) * canvas.clientHeight];
}

/** The ray of a place on the canvas. @param {View} view @param {[number, number]} at */
export function ray(view, [x, y]) {
  const { canvas, camera } = view.stage, caster = new Raycaster();
  caster.setFromCamera(new Vector2((2 * x) / canvas.clientWidth - 1, 1 - (2 * y) / canvas.clientHeight), camera);
  return caster;
}

/** @param {View} view @param {[number, number]} at @returns {Selection} */
export function pick(view, at) {
  const distance = (/** @type {[number, number]} */ p, /** @type {[number, number]} */ q) => {
    const [dx, dy] = [q[0] - p[0], q[1] - p[1]], t = Math.max(0, Math.min(1, ((at[0] - p[0]) * dx + (at[1] - p[1]) * dy) / (dx * dx + dy * dy || 1)));
    return Math.hypot(at[0] - p[0] - t * dx, at[1] - p[1] - t * dy);
  };
  const joint = view.surroundings.places.findIndex((p) => { const q = project(view, p); return distance(q, q) < NEAR; });
  if (joint >= 0) return { kind: "joint", index: joint };
  const { points } = view.cables.ribbon, point = new Vector3();
  let best = NEAR, muscle = -1;
  view.cables.starts.forEach((start, index) => {
    /** @type {[number, number]|null} */
    let last = null;
    for (let k = start; k < start + view.cables.counts[index]; k += 1) {
      const here = project(view, point.fromArray(points, 3 * k));
      if (last) {
        const d = distance(last, here);
        if (d < best) [best, muscle] = [d, index];
      }
      last = here;
    }
  });
  if (muscle >= 0) return { kind: "muscle", index: muscle };
  const hit = ray(view, at).intersectObjects(view.bodies.targets(), false)[0];
  const shape = hit?.instanceId === undefined ? undefined : hit.object.userData.shapes[hit.instanceId];
  return shape && shape.body > 0 ? { kind: "body", index: shape.body } : null;
}
