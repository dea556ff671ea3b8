// Which prim is seen at a pixel, and where: drawn as numbers into a hidden frame.

import { Frame, program } from "orusd/gl.js";
import { NAMED, VERTEX } from "orusd/shading.js";

/** Numbers, places and directions of what a camera sees. */
export class Picking {
  constructor(gl) {
    this.gl = gl;
    this.named = program(gl, VERTEX, NAMED);
    this.one = new Frame(gl, 1, 1, [gl.RGBA32F, gl.RGBA32F, gl.RGBA32F]);
  }

  /**
   * What is at a place of a picture: { path, point, normal }, in the room's frame; null for nothing.
   * Clear panes are seen; `through` looks past them.
   */
  at(surfaces, camera, x, y, width, height, through = false) {
    // The frame is one pixel: the picture is moved until the wanted one lies there.
    this.draw(surfaces, camera, this.one, width, height, [-Math.floor(x), -(height - 1 - Math.floor(y))], through);
    const [number] = this.one.pixels(0);
    if (!number) return null;
    const [point, normal] = [1, 2].map((k) => [...this.one.pixels(k).slice(0, 3)]);
    return { path: surfaces.prims[Math.round(number)], point, normal };
  }

  /** The numbers of the prims in a whole picture, rows from the top: of `surfaces.prims`. */
  labels(surfaces, camera, width, height, through = true) {
    const { gl } = this;
    const frame = new Frame(gl, width, height, [gl.RGBA32F, gl.RGBA32F, gl.RGBA32F]);
    this.draw(surfaces, camera, frame, width, height, [0, 0], through);
    const pixels = frame.pixels(0);
    frame.remove();
    return Array.from({ length: width * height }, (_, k) => Math.round(pixels[4 * k]));
  }

  draw(surfaces, camera, frame, width, height, corner, through) {
    const { gl, named } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame.made);
    gl.viewport(...corner, width, height);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    for (const number of frame.textures.keys()) gl.clearBufferfv(gl.COLOR, number, [0, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    gl.useProgram(named.program);
    gl.uniformMatrix4fv(named.at("u_camera"), false, camera.matrix(width, height));
    gl.uniform3f(named.at("u_eye"), ...camera.eye);
    surfaces.draw(named.at, surfaces.groups, ({ material }) => !(through && material.clear));
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }
}
