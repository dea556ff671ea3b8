// The light of a room from lightmaps: each lamp and opening at each moment, added up as sliders say.

import { Frame, filters, program } from "orusd/gl.js";
import { fromRows } from "orusd/matrix.js";
import { ADDED, MOST_OPENINGS, SKY, WHOLE } from "orusd/shading.js";
import { resource } from "orusd/source.js";

/** Lamps, openings and skies of a room. told: `light` of the state. */
export class Light {
  static async open(gl, told) {
    const names = [...Object.values(told.atlases), ...told.skies];
    const buffers = await Promise.all(names.map(({ resource: name }) => resource(name)));
    return new Light(gl, told, new Map(names.map(({ resource: name }, k) => [name, buffers[k]])));
  }

  constructor(gl, told, buffers) {
    Object.assign(this, { gl, told, lights: told.lights });
    this.added = program(gl, WHOLE, ADDED);
    this.behind = program(gl, WHOLE, SKY);
    /** Of each light: whether it is on, by how much it is dimmed, and its colour temperature. */
    this.set = told.lights.map(({ kelvin }) => ({ on: true, share: 1, kelvin }));
    /** How much of each moment there is. */
    this.shares = told.moments.map((_, number) => Number(number === 0));
    const float = gl.getExtension("OES_texture_float_linear") ? gl.RGBA32F : gl.RGBA16F;
    this.maps = new Map(Object.entries(told.atlases).map(([path, { resource: name, size, ...more }]) => {
      const frame = new Frame(gl, ...size, [float]);
      gl.bindTexture(gl.TEXTURE_2D, frame.textures[0]);
      filters(gl, gl.TEXTURE_2D, gl.LINEAR, gl.CLAMP_TO_EDGE, gl.CLAMP_TO_EDGE);
      return [path, { ...more, size, frame, layers: layers(gl, new Uint16Array(buffers.get(name)), size, told.layers.length) }];
    }));
    this.weights = gl.createTexture();
    this.skies = told.skies.map((one) => sky(gl, one, new Uint16Array(buffers.get(one.resource))));
    this.sum();
  }

  /** What a light is multiplied with, of each primary. */
  weight(number) {
    const { on, share, kelvin } = this.set[number];
    const [now, usual] = [white(kelvin), white(this.lights[number].kelvin)];
    return now.map((value, k) => (on ? share * value / usual[k] : 0));
  }

  /** Go to a time: 0 is the first moment, 1 the second, and between them are both in parts. */
  go(time) {
    this.shares = this.told.moments.map((_, number) => Math.max(0, 1 - Math.abs(time - number)));
  }

  /** Add all up again, after something was set. */
  sum() {
    const { gl, added } = this;
    const weights = this.told.layers.map(([number, moment]) => (
      this.weight(number).map((value) => value * this.shares[moment])));
    gl.bindTexture(gl.TEXTURE_2D, this.weights);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, weights.length, 1, 0, gl.RGBA, gl.FLOAT,
      new Float32Array(weights.flatMap((weight) => [...weight, 0])));
    filters(gl, gl.TEXTURE_2D, gl.NEAREST, gl.CLAMP_TO_EDGE, gl.CLAMP_TO_EDGE, gl.NEAREST);
    gl.useProgram(added.program);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    for (const { frame, layers: held } of this.maps.values()) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, frame.made);
      gl.viewport(0, 0, frame.width, frame.height);
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, held);
      gl.uniform1i(added.at("u_lights"), 0);
      gl.activeTexture(gl.TEXTURE1);
      gl.bindTexture(gl.TEXTURE_2D, this.weights);
      gl.uniform1i(added.at("u_weights"), 1);
      gl.uniform1i(added.at("u_count"), weights.length);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.mean = this.average(weights);
  }

  /** Lux of each primary in the mean: for what has no lightmap. */
  average(weights) {
    const total = [0, 0, 0];
    let texels = 0;
    for (const { sums, texels: count } of this.maps.values()) {
      texels += count;
      sums.forEach((sum, number) => sum.forEach((value, k) => { total[k] += value * weights[number][k]; }));
    }
    return total.map((value) => value / Math.max(texels, 1));
  }

  /** A lightmap and the unit of its numbers, in lux; null where there is none of that name. */
  atlas(path) {
    const found = this.maps.get(path);
    return found ? { texture: found.frame.textures[0], scale: found.scale } : null;
  }

  /** What the glow of a prim is multiplied with: that of the lamp that it is part of. */
  glow(path) {
    const number = this.lights.findIndex(({ kind, path: lamp }) => (
      kind === "lamp" && (path === lamp || path.startsWith(`${lamp}/`))));
    return number < 0 ? [1, 1, 1] : this.weight(number);
  }

  /** Skies that are seen now, one or two, each with the unit of its numbers in nits. */
  get seen() {
    const now = this.skies.filter(({ moment }) => this.shares[moment] > 0);
    const [first = this.skies[0], second = first] = now;
    const scale = (one) => one.scale * this.shares[one.moment];
    return [{ ...first, scale: scale(first) }, { ...second, scale: second === first ? 0 : scale(second) }];
  }

  /** Openings through which the sky is seen, each with what it is multiplied with. */
  get openings() {
    return this.lights.flatMap(({ half, portal_from_world: rows }, number) => (
      rows ? [{ half, matrix: fromRows(rows), weight: this.weight(number) }] : [])).slice(0, MOST_OPENINGS);
  }
}

/** The colour of a black body in linear Rec.709, of luminance 1. */
export function white(kelvin) {
  const t = Math.min(Math.max(kelvin, 1667), 25000);
  // Y.-S. Kang et al., Design of Advanced Color Temperature Control System, 2002.
  const x = t < 4000
    ? -0.2661239e9 / t ** 3 - 0.234358e6 / t ** 2 + 0.8776956e3 / t + 0.17991
    : -3.0258469e9 / t ** 3 + 2.1070379e6 / t ** 2 + 0.2226347e3 / t + 0.24039;
  const y = t < 2222 ? -1.1063814 * x ** 3 - 1.3481102 * x ** 2 + 2.18555832 * x - 0.20219683
    : t < 4000 ? -0.9549476 * x ** 3 - 1.37418593 * x ** 2 + 2.09137015 * x - 0.16748867
      : 3.081758 * x ** 3 - 5.8733867 * x ** 2 + 3.75112997 * x - 0.37001483;
  const [X, Z] = [x / y, (1 - x - y) / y];
  return [3.2404542 * X - 1.5371385 - 0.4985314 * Z, -0.969266 * X + 1.8760108 + 0.041556 * Z,
    0.0556434 * X - 0.2040259 + 1.0572252 * Z].map((value) => Math.max(value, 0.003));
}

function layers(gl, halves, [width, height], count) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, made);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage3D(gl.TEXTURE_2D_ARRAY, 0, gl.RGBA16F, width, height, count, 0, gl.RGBA, gl.HALF_FLOAT, halves);
  filters(gl, gl.TEXTURE_2D_ARRAY, gl.NEAREST, gl.CLAMP_TO_EDGE, gl.CLAMP_TO_EDGE, gl.NEAREST);
  return made;
}

function sky(gl, { size, scale, moment, world_from_sky }, halves) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, ...size, 0, gl.RGBA, gl.HALF_FLOAT, halves);
  filters(gl, gl.TEXTURE_2D, gl.LINEAR, gl.REPEAT, gl.CLAMP_TO_EDGE);
  // Rows of the matrix are columns of its transpose: to the sky from the world.
  return { texture, scale, moment, sky_from_world: world_from_sky.flat() };
}
