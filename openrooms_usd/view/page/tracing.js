// A path-traced picture of what is seen now, made by the renderer while one goes on looking.

import { button, choice, complain, element, section, tick } from "orusd/panel.js";
import { multiply, toRows } from "orusd/matrix.js";
import { offline, resource, send } from "orusd/source.js";

const PAUSE_MS = 300;
// WebGL's axes of a camera (right, up, backward) to OpenCV's.
const FLIP = [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1];

/** The section; none in a file, where there is no renderer. */
export function tracing(room, stand) {
  if (offline) return [];
  const asked = { share: 0.5, samples: 64, denoise: true };
  const progress = element("progress", { id: "progress", max: 1, value: 0, hidden: true });
  const said = element("output", { id: "traced-samples", className: "told" });
  const image = element("img", { id: "traced", hidden: true, alt: "path-traced", title: "click to close" });
  const frame = stand.appendChild(image);
  frame.addEventListener("click", () => { frame.hidden = true; });

  const follow = async () => {
    progress.hidden = false;
    let shown = 0;
    for (;;) {
      const { state, samples, fraction, error } = await send("traced");
      progress.value = fraction;
      said.textContent = state === "opening" ? "the stage is opened" : `${samples} samples`;
      if (error) throw Object.assign(new Error(error.message), error);
      if (samples > shown || state === "ready") {
        shown = samples;
        if (samples) await show(image);
      }
      if (state === "ready") break;
      await new Promise((done) => { setTimeout(done, PAUSE_MS); });
    }
    progress.hidden = true;
    document.body.dataset.traced = Number(document.body.dataset.traced ?? 0) + 1;
  };

  const start = async () => {
    const { clientWidth, clientHeight } = room.canvas;
    const [width, height] = [clientWidth, clientHeight].map((side) => Math.max(16, Math.round(side * asked.share)));
    await send("trace", { ...camera(room.camera), width, height, samples: asked.samples,
      denoise: asked.denoise, moves: moves(room), weights: weights(room) });
    await follow();
  };

  return [section("Path-traced picture", "tracing",
    choice("trace-size", "size", [[0.25, "a quarter"], [0.5, "half"], [1, "full size"]], 0.5, (value) => { asked.share = Number(value); }),
    choice("trace-samples", "samples", [4, 16, 64, 256, 1024], 64, (value) => { asked.samples = Number(value); }),
    tick("trace-denoise", "denoise", true, (on) => { asked.denoise = on; }),
    element("div", { className: "buttons" },
      button("trace", "trace", () => start().catch((error) => { progress.hidden = true; complain(error); })),
      button("trace-stop", "stop", () => send("trace_stop").catch(complain))),
    progress, said)];
}

async function show(image) {
  const old = image.src;
  image.src = URL.createObjectURL(new Blob([await resource("traced.png")], { type: "image/png" }));
  await image.decode();
  if (old) URL.revokeObjectURL(old);
  image.hidden = false;
}

function camera({ pose, lens }) {
  return { world_from_camera: toRows(multiply(pose, FLIP)), ...lens };
}

const moves = (room) => Object.fromEntries([...room.surfaces.moves].map(([path, matrix]) => [path, toRows(matrix)]));

/** What lamps are set to; nothing where all are as the stage has them. */
function weights({ light }) {
  if (!light || light.set.every(({ on, share, kelvin }, k) => on && share === 1 && kelvin === light.lights[k].kelvin)) return {};
  return Object.fromEntries(light.lights.map(({ name }, number) => [name, light.weight(number)]));
}
