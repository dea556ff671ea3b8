// `orusd edit materials STAGE`: click a part, see what it is made of, choose something else.

import { Correcting } from "orusd/correcting.js";
import { button, choice, complain, element, facts, row, section } from "orusd/panel.js";
import * as source from "orusd/source.js";

/** Fill the page. */
export async function start(root) {
  const page = new Page();
  const held = await Correcting.open(root, (state) => page.renew(state), [["click", "select a part"]]);
  page.fill(held, await source.state());
}

class Page {
  constructor() {
    this.path = null;
    this.state = null;
    this.pictures = new Map();
  }

  fill(held, state) {
    this.held = held;
    this.about = element("div", { id: "about" });
    this.families = element("div", { id: "families", className: "swatches" });
    this.number = element("input", { id: "number", type: "number", min: 0, max: state.numbers - 1, value: 0 });
    this.number.addEventListener("change", () => this.offer());
    held.panel.append(
      section("Part", "part", this.about),
      section("Made of", "materials",
        choice("scope", "for", Object.entries(state.scopes), "part", () => this.mark()),
        choice("substance", "substance", Object.keys(state.library), "wood", () => this.offer()),
        row("number", this.number),
        this.families,
        button("reset", "as it was composed", () => this.reset())),
    );
    held.room.onPick((found) => this.choose(found?.path ?? null));
    this.renew(state);
    this.offer();
  }

  renew(state) {
    this.state = state;
    this.known = new Map(state.prims.map((prim) => [prim.path, prim]));
    this.objects = new Set(Object.keys(state.made).map(objectOf));
    if (this.held) this.choose(this.path);
  }

  get scope() { return document.getElementById("scope").value; }

  choose(path) {
    const before = this.path;
    this.path = this.state.made[path] ? path : null;
    document.body.dataset.part = this.path ?? "";
    this.mark();
    if (!this.path) return this.about.replaceChildren(element("p", { className: "told" }, "click a part of the room"));
    const { material, substance, family, number } = this.state.made[this.path];
    const object = objectOf(this.path);
    this.about.replaceChildren(facts("facts", {
      object: object.slice(object.lastIndexOf("/") + 1), category: this.category(object),
      part: this.known.get(this.path)?.part, substance, family, number, material,
    }));
    if (substance && this.path !== before) {
      document.getElementById("substance").value = substance;
      if (number !== undefined) this.number.value = number;
      this.offer();
    }
    this.families.querySelectorAll(".chosen").forEach((one) => one.classList.remove("chosen"));
    this.families.querySelector(`[data-family="${family}"]`)?.classList.add("chosen");
  }

  category(path) {
    for (let end = path; end; end = end.slice(0, end.lastIndexOf("/")))
      if (this.known.get(end)?.category) return this.known.get(end).category;
    return null;
  }

  /** Mark what is meant. */
  mark() {
    if (!this.path) return this.held.room.select([]);
    const object = objectOf(this.path);
    const category = this.category(object);
    const of_kind = () => [...this.objects].filter((path) => this.category(path) === category);
    const kind = (path) => this.known.get(path)?.part?.replace(/_\d+$/, "");
    this.held.room.select({
      part: () => [this.path],
      object: () => [object],
      category: of_kind,
      alike: () => {
        const roots = new Set(of_kind());
        return Object.keys(this.state.made).filter((path) => roots.has(objectOf(path)) && kind(path) === kind(this.path));
      },
    }[this.scope]());
  }

  /** The families of a substance as buttons with pictures. */
  offer() {
    const substance = document.getElementById("substance").value;
    const number = Math.max(0, Math.min(this.state.numbers - 1, Math.round(Number(this.number.value) || 0)));
    this.families.replaceChildren(...Object.entries(this.state.library[substance]).map(([family, size]) => {
      const image = element("img", { alt: family, width: 56, height: 56 });
      this.picture(family, number).then((address) => { image.src = address; }, complain);
      return element("button", { type: "button", "data-family": family, title: `${family}, ${size} m`,
        onclick: () => this.assign(family, number, image) }, image, element("span", {}, family.replaceAll("_", " ")));
    }));
  }

  picture(family, number) {
    const name = `material/${family}/${number}.png`;
    if (!this.pictures.has(name))
      this.pictures.set(name, source.resource(name).then((bytes) => URL.createObjectURL(new Blob([bytes], { type: "image/png" }))));
    return this.pictures.get(name);
  }

  assign(family, number, image) {
    if (!this.path) return complain(new Error("click a part of the room first"));
    const color = mean(image);
    this.held.send("assign", { path: this.path, scope: this.scope, look: { family, number } }, {
      shown: ({ parts }) => {
        this.held.room.select([]);
        this.held.room.redress(parts, color);
      },
      words: `${family} ${number}: saved in edits.usda`,
    });
  }

  reset() {
    if (!this.path) return complain(new Error("click a part of the room first"));
    this.held.send("reset", { path: this.path, scope: this.scope });
  }
}

/** The object that a part belongs to; of the shell the part itself. */
function objectOf(path) {
  for (const group of ["/World/Furniture/", "/World/Room/Openings/"])
    if (path.startsWith(group)) return group + path.slice(group.length).split("/")[0];
  return path;
}

/** The mean colour of a picture of a ball, scene-linear: what is seen until the room is read anew. */
function mean(image) {
  if (!image.naturalWidth) return [0.5, 0.5, 0.5];
  const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight);
  const pen = canvas.getContext("2d");
  pen.drawImage(image, 0, 0);
  const { data } = pen.getImageData(0, 0, canvas.width, canvas.height);
  const sum = [0, 0, 0, 0];
  for (let k = 0; k < data.length; k += 4) {
    if (data[k + 3] < 255) continue;
    for (let c = 0; c < 3; c += 1) sum[c] += (data[k + c] / 255) ** 2.2;
    sum[3] += 1;
  }
  return sum.slice(0, 3).map((value) => Math.min(1, value / Math.max(sum[3], 1)));
}
