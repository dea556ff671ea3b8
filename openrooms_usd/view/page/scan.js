// The points of a scan over the room that was made of it, or alone.

import { complain, section, slider, tick } from "orusd/panel.js";
import { resource } from "orusd/source.js";

const SIZE_PX = 2;

/** The section of the scan; none where the room comes from none. */
export function scan(room, state) {
  if (!state.scan) return [];
  let [held, size, on] = [null, SIZE_PX, !state.prims.length];
  const show = async () => {
    held ??= unpacked(await resource(state.scan));
    room.overlay("scan", on ? held.points : null, { colors: held.colors, kind: "points", size });
    document.body.dataset.points = on ? held.points.length / 3 : 0;
  };
  if (on) show().catch(complain);
  return [section("Scan", "scan",
    tick("scan-points", "show its points", on, (value) => { on = value; show().catch(complain); }),
    slider("scan-size", "size", { min: 1, max: 8, step: 1, value: size, unit: " px" }, (value) => { size = value; if (on) show().catch(complain); }))];
}

/** The count, places and colours, as openrooms_usd/view/scanned.py packs them. */
function unpacked(buffer) {
  const count = new DataView(buffer).getUint32(0, true);
  const points = new Float32Array(buffer, 4, count * 3);
  const colors = Float32Array.from(new Uint8Array(buffer, 4 + count * 12, count * 3), (code) => code / 255);
  return { points, colors };
}
