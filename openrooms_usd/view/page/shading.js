// What runs on the GPU: one way to place triangles, and what they show.

import { GLSL } from "orusd/tone.js";

/** Places of attributes; those from `world` on are of instances. */
export const PLACES = { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2, TEXCOORD_1: 3, MAP: 4,
  world: 5, area: 9, glow: 10, prim: 11 };

/** Numbers of an instance: a matrix, its area of the lightmap, its glow, its prim and whether it is marked. */
export const INSTANCE = { world: [0, 16], area: [16, 4], glow: [20, 3], prim: [23, 2], size: 25 };

export const VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 st0;
layout(location = 3) in vec2 st1;
layout(location = 4) in vec2 map;
layout(location = 5) in mat4 world;
layout(location = 9) in vec4 area;
layout(location = 10) in vec3 glow;
layout(location = 11) in vec2 prim;
uniform mat4 u_camera;
uniform vec3 u_eye;
out vec3 v_place, v_normal;
out vec2 v_st0, v_st1, v_map;
flat out vec3 v_glow;
flat out vec2 v_prim;
void main() {
  vec4 place = world * vec4(position, 1.0);
  v_place = place.xyz;
  mat3 linear = mat3(world);
  v_normal = inverse(transpose(linear)) * normal;
  v_st0 = st0;
  v_st1 = st1;
  v_map = map * area.xy + area.zw;
  v_glow = glow;
  v_prim = prim;
  gl_Position = u_camera * place;
}`;

const SURFACE = `#version 300 es
precision highp float;
precision highp int;
in vec3 v_place, v_normal;
in vec2 v_st0, v_st1, v_map;
flat in vec3 v_glow;
flat in vec2 v_prim;
uniform vec3 u_eye;
uniform vec4 u_color;
uniform float u_cutoff;
uniform ivec3 u_sets;     // sets of coordinates of colour, metal and glow
uniform sampler2D u_colorMap;
uniform float u_metallic;
uniform sampler2D u_metalMap;
uniform vec3 u_emission;
uniform sampler2D u_glowMap;
vec2 coordinates(int number) { return number == 0 ? v_st0 : v_st1; }
vec4 base() {
  vec4 color = u_color * texture(u_colorMap, coordinates(u_sets.x));
  if (color.a < u_cutoff) discard;
  return color;
}
`;

/** What is seen: by lightmaps, or by a lamp at the head. */
export const SHOWN = `${SURFACE}${GLSL}
uniform int u_lit;         // 0 a headlight, 1 a lightmap, 2 the mean of lightmaps
uniform int u_output;      // 0 for people, 1 light in nits, 2 base colour
uniform float u_matt;      // of the colour of metals, how much is shown as if they were matt
uniform sampler2D u_light;
uniform float u_unit;      // lux of one in it
uniform vec3 u_mean;
uniform vec3 u_mark;
out vec4 result;
vec3 radiance(vec3 color) {
  float metal = u_metallic * texture(u_metalMap, coordinates(u_sets.y)).b;
  vec3 irradiance = u_lit == 1 ? texture(u_light, v_map).rgb * u_unit : u_mean;
  vec3 glowing = u_emission * texture(u_glowMap, coordinates(u_sets.z)).rgb * v_glow;
  return color * (1.0 - metal * (1.0 - u_matt)) * irradiance / 3.14159265359 + glowing;
}
vec3 headlit(vec3 color) {
  vec3 towards = normalize(u_eye - v_place);
  vec3 normal = normalize(v_normal);
  if (dot(normal, towards) < 0.0) normal = -normal;
  float ambient = 0.52 + 0.1 * normal.z + 0.05 * normal.x;
  vec3 lit = color * (ambient + 0.45 * dot(normal, towards));
  return encoded(clamp(lit + min(u_emission, vec3(1.0)), 0.0, 1.0));
}
void main() {
  vec4 color = base();
  if (u_output == 2) { result = vec4(color.rgb, 1.0); return; }
  if (u_output == 1) { result = vec4(radiance(color.rgb), 1.0); return; }
  vec3 seen = u_lit == 0 ? headlit(color.rgb) : shown(radiance(color.rgb));
  result = vec4(mix(seen, u_mark, v_prim.y * 0.45), color.a);
}`;

/** Which prim is there, where in the room, and which way its surface faces. */
export const NAMED = `${SURFACE}
layout(location = 0) out vec4 prim;
layout(location = 1) out vec4 place;
layout(location = 2) out vec4 facing;
void main() {
  base();
  vec3 normal = normalize(v_normal);
  if (dot(normal, u_eye - v_place) < 0.0) normal = -normal;
  prim = vec4(v_prim.x, 0.0, 0.0, 1.0);
  place = vec4(v_place, 1.0);
  facing = vec4(normal, 1.0);
}`;

/** A triangle over the whole frame. */
export const WHOLE = `#version 300 es
out vec2 v_at;
void main() {
  v_at = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
  gl_Position = vec4(v_at * 2.0 - 1.0, 0.0, 1.0);
}`;

/** The sum of lights, each multiplied with its weight. */
export const ADDED = `#version 300 es
precision highp float;
precision highp sampler2DArray;
uniform sampler2DArray u_lights;
uniform sampler2D u_weights;
uniform int u_count;
out vec4 result;
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec3 sum = vec3(0.0);
  for (int k = 0; k < u_count; k += 1) {
    vec3 weight = texelFetch(u_weights, ivec2(k, 0), 0).rgb;
    // Most are of moments that are not now.
    if (weight != vec3(0.0)) sum += texelFetch(u_lights, ivec3(texel, k), 0).rgb * weight;
  }
  result = vec4(sum, 1.0);
}`;

/** How many openings the sky is seen through, each as bright as it is set; others as they are. */
export const MOST_OPENINGS = 16;

/** The sky behind all: panoramas of two moments, whose columns run about their Y axes. */
export const SKY = `#version 300 es
precision highp float;
precision highp int;
${GLSL}
in vec2 v_at;
uniform sampler2D u_sky0, u_sky1;
uniform vec2 u_scales;
uniform vec3 u_eye;
uniform int u_openings;
uniform mat4 u_portals[${MOST_OPENINGS}];   // to an opening from the world; it lies in z = 0
uniform vec2 u_halves[${MOST_OPENINGS}];
uniform vec3 u_weights[${MOST_OPENINGS}];
uniform mat3 u_local0, u_local1;   // to the skies from the world
uniform mat3 u_pose;       // to the world from the camera
uniform vec4 u_lens;       // 2 focal, its part of the height, right, down
uniform int u_output;
out vec4 result;
vec3 daylight(vec3 way) {
  float nearest = 1e9;
  vec3 found = vec3(1.0);
  for (int k = 0; k < u_openings; k += 1) {
    vec3 eye = (u_portals[k] * vec4(u_eye, 1.0)).xyz;
    vec3 along = mat3(u_portals[k]) * way;
    float far = -eye.z / along.z;
    vec2 met = abs(eye.xy + far * along.xy);
    if (far <= 0.0 || far >= nearest || any(greaterThan(met, u_halves[k]))) continue;
    nearest = far;
    found = u_weights[k];
  }
  return found;
}
vec3 panorama(sampler2D sky, vec3 way) {
  return textureLod(sky, vec2(atan(way.x, -way.z) / 6.28318530718, acos(clamp(way.y, -1.0, 1.0)) / 3.14159265359), 0.0).rgb;
}
void main() {
  vec2 at = v_at * 2.0 - 1.0;
  vec3 seen = u_pose * vec3((at.x - u_lens.z) / u_lens.x, (at.y + u_lens.w) / u_lens.y, -1.0);
  seen = normalize(seen);
  vec3 light = panorama(u_sky0, u_local0 * seen) * u_scales.x + panorama(u_sky1, u_local1 * seen) * u_scales.y;
  light *= daylight(seen);
  result = vec4(u_output == 1 ? light : shown(light), 1.0);
}`;

/** Lines and dots that lie over the picture. */
export const LINES = {
  vertex: `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 color;
uniform mat4 u_camera;
uniform float u_size;
out vec3 v_color;
void main() {
  v_color = color;
  gl_Position = u_camera * vec4(position, 1.0);
  gl_PointSize = u_size;
}`,
  fragment: `#version 300 es
precision highp float;
in vec3 v_color;
uniform float u_alpha;
out vec4 result;
void main() { result = vec4(v_color, u_alpha); }`,
};
