// The page of a room: the picture on the left; cameras, light, doors, prims on the right.

import { cameras } from "orusd/cameras.js";
import { doors } from "orusd/doors.js";
import { lamps } from "orusd/lamps.js";
import { looks } from "orusd/looks.js";
import { measuring } from "orusd/measuring.js";
import { complain, element, facts, section, tell, tick } from "orusd/panel.js";
import { listen, offline, resource, send, state as stateNow } from "orusd/source.js";
import { scan } from "orusd/scan.js";
import { shots } from "orusd/shots.js";
import { tracing } from "orusd/tracing.js";
import { tree } from "orusd/tree.js";

const PLAN = [0.95, 0.3, 0.6];

/** Fill the panel, and join it to the room. */
export async function roomPage(room, state, { stand, panel }) {
  let known = byPath(state);
  const about = element("div", { id: "about" });
  let prims = tree(state.prims, (path) => choose(path));
  let [plan, planned] = [state.plan, false];
  const overlayPlan = () => room.overlay("plan", planned ? plan : null, { color: PLAN, over: true });

  const choose = (path) => {
    const prim = known.get(path);
    room.select(path ? [path] : []);
    prims.choose(path);
    about.replaceChildren(...(prim ? [told(whole(prim, known)), ...opinions(path)] : []));
    document.body.dataset.prim = path ?? "";
  };
  room.onPick((found) => choose(found && nearest(found.path, known)));

  const lit = await lamps(room, state);
  const taken = shots(room, state, stand);
  panel.append(
    element("div", { id: "told", className: "told" }),
    ...cameras(room, state),
    ...taken,
    ...lit,
    section("View", "ways",
      tick("walk", "walk (W A S D)", false, (on) => room.camera.become(on ? "walk" : "orbit")),
      tick("outside", "hide near walls", true, (on) => { room.outside = on; room.draw(); }),
      ...(state.plan.length ? [tick("plan", "plan", false, (on) => { planned = on; overlayPlan(); })] : [])),
    ...measuring(room, stand),
    ...scan(room, state),
    ...(state.prims.length ? tracing(room, stand) : []),
    section("Prim", "prim", about),
    ...doors(room, state),
    ...looks(room, state),
    section("Stage", "prims", prims.root),
  );
  room.page = { choose, state, stand };

  /** The stage has changed: show its current state. */
  const again = async ({ file }) => {
    const [now, glb] = await Promise.all([stateNow(), resource("room.glb")]);
    known = byPath(now);
    plan = now.plan;
    overlayPlan();
    const before = prims.root;
    prims = tree(now.prims, (path) => choose(path));
    before.replaceWith(prims.root);
    await room.load(glb);
    if (document.body.dataset.prim) choose(document.body.dataset.prim);
    document.body.dataset.changes = Number(document.body.dataset.changes ?? 0) + 1;
    tell(`${file} was changed`);
  };
  listen((told) => { if (told.event === "changed") again(told).catch(complain); });
}

const byPath = (state) => new Map(state.prims.map((prim) => [prim.path, prim]));

/** A prim with what only the object that it is a part of is said to have. */
function whole(prim, known) {
  const found = { ...prim };
  for (let end = prim.path.lastIndexOf("/"); end > 0; end = prim.path.lastIndexOf("/", end - 1)) {
    const { category, mass } = known.get(prim.path.slice(0, end)) ?? {};
    found.category ??= category;
    found.mass ??= mass;
  }
  return found;
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

/** A list of each layer's opinions on a prim, when the user opens it. */
function opinions(path) {
  if (offline) return [];
  const list = element("div", {});
  return [element("details", { id: "opinions", ontoggle: async (event) => {
    if (!event.target.open || list.childElementCount) return;
    try {
      const { opinions: found } = await send("opinions", { path });
      list.replaceChildren(...found.map(({ layer, properties }) => element("div", { "data-layer": layer },
        element("h2", {}, layer), facts("", Object.fromEntries(properties)))));
    } catch (error) { complain(error); }
  } }, element("summary", {}, "Opinions"), list)];
}

/** The prim that the state tells of, or the nearest one above it. */
function nearest(path, known) {
  let found = path;
  while (found && !known.has(found)) found = found.slice(0, found.lastIndexOf("/"));
  return found || null;
}
