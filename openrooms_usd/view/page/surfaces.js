// The surfaces of a room on the GPU: uploaded once, drawn with a few calls.

import * as m from "orusd/matrix.js";
import { buffer, picture, plain } from "orusd/gl.js";
import { INSTANCE, PLACES } from "orusd/shading.js";

// How much of itself clear glass shows.
const CLEAR = 0.06;

/**
 * Triangles and materials of a parsed GLB file.
 *
 * prims: paths by number; number 0 is nothing. What repeats is drawn in one call.
 */
export class Surfaces {
  constructor(gl, { nodes, meshes, materials, textures, images }) {
    Object.assign(this, { gl, nodes, materials });
    this.prims = [""];
    this.numbers = new Map();
    this.marked = new Set();
    this.moves = new Map();
    this.hidden = new Set();
    this.texels = 0;
    this.white = plain(gl, [255, 255, 255, 255]);
    const held = new Map();
    this.picture = (info, encoded) => {
      if (!info) return this.white;
      const key = `${info.index} ${encoded}`;
      const { image, ...how } = textures[info.index];
      if (!held.has(key)) {
        held.set(key, picture(gl, images[image], encoded, how));
        this.texels += images[image].width * images[image].height;
      }
      return held.get(key);
    };
    const vertices = new Map();
    const upload = (accessor, target) => {
      const key = `${accessor.key} ${target}`;
      if (!vertices.has(key)) vertices.set(key, buffer(gl, accessor.array, target));
      return vertices.get(key);
    };
    this.groups = grouped(nodes).flatMap((members) => meshes[nodes[members[0]].mesh].map(
      (primitive) => this.group(primitive, members, upload)));
    for (const node of nodes) if (node.path) this.number(node.path);
    this.textures = held;
    this.vertices = vertices;
    this.refresh();
  }

  number(path) {
    if (!this.numbers.has(path)) {
      this.numbers.set(path, this.prims.length);
      this.prims.push(path);
    }
    return this.numbers.get(path);
  }

  group(primitive, members, upload) {
    const { gl } = this;
    const { attributes, indices, material, extras } = primitive;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const wanted = { ...attributes };
    // Coordinates of the lightmap may be any set; those of materials are the first two.
    if (extras.lightmap !== undefined) wanted.MAP = attributes[`TEXCOORD_${extras.lightmap}`];
    for (const [name, accessor] of Object.entries(wanted)) {
      if (PLACES[name] === undefined) continue;
      upload(accessor, gl.ARRAY_BUFFER);
      gl.bindBuffer(gl.ARRAY_BUFFER, upload(accessor, gl.ARRAY_BUFFER));
      gl.enableVertexAttribArray(PLACES[name]);
      gl.vertexAttribPointer(PLACES[name], accessor.size, accessor.kind, false, 0, 0);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, upload(indices, gl.ELEMENT_ARRAY_BUFFER));
    const data = new Float32Array(members.length * INSTANCE.size);
    const instances = buffer(gl, data, gl.ARRAY_BUFFER, gl.DYNAMIC_DRAW);
    for (const name of ["world", "area", "glow", "prim"]) {
      const [first, size] = INSTANCE[name];
      for (let row = 0; row < size; row += 4) {
        const place = PLACES[name] + row / 4;
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, Math.min(size, 4), gl.FLOAT, false, INSTANCE.size * 4, (first + row) * 4);
        gl.vertexAttribDivisor(place, 1);
      }
    }
    gl.bindVertexArray(null);
    const said = this.materials[material];
    const box = bounds(attributes.POSITION.array);
    return { primitive, upload, array, instances, data, members, box, count: indices.array.length, shown: members.length,
      indexKind: indices.kind, material: said, atlas: this.nodes[members[0]].extras.lightmap?.atlas ?? null,
      see_through: said.mode === "BLEND" };
  }

  /** Bring all that moves, is marked or glows to the GPU. */
  refresh(glow = () => [1, 1, 1]) {
    this.glow = glow;
    const { gl } = this;
    for (const group of this.groups) {
      let row = 0;
      for (const member of group.members) {
        const node = this.nodes[member];
        if (this.above(node.path, this.hidden)) continue;
        group.data.set(this.world(node), row);
        group.data.set(node.extras.lightmap?.area ?? [1, 1, 0, 0], row + INSTANCE.area[0]);
        group.data.set(glow(node.path), row + INSTANCE.glow[0]);
        group.data.set([this.number(node.path), this.above(node.path, this.marked) ? 1 : 0], row + INSTANCE.prim[0]);
        row += INSTANCE.size;
      }
      group.shown = row / INSTANCE.size;
      gl.bindBuffer(gl.ARRAY_BUFFER, group.instances);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, group.data);
    }
  }

  /** Show prims in a plain colour (scene-linear), until another file is loaded. */
  redress(paths, color) {
    const wanted = new Set(paths);
    const plain = { color, colorTexture: null, metallic: 0, metallicTexture: null };
    this.groups = this.groups.flatMap((group) => {
      const meant = group.members.filter((member) => wanted.has(this.nodes[member].path));
      if (!meant.length) return [group];
      const rest = group.members.filter((member) => !meant.includes(member));
      const made = rest.length ? this.group(group.primitive, meant, group.upload) : group;
      made.material = { ...group.material, ...plain };
      group.members = rest.length ? rest : meant;
      return rest.length ? [group, made] : [made];
    });
    this.refresh(this.glow);
  }

  /** Whether a path, or what it is below, is in a set. */
  above(path, set) {
    if (!set.size) return false;
    for (let end = path.length; end > 0; end = path.lastIndexOf("/", end - 1))
      if (set.has(path.slice(0, end))) return true;
    return false;
  }

  /** Where a node is, moved with all that it is below. */
  world(node) {
    let found = node.world;
    if (!this.moves.size) return found;
    const { path } = node;
    for (let end = path.length; end > 0; end = path.lastIndexOf("/", end - 1)) {
      const move = this.moves.get(path.slice(0, end));
      if (move) found = m.multiply(move, found);
    }
    return found;
  }

  /** The box of what is below some prims, or of all: two corners; null of nothing. */
  bounds(paths = [""]) {
    const low = [Infinity, Infinity, Infinity];
    const high = low.map((v) => -v);
    const wanted = new Set(paths);
    const all = wanted.has("");
    for (const { box, members } of this.groups)
      for (const member of members) {
        const node = this.nodes[member];
        if (!all && !this.above(node.path, wanted)) continue;
        const world = this.world(node);
        for (let corner = 0; corner < 8; corner += 1) {
          const at = m.point(world, [0, 1, 2].map((k) => box[corner >> k & 1][k]));
          for (let k = 0; k < 3; k += 1) {
            low[k] = Math.min(low[k], at[k]);
            high[k] = Math.max(high[k], at[k]);
          }
        }
      }
    return low[0] <= high[0] ? [low, high] : null;
  }

  /**
   * Draw with a program that is in use.
   * ready: called for each group before it is drawn; false leaves it out.
   */
  draw(at, groups = this.groups, ready = () => true) {
    const { gl } = this;
    let last = null;
    for (const group of groups) {
      if (!group.shown || ready(group) === false) continue;
      if (group.material !== last) this.bind(at, last = group.material);
      gl.bindVertexArray(group.array);
      gl.drawElementsInstanced(gl.TRIANGLES, group.count, group.indexKind, 0, group.shown);
    }
    gl.bindVertexArray(null);
  }

  bind(at, one) {
    const { gl } = this;
    gl.uniform4f(at("u_color"), ...one.color, one.clear ? CLEAR : one.alpha);
    gl.uniform1f(at("u_cutoff"), one.mode === "MASK" ? one.cutoff : 0);
    gl.uniform1f(at("u_metallic"), one.metallic);
    gl.uniform3f(at("u_emission"), ...one.emission);
    const infos = [one.colorTexture, one.metallicTexture, one.emissionTexture];
    gl.uniform3i(at("u_sets"), ...infos.map((info) => info?.texCoord ?? 0));
    infos.forEach((info, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, this.picture(info, unit !== 1));
      gl.uniform1i(at(["u_colorMap", "u_metalMap", "u_glowMap"][unit]), unit);
    });
  }

  /** How many triangles are drawn, and how many pixels of textures are held. */
  get sizes() {
    const triangles = this.groups.reduce((sum, { count, members }) => sum + count / 3 * members.length, 0);
    return { triangles, calls: this.groups.length, textures: this.textures.size, texels: this.texels };
  }

  remove() {
    const { gl } = this;
    for (const { array, instances } of this.groups) {
      gl.deleteVertexArray(array);
      gl.deleteBuffer(instances);
    }
    for (const one of this.vertices.values()) gl.deleteBuffer(one);
    for (const one of this.textures.values()) gl.deleteTexture(one);
  }
}

/** The numbers of nodes that show the same mesh in the same lightmap. */
function grouped(nodes) {
  const found = new Map();
  nodes.forEach(({ mesh, extras }, number) => {
    if (mesh === null) return;
    const key = `${mesh} ${extras.lightmap?.atlas ?? ""}`;
    if (!found.has(key)) found.set(key, []);
    found.get(key).push(number);
  });
  return [...found.values()];
}

function bounds(array) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let k = 0; k < array.length; k += 1) {
    low[k % 3] = Math.min(low[k % 3], array[k]);
    high[k % 3] = Math.max(high[k % 3], array[k]);
  }
  return [low, high];
}
