// A camera that orbits a point, with the direction against gravity upwards: pointer, pinch, wheel, keys, named views.
import { Matrix4, Vector3 } from "../vendor/three/three.module.min.js";

/** @import {Stage} from "./stage.js" */

/** Yaw and pitch of the named views, rad; the machine looks along x. @type {Record<string, [number, number]>} */
export const VIEWS = { free: [-0.75, 0.22], front: [0, 0], side: [-Math.PI / 2, 0], top: [-Math.PI / 2, 1.5] };
const STEEPEST = 1.54;

export class Orbit {
  /**
   * @param {Stage} stage
   * @param {number[]} gravity
   */
  constructor(stage, gravity) {
    this.stage = stage;
    const down = new Vector3().fromArray(gravity);
    this.up = down.lengthSq() > 0 ? down.negate().normalize() : new Vector3(0, 0, 1);
    const ahead = Math.abs(this.up.x) < 0.9 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
    this.ahead = ahead.addScaledVector(this.up, -ahead.dot(this.up)).normalize();
    this.left = new Vector3().crossVectors(this.up, this.ahead);
    /** What is framed. @type {Vector3[]} */
    this.points = [];
    this.reach = 0.5;
    this.target = new Vector3();
    this.yaw = VIEWS.free[0];
    this.pitch = VIEWS.free[1];
    this.distance = 2;
    stage.camera.up.copy(this.up);
    stage.before.push(() => this.place());
    /** Whether the pointer is taken by another tool. @type {(() => boolean)[]} */
    this.taken = [];
    this.listen();
  }

  /**
   * Frames points, whichever direction they are seen from.
   * @param {Vector3[]} points
   * @param {number} radius of a ball around them, m
   */
  frame(points, radius) {
    this.points = points;
    this.reach = Math.max(radius, 0.02);
    this.reset();
  }

  /** Looks at the middle of what the points cover on the screen, from where they fill it. */
  reset() {
    const { camera } = this.stage, out = this.outwards();
    const right = new Vector3().crossVectors(this.up, out).normalize(), above = new Vector3().crossVectors(out, right);
    const axes = [right, above, out];
    const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    for (const point of this.points) axes.forEach((axis, k) => { const at = point.dot(axis); low[k] = Math.min(low[k], at); high[k] = Math.max(high[k], at); });
    if (!Number.isFinite(low[0])) return;
    this.target.set(0, 0, 0);
    axes.forEach((axis, k) => this.target.addScaledVector(axis, (low[k] + high[k]) / 2));
    const slope = Math.tan((camera.fov * Math.PI) / 360), margin = 1.16, half = (/** @type {number} */ k) => (high[k] - low[k]) / 2;
    this.distance = Math.max((margin * half(1)) / slope, (margin * half(0)) / (slope * camera.aspect), 0.05 * this.reach) + 0.6 * half(2);
    camera.near = this.distance / 100;
    camera.far = this.distance + 30 * this.reach;
    camera.updateProjectionMatrix();
    this.stage.invalidate();
  }

  /** Direction from the target to the camera. */
  outwards() {
    const flat = Math.cos(this.pitch);
    return new Vector3().addScaledVector(this.ahead, flat * Math.cos(this.yaw)).addScaledVector(this.left, flat * Math.sin(this.yaw)).addScaledVector(this.up, Math.sin(this.pitch));
  }

  /** @param {string} name one of `VIEWS` */
  view(name) {
    const view = VIEWS[name];
    if (!view) return;
    [this.yaw, this.pitch] = view;
    this.reset();
  }

  /** @param {number} yaw @param {number} pitch rad */
  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.max(-STEEPEST, Math.min(STEEPEST, this.pitch + pitch));
    this.stage.invalidate();
  }

  /** @param {number} factor */
  zoom(factor) {
    this.distance = Math.max(0.15 * this.reach, Math.min(30 * this.reach, this.distance / factor));
    this.stage.invalidate();
  }

  /** Moves the point that is looked at. @param {number} dx @param {number} dy px */
  pan(dx, dy) {
    const scale = (2 * this.distance * Math.tan((this.stage.camera.fov * Math.PI) / 360)) / (this.stage.canvas.clientHeight || 1);
    const [right, up] = this.axes();
    this.target.addScaledVector(right, -dx * scale).addScaledVector(up, dy * scale);
    this.stage.invalidate();
  }

  /** Directions to the right and upwards on the screen. @returns {[Vector3, Vector3]} */
  axes() {
    const m = this.stage.camera.matrixWorld;
    return [new Vector3().setFromMatrixColumn(m, 0), new Vector3().setFromMatrixColumn(m, 1)];
  }

  place() {
    const { camera, key } = this.stage;
    camera.position.copy(this.target).addScaledVector(this.outwards(), this.distance);
    camera.lookAt(this.target);
    camera.updateMatrixWorld();
    const [right, up] = this.axes();
    key.position.copy(camera.position).addScaledVector(right, -0.45 * this.distance).addScaledVector(up, 0.7 * this.distance);
    key.target.position.copy(this.target);
    key.target.updateMatrixWorld();
  }

  /** Acts on a key of the focused canvas; whether it was one of the view's. @param {string} key */
  key(key) {
    /** @type {Record<string, () => void>} */
    const acts = {
      ArrowLeft: () => this.turn(-0.1, 0), ArrowRight: () => this.turn(0.1, 0), ArrowUp: () => this.turn(0, 0.1), ArrowDown: () => this.turn(0, -0.1),
      "+": () => this.zoom(1.2), "=": () => this.zoom(1.2), "-": () => this.zoom(1 / 1.2), 0: () => this.view("free"),
      1: () => this.view("front"), 2: () => this.view("side"), 3: () => this.view("top"), 4: () => this.view("free"),
    };
    if (!acts[key]) return false;
    acts[key]();
    return true;
  }

  listen() {
    const { canvas } = this.stage;
    /** @type {Map<number, number[]>} */
    const held = new Map();
    canvas.addEventListener("pointerdown", (e) => {
      if (this.taken.some((taken) => taken())) return;
      canvas.setPointerCapture(e.pointerId);
      held.set(e.pointerId, [e.clientX, e.clientY]);
    });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(name, (e) => held.delete(/** @type {PointerEvent} */ (e).pointerId));
    }
    canvas.addEventListener("pointermove", (e) => {
      const was = held.get(e.pointerId);
      if (!was) return;
      const here = [e.clientX, e.clientY], other = [...held].find(([id]) => id !== e.pointerId)?.[1];
      held.set(e.pointerId, here);
      const [dx, dy] = [here[0] - was[0], here[1] - was[1]];
      if (other) {
        const length = (/** @type {number[]} */ p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
        this.zoom(length(here) / length(was));
        this.pan(dx / 2, dy / 2);
      } else if (e.shiftKey || e.buttons === 2 || e.buttons === 4) this.pan(dx, dy);
      else this.turn(-dx / 170, dy / 170);
    });
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("keydown", (e) => {
      if (!e.ctrlKey && !e.metaKey && !e.altKey && this.key(e.key)) e.preventDefault();
    });
    // The wheel scrolls a page; with Ctrl, or where the view fills the window, it zooms.
    canvas.addEventListener("wheel", (e) => {
      if (!e.ctrlKey && canvas.dataset.wheel !== "zoom") return;
      e.preventDefault();
      this.zoom(Math.exp(-e.deltaY / 500));
    }, { passive: false });
  }
}

/** A matrix of a pose. @param {ArrayLike<number>} poses @param {number} body @param {Matrix4} out */
export function poseMatrix(poses, body, out) {
  const k = 7 * body, [x, y, z, w, a, b, c] = [0, 1, 2, 3, 4, 5, 6].map((i) => poses[k + i]);
  // By rows; a quaternion (w; a, b, c) of unit length.
  return out.set(
    1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b), x,
    2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a), y,
    2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b), z,
    0, 0, 0, 1,
  );
}
