// From light to a picture as a camera would show it: the same as openrooms_usd/rendering/tone.py.

const GREY = 0.18;
const KEY = 0.27;
const BLOCK = 8;
const KNEE_STOPS = 1.5;
const BRIGHT_STOPS = 3.9;
const LEAST_LEVEL = 0.47;
const LEVEL_OF_A_STOP = 0.13;
const MAX_RAISED_STOPS = 0.6;
const LUMINANCE = [0.2126390058715104, 0.7151686787677559, 0.07219231536073371];

const PRIMARIES = [
  [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
  [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
  [0.0423756549057051, 0.0784336, 0.879142973793104],
].map((row) => row.map((value) => value / row.reduce((a, b) => a + b)));
const [LOW, HIGH] = [-10, 6.5];
const [SLOPE, POWER, GAMMA] = [2.4, 1.5, 2.2];
const MIDDLE = [-LOW / (HIGH - LOW), GREY ** (1 / GAMMA)];
const bend = (run, rise) => (rise ** -POWER - run ** -POWER) ** (-1 / POWER);
const TOE = bend(SLOPE * MIDDLE[0], MIDDLE[1]);
const SHOULDER = bend(SLOPE * (1 - MIDDLE[0]), 1 - MIDDLE[1]);

const float = (value) => value.toPrecision(9).replace(/^(-?\d+)$/, "$1.0");
const vector = (values) => `vec3(${values.map(float).join(", ")})`;
// Columns, as GLSL wants them.
const columns = (rows) => `mat3(${[0, 1, 2].map((c) => vector(rows.map((row) => row[c]))).join(", ")})`;

function inverted(m) {
  const c = (i, j) => m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3]
    - m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3];
  const size = m[0][0] * c(0, 0) + m[0][1] * c(0, 1) + m[0][2] * c(0, 2);
  return [0, 1, 2].map((i) => [0, 1, 2].map((j) => c(j, i) / size));
}

/** GLSL: `vec3 shown(vec3 radiance)` gives codes in sRGB, by the uniforms u_exposure and others. */
export const GLSL = `
uniform vec3 u_exposure;  // what light is multiplied by, white balance included
uniform float u_slope;    // stops for a stop above the knee
uniform int u_tone;       // 0 srgb, 1 film, 2 photograph
const vec3 LUMINANCE = ${vector(LUMINANCE)};
vec3 encoded(vec3 x) {
  return mix(12.92 * x, 1.055 * pow(max(x, vec3(1e-9)), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}
vec3 film(vec3 linear) {
  vec3 inset = max(${columns(PRIMARIES)} * linear, vec3(1e-10));
  vec3 x = (clip3(log2(inset / ${float(GREY)}), ${float(LOW)}, ${float(HIGH)}) - ${float(LOW)}) / ${float(HIGH - LOW)};
  vec3 line = ${float(SLOPE)} * (x - ${float(MIDDLE[0])});
  vec3 limit = mix(vec3(${float(SHOULDER)}), vec3(${float(TOE)}), vec3(lessThan(line, vec3(0.0))));
  vec3 curved = ${float(MIDDLE[1])} + line / pow(1.0 + pow(abs(line / limit), vec3(${float(POWER)})), vec3(${float(1 / POWER)}));
  return pow(clip3(${columns(inverted(PRIMARIES))} * curved, 0.0, 1.0), vec3(${float(GAMMA)}));
}
vec3 compressed(vec3 exposed) {
  float bright = max(dot(exposed, LUMINANCE), 1e-6);
  float above = (log2(bright / ${float(GREY)}) - ${float(KNEE_STOPS)}) / 0.5;
  float bent = above > 20.0 ? above : log(1.0 + exp(above));
  return exposed * exp2(-(1.0 - u_slope) * 0.5 * bent);
}
vec3 graded(vec3 x) {
  float bright = max(dot(x, LUMINANCE), 1e-6);
  float odds = pow(bright / max(1.0 - bright, 1e-6), 1.45) * pow(${float(GREY / (1 - GREY))}, -0.45);
  return clip3((bright + (x - bright) * 1.25) * (odds / (1.0 + odds) / bright), 0.0, 1.0);
}
vec3 shown(vec3 radiance) {
  vec3 exposed = radiance * u_exposure;
  if (u_tone == 0) return encoded(clip3(exposed, 0.0, 1.0));
  if (u_tone == 1) return encoded(film(exposed));
  return encoded(graded(film(compressed(exposed))));
}
`.replaceAll("clip3(", "clamp(");

/**
 * The tone of a picture: { exposure, balance, slope, over }; over: stops of its brightest part.
 * pixels: its light, four values each; exposure: that of the camera, or null to fit it.
 */
export function fitted(pixels, width, height, exposure = null) {
  const means = blocks(pixels, width, height).filter((b) => b.every((v) => v > 0 && Number.isFinite(v)));
  if (!means.length) return { exposure: exposure ?? 1, balance: [1, 1, 1], slope: 1, over: 0 };
  const balance = whiteBalance(means);
  const bright = means.map((b) => b.reduce((sum, v, k) => sum + v * balance[k] * LUMINANCE[k], 0)).sort((a, b) => a - b);
  let factor = exposure ?? KEY / Math.exp(clippedMean(bright.map(Math.log)));
  let over = Math.log2(at(bright, 0.985) * factor / GREY);
  if (exposure === null) {
    const lowered = clamp(0.15 * (over - BRIGHT_STOPS), 0, 0.4);
    factor *= 2 ** -lowered;
    over -= lowered;
  }
  return { exposure: factor, balance, slope: slopeOf(over), over };
}

/**
 * The same tone, raised where what it shows is too dark in the mean.
 * codes: what is shown with it, four bytes each.
 */
export function raised(tone, codes) {
  let sum = 0;
  for (let k = 0; k < codes.length; k += 4) {
    const light = LUMINANCE.reduce((total, share, c) => total + share * decoded(codes[k + c] / 255), 0);
    sum += light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055;
  }
  const stops = clamp((LEAST_LEVEL - sum / (codes.length / 4)) / LEVEL_OF_A_STOP, 0, MAX_RAISED_STOPS);
  return { ...tone, exposure: tone.exposure * 2 ** stops, slope: slopeOf(tone.over + stops) };
}

const decoded = (code) => (code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4);

/** Stops for each stop above the knee that bring the brightest part to where it keeps its detail. */
const slopeOf = (over) => Math.max((BRIGHT_STOPS - KNEE_STOPS) / (Math.max(over, BRIGHT_STOPS) - KNEE_STOPS), 0.3);

function blocks(pixels, width, height) {
  const out = [];
  for (let y = 0; y + BLOCK <= height; y += BLOCK)
    for (let x = 0; x + BLOCK <= width; x += BLOCK) {
      const sum = [0, 0, 0];
      for (let k = 0; k < BLOCK * BLOCK; k += 1) {
        const first = ((y + Math.floor(k / BLOCK)) * width + x + k % BLOCK) * 4;
        for (let c = 0; c < 3; c += 1) sum[c] += pixels[first + c];
      }
      out.push(sum.map((value) => value / (BLOCK * BLOCK)));
    }
  return out;
}

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length;

/** A percentile of sorted values, linear between them. */
function at(sorted, share) {
  const place = share * (sorted.length - 1);
  const low = Math.floor(place);
  return sorted[low] + (sorted[Math.min(low + 1, sorted.length - 1)] - sorted[low]) * (place - low);
}

function clippedMean(sorted) {
  const [low, high] = [at(sorted, 0.05), at(sorted, 0.95)];
  return mean(sorted.map((value) => clamp(value, low, high)));
}

function whiteBalance(means) {
  const light = (b) => b.reduce((sum, v, k) => sum + v * LUMINANCE[k], 0);
  const ordered = [...means].sort((a, b) => light(a) - light(b));
  const first = Math.floor(0.2 * ordered.length);
  const counted = ordered.slice(first, Math.max(Math.floor(0.95 * ordered.length), first + 1));
  const logs = [1.05, 1, 0.93].map((share, k) => mean(counted.map((b) => Math.log(b[k]))) - Math.log(share));
  const size = Math.hypot(0.64, 1);
  const way = [0.64 / size, -1 / size];
  const along = (logs[0] - logs[1]) * way[0] + (logs[2] - logs[1]) * way[1];
  const cast = -Math.sign(along) * clamp(Math.abs(along) - 0.1, 0, 1.45) * 0.7;
  const factors = [Math.exp(cast * way[0]), 1, Math.exp(cast * way[1])];
  const colour = logs.map(Math.exp);
  const kept = light(colour) / light(colour.map((v, k) => v * factors[k]));
  return factors.map((factor) => factor * kept);
}
