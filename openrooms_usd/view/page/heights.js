// How many points there are at each height; the ceiling's height is dragged over them.

import { follow, shape } from "orusd/svg.js";

/** Draw a histogram; gives what shows the room's height in it. */
export function heightPicker(svg, { step, counts }, editor) {
  const most = Math.max(1, ...counts);
  const highest = Math.max(3, counts.length * step);
  svg.setAttribute("viewBox", `0 ${-highest} 1 ${highest}`);
  svg.setAttribute("preserveAspectRatio", "none");
  const group = shape(svg, "g", { transform: "scale(1 -1)" });
  counts.forEach((count, number) => {
    const width = Math.sqrt(count / most);
    if (count) shape(group, "rect", { x: 0, y: number * step, width, height: step, class: "count" });
  });
  const mark = shape(group, "line", { x1: 0, x2: 1, class: "ceiling", id: "ceiling" });
  const given = ([, height]) => ({ height: Math.max(0.5, height) });
  svg.addEventListener("pointerdown", (event) => follow(event, group, {
    moved: (_, to) => editor.tryOut("set_height", given(to)),
    dropped: (_, to) => editor.change("set_height", given(to)),
    clicked: (at) => editor.change("set_height", given(at)),
  }));
  return (height) => {
    mark.setAttribute("y1", height);
    mark.setAttribute("y2", height);
  };
}
