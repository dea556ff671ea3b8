// Sliders of the lights: the time of day, on or off, dimmed, and of another colour.

import { Light } from "orusd/light.js";
import { button, choice, element, section, slider, tick } from "orusd/panel.js";

const KELVIN = { min: 1800, max: 9000, step: 50, unit: " K" };

/** The sections of time, lamps, windows and exposure; none where there are no lightmaps. */
export async function lamps(room, state) {
  if (!state.light) return [];
  const light = await Light.open(room.gl, state.light);
  room.light = light;
  room.refresh();
  const changed = () => { light.sum(); room.refresh(); };
  const rows = (wanted) => light.lights.flatMap(({ name, kind }, number) => {
    if (!wanted.includes(kind)) return [];
    const set = light.set[number];
    return [element("div", { className: "lamp", "data-light": name },
      tick(`on-${name}`, name === "elsewhere" ? "from elsewhere" : name, true, (on) => { set.on = on; changed(); }),
      slider(`share-${name}`, "brightness", { max: 2, value: 1 }, (value) => { set.share = value; changed(); }),
      slider(`kelvin-${name}`, "colour", { ...KELVIN, value: set.kelvin }, (value) => { set.kelvin = value; changed(); }))];
  });
  room.jumps.push((camera) => room.meter(camera.exposure));
  return [
    ...time(light, changed),
    section("Lamps", "lamps", ...rows(["lamp"])),
    section("Windows and doors", "openings", ...rows(["opening", "elsewhere"])),
    section("Exposure", "exposure",
      slider("stops", "stops", { min: -5, max: 5, step: 0.1, value: 0 }, (value) => { room.tone.stops = value; room.draw(); }),
      choice("tone", "tone", ["photograph", "film", "srgb"], "photograph", (name) => { room.tone.name = name; room.draw(); }),
      tick("matt", "metals are shown matt", true, (on) => { room.matt = on ? 1 : 0; room.draw(); }),
      element("div", { className: "buttons" }, button("meter", "fit to what is seen", () => room.meter()))),
  ];
}

/** The time of day; none where there is one moment alone. */
function time(light, changed) {
  const { moments } = light.told;
  if (moments.length < 2) return [];
  const words = (now) => [...new Set([moments[Math.floor(now)], moments[Math.ceil(now)]])].join(" to ");
  return [section("Time of day", "times",
    slider("time", "time", { max: moments.length - 1, words }, (now) => { light.go(now); changed(); }))];
}
