// Taking hold of the end point: the pointer drags its handle in the plane of the screen, keys move it in small steps.
import { Plane, Vector3 } from "../vendor/three/three.module.min.js";
import { place, project, ray } from "../view/pick.js";

/** @import {Session} from "./session.js" */
/** @import {View} from "../view/view.js" */

/** Distance at which the handle is taken, CSS pixels; a finger is wider. */
const NEAR = { mouse: 16, pen: 20, touch: 28 };
/** Between two commands, ms. */
const EVERY = 33;
/** Step of a key, as a fraction of the reach of the view. */
const STEP = 0.04;

export class Grasp {
  /** @param {Session} session @param {View} view */
  constructor(session, view) {
    this.session = session;
    this.view = view;
    this.held = false;
    this.sent = 0;
    /** @type {Vector3|null} Where keys have moved the target to. */
    this.target = null;
    const { canvas } = view.stage, plane = new Plane(), requested = new Vector3();
    view.orbit.taken.push(() => this.held);
    canvas.addEventListener("pointerdown", (e) => {
      if (!session.accepts("drag") || !view.surroundings.handle.visible) return;
      const at = place(view, e), q = project(view, view.surroundings.handle.position);
      if (Math.hypot(at[0] - q[0], at[1] - q[1]) > (NEAR[/** @type {keyof typeof NEAR} */ (e.pointerType)] ?? NEAR.mouse)) return;
      this.held = true;
      canvas.setPointerCapture(e.pointerId);
      canvas.classList.add("holding");
      plane.setFromNormalAndCoplanarPoint(view.stage.camera.getWorldDirection(new Vector3()), view.surroundings.handle.position);
    }, { capture: true });
    canvas.addEventListener("pointermove", (e) => {
      if (!this.held) return;
      if (ray(view, place(view, e)).ray.intersectPlane(plane, requested)) this.drag(requested);
    });
    const release = () => {
      if (!this.held) return;
      this.held = false;
      canvas.classList.remove("holding");
      this.end();
    };
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) canvas.addEventListener(name, release);
  }

  /** Asks for a place of the end point. @param {Vector3} at @param {boolean} [now] */
  drag(at, now = false) {
    const clock = performance.now();
    if (!now && clock - this.sent < EVERY) return;
    this.sent = clock;
    this.session.command("drag", { position: at.toArray() });
  }

  end() {
    this.target = null;
    this.session.command("drag_end");
  }

  /** Moves the target with a key: w a s d in the plane of the screen, q and e away and near. @param {string} key @returns {boolean} */
  key(key) {
    const { view } = this;
    if (!this.session.accepts("drag") || !view.surroundings.handle.visible) return false;
    const [right, up] = view.orbit.axes(), away = view.stage.camera.getWorldDirection(new Vector3());
    const move = /** @type {Record<string, Vector3>} */ ({ w: up, s: up.clone().negate(), d: right, a: right.clone().negate(), q: away, e: away.clone().negate() })[key];
    if (!move) return false;
    this.target ??= view.surroundings.handle.position.clone();
    this.target.addScaledVector(move, STEP * view.orbit.reach);
    this.drag(this.target, true);
    return true;
  }
}
