// The plan from above: points, what was found, and what is drawn; corners and walls are dragged.

import { resource } from "orusd/source.js";
import { follow, placeOf, segment, shape } from "orusd/svg.js";

const MARK_PX = 6;

export class TopView {
  /** A drawing in `holder` of the plan that `told` tells; `editor` is asked for every change. */
  constructor(holder, told, editor) {
    this.editor = editor;
    [this.left, this.right, this.bottom, this.top] = told.box;
    this.svg = shape(holder, "svg", { id: "plan", preserveAspectRatio: "xMidYMid meet" });
    const [left, right, bottom, top] = told.look;
    this.home = [left, top, right - left, top - bottom];
    this.fit();
    // Metres with y upwards.
    this.group = shape(this.svg, "g", { transform: "scale(1 -1)" });
    this.under = shape(this.group, "g");
    this.drawn = shape(this.group, "g", { id: "drawn" });
    for (const [name, found] of Object.entries(told.found)) this.#found(name, found);
    if (told.picture) this.#points(told.picture);
    this.svg.addEventListener("pointerdown", (event) => this.#background(event));
    this.svg.addEventListener("wheel", (event) => this.#zoom(event), { passive: false });
    new ResizeObserver(() => this.#sizes()).observe(this.svg);
  }

  /** Show the whole plan. */
  fit() { this.look(...this.home); }

  /** Show a part of the plan, by its upper left corner and its size in metres. */
  look(left, top, width, height) {
    this.seen = [left, top, width, height];
    this.svg.setAttribute("viewBox", `${left} ${-top} ${width} ${height}`);
    this.#sizes();
  }

  /** Draw a plan; `chosen` is what is selected. */
  show(plan, chosen) {
    this.plan = plan;
    const { drawn } = this;
    drawn.replaceChildren();
    shape(drawn, "polygon", { points: plan.corners.map(String).join(" "), class: "floor" });
    plan.corners.forEach((corner, number) => {
      const ends = [corner, plan.corners[(number + 1) % plan.corners.length]];
      this.#wall(ends, { wall: number }, chosen.wall === number);
    });
    for (const row of plan.partitions) {
      this.#wall(row.line, { partition: row.name }, chosen.partition === row.name);
    }
    for (const [number, row] of plan.openings.entries()) {
      segment(drawn, row.line, { class: `opening ${row.kind}`, "data-opening": number });
    }
    plan.partitions.forEach((row, number) => this.#ends(row, number));
    plan.corners.forEach((corner, number) => this.#corner(corner, number, chosen));
    this.#sizes();
  }

  #found(name, found) {
    const points = found.corners.map(String).join(" ");
    shape(this.under, "polygon", { points, class: "found", "data-found": name });
    for (const row of found.openings) segment(this.under, row.line, { class: "found" });
  }

  async #points(name) {
    const content = new Blob([await resource(name)], { type: "image/png" });
    const picture = shape(this.under, "image", {
      id: "points", x: this.left, y: -this.top, transform: "scale(1 -1)",
      width: this.right - this.left, height: this.top - this.bottom, preserveAspectRatio: "none",
    });
    picture.addEventListener("load", () => { picture.dataset.loaded = "yes"; });
    picture.setAttribute("href", URL.createObjectURL(content));
    this.under.prepend(picture);
  }

  #wall(ends, name, chosen) {
    const key = "wall" in name ? { "data-wall": name.wall } : { "data-partition": name.partition };
    segment(this.drawn, ends, { class: chosen ? "wall chosen-wall" : "wall" });
    const grip = segment(this.drawn, ends, { class: "grip", ...key });
    grip.addEventListener("pointerdown", (event) => this.#grab(event, ends, name));
    grip.addEventListener("dblclick", (event) => {
      if ("wall" in name) {
        this.editor.change("split_wall", { wall: name.wall, at: placeOf(this.group, event) });
      }
    });
  }

  #grab(event, ends, name) {
    const by = (from, to) => [to[0] - from[0], to[1] - from[1]];
    const shifted = (from, to) => {
      const [dx, dy] = by(from, to);
      return ends.map(([x, y]) => [x + dx, y + dy]);
    };
    const number = this.plan.partitions.findIndex((row) => row.name === name.partition);
    const [command, given] = "wall" in name
      ? ["move_wall", (from, to) => ({ wall: name.wall, by: by(from, to) })]
      : ["move_partition", (from, to) => ({ partition: number, line: shifted(from, to) })];
    follow(event, this.group, {
      moved: (from, to) => this.editor.tryOut(command, given(from, to)),
      dropped: (from, to) => this.editor.change(command, given(from, to)),
      clicked: () => this.editor.choose(name),
    });
  }

  #ends(row, number) {
    row.line.forEach(([cx, cy], end) => {
      const mark = shape(this.drawn, "circle", {
        cx, cy, class: "corner", "data-end": `${row.name}:${end}`,
      });
      const given = (to) => ({ partition: number, line: row.line.with(end, to) });
      mark.addEventListener("pointerdown", (event) => follow(event, this.group, {
        moved: (_, to) => this.editor.tryOut("move_partition", given(to)),
        dropped: (_, to) => this.editor.change("move_partition", given(to)),
        clicked: () => this.editor.choose({ partition: row.name }),
      }));
    });
  }

  #corner([cx, cy], number, chosen) {
    const mark = shape(this.drawn, "circle", {
      cx, cy, class: chosen.corner === number ? "corner chosen-corner" : "corner",
      "data-corner": number,
    });
    mark.addEventListener("pointerdown", (event) => follow(event, this.group, {
      moved: (_, to) => this.editor.tryOut("move_corner", { corner: number, to }),
      dropped: (_, to) => this.editor.change("move_corner", { corner: number, to }),
      clicked: () => this.editor.choose({ corner: number }),
    }));
  }

  #background(event) {
    const [left, top, width, height] = this.seen;
    if (this.editor.building) {
      const given = (from, to) => ({ line: [from, to] });
      follow(event, this.group, {
        moved: (from, to) => this.editor.tryOut("add_partition", given(from, to)),
        dropped: (from, to) => this.editor.change("add_partition", given(from, to)),
      });
      return;
    }
    const scale = 1 / this.group.getScreenCTM().a;
    const pan = (x, y) => this.look(
      left - (x - event.clientX) * scale, top + (y - event.clientY) * scale, width, height,
    );
    const move = (now) => pan(now.clientX, now.clientY);
    window.addEventListener("pointermove", move);
    window.addEventListener("pointerup", () => window.removeEventListener("pointermove", move), {
      once: true,
    });
  }

  #zoom(event) {
    event.preventDefault();
    const [left, top, width, height] = this.seen;
    const [x, y] = placeOf(this.group, event);
    const by = 1.0015 ** event.deltaY;
    this.look(x - (x - left) * by, y + (top - y) * by, width * by, height * by);
  }

  /** Marks and lines are as large on the screen whatever is seen. */
  #sizes() {
    const pixel = 1 / (this.group?.getScreenCTM()?.a || 1);
    this.svg.style.setProperty("--pixel", pixel);
    for (const mark of this.svg.querySelectorAll("circle")) {
      mark.setAttribute("r", MARK_PX * pixel);
    }
  }
}
