// A room's plan over its scan. What a change makes of it is Python's to say: the page shows it.

import { Elevation } from "orusd/elevation.js";
import { folding, helping, undoing } from "orusd/frame.js";
import { heightPicker } from "orusd/heights.js";
import { listen, send, state } from "orusd/source.js";
import { TopView } from "orusd/topview.js";

const FRAME = `
  <section id="drawing">
    <div id="top"></div>
    <div id="wall"><p id="hint" class="told">Click a wall to see it here, then draw its windows and
      doors.</p></div>
  </section>
  <aside class="panel">
    <p id="draft" class="row" hidden>There are unsaved changes from last time.
      <button id="draft-take">restore</button><button id="draft-drop">discard</button></p>
    <div class="row">
      <button id="undo" title="Ctrl+Z">undo</button><button id="redo" title="Ctrl+Y, Ctrl+Shift+Z">redo</button>
      <button id="save" title="Ctrl+S">save</button>
      <label><input type="checkbox" id="snap" checked> snap (g)</label>
    </div>
    <div class="row">
      <button id="square" title="q">square up</button>
      <button id="remove" title="Delete">remove</button>
      <label><input type="checkbox" id="build"> draw inner walls (i)</label>
    </div>
    <div class="row"><button id="fit" title="f">fit view</button></div>
    <div class="row"><label for="kind">opening type</label><select id="kind">
      <option value="">door or window</option><option>window</option><option>door</option>
      <option value="opening">passage</option></select></div>
    <p id="refusal" class="wrong"></p>
    <p id="renumbered" class="wrong" hidden>The room has other walls now: look at cladding and
      accents, which name walls by their numbers.</p>
    <h2>Height</h2>
    <div class="row"><label for="height">floor to ceiling, m</label>
      <input id="height" type="number" step="0.01" min="0.5" size="6"></div>
    <svg id="heights"></svg>
    <h2>Selected</h2><p id="selected" class="told"></p>
    <h2>Found</h2><div id="rooms" class="row"></div>
    <p class="told"><span id="area"></span> m²; <span id="clicks">0 clicks</span>,
      <span id="saved"></span></p>
    <div id="notes" class="told"></div>
  </aside>`;

const HELP = [
  ["drag a corner or a wall", "move it"], ["double-click a wall", "split it"], ["click a wall", "show its openings below"],
  ["drag the ground", "move the plan"], ["wheel", "nearer, farther"], ["F", "fit the plan into the window"],
  ["G", "snap"], ["I", "draw inner walls"], ["Q", "square up"], ["Delete", "remove what is selected"],
  ["Ctrl+Z", "undo"], ["Ctrl+Y, Ctrl+Shift+Z", "redo"], ["Ctrl+S", "save"],
];

/** Fill the page. */
export async function start(root) {
  root.innerHTML = FRAME;
  folding(root.querySelector(".panel"));
  helping(HELP);
  new Editor(await state());
}

const element = (id) => document.getElementById(id);

class Editor {
  constructor(told) {
    this.plan = told;
    this.chosen = {};
    this.clicks = 0;
    this.waiting = null;
    this.busy = Promise.resolve();
    this.top = new TopView(element("top"), told, this);
    this.wall = new Elevation(element("wall"), this);
    this.setHeights = heightPicker(element("heights"), told.heights, this);
    element("draft").hidden = !told.draft;
    element("notes").replaceChildren(...told.notes.map((note) => line(note)));
    this.#buttons(Object.keys(told.found));
    document.addEventListener("keydown", (event) => this.#key(event));
    undoing(() => this.do("undo"), () => this.do("redo"));
    element("fit").addEventListener("click", () => this.top.fit());
    document.addEventListener("pointerdown", () => {
      this.clicks += 1;
      element("clicks").textContent = this.clicks === 1 ? "1 click" : `${this.clicks} clicks`;
    }, { capture: true });
    listen(({ event }) => { if (event === "changed") this.do("reload"); });
    this.show(told);
  }

  /** Whether a drag on the ground draws a wall. */
  get building() {
    return element("build").checked;
  }

  /** What is drawn on an elevation, where that is said. */
  kind() {
    const kind = element("kind").value;
    return kind ? { kind } : {};
  }

  /** Change the plan; what comes of it is shown. */
  async change(command, given = {}) {
    this.waiting = null;
    await this.do(command, { ...given, snap: element("snap").checked });
    if (command === "add_opening") {
      this.choose({ ...this.#place(), opening: this.plan.openings.length - 1 });
    }
  }

  /** Show what a change would make of the plan; only the last one of many is asked for. */
  tryOut(command, given) {
    const idle = this.waiting === null;
    this.waiting = [command, { ...given, snap: element("snap").checked, final: false }];
    if (idle) this.busy = this.busy.then(() => this.#ask());
  }

  /** Do something that needs no place. */
  do(command, given = {}) {
    this.busy = this.busy.then(async () => {
      try {
        this.show(await send(command, given));
        await this.#elevation();
      } catch (error) {
        // What was only tried out is shown no more.
        this.show(await state());
        this.#refuse(error);
      }
    });
    return this.busy;
  }

  /** Select a corner, a wall, a partition, or an opening of one. */
  choose(what) {
    this.chosen = what;
    this.busy = this.busy.then(() => this.#elevation());
  }

  show(told) {
    Object.assign(this.plan, told);
    const { plan } = this;
    if (this.chosen.wall >= plan.corners.length) this.chosen = {};
    this.top.show(plan, this.chosen);
    this.wall.show(plan, this.chosen);
    this.setHeights(plan.height);
    if (document.activeElement !== element("height")) element("height").value = plan.height.toFixed(3);
    element("area").textContent = plan.area.toFixed(2);
    element("saved").textContent = plan.unsaved ? "not saved" : `as in ${plan.file}`;
    element("undo").disabled = plan.undo === 0;
    element("redo").disabled = plan.redo === 0;
    element("selected").textContent = this.#words();
    if (plan.refusal) this.#refuse(plan.refusal);
    else element("refusal").textContent = "";
    element("renumbered").hidden = !plan.renumbered;
    document.body.dataset.undo = plan.undo;
  }

  async #ask() {
    const [command, given] = this.waiting ?? [];
    if (!command) return;
    try {
      const told = await send(command, given);
      if (this.waiting) this.show(told);
    } catch (error) {
      this.#refuse(error);
    }
    if (this.waiting && this.waiting[1] !== given) await this.#ask();
    else this.waiting = null;
  }

  #place() {
    const { wall, partition } = this.chosen;
    return wall !== undefined ? { wall } : partition !== undefined ? { partition } : null;
  }

  async #elevation() {
    const place = this.#place();
    element("hint").hidden = place !== null;
    if (place === null) this.wall.clear();
    else {
      try {
        await this.wall.wall(await send("elevation", place), place);
      } catch (error) {
        this.chosen = {};
        this.wall.clear();
      }
    }
    this.show({});
  }

  #refuse({ message, place, remedy }) {
    element("refusal").textContent = [place, message, remedy].filter(Boolean).join("\n");
  }

  #words() {
    const { corner, opening } = this.chosen;
    if (opening !== undefined && this.plan.openings[opening]) {
      const { name, rectangle: [left, right, bottom, top] } = this.plan.openings[opening];
      const [width, high, sill] = [right - left, top - bottom, bottom].map((at) => at.toFixed(2));
      return `${name}: ${width} x ${high} m, sill at ${sill} m`;
    }
    if (corner !== undefined) return `corner ${corner}`;
    const { wall, partition } = this.chosen;
    return partition ?? (wall === undefined ? "nothing" : `wall ${wall}`);
  }

  #buttons(rooms) {
    for (const command of ["undo", "redo", "save"]) {
      element(command).addEventListener("click", () => this.do(command));
    }
    element("square").addEventListener("click", () => this.change("square"));
    element("remove").addEventListener("click", () => this.#remove());
    for (const [id, take] of [["draft-take", true], ["draft-drop", false]]) {
      element(id).addEventListener("click", () => {
        element("draft").hidden = true;
        this.do("draft", { take });
      });
    }
    element("height").addEventListener("change", ({ target }) => {
      this.change("set_height", { height: target.valueAsNumber });
    });
    element("kind").addEventListener("change", ({ target }) => {
      const { opening } = this.chosen;
      if (opening !== undefined && target.value) {
        this.change("set_opening", { opening, kind: target.value });
      }
    });
    element("rooms").replaceChildren(...rooms.map((room) => {
      const button = document.createElement("button");
      button.textContent = room === "all" ? "all rooms" : `room ${room}`;
      button.dataset.room = room;
      button.addEventListener("click", () => this.do("take", { room }));
      return button;
    }));
  }

  #remove() {
    const { corner, wall, partition, opening } = this.chosen;
    const number = this.plan.partitions.findIndex((row) => row.name === partition);
    this.chosen = opening === undefined ? {} : this.#place();
    if (opening !== undefined) this.change("remove_opening", { opening });
    else if (corner !== undefined) this.change("remove_corner", { corner });
    else if (wall !== undefined) this.change("remove_wall", { wall });
    else if (number >= 0) this.change("remove_partition", { partition: number });
  }

  #key(event) {
    if (event.target.matches("input[type=number], select")) return;
    const key = (event.ctrlKey || event.metaKey ? "Ctrl+" : "") + event.key.toLowerCase();
    const actions = {
      "Ctrl+s": () => this.do("save"),
      delete: () => this.#remove(),
      backspace: () => this.#remove(),
      escape: () => this.choose({}),
      g: () => element("snap").click(),
      i: () => element("build").click(),
      q: () => this.change("square"),
      f: () => this.top.fit(),
    };
    if (!(key in actions)) return;
    event.preventDefault();
    actions[key]();
  }
}

function line(text) {
  const made = document.createElement("p");
  made.textContent = text;
  return made;
}
