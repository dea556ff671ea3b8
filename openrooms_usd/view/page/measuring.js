// The distance between two places that are clicked; it stands at its line.

import { element, section, tick } from "orusd/panel.js";
import { add, length } from "orusd/matrix.js";

const COLOR = [1, 0.2, 0.35];

/** The section for measuring; while it is on, clicks are places. */
export function measuring(room, stand) {
  const label = element("output", { id: "length", hidden: true });
  stand.append(label);
  const told = element("output", { id: "distance", className: "told" });
  let places = null;
  const show = () => {
    room.overlay("measure", places?.length === 2 ? places : null, { color: COLOR, over: true });
    room.overlay("places", places, { color: COLOR, kind: "points", size: 9, over: true });
    if (!places) told.textContent = "";
    else if (places.length < 2) told.textContent = "click two places";
    else {
      const way = add(places[1], places[0], -1);
      label.textContent = `${length(way).toFixed(3)} m`;
      told.textContent = `${label.textContent}; along x ${way[0].toFixed(3)}, y ${way[1].toFixed(3)}, up ${way[2].toFixed(3)}`;
    }
  };
  const pick = (found) => {
    if (!found) return;
    places = places.length === 2 ? [found.point] : [...places, found.point];
    show();
  };
  room.onDraw(() => {
    const at = places?.length === 2 && room.camera.project(add(places[0], add(places[1], places[0], -1), 0.5));
    label.hidden = !at;
    if (at) [label.style.left, label.style.top] = at.map((value) => `${value}px`);
  });
  return [section("Distance", "measuring",
    tick("measure", "measure", false, (on) => {
      places = on ? [] : null;
      room.tool = on ? pick : null;
      show();
    }), told)];
}
