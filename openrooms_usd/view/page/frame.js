// What surrounds every page: the panel that folds, help by `?`, and keys for all.

import { WRITING } from "orusd/camera.js";
import { button, element } from "orusd/panel.js";

const NARROW = matchMedia("(max-width: 700px)");

/** Put a button before a panel that folds it away; in narrow windows it starts folded. */
export function folding(panel) {
  const fold = button("fold", "", () => set(!panel.hidden));
  const set = (closed) => {
    panel.hidden = closed;
    fold.textContent = closed ? "☰" : "×";
    fold.title = closed ? "show the panel" : "hide the panel";
    fold.setAttribute("aria-expanded", String(!closed));
  };
  set(NARROW.matches);
  panel.before(fold);
}

/** Help: what mouse, fingers and keys do. rows: [what is pressed, what it does]. */
export function helping(rows) {
  const list = rows.flatMap(([pressed, does]) => [element("dt", {}, pressed), element("dd", {}, does)]);
  const close = button("help-close", "close", () => dialog.close());
  const dialog = element("dialog", { id: "help" }, element("dl", { className: "facts" }, ...list), close);
  const open = button("help-open", "?", () => dialog.showModal());
  open.title = "mouse and keys (?)";
  document.body.append(dialog, open);
  addEventListener("keydown", (event) => {
    if (event.key !== "?" || event.target.matches(WRITING)) return;
    event.preventDefault();
    if (dialog.open) dialog.close();
    else dialog.showModal();
  });
}

/** Undo and redo by the keys that programs use for them. */
export function undoing(undo, redo) {
  addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.target.matches(WRITING)) return;
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    if (key === "y" || event.shiftKey) redo();
    else undo();
  });
}

/** What moves a picture of a room on every page. */
export const MOVING = [
  ["left drag, one finger", "turn"],
  ["right drag, Shift and drag, two fingers", "move sideways"],
  ["wheel, pinch", "nearer, farther"],
  ["F", "fit the room into the window"],
];
