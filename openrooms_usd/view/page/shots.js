// What a camera saw: its photograph, and the channels of a finished render, over the page.

import { choice, complain, element, section, slider } from "orusd/panel.js";
import { offline, resource, send } from "orusd/source.js";

const NOTHING = "the page alone";
const KINDS = { jpg: "image/jpeg", jpeg: "image/jpeg", png: "image/png" };

/** The section; none where nothing was taken. */
export function shots(room, state, stand) {
  if (!Object.keys(state.shots).length) return [];
  const image = element("img", { id: "shot", hidden: true, alt: "" });
  stand.append(image);
  let [camera, wanted] = [null, NOTHING];
  const place = element("div", {});

  const show = async () => {
    const name = camera && state.shots[camera.path]?.[wanted];
    image.hidden = true;
    document.body.dataset.shot = name ?? "";
    if (!name) return;
    const ending = name.slice(name.lastIndexOf(".") + 1).toLowerCase();
    if (image.src) URL.revokeObjectURL(image.src);
    image.src = URL.createObjectURL(new Blob([await resource(name)], { type: KINDS[ending] }));
    await image.decode();
    image.hidden = false;
  };
  room.jumps.push((now) => {
    camera = now;
    const offered = [NOTHING, ...Object.keys(state.shots[now.path] ?? {})];
    if (!offered.includes(wanted)) wanted = NOTHING;
    place.replaceChildren(choice("shot-kind", "show", offered, wanted, (value) => { wanted = value; show().catch(complain); }));
    show().catch(complain);
  });
  // Who moves on looks at the room again.
  room.onDraw(() => { if (!room.camera.exact) image.hidden = true; });
  return [section("Photograph and render", "shots", place,
    slider("shot-opacity", "opacity", { value: 1 }, (value) => { image.style.opacity = value; })),
    ...hemispheres(room, state, () => camera)];
}

/** Light that arrives at a clicked place, where the render of the camera has it. */
function hemispheres(room, state, camera) {
  if (offline || !state.hemispheres.length) return [];
  const image = element("img", { id: "hemisphere", hidden: true, alt: "light from the hemisphere" });
  const told = element("output", { id: "irradiance", className: "told" }, "click a place in a camera's view");
  room.onPick((found, event) => {
    const now = camera();
    if (!found || !room.camera.exact || !state.hemispheres.includes(now?.path)) return;
    const { clientWidth, clientHeight } = room.canvas;
    const y = ((event.offsetY - clientHeight / 2) / clientWidth) * now.aspect + 0.5;
    if (y < 0 || y > 1) return;
    send("hemisphere", { camera: now.path, x: event.offsetX / clientWidth, y }).then(({ picture, irradiance }) => {
      image.src = picture;
      image.hidden = false;
      told.textContent = `${irradiance.map((value) => value.toPrecision(3)).join(", ")} lux of each primary; zenith above`;
    }).catch(complain);
  });
  return [section("Light at a place", "hemispheres", image, told)];
}
