// A wall square on, seen from inside: its points on a canvas, its openings drawn over them.

import { follow, shape } from "orusd/svg.js";

// What of an opening's rectangle each of its edges and corners moves: left, right, bottom, top.
const GRIPS = [
  [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1],
  [1, 0, 1, 0], [1, 0, 0, 1], [0, 1, 1, 0], [0, 1, 0, 1],
];
const SIDES = ["left", "right", "bottom", "top"];
const GRIP_PX = 5;

export class Elevation {
  constructor(holder, editor) {
    this.editor = editor;
    this.holder = holder;
    this.canvas = document.createElement("canvas");
    this.canvas.id = "elevation-points";
    holder.append(this.canvas);
    this.svg = shape(holder, "svg", { id: "elevation", preserveAspectRatio: "none" });
    this.group = shape(this.svg, "g", { transform: "scale(1 -1)" });
    this.svg.addEventListener("pointerdown", (event) => this.#begin(event));
    new ResizeObserver(() => this.#fit()).observe(holder);
  }

  /** Show a wall; `told` is what the command `elevation` tells of it. */
  async wall(told, name) {
    this.told = told;
    this.name = name;
    this.svg.setAttribute("viewBox", `0 ${-told.height} ${told.length} ${told.height}`);
    await this.#points(told.png);
    this.#fit();
  }

  /** Nothing to show. */
  clear() {
    this.told = null;
    this.group.replaceChildren();
    this.canvas.getContext("2d").clearRect(0, 0, this.canvas.width, this.canvas.height);
  }

  /** Draw the openings of a plan that are in this wall. */
  show(plan, chosen) {
    if (!this.told) return;
    this.group.replaceChildren();
    const { length, height } = this.told;
    shape(this.group, "rect", { x: 0, y: 0, width: length, height, class: "face" });
    plan.openings.forEach((row, number) => {
      const here = row.partition === (this.name.partition ?? null)
        && row.wall === (this.name.wall ?? null);
      if (here) this.#opening(row, number, chosen.opening === number);
    });
  }

  #opening(row, number, chosen) {
    const [left, right, bottom, top] = row.rectangle;
    const body = shape(this.group, "rect", {
      x: left, y: bottom, width: right - left, height: top - bottom,
      class: `hole ${row.kind}${chosen ? " chosen-hole" : ""}`, "data-hole": number,
    });
    this.#drags(body, number, row.rectangle, [1, 1, 1, 1]);
    const [sx, sy] = this.pixel;
    for (const moves of GRIPS) {
      const name = SIDES.filter((_, side) => moves[side]).join("-");
      const x = moves[0] ? left : moves[1] ? right : left;
      const y = moves[2] ? bottom : moves[3] ? top : bottom;
      const wide = !moves[0] && !moves[1] ? right - left : 2 * GRIP_PX * sx;
      const high = !moves[2] && !moves[3] ? top - bottom : 2 * GRIP_PX * sy;
      const grip = shape(this.group, "rect", {
        x: moves[0] || moves[1] ? x - wide / 2 : x, y: moves[2] || moves[3] ? y - high / 2 : y,
        width: wide, height: high, class: `edge ${name}`, "data-edge": `${number}:${name}`,
      });
      this.#drags(grip, number, row.rectangle, moves);
    }
  }

  #drags(mark, number, rectangle, moves) {
    const given = (from, to) => {
      const by = [to[0] - from[0], to[0] - from[0], to[1] - from[1], to[1] - from[1]];
      return { opening: number, rectangle: rectangle.map((at, side) => at + moves[side] * by[side]) };
    };
    mark.addEventListener("pointerdown", (event) => follow(event, this.group, {
      moved: (from, to) => this.editor.tryOut("set_opening", given(from, to)),
      dropped: (from, to) => this.editor.change("set_opening", given(from, to)),
      clicked: () => this.editor.choose({ ...this.name, opening: number }),
    }));
  }

  #begin(event) {
    if (!this.told) return;
    const given = ([x1, y1], [x2, y2]) => ({
      ...this.name, ...this.editor.kind(),
      rectangle: [Math.min(x1, x2), Math.max(x1, x2), Math.min(y1, y2), Math.max(y1, y2)],
    });
    follow(event, this.group, {
      moved: (from, to) => this.editor.tryOut("add_opening", given(from, to)),
      dropped: (from, to) => this.editor.change("add_opening", given(from, to)),
      clicked: () => this.editor.choose(this.name),
    });
  }

  async #points(png) {
    const context = this.canvas.getContext("2d");
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.canvas.dataset.shown = "";
    if (!png) return;
    const bytes = Uint8Array.from(atob(png), (letter) => letter.charCodeAt(0));
    const picture = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    [this.canvas.width, this.canvas.height] = [picture.width, picture.height];
    context.drawImage(picture, 0, 0);
    this.canvas.dataset.shown = this.told.wall;
  }

  /** As large as its holder allows, without stretching. */
  #fit() {
    if (!this.told) return;
    const { clientWidth, clientHeight } = this.holder;
    const scale = 0.96 * Math.min(clientWidth / this.told.length, clientHeight / this.told.height);
    for (const element of [this.canvas, this.svg]) {
      element.style.width = `${this.told.length * scale}px`;
      element.style.height = `${this.told.height * scale}px`;
    }
    this.pixel = [1 / scale, 1 / scale];
  }
}
