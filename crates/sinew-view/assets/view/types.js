// Types of the data that a page receives; comments alone, so that `tsc --checkJs` can hold the code against them.

/**
 * Position, m, and orientation of a body: x, y, z, then the quaternion w, x, y, z.
 * @typedef {ArrayLike<number>} Pose
 */

/**
 * A shape in the frame of its body. Sizes are half lengths as in MJCF, the radius first for capsules and cylinders.
 * @typedef {object} Shape
 * @property {number} body
 * @property {"sphere"|"capsule"|"cylinder"|"box"|"ellipsoid"|"mesh"|"plane"|"bone"} kind
 * @property {number[]} size
 * @property {number[]} position
 * @property {number[]} quaternion
 * @property {boolean} [wrap]
 * @property {number} [mesh] index of its triangles
 * @property {string} [name]
 */

/**
 * Triangles in the frame of a shape, in base64: corners as three float32 each, m; triangles as three uint16 each.
 * @typedef {{vertices: string, triangles: string}} MeshData
 */

/**
 * @typedef {object} Muscle
 * @property {string} name
 * @property {number[]} [tension_limits_n]
 * @property {{length_m: number, bend_rad: number, mu: number, pretension_n?: number}|null} [sheath]
 * @property {number} points
 * @property {number} sheath_points
 */

/**
 * @typedef {object} Joint
 * @property {string} name
 * @property {string} unit
 * @property {number[]|null} range
 * @property {number} body
 * @property {number[]} axis
 * @property {number[]} position
 */

/**
 * A machine as it is drawn.
 * @typedef {object} Machine
 * @property {number[]} gravity
 * @property {{name: string, parent: number}[]} bodies
 * @property {Shape[]} shapes
 * @property {MeshData[]} meshes
 * @property {Joint[]} joints
 * @property {Muscle[]} muscles
 * @property {{body: number, position: number[]}|null} end_point
 * @property {number[][]|null} [path]
 * @property {number[][]} [extent] places that a view of the motion contains
 */

/**
 * What is drawn of one instant. Numbers that are not known are NaN.
 * @typedef {object} Instant
 * @property {ArrayLike<number>} body_pose
 * @property {ArrayLike<number>} [reference_pose]
 * @property {ArrayLike<number>} [body_pose_2]
 * @property {ArrayLike<number>} cable_points
 * @property {ArrayLike<number>} [cable_tension]
 * @property {ArrayLike<number>} [cable_sliding]
 * @property {ArrayLike<number>} [end_point]
 * @property {ArrayLike<number>} [end_point_reference]
 * @property {ArrayLike<number>} [end_point_2]
 * @property {ArrayLike<number>} [time_s]
 */

/** @typedef {{kind: "body"|"joint"|"muscle", index: number}|null} Selection */

export {};
