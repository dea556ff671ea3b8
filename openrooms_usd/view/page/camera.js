// Where a picture is taken from, and how mouse and keys move it: around a point, or on foot.

import * as m from "orusd/matrix.js";

const EYE_HEIGHT_M = 1.6;
const STEP_M_S = 1.8;
const NEAR_M = 0.02;
const FAR_M = 400;
const TURN = 0.005;
const STEEPEST = Math.PI / 2 - 0.001;
// OpenCV's axes of a camera (right, down, forward) to WebGL's (right, up, backward).
const FLIP = [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1];
// Where keys are letters.
export const WRITING = "input:not([type=checkbox]):not([type=range]), select, textarea";
const KEYS = { KeyW: [0, 1], ArrowUp: [0, 1], KeyS: [0, -1], ArrowDown: [0, -1],
  KeyA: [-1, 0], ArrowLeft: [-1, 0], KeyD: [1, 0], ArrowRight: [1, 0] };

/**
 * A camera on a canvas. Left drag turns, right drag or Shift moves aside, the wheel goes nearer, two
 * fingers do both;
 * in `walk` the eye stays at 1.6 m, drags turn the head, W A S D or arrows go.
 */
export class Camera {
  constructor(canvas, changed) {
    Object.assign(this, { canvas, changed, mode: "orbit", target: [0, 0, 1], distance: 6,
      yaw: 0.8, pitch: -0.4, lens: { focal: 0.9, right: 0, down: 0 }, exact: null, floor: 0, box: null });
    /** While it returns true, another handler has the drags. */
    this.held = () => false;
    this.listen();
  }

  /** Metres, in the room's frame. */
  get eye() { return this.exact ? this.exact.slice(12, 15) : m.add(this.target, this.forward, -this.distance); }

  get forward() {
    if (this.exact) return [-this.exact[8], -this.exact[9], -this.exact[10]];
    const flat = Math.cos(this.pitch);
    return [flat * Math.cos(this.yaw), flat * Math.sin(this.yaw), Math.sin(this.pitch)];
  }

  /** To the world from the camera: right, up, backward. */
  get pose() {
    if (this.exact) return this.exact;
    const [back, eye] = [this.forward.map((v) => -v), this.eye];
    const right = [Math.sin(this.yaw), -Math.cos(this.yaw), 0];
    return [...right, 0, ...m.cross(back, right), 0, ...back, 0, ...eye, 1];
  }

  /** To WebGL's cube from the world, for a picture of this size. */
  matrix(width, height) {
    const { focal, right, down } = this.lens;
    const [x, y] = [2 * focal, 2 * focal * width / height];
    const projection = [
      x, 0, 0, 0, 0, y, 0, 0,
      -2 * right, 2 * down * width / height, -(FAR_M + NEAR_M) / (FAR_M - NEAR_M), -1,
      0, 0, -2 * FAR_M * NEAR_M / (FAR_M - NEAR_M), 0,
    ];
    return m.multiply(projection, m.inverse(this.pose));
  }

  /** Where a place is in a picture of this size, pixels from the top left; null behind it. */
  project(place, width = this.canvas.clientWidth, height = this.canvas.clientHeight) {
    const c = this.matrix(width, height);
    const at = [0, 1, 3].map((r) => c[r] * place[0] + c[4 + r] * place[1] + c[8 + r] * place[2] + c[12 + r]);
    if (at[2] <= 0) return null;
    return [(at[0] / at[2] + 1) / 2 * width, (1 - at[1] / at[2]) / 2 * height];
  }

  /** The ray through a pixel of the canvas: { origin, direction }, of length one. */
  ray(x, y, width = this.canvas.clientWidth, height = this.canvas.clientHeight) {
    const { focal, right, down } = this.lens;
    const local = [(x / width - 0.5 - right) / focal, -((y - height / 2) / width - down) / focal, -1];
    return { origin: this.eye, direction: m.unit(m.direction(this.pose, local)) };
  }

  /**
   * Jump into a camera of the stage.
   * world_from_camera: (4, 4) rows, OpenCV; focal, right, down: parts of the picture's width.
   */
  jump({ world_from_camera, focal, right = 0, down = 0 }) {
    this.settle(m.multiply(m.fromRows(world_from_camera), FLIP));
    this.exact = m.multiply(m.fromRows(world_from_camera), FLIP);
    this.lens = { focal, right, down };
    this.changed();
  }

  /** Show a box from outside: two corners. */
  frame(low, high) {
    this.exact = null;
    this.target = low.map((v, k) => (v + high[k]) / 2);
    // A little nearer than where the whole ball about the box is seen.
    const { clientWidth, clientHeight } = this.canvas;
    const half = Math.atan(0.5 / this.lens.focal * Math.min(1, clientHeight / clientWidth));
    this.distance = 0.43 * m.length(m.add(high, low, -1)) / Math.sin(half);
    this.changed();
  }

  /** Go on freely from a pose that may be tilted. */
  settle(pose = this.exact) {
    if (!pose) return;
    const forward = [-pose[8], -pose[9], -pose[10]];
    this.yaw = Math.atan2(forward[1], forward[0]);
    this.pitch = Math.max(-STEEPEST, Math.min(STEEPEST, Math.asin(Math.max(-1, Math.min(1, forward[2])))));
    this.distance = this.mode === "walk" ? 0.001 : Math.min(this.distance, 3);
    this.exact = null;
    this.target = m.add(pose.slice(12, 15), this.forward, this.distance);
  }

  /** Walk, or go around. */
  become(mode) {
    this.settle();
    const { eye } = this;
    this.mode = mode;
    this.distance = mode === "walk" ? 0.001 : 3;
    this.target = m.add(eye, this.forward, this.distance);
    if (mode === "walk") this.enter(eye);
    this.changed();
  }

  /** Stand on the floor, inside of the room. */
  enter(eye) {
    const { box } = this;
    const inside = !box || [0, 1].every((k) => eye[k] > box[0][k] && eye[k] < box[1][k]);
    const stand = inside ? [...eye] : [0, 1, 2].map((k) => (box[0][k] + box[1][k]) / 2);
    stand[2] = this.floor + EYE_HEIGHT_M;
    this.pitch = inside ? this.pitch : -0.1;
    this.target = m.add(stand, this.forward, this.distance);
  }

  turned(dx, dy) {
    this.settle();
    const sign = this.mode === "walk" ? -1 : 1;
    const { eye } = this;
    this.yaw -= sign * dx * TURN;
    this.pitch = Math.max(-STEEPEST, Math.min(STEEPEST, this.pitch - sign * dy * TURN));
    if (this.mode === "walk") this.target = m.add(eye, this.forward, this.distance);
    this.changed();
  }

  moved(dx, dy) {
    this.settle();
    const scale = Math.max(this.distance, 1) / (this.lens.focal * this.canvas.clientWidth);
    this.target = m.add(m.add(this.target, this.pose.slice(0, 3), -dx * scale), this.pose.slice(4, 7), dy * scale);
    this.changed();
  }

  /** One of two fingers goes on while the other rests. */
  pinched(other, last, now) {
    const [before, after] = [last, now].map((at) => Math.max(1, Math.hypot(at[0] - other[0], at[1] - other[1])));
    this.moved((now[0] - last[0]) / 2, (now[1] - last[1]) / 2);
    this.nearer(1000 * Math.log(before / after));
  }

  nearer(amount) {
    this.settle();
    if (this.mode === "walk") return;
    this.distance = Math.max(0.05, this.distance * Math.exp(amount * 0.001));
    this.changed();
  }

  listen() {
    const { canvas } = this;
    const down = new Map();
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => {
      if (this.held(event)) return;
      down.set(event.pointerId, [event.clientX, event.clientY]);
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const last = down.get(event.pointerId);
      if (!last || this.held(event)) return;
      const now = [event.clientX, event.clientY];
      const [dx, dy] = [now[0] - last[0], now[1] - last[1]];
      down.set(event.pointerId, now);
      if (!dx && !dy) return;
      const other = [...down].find(([id]) => id !== event.pointerId)?.[1];
      if (other) this.pinched(other, last, now);
      else if (event.shiftKey || event.buttons & 6) this.moved(dx, dy);
      else this.turned(dx, dy);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => down.delete(event.pointerId));
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.nearer(event.deltaY); }, { passive: false });
    this.listenToKeys();
  }

  listenToKeys() {
    const down = new Set();
    let before = 0;
    const go = (now) => {
      if (!down.size || this.mode !== "walk") { before = 0; return; }
      const passed = before ? Math.min((now - before) / 1000, 0.1) : 1 / 60;
      before = now;
      this.settle();
      const [side, ahead] = [...down].map((key) => KEYS[key]).reduce(([a, b], [c, d]) => [a + c, b + d], [0, 0]);
      const way = [Math.cos(this.yaw) * ahead + Math.sin(this.yaw) * side,
        Math.sin(this.yaw) * ahead - Math.cos(this.yaw) * side, 0];
      this.target = m.add(this.target, way, STEP_M_S * passed);
      this.changed();
      requestAnimationFrame(go);
    };
    addEventListener("keydown", (event) => {
      if (!(event.code in KEYS) || this.mode !== "walk" || event.target.matches(WRITING)) return;
      event.preventDefault();
      const first = !down.size;
      down.add(event.code);
      if (first) requestAnimationFrame(go);
    });
    addEventListener("keyup", (event) => down.delete(event.code));
    addEventListener("blur", () => down.clear());
  }
}
