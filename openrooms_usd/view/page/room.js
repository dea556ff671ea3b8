// A room to look at: `orusd view STAGE`.
//
// What other pages build on:
//
//   room = await openRoom(canvas, glb, { shell, hung })   glb: an ArrayBuffer, or null; shell: paths of walls and
//                                  the like; hung: paths of what hangs on walls
//   room.select(paths)             mark prims and all below them
//   room.onPick((found, event))    a click: found is { path, point, normal }, or null for nothing;
//                                  path is a mesh's, point and normal are in the room's frame
//   room.at(x, y)                  the same at a place of the canvas, pixels from its top left
//   room.move(path, matrix)        move a prim and all below it from where the stage has it: a (4, 4)
//                                  of orusd/matrix.js in the room's frame; null takes it back
//   room.hide(paths)               leave prims out
//   room.overlay(name, points, { color, kind, size, over })   lines or dots over the picture
//   room.bounds(paths)             the box of prims: [[x, y, z], [x, y, z]]
//   room.load(glb)                 show another file from the same place
//   room.camera                    .project(point) -> [x, y], .ray(x, y) -> { origin, direction },
//                                  .jump(camera of the state), .frame(low, high),
//                                  .held = (event) => true keeps drags from turning the picture
//   room.onDraw((room))            after each picture: move what lies over it
//   room.draw()                    ask for a new picture
//
// All places are metres in the room's frame, Z up, as in the stage that orusd composes.

import { MOVING, folding, helping } from "orusd/frame.js";
import { element } from "orusd/panel.js";
import { roomPage } from "orusd/roompage.js";
import * as source from "orusd/source.js";
import { Room } from "orusd/viewer.js";

/** A room on a canvas. */
export async function openRoom(canvas, glb, { shell = [], hung = [] } = {}) {
  const room = new Room(canvas);
  // So that a page's other tools, and tests, find it.
  canvas.room = room;
  await room.load(glb);
  room.enclose(shell, hung);
  return room;
}

/** Fill the page. */
export async function start(root) {
  const canvas = element("canvas", { id: "view", tabIndex: 0 });
  const stand = element("div", { className: "stand" }, canvas);
  const panel = element("aside", { className: "panel" });
  root.append(stand, panel);
  folding(panel);
  helping([...MOVING, ["W A S D, arrows", "walk, where that is ticked"], ["click", "select a prim"]]);
  const state = await source.state();
  const glb = state.glb ? await source.resource("room.glb") : null;
  const room = await openRoom(canvas, glb, state);
  await roomPage(room, state, { stand, panel });
}
