// The distance between two places that are clicked.

import { element, section, tick } from "orusd/panel.js";
import { add, length } from "orusd/matrix.js";

const COLOR = [1, 0.2, 0.35];

/** The section for measuring; while it is on, clicks are places. */
export function measuring(room) {
  const told = element("output", { id: "distance", className: "told" });
  let places = null;
  const show = () => {
    room.overlay("measure", places?.length === 2 ? places : null, { color: COLOR, over: true });
    room.overlay("places", places, { color: COLOR, kind: "points", size: 9, over: true });
    if (!places) told.textContent = "";
    else if (places.length < 2) told.textContent = "click two places";
    else {
      const way = add(places[1], places[0], -1);
      told.textContent = `${length(way).toFixed(3)} m; along x ${way[0].toFixed(3)}, y ${way[1].toFixed(3)}, up ${way[2].toFixed(3)}`;
    }
  };
  room.onPick((found) => {
    if (!places || !found) return;
    places = places.length === 2 ? [found.point] : [...places, found.point];
    show();
  });
  return [section("Distance", "measuring",
    tick("measure", "measure", false, (on) => { places = on ? [] : null; show(); }), told)];
}
