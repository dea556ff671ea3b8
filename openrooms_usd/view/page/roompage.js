// The page of a room: the picture on the left; cameras, light, doors, prims on the right.

import { cameras } from "orusd/cameras.js";
import { lamps } from "orusd/lamps.js";
import { element, facts, section, tick } from "orusd/panel.js";
import { tree } from "orusd/tree.js";

/** Fill the panel, and join it to the room. */
export async function roomPage(room, state, { stand, panel }) {
  const known = new Map(state.prims.map((prim) => [prim.path, prim]));
  const about = element("div", { id: "about" });
  const prims = tree(state.prims, (path) => choose(path));

  const choose = (path) => {
    const prim = known.get(path);
    room.select(path ? [path] : []);
    prims.choose(path);
    about.replaceChildren(...(prim ? [told(prim)] : []));
    document.body.dataset.prim = path ?? "";
  };
  room.onPick((found) => choose(found && nearest(found.path, known)));

  const lit = await lamps(room, state);
  panel.append(
    element("div", { id: "told", className: "told" }),
    ...cameras(room, state),
    ...lit,
    section("View", "ways",
      tick("walk", "walk (W A S D)", false, (on) => room.camera.become(on ? "walk" : "orbit")),
      tick("outside", "walls between are left out", true, (on) => { room.outside = on; room.draw(); })),
    section("Prim", "prim", about),
    section("Stage", "prims", prims.root),
  );
  room.page = { choose, state, stand };
}

/** What is known of a prim. */
function told(prim) {
  const { path, type, kind, category, part, material, mass, friction, source, layers } = prim;
  return facts("facts", {
    path, type, kind, category, part, material,
    mass: mass && `${mass.toPrecision(3)} kg`, friction: friction?.toPrecision(2), source,
    layers: layers && Object.entries(layers).map(([name, count]) => `${name} (${count})`).join(", "),
  });
}

/** The prim that the state tells of, or the nearest one above it. */
function nearest(path, known) {
  let found = path;
  while (found && !known.has(found)) found = found.slice(0, found.lastIndexOf("/"));
  return found || null;
}
