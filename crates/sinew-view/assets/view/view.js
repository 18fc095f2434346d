// The three-dimensional view of a machine: one object that takes instants and shows them. The live page and the reports
// use the same.
import { Group, Matrix4, Vector2, Vector3 } from "../vendor/three/three.module.min.js";
import { Bodies, outline } from "./bodies.js";
import { Cables } from "./cables.js";
import { Orbit, poseMatrix } from "./camera.js";
import { pick, place } from "./pick.js";
import { Stage } from "./stage.js";
import { Surroundings } from "./surroundings.js";
import { Path, Trail } from "./trail.js";

/** @import {Machine, Instant, Selection} from "./types.js" */

/** Seconds that the trail shows. */
const TRAIL = 12;

export class View {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Machine} machine
   * @param {{select?: (found: Selection) => void, reduced?: boolean, colours?: number[], printed?: boolean}} [options] `colours`: of each cable, where no tension is known; `printed`: whether the page may be printed
   */
  constructor(canvas, machine, options = {}) {
    this.stage = new Stage(canvas, options.printed);
    this.machine = machine;
    this.options = options;
    this.orbit = new Orbit(this.stage, machine.gravity);
    this.root = new Group();
    this.stage.scene.add(this.root);
    /** @type {Instant|null} */
    this.now = null;
    /** @type {Instant|null} */
    this.waiting = null;
    /** What is looked at. @type {Selection} */
    this.looked = null;
    /** Whether the camera was placed for what is shown. */
    this.framed = false;
    this.highest = 1;
    this.ghost = true;
    this.still = options.reduced ?? false;
    const { software } = this.stage;
    this.bodies = new Bodies(machine, software);
    this.cables = new Cables(machine, options.colours, software);
    this.surroundings = new Surroundings(machine, this.orbit.up, software);
    this.trail = new Trail(TRAIL, "--accent");
    this.second = new Trail(TRAIL, "--warm");
    /** @type {Path[]} */
    this.paths = [];
    this.root.add(this.surroundings.group, this.bodies.group, ...this.cables.meshes, ...this.trail.ribbon.meshes, ...this.second.ribbon.meshes);
    this.path(machine.path ?? null);
    // Before the camera is placed: the first instant decides what it looks at.
    this.stage.before.unshift((now) => this.beforeFrame(now));
    this.listen();
  }

  /** Highest tension of the map, from the limits of the muscles. @param {number} highest N */
  range(highest) {
    this.highest = highest > 0 ? highest : 1;
  }

  /** Sets the requested path. @param {number[][]|null} points */
  path(points) {
    for (const path of this.paths) this.root.remove(...path.ribbon.meshes);
    this.paths = [];
    if (points && points.length > 1) this.addPath(points, "--measured", 1.6, 0);
  }

  /** @param {number[][]} points @param {string} colour @param {number} width px @param {number} dash m */
  addPath(points, colour, width, dash) {
    const path = new Path(points, colour, width, dash);
    this.paths.push(path);
    this.root.add(...path.ribbon.meshes);
    this.stage.invalidate();
  }

  /** Takes an instant, which the next frame shows. @param {Instant} now @param {number} time s */
  take(now, time) {
    this.waiting = now;
    this.stage.ready = true;
    this.mark(now, time);
    this.stage.invalidate();
  }

  /** Adds to the trails. @param {Instant} now @param {number} time s */
  mark(now, time) {
    if (now.end_point) this.trail.push(time, now.end_point);
    if (now.end_point_2) this.second.push(time, now.end_point_2);
  }

  /**
   * Draws the trails anew from samples of the past.
   * @param {{count: number, from: (time: number) => number, at: (k: number) => number, time: ArrayLike<number>, value: (field: string, index: number, k: number) => number}} past
   */
  retrace(past) {
    const end = past.count ? past.time[past.at(past.count - 1)] : 0;
    this.trail.clear();
    this.second.clear();
    for (let k = past.from(end - TRAIL); k < past.count; k += 1) {
      const of = (/** @type {string} */ field) => [0, 1, 2].map((i) => past.value(field, i, k)), time = past.time[past.at(k)];
      this.mark({ body_pose: [], cable_points: [], end_point: of("end_point"), end_point_2: of("end_point_2") }, time);
    }
    this.stage.invalidate();
  }

  /** Shows an instant. @param {Instant} now */
  update(now) {
    this.now = now;
    this.bodies.update("body", now.body_pose);
    this.bodies.update("surface", now.body_pose);
    const known = (/** @type {ArrayLike<number>|undefined} */ list) => list !== undefined && list.length > 0 && Number.isFinite(list[list.length - 1]);
    for (const [look, poses, requested] of /** @type {const} */ ([["ghost", now.reference_pose, this.ghost], ["second", now.body_pose_2, true]])) {
      this.bodies.show(look, requested && known(poses));
      if (poses && requested) this.bodies.update(look, poses);
    }
    this.cables.update(now, this.highest);
    this.surroundings.update(now.body_pose, now.end_point);
    this.trail.flush();
    this.second.flush();
    for (const mesh of this.second.ribbon.meshes) mesh.visible = known(now.end_point_2);
    if (!this.framed) {
      this.framed = true;
      this.frame();
      this.look(this.looked);
    }
    this.stage.invalidate();
  }

  /** Frames what is shown. */
  frame() {
    const { now } = this;
    if (!now) return;
    const low = new Vector3(Infinity, Infinity, Infinity), high = low.clone().negate();
    const take = (/** @type {Vector3} */ p, /** @type {number} */ r) => { low.min(p.clone().subScalar(r)); high.max(p.clone().addScalar(r)); points.push(p); };
    /** @type {Vector3[]} */
    const points = [];
    const pose = new Matrix4();
    let lowest = Infinity;
    for (const shape of this.machine.shapes) {
      // A floor does not set the scale.
      if (shape.body === 0 || shape.kind === "plane") continue;
      poseMatrix(now.body_pose, shape.body, pose);
      for (const { at, radius } of outline(shape)) {
        const p = at.applyMatrix4(pose);
        take(p, 0.8 * radius);
        lowest = Math.min(lowest, p.dot(this.orbit.up) - radius);
      }
    }
    for (let k = 0; k + 2 < now.cable_points.length; k += 3) {
      const p = new Vector3(now.cable_points[k], now.cable_points[k + 1], now.cable_points[k + 2]);
      if (Number.isFinite(p.x)) { take(p, 0); lowest = Math.min(lowest, p.dot(this.orbit.up)); }
    }
    for (const place of this.machine.extent ?? []) {
      const p = new Vector3().fromArray(place);
      take(p, 0);
      lowest = Math.min(lowest, p.dot(this.orbit.up));
    }
    for (const path of this.paths) for (let k = 0; k + 2 < path.ribbon.points.length; k += 3) take(new Vector3().fromArray(path.ribbon.points, k), 0);
    if (!Number.isFinite(low.x)) { low.set(-0.1, -0.1, -0.1); high.set(0.1, 0.1, 0.1); }
    const centre = low.clone().add(high).multiplyScalar(0.5), radius = Math.max(0.02, 0.5 * high.distanceTo(low));
    this.cables.scale(radius);
    this.surroundings.place(centre, radius, Math.min(Number.isFinite(lowest) ? lowest : 0, centre.dot(this.orbit.up) - 0.5 * radius) - 0.03 * radius);
    this.surroundings.update(now.body_pose, now.end_point);
    this.surroundings.drums(this.cables.ribbon.points, this.cables.starts);
    this.orbit.frame(points, radius);
  }

  /** Looks at what is selected, from the same side; at everything where nothing is. @param {Selection} selection */
  look(selection) {
    this.looked = selection;
    if (!this.now) return;
    const { points } = this.cables.ribbon, { starts, counts } = this.cables, found = [];
    if (selection?.kind === "muscle") for (let k = starts[selection.index]; k < starts[selection.index] + counts[selection.index]; k += 1) found.push(new Vector3().fromArray(points, 3 * k));
    const place = selection?.kind === "joint" ? this.surroundings.places[selection.index] : null;
    const body = selection?.kind === "body" && this.now ? new Vector3().fromArray(Array.from(this.now.body_pose).slice(7 * selection.index, 7 * selection.index + 3)) : null;
    const middle = place ?? body, around = 0.3 * this.orbit.reach;
    if (middle) for (const side of [-around, around]) found.push(middle.clone().addScalar(side), middle.clone().add(new Vector3(side, -side, side)));
    if (!found.length) { this.frame(); return; }
    this.orbit.frame(found, this.orbit.reach);
  }

  /** Marks what is selected. @param {Selection} selection */
  select(selection) {
    const of = (/** @type {string} */ kind) => (selection?.kind === kind ? selection.index : -1);
    this.cables.select(of("muscle"));
    this.bodies.select(of("body"));
    this.surroundings.selected = of("joint");
    if (this.now) this.surroundings.update(this.now.body_pose, this.now.end_point);
    this.stage.invalidate();
  }

  recolour() {
    for (const part of [this.stage, this.bodies, this.cables, this.surroundings, this.trail, this.second, ...this.paths]) part.recolour();
  }

  /** A picture of what is shown. @param {(picture: Blob) => void} use */
  picture(use) {
    this.stage.resize(1);
    this.stage.before.forEach((call) => call(0));
    this.stage.renderer.render(this.stage.scene, this.stage.camera);
    this.stage.canvas.toBlob((blob) => blob && use(blob));
    this.stage.refit();
  }

  /** @param {number} now ms */
  beforeFrame(now) {
    if (this.waiting) this.update(this.waiting);
    this.waiting = null;
    const { canvas } = this.stage, size = new Vector2(canvas.clientWidth, canvas.clientHeight);
    for (const { ribbon } of [this.cables, this.trail, this.second, ...this.paths]) ribbon.resize(size.x, size.y, 1.3 / this.stage.renderer.getPixelRatio());
    if (!this.still) this.cables.animate(now / 1000);
  }

  listen() {
    const { canvas } = this.stage;
    /** @type {number[]|null} */
    let down = null;
    canvas.addEventListener("pointerdown", (e) => { down = [e.clientX, e.clientY]; });
    canvas.addEventListener("pointerup", (e) => {
      // A click, not a turn of the view.
      if (down && Math.hypot(e.clientX - down[0], e.clientY - down[1]) < 4) this.options.select?.(pick(this, place(this, e)));
      down = null;
    });
  }
}
