// Drawings in metres: elements of SVG, where the mouse is in them, and how far it must go.

const SPACE = "http://www.w3.org/2000/svg";

/** An SVG element with attributes, inside of a parent. */
export function shape(parent, name, attributes = {}) {
  const made = document.createElementNS(SPACE, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  parent.append(made);
  return made;
}

/** A line between two points. */
export function segment(parent, [[x1, y1], [x2, y2]], attributes = {}) {
  return shape(parent, "line", { x1, y1, x2, y2, ...attributes });
}

/** Where an event is in a group's own coordinates. */
export function placeOf(group, event) {
  const point = new DOMPoint(event.clientX, event.clientY);
  const { x, y } = point.matrixTransform(group.getScreenCTM().inverse());
  return [x, y];
}

const STILL_PX = 3;

/**
 * Follow the mouse from where it was pressed.
 *
 * `moved(from, to)` is called on the way and `dropped(from, to)` at the end, with places in the
 * group's coordinates; `clicked(from)` where it has hardly moved.
 */
export function follow(event, group, { moved, dropped, clicked }) {
  event.preventDefault();
  event.stopPropagation();
  const from = placeOf(group, event);
  const before = [event.clientX, event.clientY];
  let far = false;
  const way = (now) => Math.hypot(now.clientX - before[0], now.clientY - before[1]);
  const move = (now) => {
    far ||= way(now) > STILL_PX;
    if (far) moved?.(from, placeOf(group, now));
  };
  const up = (now) => {
    window.removeEventListener("pointermove", move);
    window.removeEventListener("pointerup", up);
    window.removeEventListener("pointercancel", up);
    if (far || way(now) > STILL_PX) dropped?.(from, placeOf(group, now));
    else clicked?.(from);
  };
  window.addEventListener("pointermove", move);
  window.addEventListener("pointerup", up);
  window.addEventListener("pointercancel", up);
}
