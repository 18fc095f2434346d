// Floor, the arrow of gravity, marks of the joints, and the handle of the end point.
import { BufferGeometry, Color, ConeGeometry, CylinderGeometry, DoubleSide, Float32BufferAttribute, Group, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, PlaneGeometry, Quaternion, ShaderMaterial, SphereGeometry, TorusGeometry, Vector3 } from "../vendor/three/three.module.min.js";
import { poseMatrix } from "./camera.js";
import { triple } from "./cables.js";
import { token } from "./palette.js";

/** @import {Machine} from "./types.js" */

/** A length of 1, 2 or 5 times a power of ten next to a length. @param {number} length */
export function roundLength(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return power * (/** @type {number} */ ([5, 2, 1].find((m) => m * power <= length * 1.0001)) ?? 1);
}

export class Surroundings {
  /** @param {Machine} machine @param {Vector3} up @param {boolean} [software] whether no graphics processor draws: with fewer triangles */
  constructor(machine, up, software = false) {
    this.machine = machine;
    this.up = up;
    this.group = new Group();
    this.lineColour = new LineBasicMaterial({ transparent: true, opacity: 0.9 });
    this.floorUniforms = { tone: { value: new Color() }, line: { value: new Color() }, step: { value: 0.1 }, reach: { value: 1 }, middle: { value: new Vector3() } };
    this.floor = new Mesh(new PlaneGeometry(1, 1), new ShaderMaterial({
      uniforms: this.floorUniforms, transparent: true, depthWrite: false, side: DoubleSide,
      vertexShader: "varying vec2 v_at; uniform float reach; void main() { v_at = position.xy * 6.0 * reach; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
      fragmentShader: `varying vec2 v_at; uniform vec3 tone; uniform vec3 line; uniform float step; uniform float reach;
        float grid(float s) { vec2 w = fwidth(v_at / s); vec2 d = abs(fract(v_at / s - 0.5) - 0.5) / max(w, 1e-5); return (1.0 - min(min(d.x, d.y), 1.0)) * (1.0 - smoothstep(0.1, 0.5, max(w.x, w.y))); }
        void main() {
          float fade = 1.0 - smoothstep(0.35, 1.0, length(v_at) / (3.0 * reach));
          float lines = max(0.4 * grid(step), grid(5.0 * step));
          gl_FragColor = vec4(mix(tone, line, lines), fade * mix(0.5, 0.95, lines));
        }`,
    }));
    this.floor.renderOrder = 0;
    this.gravity = new Group();
    const shaft = new Mesh(new CylinderGeometry(0.03, 0.03, 0.75, 10).translate(0, 0.375, 0), new MeshBasicMaterial()), tip = new Mesh(new ConeGeometry(0.1, 0.28, 14).translate(0, 0.86, 0), shaft.material);
    this.gravity.add(shaft, tip);
    this.gravity.visible = machine.gravity.some((g) => g !== 0);
    this.joints = new InstancedMesh(new SphereGeometry(1, software ? 6 : 9, software ? 4 : 6), new MeshLambertMaterial(), Math.max(1, machine.joints.length));
    this.joints.count = machine.joints.length;
    this.joints.frustumCulled = false;
    this.joints.renderOrder = 1.2;
    this.axis = new LineSegments(new BufferGeometry().setAttribute("position", new Float32BufferAttribute([0, 0, -1, 0, 0, 1], 3)), this.lineColour);
    this.ring = new Mesh(new TorusGeometry(0.35, 0.035, 8, 32), new MeshBasicMaterial());
    this.axis.add(this.ring);
    this.axis.visible = false;
    this.axis.renderOrder = 5;
    this.handle = new Mesh(new SphereGeometry(1, software ? 10 : 18, software ? 7 : 12), new MeshBasicMaterial({ transparent: true, opacity: 0.85 }));
    this.handle.renderOrder = 5;
    this.handle.visible = false;
    this.winches = new InstancedMesh(new CylinderGeometry(1, 1, 1.6, software ? 6 : 10).rotateX(Math.PI / 2), new MeshLambertMaterial(), Math.max(1, machine.muscles.length));
    this.winches.count = machine.muscles.some((muscle) => muscle.sheath_points > 0) ? machine.muscles.length : 0;
    this.winches.frustumCulled = false;
    this.winches.renderOrder = 1.1;
    this.group.add(this.winches, this.floor, this.gravity, this.joints, this.axis, this.handle);
    this.reach = 1;
    this.selected = -1;
    /** Places of the joints, m. @type {Vector3[]} */
    this.places = machine.joints.map(() => new Vector3());
    this.recolour();
  }

  recolour() {
    const colour = (/** @type {string} */ name) => new Color().setRGB(...triple(token(name)), "srgb");
    // The floor's shader writes what it is given, without a change of colour space.
    this.floorUniforms.tone.value.setRGB(...triple(token("--grid")));
    this.floorUniforms.line.value.setRGB(...triple(token("--rule")));
    this.lineColour.color = colour("--accent");
    /** @type {MeshBasicMaterial} */ (/** @type {Mesh} */ (this.gravity.children[0]).material).color = colour("--soft");
    // Colours of instances, as the bodies have them: one shader for all.
    for (const [mesh, name] of /** @type {[InstancedMesh, string][]} */ ([[this.winches, "--shape"], [this.joints, "--soft"]])) {
      for (let k = 0; k < mesh.count; k += 1) mesh.setColorAt(k, colour(name));
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
    /** @type {MeshBasicMaterial} */ (this.ring.material).color = colour("--accent");
    /** @type {MeshBasicMaterial} */ (this.handle.material).color = colour("--accent");
  }

  /** Lays the floor below a ball. @param {Vector3} centre @param {number} radius @param {number} lowest along `up`, m */
  place(centre, radius, lowest) {
    this.reach = radius;
    this.floorUniforms.reach.value = radius;
    this.floorUniforms.step.value = roundLength(radius / 5);
    const below = centre.clone().addScaledVector(this.up, lowest - centre.dot(this.up));
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), this.up);
    this.floor.matrixAutoUpdate = false;
    this.floor.matrix.compose(below, turn, new Vector3(6 * radius, 6 * radius, 1));
    this.gravity.position.copy(centre).addScaledVector(this.up, 0.3 * radius).add(new Vector3(0, -0.9 * radius, 0));
    this.gravity.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), this.up.clone().negate());
    this.gravity.scale.setScalar(0.2 * radius);
    this.handle.scale.setScalar(0.026 * radius);
  }

  /** Puts a drum where each cable begins. @param {Float32Array} points of all cables @param {number[]} starts number of the first point of each */
  drums(points, starts) {
    const place = new Matrix4(), size = 0.02 * this.reach;
    starts.forEach((start, k) => this.winches.setMatrixAt(k, place.makeScale(size, size, size).setPosition(points[3 * start], points[3 * start + 1], points[3 * start + 2])));
    this.winches.instanceMatrix.needsUpdate = true;
  }

  /** @param {ArrayLike<number>} poses @param {ArrayLike<number>|undefined} endPoint */
  update(poses, endPoint) {
    const pose = new Matrix4(), scale = new Matrix4();
    this.machine.joints.forEach((joint, k) => {
      const at = this.places[k].fromArray(joint.position).applyMatrix4(poseMatrix(poses, joint.body, pose));
      const size = (k === this.selected ? 0.026 : 0.014) * this.reach;
      this.joints.setMatrixAt(k, scale.makeScale(size, size, size).setPosition(at));
      if (k !== this.selected) return;
      this.axis.position.copy(at);
      this.axis.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3().fromArray(joint.axis).normalize().transformDirection(pose));
      this.axis.scale.setScalar(0.22 * this.reach);
    });
    this.joints.instanceMatrix.needsUpdate = true;
    this.axis.visible = this.selected >= 0;
    this.handle.visible = endPoint !== undefined && Number.isFinite(endPoint[0]);
    if (endPoint && this.handle.visible) this.handle.position.set(endPoint[0], endPoint[1], endPoint[2]);
  }
}
