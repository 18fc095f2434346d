// Colours of the style sheet as numbers, and the map of tensions: viridis, perceptually uniform and legible with any
// colour vision, by its published polynomial of sixth degree (M. Zucker, public domain).

/** Coefficients of the map from 0..1 to red, green, blue, by rising power. */
const MAP = [
  [0.2777273272, 0.0054073445, 0.3340998053],
  [0.1050930431, 1.4046135298, 1.3845901626],
  [-0.3308618287, 0.2148475595, 0.0950951630],
  [-4.6342304984, -5.7991009734, -19.3324409563],
  [6.2282699363, 14.1799333668, 56.6905526007],
  [4.7763849979, -13.7451453777, -65.3530326333],
  [-5.4354558560, 4.6458526122, 26.3124352496],
];

/** The lowest part of the map is too dark to be seen on a dark page. */
const FIRST = 0.12;

/**
 * Colour of a fraction of the highest tension, three numbers of 0 to 1.
 * @param {number} fraction
 * @returns {number[]}
 */
export function tensionColour(fraction) {
  const at = FIRST + (1 - FIRST) * Math.min(1, Math.max(0, fraction));
  return [0, 1, 2].map((k) => Math.min(1, Math.max(0, MAP.reduceRight((sum, row) => sum * at + row[k], 0))));
}

/** The map for a fragment shader: `vec3 tension_colour(float fraction)`. */
export const TENSION_GLSL = `vec3 tension_colour(float fraction) {
  float at = ${FIRST} + ${1 - FIRST} * clamp(fraction, 0.0, 1.0);
  vec3 sum = vec3(0.0);
  ${[...MAP].reverse().map((row) => `sum = sum * at + vec3(${row.map((v) => v.toFixed(10)).join(", ")});`).join("\n  ")}
  return clamp(sum, 0.0, 1.0);
}`;

/** The map as a gradient of a style sheet, from low to high. */
export const TENSION_GRADIENT = `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map((fraction) => {
  const [r, g, b] = tensionColour(fraction).map((v) => Math.round(255 * v));
  return `rgb(${r} ${g} ${b})`;
}).join(", ")})`;

/** @type {CanvasRenderingContext2D|null} */
let pen = null;

/**
 * A custom property of the style sheet as red, green, blue of 0 to 1, in the theme that is shown.
 * @param {string} name such as `--accent`
 * @returns {number[]}
 */
export function token(name) {
  const probe = document.createElement("span");
  probe.style.color = `var(${name})`;
  probe.hidden = true;
  document.body.append(probe);
  const text = getComputedStyle(probe).color;
  probe.remove();
  pen ??= Object.assign(document.createElement("canvas"), { width: 1, height: 1 }).getContext("2d", { willReadFrequently: true });
  if (!pen) return [0.5, 0.5, 0.5];
  pen.fillStyle = text;
  pen.fillRect(0, 0, 1, 1);
  return [...pen.getImageData(0, 0, 1, 1).data].slice(0, 3).map((v) => v / 255);
}

/**
 * A custom property as a colour that a canvas understands.
 * @param {string} name
 * @returns {string}
 */
export function ink(name) {
  return `rgb(${token(name).map((v) => Math.round(255 * v)).join(" ")})`;
}
