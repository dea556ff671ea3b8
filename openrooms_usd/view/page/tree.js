// Prims as a tree: branches open on demand, one prim is selected.

import { element } from "orusd/panel.js";

/**
 * A tree of prims.
 *
 * prims: { path, category?, kind? } with parents before children.
 * chosen: called with the path of one that is clicked.
 * Gives { root, choose(path) }.
 */
export function tree(prims, chosen) {
  const below = new Map();
  for (const prim of prims) {
    const parent = prim.path.slice(0, prim.path.lastIndexOf("/"));
    if (!below.has(parent)) below.set(parent, []);
    below.get(parent).push(prim);
  }
  const items = new Map();
  let marked = null;

  const list = (parent, depth) => element("ul", { role: depth ? "group" : "tree" },
    ...(below.get(parent) ?? []).map((prim) => item(prim, depth)));

  const item = (prim, depth) => {
    const made = element("li", { role: "treeitem", "data-path": prim.path });
    const more = below.has(prim.path);
    const fold = element("button", { className: "fold", type: "button", tabIndex: -1 }, more ? "▸" : "");
    const name = element("button", { className: "name", type: "button", onclick: () => chosen(prim.path) },
      prim.path.slice(prim.path.lastIndexOf("/") + 1),
      element("span", { className: "told" }, prim.category ? ` ${prim.category}` : ""));
    made.append(fold, name);
    items.set(prim.path, made);
    made.open = (open) => {
      if (!more) return;
      fold.textContent = open ? "▾" : "▸";
      made.setAttribute("aria-expanded", open);
      if (open && !made.inside) made.append(made.inside = list(prim.path, depth + 1));
      if (made.inside) made.inside.hidden = !open;
    };
    fold.addEventListener("click", () => made.open(made.inside ? made.inside.hidden : true));
    if (depth < 1) made.open(true);
    return made;
  };

  const root = list("", 0);
  root.className = "tree";
  /** Open all that a prim is below, and mark it; null marks nothing. */
  const choose = (path) => {
    path ??= "";
    for (let end = path.indexOf("/", 1); end > 0; end = path.indexOf("/", end + 1))
      items.get(path.slice(0, end))?.open(true);
    marked?.classList.remove("chosen");
    marked = items.get(path)?.querySelector(".name") ?? null;
    marked?.classList.add("chosen");
    marked?.scrollIntoView({ block: "nearest" });
  };
  return { root, choose };
}
