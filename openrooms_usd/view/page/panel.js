// Small parts of the panel beside a picture; each has an id, so that people and tests find it.

/** An element: its tag, its properties (`data-` ones too), and what is inside. */
export function element(tag, said = {}, ...inside) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(said))
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name.includes("-") || name === "for" || name === "role") made.setAttribute(name, value);
    else made[name] = value;
  made.append(...inside);
  return made;
}

/** A heading with rows below it. */
export const section = (title, id, ...rows) => element("section", { id }, element("h2", {}, title), ...rows);

/** A row with a label. */
export const row = (label, ...inside) => element("div", { className: "row" }, element("label", { title: label }, label), ...inside);

/** A slider: `changed(value)` while it is dragged; words: what is said of a value in place of its number. */
export function slider(id, label, { min = 0, max = 1, step = 0.01, value = min, unit = "", words = null }, changed) {
  const told = element("output", { className: "told" });
  const input = element("input", { type: "range", id, min, max, step });
  input.value = value;
  const number = (now) => `${now.toFixed(step < 1 ? 2 : 0)}${unit}`;
  const tell = () => { told.textContent = (words ?? number)(Number(input.value)); };
  input.addEventListener("input", () => { tell(); changed(Number(input.value)); });
  tell();
  return row(label, input, told);
}

/** Set a slider as if the user had dragged it. */
export function slide(id, value) {
  const input = document.getElementById(id);
  input.value = value;
  input.dispatchEvent(new Event("input"));
}

/** A button. */
export const button = (id, label, pressed) => element("button", { id, type: "button", onclick: pressed }, label);

/** A box to tick. */
export function tick(id, label, checked, changed) {
  const input = element("input", { type: "checkbox", id, checked, onchange: () => changed(input.checked) });
  return element("div", { className: "row" }, input, element("label", { for: id }, label));
}

/** One of several: options are words, or [value, words]. */
export function choice(id, label, options, value, changed) {
  const list = options.map((option) => [option].flat());
  const input = element("select", { id, onchange: () => changed(input.value) },
    ...list.map(([key, words = key]) => element("option", { value: key }, words)));
  input.value = value;
  return row(label, input);
}

/** A table of what is known: empty values are left out. */
export function facts(id, known) {
  const rows = Object.entries(known).filter(([, value]) => value !== null && value !== undefined && value !== "");
  return element("dl", { id, className: "facts" }, ...rows.flatMap(([name, value]) => [
    element("dt", {}, name), element("dd", { "data-fact": name }, ...(value instanceof Node ? [value] : [String(value)])),
  ]));
}

/** Say what went wrong, with place and remedy, in the element with the id `told`. */
export function complain(error) {
  const words = [error.message, error.place, error.remedy && `→ ${error.remedy}`].filter(Boolean).join("\n");
  const told = document.getElementById("told");
  if (!told) throw error;
  told.className = "wrong";
  told.textContent = words;
}

/** Say something in the same place. */
export function tell(words) {
  const told = document.getElementById("told");
  told.className = "told";
  told.textContent = words;
}
