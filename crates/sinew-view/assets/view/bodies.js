// Shapes of the bodies: one instanced geometry per class of shape, so that a machine of a hundred shapes is a handful of
// draw calls. A second set, transparent, shows the reference; another the second simulated machine of a comparison.
import { BoxGeometry, Color, CylinderGeometry, DoubleSide, Group, InstancedMesh, LatheGeometry, Matrix4, Mesh, MeshLambertMaterial, Quaternion, SphereGeometry, Vector2, Vector3 } from "../vendor/three/three.module.min.js";
import { poseMatrix } from "./camera.js";
import { triple } from "./cables.js";
import { triangles } from "./mesh.js";
import { token } from "./palette.js";

/** @import {BufferGeometry} from "../vendor/three/three.module.min.js" */
/** @import {Machine, Shape} from "./types.js" */

/** @typedef {"body"|"surface"|"ghost"|"second"} Look */
/** @typedef {{geometry: BufferGeometry, parts: {shape: Shape, local: Matrix4}[]}} Class */

/** Shapes above which they are drawn with fewer triangles. */
const MANY = 24;

/** A link between two joints, of radius and half length 1: thick at its ends, slender between them. */
function link(detail = 1) {
  const profile = [[0, -1], [0.5, -0.985], [0.82, -0.93], [0.92, -0.85], [0.8, -0.7], [0.62, -0.45], [0.56, 0], [0.62, 0.45], [0.8, 0.7], [0.92, 0.85], [0.82, 0.93], [0.5, 0.985], [0, 1]];
  return new LatheGeometry(profile.map(([x, y]) => new Vector2(x, y)), Math.round(18 * detail)).rotateX(Math.PI / 2);
}

const SPHERE = (detail = 1) => new SphereGeometry(1, Math.round(20 * detail), Math.round(14 * detail));
const TUBE = (detail = 1) => new CylinderGeometry(1, 1, 2, Math.round(20 * detail), 1, true).rotateX(Math.PI / 2);
const CYLINDER = (detail = 1) => new CylinderGeometry(1, 1, 2, Math.round(24 * detail)).rotateX(Math.PI / 2);

/**
 * Parts of a shape: class of geometry, then its scale and place in the frame of the shape.
 * @param {Shape} shape @param {Machine["meshes"]} meshes
 * @returns {[string, (detail: number) => BufferGeometry, number[], number[]][]}
 */
function parts({ kind, size, mesh }, meshes) {
  const [a, b = a, c = a] = size;
  switch (kind) {
    case "sphere": return [["sphere", SPHERE, [a, a, a], [0, 0, 0]]];
    case "ellipsoid": return [["sphere", SPHERE, [a, b, c], [0, 0, 0]]];
    case "box": return [["box", () => new BoxGeometry(2, 2, 2), [a, b, c], [0, 0, 0]]];
    case "cylinder": return [["cylinder", CYLINDER, [a, a, b], [0, 0, 0]]];
    case "capsule": return [["tube", TUBE, [a, a, b], [0, 0, 0]], ["sphere", SPHERE, [a, a, a], [0, 0, b]], ["sphere", SPHERE, [a, a, a], [0, 0, -b]]];
    case "bone": return b < a ? [["sphere", SPHERE, [a, a, a], [0, 0, 0]]] : [["bone", link, [a, a, b + a], [0, 0, 0]]];
    case "mesh": return mesh == null ? [] : [[`mesh ${mesh}`, () => triangles(meshes[mesh]), [1, 1, 1], [0, 0, 0]]];
    default: return [];
  }
}

/** @param {Shape} shape @param {number[]} scale @param {number[]} at */
function local(shape, scale, at) {
  const [w, x, y, z] = shape.quaternion;
  const turn = new Quaternion(x, y, z, w), place = new Vector3().fromArray(at).applyQuaternion(turn).add(new Vector3().fromArray(shape.position));
  return new Matrix4().compose(place, turn, new Vector3().fromArray(scale));
}

/**
 * Points around which balls contain a shape, in the frame of its body, m: ends of what is long, corners of what has any.
 * @param {Shape} shape @returns {{at: Vector3, radius: number}[]}
 */
export function outline({ kind, size: [a, b = a, c = a], position, quaternion: [w, x, y, z] }) {
  const long = ["bone", "capsule", "cylinder"].includes(kind), edged = ["box", "mesh"].includes(kind), sides = [-1, 1];
  const ends = long ? sides.map((k) => [0, 0, k * b]) : edged ? sides.flatMap((i) => sides.flatMap((j) => sides.map((k) => [i * a, j * b, k * c]))) : [[0, 0, 0]];
  const turn = new Quaternion(x, y, z, w), centre = new Vector3().fromArray(position);
  return ends.map((end) => ({ at: new Vector3().fromArray(end).applyQuaternion(turn).add(centre), radius: long ? a : edged ? 0 : Math.max(a, b, c) }));
}

export class Bodies {
  /** @param {Machine} machine @param {boolean} [software] whether no graphics processor draws: with fewer triangles */
  constructor(machine, software = false) {
    this.machine = machine;
    this.detail = software || machine.shapes.length > MANY ? 0.55 : 1;
    this.group = new Group();
    this.selected = -1;
    /** @type {Map<Look, {mesh: InstancedMesh, parts: Class["parts"]}[]>} */
    this.looks = new Map();
    this.classes = { solid: this.sort((shape) => !shape.wrap), surface: this.sort((shape) => shape.wrap === true) };
    /** Shapes of the bodies but the world. @type {Map<string, Class>|undefined} */
    this.moving = undefined;
    this.add("body", this.classes.solid);
    this.add("surface", this.classes.surface);
    this.recolour();
  }

  /** Shapes by class of geometry. @param {(shape: Shape) => boolean} requested @returns {Map<string, Class>} */
  sort(requested) {
    /** @type {Map<string, Class>} */
    const classes = new Map();
    for (const shape of this.machine.shapes.filter((s) => s.kind !== "plane" && requested(s))) {
      for (const [name, make, scale, at] of parts(shape, this.machine.meshes)) {
        const found = classes.get(name) ?? { geometry: make(this.detail), parts: [] };
        classes.set(name, found);
        found.parts.push({ shape, local: local(shape, scale, at) });
      }
    }
    return classes;
  }

  /** Adds instances of the shapes in a look. @param {Look} look @param {Map<string, Class>} classes */
  add(look, classes) {
    const solid = look === "body";
    this.looks.set(look, [...classes].map(([name, { geometry, parts: list }]) => {
      const material = new MeshLambertMaterial(solid ? {} : { transparent: true, depthWrite: look === "ghost" });
      // Files of triangles have holes, and triangles that face inwards.
      if (name.startsWith("mesh")) material.side = DoubleSide;
      const mesh = new InstancedMesh(geometry, material, list.length);
      mesh.frustumCulled = false;
      mesh.renderOrder = { body: 1, surface: 2.5, ghost: 6, second: 1.5 }[look];
      mesh.userData.shapes = list.map((part) => part.shape);
      this.group.add(mesh);
      return { mesh, parts: list };
    }));
  }

  /** Shows or hides the reference or the second machine. @param {Look} look @param {boolean} shown */
  show(look, shown) {
    if (shown && !this.looks.has(look)) {
      // What does not move needs no second picture.
      this.moving ??= this.sort((shape) => !shape.wrap && shape.body > 0);
      this.add(look, this.moving);
      this.recolour();
    }
    for (const { mesh } of this.looks.get(look) ?? []) mesh.visible = shown;
  }

  /** Meshes that a pointer can hit. @returns {Mesh[]} */
  targets() {
    return (this.looks.get("body") ?? []).map((entry) => entry.mesh);
  }

  recolour() {
    const dark = token("--paper")[0] < 0.5;
    const bone = new Color().setRGB(...triple(dark ? [0.56, 0.58, 0.6] : [0.86, 0.85, 0.82]), "srgb");
    const fixed = new Color().setRGB(...triple(token("--shape")), "srgb");
    const accent = new Color().setRGB(...triple(token("--accent")), "srgb"), warm = new Color().setRGB(...triple(token("--warm")), "srgb");
    for (const [look, entries] of this.looks) for (const { mesh, parts: list } of entries) {
      const material = /** @type {MeshLambertMaterial} */ (mesh.material);
      material.opacity = { body: 1, surface: 0.28, ghost: 0.22, second: 0.5 }[look];
      list.forEach(({ shape }, k) => {
        const own = shape.body === 0 ? fixed : bone;
        const chosen = look === "body" && shape.body === this.selected;
        mesh.setColorAt(k, look === "ghost" ? accent : look === "second" ? warm : look === "surface" ? fixed : chosen ? own.clone().lerp(accent, 0.5) : own);
      });
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }

  /** @param {number} body -1 for none */
  select(body) {
    if (body === this.selected) return;
    this.selected = body;
    this.recolour();
  }

  /** @param {Look} look @param {ArrayLike<number>} poses seven numbers a body */
  update(look, poses) {
    const pose = new Matrix4(), out = new Matrix4();
    for (const { mesh, parts: list } of this.looks.get(look) ?? []) {
      list.forEach(({ shape, local: own }, k) => mesh.setMatrixAt(k, out.multiplyMatrices(poseMatrix(poses, shape.body, pose), own)));
      mesh.instanceMatrix.needsUpdate = true;
      // Bounds of former poses would let a pointer miss.
      mesh.boundingSphere = null;
    }
  }
}
