// Doors, sashes, lids and drawers: a slider for each, from closed to as far as it goes.

import * as m from "orusd/matrix.js";
import { element, row, section, slider } from "orusd/panel.js";

/** The section of what moves; none where nothing does. */
export function doors(room, state) {
  if (!state.joints.length) return [];
  const owners = new Map();
  for (const joint of state.joints) {
    const owner = ownerOf(joint.path, state);
    if (!owners.has(owner)) owners.set(owner, []);
    owners.get(owner).push(joint);
  }
  const groups = [...owners].map(([owner, joints]) => element("details", { "data-owner": owner },
    element("summary", {}, owner.slice(owner.lastIndexOf("/") + 1)),
    ...joints.map((joint) => door(room, joint, owner))));
  return [section("Doors and drawers", "doors", ...groups)];
}

function door(room, joint, owner) {
  const { path, type, axis, lower, upper, now } = joint;
  const world = m.fromRows(joint.world_from_prim);
  const [back, along] = [m.inverse(world), m.unit(axis)];
  const label = path.slice(owner.length + 1).replace(/^Geometry\//, "") || "it";
  if (upper <= lower) return row(label, "it is stuck");
  const hinge = type === "hinge";
  const said = { min: lower, max: upper, step: hinge ? 1 : 0.005, value: now, unit: hinge ? "°" : " m" };
  const made = slider(`joint-${path}`, label, said, (value) => {
    const by = value - now;
    // A prim's frame may be scaled: the rail is as long as the joint says, in metres.
    const slid = m.unit(m.direction(world, along)).map((v) => v * by);
    const step = hinge ? m.multiply(world, m.multiply(m.turn(along, by), back)) : m.translation(...slid);
    room.move(path, by ? step : null);
  });
  made.dataset.joint = path;
  return made;
}

/** The object that a part belongs to: the nearest prim above it that has a category. */
function ownerOf(path, state) {
  const named = new Set(state.prims.filter((prim) => prim.category).map((prim) => prim.path));
  for (let end = path.length; end > 0; end = path.lastIndexOf("/", end - 1))
    if (named.has(path.slice(0, end))) return path.slice(0, end);
  return path;
}
