// WebGL 2 in a few words: programs, vertices, pictures, and hidden frames.

/** The context of a canvas; throws where a browser has none. */
export function context(canvas) {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, powerPreference: "high-performance" });
  if (!gl) throw new Error("this browser has no WebGL 2");
  gl.getExtension("EXT_color_buffer_float");
  gl.getExtension("OES_texture_float_linear");
  return gl;
}

/** A program, and a function that gives the place of a uniform by its name. */
export function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text.trim());
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  const places = new Map();
  const at = (name) => {
    if (!places.has(name)) places.set(name, gl.getUniformLocation(made, name));
    return places.get(name);
  };
  return { program: made, at };
}

/** A buffer with an array in it. */
export function buffer(gl, array, target = gl.ARRAY_BUFFER, usage = gl.STATIC_DRAW) {
  const made = gl.createBuffer();
  gl.bindBuffer(target, made);
  gl.bufferData(target, array, usage);
  return made;
}

/** A picture with mipmaps; codes in sRGB are decoded by the GPU where `encoded` says so. */
export function picture(gl, image, encoded, { wrapS, wrapT } = {}) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, encoded ? gl.SRGB8_ALPHA8 : gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
  gl.generateMipmap(gl.TEXTURE_2D);
  filters(gl, gl.TEXTURE_2D, gl.LINEAR_MIPMAP_LINEAR, wrapS, wrapT);
  const sharper = gl.getExtension("EXT_texture_filter_anisotropic");
  if (sharper) gl.texParameterf(gl.TEXTURE_2D, sharper.TEXTURE_MAX_ANISOTROPY_EXT, 8);
  return made;
}

export function filters(gl, target, small, wrapS = gl.REPEAT, wrapT = gl.REPEAT, large = gl.LINEAR) {
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, small);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, large);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, wrapS);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, wrapT);
}

/** One texel of a color: in place of a picture that is not there. */
export function plain(gl, codes) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(codes));
  filters(gl, gl.TEXTURE_2D, gl.NEAREST, gl.REPEAT, gl.REPEAT, gl.NEAREST);
  return made;
}

/** A frame to draw into that is not shown, with a texture for each of the formats. */
export class Frame {
  constructor(gl, width, height, formats) {
    Object.assign(this, { gl, width, height });
    this.made = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.made);
    this.textures = formats.map((format, number) => {
      const texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
      const linear = format === gl.RGBA16F ? gl.LINEAR : gl.NEAREST;
      filters(gl, gl.TEXTURE_2D, linear, gl.CLAMP_TO_EDGE, gl.CLAMP_TO_EDGE, linear);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + number, gl.TEXTURE_2D, texture, 0);
      return texture;
    });
    this.depth = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, this.depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT32F, width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.depth);
    gl.drawBuffers(formats.map((_, number) => gl.COLOR_ATTACHMENT0 + number));
  }

  /** The pixels of a texture, rows from the top, four values each. */
  pixels(number = 0, Kind = Float32Array) {
    const { gl, width, height } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.made);
    gl.readBuffer(gl.COLOR_ATTACHMENT0 + number);
    const turned = new Kind(width * height * 4);
    gl.readPixels(0, 0, width, height, gl.RGBA, Kind === Float32Array ? gl.FLOAT : gl.UNSIGNED_BYTE, turned);
    const out = new Kind(turned.length);
    for (let row = 0; row < height; row += 1)
      out.set(turned.subarray((height - 1 - row) * width * 4, (height - row) * width * 4), row * width * 4);
    return out;
  }

  remove() {
    const { gl } = this;
    this.textures.forEach((texture) => gl.deleteTexture(texture));
    gl.deleteRenderbuffer(this.depth);
    gl.deleteFramebuffer(this.made);
  }
}
