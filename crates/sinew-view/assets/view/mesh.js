// Shapes of files: triangles with normals that are smooth over curved surfaces and sharp at edges.
import { BufferGeometry, Float32BufferAttribute } from "../vendor/three/three.module.min.js";

/** Cosine of the angle between two triangles above which their common edge is sharp. */
const SHARP = Math.cos(0.7);

/** @param {string} text base64 @returns {ArrayBuffer} */
function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k += 1) out[k] = raw.charCodeAt(k);
  return out.buffer;
}

/**
 * Corners of the triangles one after another, each with its normal: the mean of those of the triangles around it, weighted by
 * their areas, as far as they are not beyond a sharp edge.
 * @param {import("./types.js").MeshData|undefined} mesh
 */
export function triangles(mesh) {
  const geometry = new BufferGeometry();
  if (!mesh) return geometry;
  const at = new Float32Array(bytes(mesh.vertices)), corners = new Uint16Array(bytes(mesh.triangles)), count = corners.length / 3;
  // Normals of triangles, of the length of twice their areas.
  const faces = new Float32Array(3 * count), lengths = new Float32Array(count);
  /** @type {number[][]} */
  const around = Array.from({ length: at.length / 3 }, () => []);
  for (let t = 0; t < count; t += 1) {
    const [a, b, c] = [0, 1, 2].map((k) => 3 * corners[3 * t + k]);
    const u = [0, 1, 2].map((k) => at[b + k] - at[a + k]), v = [0, 1, 2].map((k) => at[c + k] - at[a + k]);
    for (let k = 0; k < 3; k += 1) faces[3 * t + k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    lengths[t] = Math.hypot(faces[3 * t], faces[3 * t + 1], faces[3 * t + 2]);
    for (const corner of [a, b, c]) around[corner / 3].push(t);
  }
  const positions = new Float32Array(9 * count), normals = new Float32Array(9 * count);
  for (let t = 0; t < count; t += 1) for (let k = 0; k < 3; k += 1) {
    const corner = corners[3 * t + k], place = 9 * t + 3 * k, sum = [0, 0, 0];
    for (const other of around[corner]) {
      const along = faces[3 * t] * faces[3 * other] + faces[3 * t + 1] * faces[3 * other + 1] + faces[3 * t + 2] * faces[3 * other + 2];
      if (along >= SHARP * lengths[t] * lengths[other]) for (let i = 0; i < 3; i += 1) sum[i] += faces[3 * other + i];
    }
    const length = Math.hypot(...sum) || 1;
    for (let i = 0; i < 3; i += 1) { positions[place + i] = at[3 * corner + i]; normals[place + i] = sum[i] / length; }
  }
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new Float32BufferAttribute(normals, 3));
  return geometry;
}
