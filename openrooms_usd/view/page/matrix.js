// Matrices of 4x4, column by column as WebGL takes them, and vectors of three; all right-handed.

export const identity = () => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** What glTF's world, Y up, is in ours, Z up. */
export const Z_UP_FROM_Y_UP = [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1];

/** a b: first b, then a. */
export function multiply(a, b) {
  const out = new Array(16);
  for (let column = 0; column < 16; column += 4)
    for (let row = 0; row < 4; row += 1)
      out[column + row] = a[row] * b[column] + a[row + 4] * b[column + 1]
        + a[row + 8] * b[column + 2] + a[row + 12] * b[column + 3];
  return out;
}

/** The inverse of a matrix whose last row is 0 0 0 1. */
export function inverse(m) {
  const [a, b, c] = [m.slice(0, 3), m.slice(4, 7), m.slice(8, 11)];
  const rows = [cross(b, c), cross(c, a), cross(a, b)];
  const size = dot(a, rows[0]);
  const out = identity();
  rows.forEach((row, r) => row.forEach((value, c) => { out[c * 4 + r] = value / size; }));
  const moved = [m[12], m[13], m[14]];
  for (let r = 0; r < 3; r += 1)
    out[12 + r] = -(out[r] * moved[0] + out[4 + r] * moved[1] + out[8 + r] * moved[2]);
  return out;
}

/** A matrix given row by row, as in Python and the state of pages. */
export const fromRows = (rows) => [0, 1, 2, 3].flatMap((c) => rows.map((row) => row[c]));

/** The same matrix row by row. */
export const toRows = (m) => [0, 1, 2, 3].map((r) => [m[r], m[4 + r], m[8 + r], m[12 + r]]);

export const translation = (x, y, z) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];

/** A turn about an axis of length one through the origin, counter-clockwise, in degrees. */
export function turn([x, y, z], degrees) {
  const [s, c] = [Math.sin(degrees * Math.PI / 180), Math.cos(degrees * Math.PI / 180)];
  const k = 1 - c;
  return [
    c + x * x * k, y * x * k + z * s, z * x * k - y * s, 0,
    x * y * k - z * s, c + y * y * k, z * y * k + x * s, 0,
    x * z * k + y * s, y * z * k - x * s, c + z * z * k, 0, 0, 0, 0, 1,
  ];
}

/** glTF's translation, rotation (x, y, z, w) and scale. */
export function placed({ matrix, translation: t = [0, 0, 0], rotation = [0, 0, 0, 1], scale = [1, 1, 1] }) {
  if (matrix) return [...matrix];
  const [x, y, z, w] = rotation;
  const columns = [
    [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
    [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
    [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
  ];
  return [...columns.flatMap((column, k) => [...column.map((v) => v * scale[k]), 0]), ...t, 1];
}

/** A place under a matrix. */
export const point = (m, [x, y, z]) => [0, 1, 2].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r]);

/** A direction under a matrix. */
export const direction = (m, [x, y, z]) => [0, 1, 2].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z);

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];
export const add = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
export const length = (a) => Math.hypot(...a);
export const unit = (a) => { const size = length(a) || 1; return a.map((v) => v / size); };
