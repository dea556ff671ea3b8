// Reads GLB files (glTF 2.0) as orusd writes them: nodes with prim paths, triangles, materials.
//
// What a material says with KHR_materials_emissive_strength and _transmission is understood;
// _ior, _specular, _clearcoat and KHR_lights_punctual change nothing that a page shows.

import { Z_UP_FROM_Y_UP, multiply, placed } from "orusd/matrix.js";

const MAGIC = 0x46546c67;
const ARRAYS = { 5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array,
  5125: Uint32Array, 5126: Float32Array };
const SIZES = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 };

/**
 * A file as { nodes, meshes, materials, textures, images }.
 *
 * nodes: { path, parent, world, mesh, extras }; world is (4, 4) to the room's frame, Z up, metres.
 * meshes: lists of { attributes: { POSITION: { array, size, key }, ... }, indices, material, extras }.
 * images: ImageBitmaps.
 */
export async function parse(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < 20 || view.getUint32(0, true) !== MAGIC)
    throw new Error("this is not a GLB file");
  const size = view.getUint32(12, true);
  const said = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 20, size)));
  const start = 28 + size;
  const bytes = (number) => {
    const { byteOffset = 0, byteLength } = said.bufferViews[number];
    return new Uint8Array(buffer, start + byteOffset, byteLength);
  };
  const arrays = new Map();
  const accessor = (number) => {
    if (!arrays.has(number)) arrays.set(number, read(said, start, buffer, number));
    return arrays.get(number);
  };
  const meshes = (said.meshes ?? []).map(({ primitives }) => primitives.map((primitive) => ({
    attributes: Object.fromEntries(Object.entries(primitive.attributes)
      .map(([name, number]) => [name, accessor(number)])),
    indices: accessor(primitive.indices),
    material: primitive.material,
    extras: primitive.extras ?? {},
  })));
  const images = await Promise.all((said.images ?? []).map((image) => createImageBitmap(
    new Blob([bytes(image.bufferView)], { type: image.mimeType }),
    { colorSpaceConversion: "none", premultiplyAlpha: "none" },
  )));
  const textures = (said.textures ?? []).map(({ source, sampler }) => (
    { image: source, ...(said.samplers?.[sampler] ?? {}) }));
  const materials = (said.materials ?? []).map(material);
  return { nodes: nodes(said), meshes, materials, textures, images };
}

function read(said, start, buffer, number) {
  const { bufferView, byteOffset = 0, componentType, count, type } = said.accessors[number];
  const held = said.bufferViews[bufferView];
  if (held.byteStride) throw new Error("interleaved vertices are not read");
  const size = SIZES[type];
  const first = start + (held.byteOffset ?? 0) + byteOffset;
  const array = new ARRAYS[componentType](buffer, first, count * size);
  return { array, size, kind: componentType, key: number };
}

function material(one) {
  const base = one.pbrMetallicRoughness ?? {};
  const more = one.extensions ?? {};
  const strength = more.KHR_materials_emissive_strength?.emissiveStrength ?? 1;
  const [r, g, b, alpha] = base.baseColorFactor ?? [1, 1, 1, 1];
  return {
    name: one.name ?? "",
    color: [r, g, b],
    alpha,
    colorTexture: base.baseColorTexture ?? null,
    metallic: base.metallicFactor ?? 1,
    metallicTexture: base.metallicRoughnessTexture ?? null,
    emission: (one.emissiveFactor ?? [0, 0, 0]).map((value) => value * strength),
    emissionTexture: one.emissiveTexture ?? null,
    mode: one.alphaMode ?? "OPAQUE",
    cutoff: one.alphaCutoff ?? 0.5,
    clear: more.KHR_materials_transmission !== undefined,
  };
}

function nodes(said) {
  const found = (said.nodes ?? []).map((node) => ({
    path: node.extras?.prim ?? null, parent: null, local: placed(node), world: null,
    mesh: node.mesh ?? null, extras: node.extras ?? {}, children: node.children ?? [],
  }));
  const place = (number, above, parent) => {
    const node = found[number];
    node.parent = parent;
    node.world = multiply(above, node.local);
    // Steps of a shear and lamps in meshes have no prim of their own.
    node.path ??= parent === null ? "" : found[parent].path;
    node.children.forEach((child) => place(child, node.world, number));
  };
  said.scenes[said.scene ?? 0].nodes.forEach((root) => place(root, Z_UP_FROM_Y_UP, null));
  return found;
}
