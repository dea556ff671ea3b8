// `orusd edit objects STAGE`: furniture dragged on the floor, turned, renamed, exchanged.

import { Correcting } from "orusd/correcting.js";
import * as m from "orusd/matrix.js";
import { button, choice, complain, element, facts, row, section, tick } from "orusd/panel.js";
import * as source from "orusd/source.js";

const ROOT = "/World/Furniture/";
const HANDLE_PX = 14;
const HANDLE_M = 0.35;
const TURN_DEG = 15;
const STEP_M = 0.05;
const FINE = 0.1;
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const MARK = [0.16, 0.55, 1];
const SAME = "";

/** Fill the page. */
export async function start(root) {
  const page = new Page();
  const help = [["drag a selected object", "move it; its handle turns it"], ["Q, E", "turn it"], ["arrows", "move it; with Shift finely"],
    ["Delete", "remove it"]];
  const held = await Correcting.open(root, (state) => page.renew(state), help);
  page.fill(held, await source.state());
}

class Page {
  constructor() {
    Object.assign(this, { name: null, drag: null, trying: false, objects: new Map() });
  }

  fill(held, state) {
    const { room, panel } = Object.assign(this, { held, room: held.room, panel: held.panel });
    held.held = () => this.drag !== null;
    this.about = element("div", { id: "about" });
    this.fields = element("div", { id: "fields" });
    panel.append(
      section("Object", "objects", choice("object", "object", [], SAME, (name) => this.choose(name || null)), this.about),
      section("What", "what",
        choice("category", "category", Object.keys(state.categories), SAME, (category) => this.act("relabel", { category })),
        choice("style", "model", [], SAME, (style) => style && this.act("remake", { category: this.one.category, style }))),
      section("Where", "where", this.fields, tick("snap", "flush to walls that are near", true, () => {})),
      element("div", { className: "buttons" },
        button("duplicate", "duplicate", () => this.duplicate()),
        button("delete", "delete", () => this.remove())),
    );
    room.onPick((found) => this.choose(nameOf(found?.path)));
    room.camera.held = (event) => this.holds(event);
    room.canvas.addEventListener("pointermove", (event) => this.dragged(event));
    for (const end of ["pointerup", "pointercancel"])
      room.canvas.addEventListener(end, (event) => this.dropped(event));
    addEventListener("keydown", (event) => this.pressed(event));
    this.renew(state);
  }

  get one() { return this.objects.get(this.name); }

  get snap() { return document.getElementById("snap").checked; }

  renew(state) {
    this.objects = new Map(state.objects.map((one) => [one.name, { ...one, from: { ...one } }]));
    this.categories = state.categories;
    if (!this.held) return;
    const list = document.getElementById("object");
    list.replaceChildren(...[SAME, ...this.objects.keys()].map((name) => element("option", { value: name }, name)));
    this.choose(this.objects.has(this.name) ? this.name : null);
  }

  choose(name) {
    this.name = this.objects.has(name) ? name : null;
    document.body.dataset.object = this.name ?? "";
    document.getElementById("object").value = this.name ?? SAME;
    const { one } = this;
    this.room.select(one ? [one.path] : []);
    for (const id of ["category", "style", "duplicate", "delete"]) document.getElementById(id).disabled = !one;
    this.about.replaceChildren(...(one ? [facts("facts", { category: one.category, carried: one.support })] : []));
    document.getElementById("category").value = one?.category ?? SAME;
    const styles = [[SAME, "as it is"], ...(one?.styles ?? []).map((style) => [style, style])];
    document.getElementById("style").replaceChildren(
      ...styles.map(([value, words]) => element("option", { value }, words)));
    this.write();
    this.outline(one);
  }

  /** Numbers that can be typed. */
  write() {
    const { one } = this;
    if (!one) return this.fields.replaceChildren();
    const field = (id, value, change) => row(id, element("input", { id, type: "number", step: "any",
      value: Number(value.toFixed(3)), onchange: (event) => change(Number(event.target.value)) }));
    const size = (id, k) => (value) => (value > 0
      ? this.place(one, one.size.map((before, at) => (at === k ? value : before)))
      : complain(new Error(`${id}: give more than 0 m`)));
    this.fields.replaceChildren(
      field("x", one.x, (x) => this.place({ ...one, x })),
      field("y", one.y, (y) => this.place({ ...one, y })),
      field("yaw", one.yaw, (yaw) => this.place({ ...one, yaw })),
      ...["width", "depth", "height"].map((id, k) => field(id, one.size[k], size(id, k))));
  }

  /** Its outline on the floor, and the handle by which it is turned. */
  outline(spot) {
    if (!spot) return this.room.overlay("outline", null), this.room.overlay("handle", null);
    const { low, high, z } = this.one;
    const corners = [[low[0], low[1]], [high[0], low[1]], high, [low[0], high[1]]].map((at) => there(spot, at, z));
    this.room.overlay("outline", corners.flatMap((at, k) => [at, corners[(k + 1) % 4]]), { color: MARK, over: true });
    this.handle = there(spot, [0, low[1] - HANDLE_M], z);
    this.room.overlay("handle", [this.handle], { kind: "points", color: MARK, size: 12, over: true });
  }

  /** Where a place of the canvas is at the height of the object's base. */
  floor({ offsetX, offsetY }) {
    const { origin, direction } = this.room.camera.ray(offsetX, offsetY);
    const far = (this.one.z - origin[2]) / direction[2];
    return far > 0 && Number.isFinite(far) ? m.add(origin, direction, far) : null;
  }

  /** Whether a press or a drag is ours: on the chosen object, or on its handle. */
  holds(event) {
    if (event.type !== "pointerdown") return this.drag !== null;
    if (!this.one || event.button !== 0 || event.shiftKey) return false;
    const at = this.room.camera.project(this.handle);
    const turns = at && Math.hypot(at[0] - event.offsetX, at[1] - event.offsetY) <= HANDLE_PX;
    if (!turns && nameOf(this.room.at(event.offsetX, event.offsetY)?.path) !== this.name) return false;
    const start = this.floor(event);
    if (!start) return false;
    this.drag = { start, turns, from: { ...this.one }, spot: { ...this.one }, moved: false };
    this.room.canvas.setPointerCapture(event.pointerId);
    return true;
  }

  dragged(event) {
    if (!this.drag) return;
    const at = this.floor(event);
    if (!at) return;
    const { start, from, turns } = this.drag;
    const angle = (place) => Math.atan2(place[1] - from.y, place[0] - from.x) * 180 / Math.PI;
    this.drag.moved = true;
    this.drag.spot = turns ? { ...from, yaw: from.yaw + angle(at) - angle(start) }
      : { ...from, x: from.x + at[0] - start[0], y: from.y + at[1] - start[1] };
    this.show(this.drag.spot);
    this.tryOut();
  }

  /** Ask where it would come to stand, one question at a time. */
  async tryOut() {
    if (this.trying || !this.snap) return;
    this.trying = true;
    const { drag } = this;
    const asked = drag.spot;
    try {
      const spot = await source.send("try", { name: this.name, x: asked.x, y: asked.y, yaw: asked.yaw });
      if (this.drag === drag && drag.spot === asked) this.show({ ...asked, ...spot });
    } catch { /* It is said when the object is dropped. */ }
    this.trying = false;
    if (this.drag && this.drag.spot !== asked) this.tryOut();
  }

  dropped() {
    const { drag } = this;
    this.drag = null;
    if (drag?.moved) this.place(drag.spot);
    else if (this.held.wanted) this.held.renew();
  }

  /** Show an object where it is not yet; the picture has it where it was when that was made. */
  show(spot, one = this.one) {
    const { from } = one;
    const turned = m.multiply(m.turn([0, 0, 1], spot.yaw - from.yaw), m.translation(-from.x, -from.y, 0));
    this.room.move(one.path, m.multiply(m.translation(spot.x, spot.y, spot.z - from.z), turned));
    if (one === this.one) this.outline(spot);
  }

  pressed(event) {
    if (!this.one || event.target.matches("input, select") || event.ctrlKey || event.metaKey) return;
    const share = event.shiftKey ? FINE : 1;
    const turn = { KeyQ: 1, KeyE: -1 }[event.code];
    const step = KEYS[event.code];
    if (event.code === "Delete") this.remove();
    else if (turn) this.place({ ...this.one, yaw: this.one.yaw + turn * TURN_DEG * share });
    else if (step) this.place({ ...this.one, x: this.one.x + step[0] * STEP_M * share, y: this.one.y + step[1] * STEP_M * share });
    else return;
    event.preventDefault();
  }

  place({ x, y, yaw }, size = null) {
    const { one, name } = this;
    // The next key or field starts from here, whether the room was read anew or not.
    Object.assign(one, { x, y, yaw });
    this.held.send("place", { name, x, y, yaw, snap: this.snap, ...(size ? { size } : {}) }, {
      renew: size !== null,
      shown: ({ object }) => {
        Object.assign(one, object);
        if (this.name === name) this.choose(name);
        if (!size && this.objects.get(name) === one) this.show(object, one);
      },
    });
  }

  act(command, given) {
    if (this.one) this.held.send(command, { name: this.name, ...given });
  }

  async duplicate() {
    if (!this.one) return;
    // It is selected when the room is read anew, which knows it.
    await this.held.send("duplicate", { name: this.name }, { shown: ({ object }) => { this.name = object.name; } });
  }

  remove() {
    if (!this.one) return;
    this.room.hide([...this.room.hidden, this.one.path]);
    this.act("remove", {});
  }
}

/** The object that a prim is a part of. */
function nameOf(path) {
  return path?.startsWith(ROOT) ? path.slice(ROOT.length).split("/")[0] : null;
}

/** A place of an object's own frame in the room. */
function there({ x, y, yaw }, [across, along], z) {
  const [s, c] = [Math.sin(yaw * Math.PI / 180), Math.cos(yaw * Math.PI / 180)];
  return [x + c * across - s * along, y + s * across + c * along, z + 0.01];
}
