// Several looks of an object, one of which is shown.

import { choice, complain, section } from "orusd/panel.js";
import { offline, resource, send } from "orusd/source.js";

/** The section of looks; none where there is no choice. */
export function looks(room, state) {
  const several = state.looks.filter((one) => one.looks.length > 1);
  if (!several.length || offline) return [];
  return [section("Looks", "looks", ...several.map(({ path, looks: offered, chosen }) => choice(
    `look-${path}`, path.slice(path.lastIndexOf("/") + 1), offered, chosen,
    (look) => show(room, path, look).catch(complain))))];
}

async function show(room, path, look) {
  await send("look", { path, look });
  await room.load(await resource("room.glb"));
}
