// A room on a canvas: what it shows, what is picked, what is moved.

import { Camera, WRITING } from "orusd/camera.js";
import { Frame, buffer, context, program } from "orusd/gl.js";
import { parse } from "orusd/glb.js";
import * as m from "orusd/matrix.js";
import { Picking } from "orusd/picking.js";
import { LINES, SHOWN, VERTEX } from "orusd/shading.js";
import { Surfaces } from "orusd/surfaces.js";
import { fitted, raised } from "orusd/tone.js";

const MARK = [0.16, 0.55, 1];
const TONES = { srgb: 0, film: 1, photograph: 2 };
// A press that moves farther than this is not a click, pixels.
const CLICK_PX = 4;
// What hangs on a wall is so near to it, metres.
const BESIDE_M = 0.05;
const NOTHING = { nodes: [], meshes: [], materials: [], textures: [], images: [] };
const BACK = [0.62, 0.68, 0.74];

/** See the top of room.js. */
export class Room {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = context(canvas);
    this.camera = new Camera(canvas, () => this.draw());
    this.picking = new Picking(this.gl);
    this.shown = program(this.gl, VERTEX, SHOWN);
    this.lines = program(this.gl, LINES.vertex, LINES.fragment);
    this.surfaces = null;
    /** A Light of light.js, or null for a headlight. */
    this.light = null;
    this.tone = { name: "photograph", exposure: 1, balance: [1, 1, 1], slope: 1, stops: 0 };
    this.matt = 1;
    this.outside = true;
    this.shell = [];
    this.hung = [];
    this.overlays = new Map();
    /** Finds a point of a scan at a place of the canvas, where one is shown. */
    this.points = null;
    /** Called with a camera of the state after the user has jumped to it. */
    this.jumps = [];
    this.handlers = { pick: [], draw: [] };
    /** Called with what is clicked in place of all who listen, while a tool is in use. */
    this.tool = null;
    this.hidden = new Set();
    this.wanted = false;
    new ResizeObserver(() => this.draw()).observe(canvas);
    this.listen();
  }

  /** Show another GLB file; what is marked and moved stays so. */
  async load(buffer) {
    const before = this.surfaces;
    const made = new Surfaces(this.gl, buffer ? await parse(buffer) : NOTHING);
    if (before) {
      [made.marked, made.moves] = [before.marked, before.moves];
      before.remove();
    }
    this.surfaces = made;
    this.refresh();
  }

  select(paths) {
    this.surfaces.marked = new Set(paths);
    this.refresh();
  }

  move(path, matrix) {
    if (matrix === null) this.surfaces.moves.delete(path);
    else this.surfaces.moves.set(path, matrix);
    this.refresh();
  }

  hide(paths) {
    this.hidden = new Set(paths);
    this.refresh();
  }

  /** Show prims in a plain colour until another file is loaded. */
  redress(paths, color) {
    this.surfaces.redress(paths, color);
    this.draw();
  }

  onPick(handler) { this.handlers.pick.push(handler); }

  onDraw(handler) { this.handlers.draw.push(handler); }

  /** What is at a place of the canvas, pixels from its top left: see `Picking.at`. */
  at(x, y, through = false) {
    const { clientWidth, clientHeight } = this.canvas;
    this.follow();
    return this.picking.at(this.surfaces, this.camera, x, y, clientWidth, clientHeight, through)
      ?? this.points?.(x, y) ?? null;
  }

  labels(width, height, through = true) {
    this.follow();
    return this.picking.labels(this.surfaces, this.camera, width, height, through);
  }

  bounds(paths) { return this.surfaces.bounds(paths); }

  /**
   * Lines (pairs of points), dots or triangles over the picture, by a name; null takes them away.
   * points: [[x, y, z], ...]; how: { color, kind: "lines" | "points" | "triangles", size, over, alpha };
   * colors: one for each point, in place of `color`.
   */
  overlay(name, points, { color = MARK, kind = "lines", size = 6, over = false, colors = null, alpha = 1 } = {}) {
    const { gl } = this;
    const before = this.overlays.get(name);
    if (before) [before.places, before.paint].forEach((one) => gl.deleteBuffer(one));
    this.overlays.delete(name);
    if (points?.length) {
      const flat = points instanceof Float32Array ? points : new Float32Array(points.flat());
      const paint = colors instanceof Float32Array ? colors
        : new Float32Array(colors?.flat() ?? Array.from({ length: flat.length / 3 }, () => color).flat());
      this.overlays.set(name, { places: buffer(gl, flat), paint: buffer(gl, paint),
        count: flat.length / 3, kind, size, over, alpha });
    }
    this.draw();
  }

  /** Bring marks, moves and hidden things to the screen. */
  refresh() {
    this.cut();
    this.surfaces.refresh(this.light ? (path) => this.light.glow(path) : undefined);
    this.draw();
  }

  /** Draw as soon as the browser is ready for it. */
  draw() {
    if (this.wanted) return;
    this.wanted = true;
    requestAnimationFrame(() => {
      this.wanted = false;
      if (!this.surfaces || !this.canvas.clientWidth) return;
      const ratio = devicePixelRatio || 1;
      const size = [this.canvas.clientWidth, this.canvas.clientHeight].map((side) => Math.round(side * ratio));
      if (size[0] !== this.canvas.width || size[1] !== this.canvas.height)
        [this.canvas.width, this.canvas.height] = size;
      this.follow();
      this.paint(null, ...size);
      this.handlers.draw.forEach((handler) => handler(this));
    });
  }

  /** Leave out what the camera does not want any more. */
  follow() {
    if (this.cut()) this.surfaces.refresh(this.surfaces.glow);
  }

  /** From outside, what stands between the eye and the room is left out; whether that changed. */
  cut() {
    const eye = this.camera.eye;
    const hidden = new Set(this.hidden);
    if (this.outside && this.shell.length) {
      const { box } = this;
      const inside = eye.every((value, k) => value > box[0][k] - 0.3 && value < box[1][k] + 0.3);
      if (!inside) for (const { path, middle, normal } of this.shell)
        if (m.dot(m.add(eye, middle, -1), normal) > 0) hidden.add(path);
      for (const { path, walls } of this.hung)
        if (walls.length && walls.every((wall) => hidden.has(wall))) hidden.add(path);
    }
    const before = this.surfaces.hidden;
    if (before.size === hidden.size && [...hidden].every((path) => before.has(path))) return false;
    this.surfaces.hidden = hidden;
    return true;
  }

  /** What the room's shell is made of: walls, ceilings and what is in them; hung: what hangs there. */
  enclose(paths, hung = []) {
    this.box = this.bounds(paths);
    if (!this.box) return;
    this.camera.box = this.box;
    const middle = this.box[0].map((value, k) => (value + this.box[1][k]) / 2);
    this.shell = paths.map((path) => ({ path, box: this.bounds([path]) })).filter(({ box }) => box)
      .map(({ path, box: [low, high] }) => {
        const at = low.map((value, k) => (value + high[k]) / 2);
        const size = high.map((value, k) => value - low[k]);
        const thin = size.indexOf(Math.min(...size));
        const normal = [0, 0, 0];
        normal[thin] = Math.sign(at[thin] - middle[thin]) || 1;
        return { path, middle: at, normal, box: [low, high] };
      });
    this.hung = hung.map((path) => ({ path, walls: this.wallsOf(this.bounds([path])) }));
    this.refresh();
  }

  /** The parts of the shell beside which a box stands upright. */
  wallsOf(box) {
    const near = ({ box: [low, high], normal }) => !normal[2] && box[0].every((value, k) => (
      value < high[k] + BESIDE_M && box[1][k] > low[k] - BESIDE_M));
    return box ? this.shell.filter(near).map(({ path }) => path) : [];
  }

  /** Draw into a frame, or on the canvas; output: 0 for people, 1 light in nits, 2 base colour. */
  paint(frame, width, height, output = 0) {
    const { gl, camera, shown, light, surfaces } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame?.made ?? null);
    gl.viewport(0, 0, width, height);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    gl.clearColor(...(output ? [0, 0, 0] : BACK), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (light?.skies.length && output < 2) this.paintSky(width, height, output);
    gl.useProgram(shown.program);
    gl.uniformMatrix4fv(shown.at("u_camera"), false, camera.matrix(width, height));
    gl.uniform3f(shown.at("u_eye"), ...camera.eye);
    this.expose(shown.at, output);
    gl.uniform1f(shown.at("u_matt"), this.matt);
    gl.uniform3f(shown.at("u_mark"), ...MARK);
    gl.uniform3f(shown.at("u_mean"), ...(light?.mean ?? [0, 0, 0]));
    gl.uniform1i(shown.at("u_light"), 3);
    const lit = ({ atlas }) => {
      const map = light?.atlas(atlas) ?? null;
      gl.activeTexture(gl.TEXTURE3);
      gl.bindTexture(gl.TEXTURE_2D, map?.texture ?? surfaces.white);
      gl.uniform1f(shown.at("u_unit"), map?.scale ?? 1);
      gl.uniform1i(shown.at("u_lit"), light === null ? 0 : map === null ? 2 : 1);
    };
    surfaces.draw(shown.at, surfaces.groups.filter((group) => !group.see_through), lit);
    if (output) return;
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    surfaces.draw(shown.at, surfaces.groups.filter((group) => group.see_through), lit);
    gl.depthMask(true);
    this.paintOverlays(width, height);
  }

  expose(at, output) {
    const { gl } = this;
    const { exposure, balance, slope, stops, name } = this.tone;
    gl.uniform3f(at("u_exposure"), ...balance.map((factor) => factor * exposure * 2 ** stops));
    gl.uniform1f(at("u_slope"), slope);
    gl.uniform1i(at("u_tone"), TONES[name]);
    gl.uniform1i(at("u_output"), output);
  }

  paintSky(width, height, output) {
    const { gl, camera, light: { behind: { program: made, at }, seen, openings } } = this;
    const { focal, right, down } = camera.lens;
    const { pose } = camera;
    gl.useProgram(made);
    gl.disable(gl.DEPTH_TEST);
    this.expose(at, output);
    seen.forEach(({ texture, sky_from_world: local }, k) => {
      gl.activeTexture(gl.TEXTURE0 + k);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.uniform1i(at(`u_sky${k}`), k);
      gl.uniformMatrix3fv(at(`u_local${k}`), false, local);
    });
    gl.uniform2f(at("u_scales"), ...seen.map(({ scale }) => scale));
    gl.uniform3f(at("u_eye"), ...camera.eye);
    gl.uniform1i(at("u_openings"), openings.length);
    openings.forEach(({ matrix, half, weight }, k) => {
      gl.uniformMatrix4fv(at(`u_portals[${k}]`), false, matrix);
      gl.uniform2f(at(`u_halves[${k}]`), ...half);
      gl.uniform3f(at(`u_weights[${k}]`), ...weight);
    });
    gl.uniformMatrix3fv(at("u_pose"), false, [0, 4, 8].flatMap((k) => [...pose.slice(k, k + 3)]));
    gl.uniform4f(at("u_lens"), 2 * focal, 2 * focal * width / height, 2 * right, 2 * down * width / height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.enable(gl.DEPTH_TEST);
  }

  /** Let the exposure fit what is seen, as a camera would; exposure: that of the camera, or null. */
  meter(exposure = null) {
    if (!this.light) return;
    const [width, height] = [160, Math.round(160 * this.canvas.clientHeight / this.canvas.clientWidth)];
    Object.assign(this.tone, fitted(this.radiance(width, height), width, height, exposure), { stops: 0 });
    if (exposure === null) Object.assign(this.tone, raised(this.tone, this.codes(width, height)));
    this.draw();
  }

  paintOverlays(width, height) {
    const { gl, lines } = this;
    gl.useProgram(lines.program);
    gl.uniformMatrix4fv(lines.at("u_camera"), false, this.camera.matrix(width, height));
    for (const { places, paint, count, kind, size, over, alpha } of this.overlays.values()) {
      if (over) gl.disable(gl.DEPTH_TEST);
      [places, paint].forEach((one, place) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, one);
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
      });
      gl.uniform1f(lines.at("u_size"), size * (devicePixelRatio || 1));
      gl.uniform1f(lines.at("u_alpha"), alpha);
      gl.drawArrays({ lines: gl.LINES, points: gl.POINTS, triangles: gl.TRIANGLES }[kind], 0, count);
      gl.enable(gl.DEPTH_TEST);
    }
  }

  /** The light that a picture of this size shows, four floats a pixel, rows from the top. */
  radiance(width, height, output = 1) {
    this.follow();
    const frame = new Frame(this.gl, width, height, [this.gl.RGBA32F]);
    this.paint(frame, width, height, output);
    const pixels = frame.pixels();
    frame.remove();
    return pixels;
  }

  /** What people see of a picture of this size, four bytes a pixel, rows from the top. */
  codes(width, height) {
    this.follow();
    const frame = new Frame(this.gl, width, height, [this.gl.RGBA8]);
    this.paint(frame, width, height);
    const pixels = frame.pixels(0, Uint8Array);
    frame.remove();
    return pixels;
  }

  /** See the whole room, from where it is looked at. */
  fit() {
    const box = this.box ?? this.bounds();
    if (box) this.camera.frame(...box);
  }

  listen() {
    addEventListener("keydown", (event) => {
      if (event.key.toLowerCase() !== "f" || event.ctrlKey || event.metaKey || event.target.matches(WRITING)) return;
      this.fit();
    });
    let start = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      start = event.isPrimary ? [event.clientX, event.clientY] : null;
    });
    this.canvas.addEventListener("pointerup", (event) => {
      const near = start && Math.hypot(event.clientX - start[0], event.clientY - start[1]) <= CLICK_PX;
      start = null;
      if (!near || event.button !== 0 || !this.surfaces) return;
      const found = this.at(event.offsetX, event.offsetY);
      for (const handler of this.tool ? [this.tool] : this.handlers.pick) handler(found, event);
    });
  }
}
