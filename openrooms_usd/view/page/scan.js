// The points of a scan over the room that was made of it, or alone.

import { complain, section, slider, tick } from "orusd/panel.js";
import { resource } from "orusd/source.js";

const SIZE_PX = 2;
// How far from a point a click may be.
const NEAR_PX = 4;

/** The section of the scan; none where the room comes from none. */
export function scan(room, state) {
  if (!state.scan) return [];
  let [held, size, on] = [null, SIZE_PX, !state.prims.length];
  const show = async () => {
    held ??= unpacked(await resource(state.scan));
    room.overlay("scan", on ? held.points : null, { colors: held.colors, kind: "points", size });
    room.points = on ? (x, y) => nearest(room, held.points, x, y) : null;
    document.body.dataset.points = on ? held.points.length / 3 : 0;
  };
  if (on) show().catch(complain);
  return [section("Scan", "scan",
    tick("scan-points", "show its points", on, (value) => { on = value; show().catch(complain); }),
    slider("scan-size", "size", { min: 1, max: 8, step: 1, value: size, unit: " px" }, (value) => { size = value; if (on) show().catch(complain); }))];
}

/** The foremost point near a place of the canvas: { path: "", point, normal: null }; or null. */
function nearest({ camera, canvas: { clientWidth: width, clientHeight: height } }, points, x, y) {
  const c = camera.matrix(width, height);
  let [found, foremost] = [-1, Infinity];
  for (let k = 0; k < points.length; k += 3) {
    const [a, b, d] = [points[k], points[k + 1], points[k + 2]];
    const depth = c[3] * a + c[7] * b + c[11] * d + c[15];
    if (depth <= 0 || depth >= foremost) continue;
    const across = ((c[0] * a + c[4] * b + c[8] * d + c[12]) / depth + 1) / 2 * width - x;
    const down = (1 - (c[1] * a + c[5] * b + c[9] * d + c[13]) / depth) / 2 * height - y;
    if (across * across + down * down <= NEAR_PX * NEAR_PX) [found, foremost] = [k, depth];
  }
  return found < 0 ? null : { path: "", point: [...points.subarray(found, found + 3)], normal: null };
}

/** The count, places and colours, as openrooms_usd/view/scanned.py packs them. */
function unpacked(buffer) {
  const count = new DataView(buffer).getUint32(0, true);
  const points = new Float32Array(buffer, 4, count * 3);
  const colors = Float32Array.from(new Uint8Array(buffer, 4 + count * 12, count * 3), (code) => code / 255);
  return { points, colors };
}
