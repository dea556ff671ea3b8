// The stage's cameras: small pyramids in the room, and buttons that jump into them.

import { fromRows, point } from "orusd/matrix.js";
import { button, element, section, tick } from "orusd/panel.js";

const COLOR = [0.95, 0.55, 0.1];
const DEPTH_M = 0.25;
const NEAR_PX = 10;

/** The section of the cameras; jumps into the first one. */
export function cameras(room, state) {
  const list = state.cameras;
  const jump = (camera) => {
    room.camera.become("orbit");
    room.camera.jump(camera);
    document.body.dataset.camera = camera.name;
    room.jumps.forEach((jumped) => jumped(camera));
  };
  const overview = () => {
    const box = room.bounds() ?? state.box;
    document.body.dataset.camera = "";
    if (box) {
      Object.assign(room.camera, { yaw: 0.9, pitch: -0.75, lens: { focal: 0.9, right: 0, down: 0 } });
      room.camera.frame(...box);
    }
  };
  // While they are shown, a click near one's eye jumps there.
  let standing = false;
  room.onPick((found, event) => {
    const near = list.map((camera) => [camera, room.camera.project(fromRows(camera.world_from_camera).slice(12, 15))])
      .find(([, at]) => at && Math.hypot(at[0] - event.offsetX, at[1] - event.offsetY) < NEAR_PX);
    if (standing && near) jump(near[0]);
  });
  const pyramids = (on) => { standing = on; room.overlay("cameras", on ? list.flatMap(pyramid) : null, { color: COLOR }); };
  room.camera.floor = room.bounds(["/World/Room/Floor"])?.[1][2] ?? 0;
  if (list.length) jump(list[0]);
  else overview();
  const buttons = list.map((camera) => button(`camera-${camera.name}`, camera.name, () => jump(camera)));
  return [section("Cameras", "cameras",
    element("div", { className: "buttons" }, button("overview", "whole room", overview), ...buttons),
    tick("pyramids", "show where they stand", false, pyramids))];
}

/** Lines of a camera: its opening, and the edges to its eye. */
function pyramid({ world_from_camera, focal, right, down, aspect }) {
  const place = fromRows(world_from_camera);
  const side = DEPTH_M / focal;
  const corner = (x, y) => point(place, [(x - right) * side, (y / aspect - down) * side, DEPTH_M]);
  const corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(([x, y]) => corner(x, y));
  const eye = point(place, [0, 0, 0]);
  return corners.flatMap((at, k) => [at, corners[(k + 1) % 4], eye, at]);
}
