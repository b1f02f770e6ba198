// The traversal of trace.js in GLSL, in single precision, and the shading of what it found.

import { BACKGROUND, DIVERGING, HEAT, LIT, SHADES } from "./colour.js";
import { NODE_COST } from "./tree.js";

export const WIDTH = 2048; // texels of a row of a texture that holds records

export const CORNERS = `#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;

const RECORDS = `#version 300 es
precision highp float; precision highp int; precision highp usampler2D;
uniform usampler2D uNodes, uTriangles, uInstances;
uvec4 record(usampler2D from, uint at) { return texelFetch(from, ivec2(int(at & ${WIDTH - 1}u), int(at >> 11u)), 0); }
vec3 moved(uint instance, uint from, vec3 p, float one) {
  vec4 h = vec4(p, one);
  return vec3(dot(uintBitsToFloat(record(uInstances, instance * 8u + from)), h),
              dot(uintBitsToFloat(record(uInstances, instance * 8u + from + 1u)), h),
              dot(uintBitsToFloat(record(uInstances, instance * 8u + from + 2u)), h));
}
`;

/** `stack`: entries that the deepest walk of the scene needs. */
export const tracing = (stack, isTwoLevel) => `${RECORDS}
#define TWO_LEVEL ${isTwoLevel ? 1 : 0}
const float FAR = 3.0e38;
const uint INSTANCE = 0x80000000u;
uniform vec3 uEye, uForward, uRight, uUp;
uniform vec2 uSize;
uniform int uOrder;
uniform uint uRoot, uBrute, uTriangleCount, uInstanceCount, uNodeCount;
uniform int uRootInstance; // -1 where the root stands in world space, -2 where there is no tree
layout(location = 0) out uvec4 outHit;
layout(location = 1) out uvec4 outWork;

vec3 O, D, o, d, inv;
ivec3 axes;
vec3 shear;
float best;
uvec4 hit;
uint inner, tests, entered;

void aim(vec3 origin, vec3 direction) {
  o = origin; d = direction; inv = 1.0 / d;
  vec3 s = abs(d);
  int z = s.x > s.y ? (s.x > s.z ? 0 : 2) : (s.y > s.z ? 1 : 2);
  axes = ivec3((z + 1) % 3, (z + 2) % 3, z);
  shear = vec3(d[axes.x] / d[z], d[axes.y] / d[z], 1.0 / d[z]);
}
void enter(int instance) {
#if TWO_LEVEL
  if (instance >= 0) { aim(moved(uint(instance), 3u, O, 1.0), moved(uint(instance), 3u, D, 0.0)); return; }
#endif
  aim(O, D);
}
float near(vec3 low, vec3 high) {
  vec3 slack = 4.0e-7 * max(max(abs(low), abs(high)), abs(o));
  vec3 a = (low - slack - o) * inv, b = (high + slack - o) * inv;
  // A ray along an axis: inside the slab everything is met, outside of it nothing.
  for (int k = 0; k < 3; k++) if (d[k] == 0.0) {
    bool inside = o[k] >= low[k] - slack[k] && o[k] <= high[k] + slack[k];
    a[k] = inside ? -FAR : FAR; b[k] = inside ? FAR : -FAR;
  }
  vec3 n = min(a, b), f = max(a, b);
  for (int k = 0; k < 3; k++) if (d[k] == 0.0) { n[k] = a[k]; f[k] = b[k]; }
  float t0 = max(max(n.x, n.y), max(n.z, 0.0)), t1 = min(min(f.x, f.y), min(f.z, best));
  return t0 <= t1 * 1.000001 ? t0 : FAR;
}
void test(uint triangle, int instance, uint leaf) {
  tests++;
  uvec4 ra = record(uTriangles, triangle * 3u), rb = record(uTriangles, triangle * 3u + 1u), rc = record(uTriangles, triangle * 3u + 2u);
  vec3 a = uintBitsToFloat(ra.xyz) - o, b = uintBitsToFloat(rb.xyz) - o, c = uintBitsToFloat(rc.xyz) - o;
  float az = a[axes.z], bz = b[axes.z], cz = c[axes.z];
  vec2 pa = vec2(a[axes.x], a[axes.y]) - shear.xy * az;
  vec2 pb = vec2(b[axes.x], b[axes.y]) - shear.xy * bz;
  vec2 pc = vec2(c[axes.x], c[axes.y]) - shear.xy * cz;
  float u = pc.x * pb.y - pc.y * pb.x, v = pa.x * pc.y - pa.y * pc.x, w = pb.x * pa.y - pb.y * pa.x;
  if (min(u, min(v, w)) < 0.0 && max(u, max(v, w)) > 0.0) return;
  float det = u + v + w;
  if (det == 0.0) return;
  float t = (u * az + v * bz + w * cz) * shear.z / det;
  if (!(t >= 0.0) || t > best) return;
  if (t == best && hit.x != 0u) {
    uint other = hit.x - 1u;
    uvec2 mine = uvec2(rb.w, ra.w), theirs = uvec2(record(uTriangles, other * 3u + 1u).w, record(uTriangles, other * 3u).w);
#if TWO_LEVEL
    uint a = record(uInstances, uint(instance) * 8u + 6u).y, b = record(uInstances, (hit.y - 1u) * 8u + 6u).y;
    if (a != b) { if (a > b) return; } else
#endif
    if (mine.x > theirs.x || (mine.x == theirs.x && mine.y >= theirs.y)) return;
  }
  best = t;
  hit = uvec4(triangle + 1u, uint(instance + 1), floatBitsToUint(t), leaf);
}
float surface(vec3 low, vec3 high) { vec3 s = high - low; return s.x * s.y + s.y * s.z + s.z * s.x; }
bool holds(vec3 low, vec3 high) { return all(lessThanEqual(low, o)) && all(lessThanEqual(o, high)); }

void walk() {
  uint stack[${stack}];
  float nearOf[${stack}];
  int depth = 0, base = -1, instance = uRootInstance;
  enter(instance);
  uint node = uRoot;
  uvec4 low = record(uNodes, node * 2u), high = record(uNodes, node * 2u + 1u);
  float at = near(uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz));
  if (at == FAR) return;
  for (int step = 0; step < 1000000; step++) {
    bool goesOn = false;
    uint count = high.w & 255u;
    if (count == 0u) {
      inner++;
      uint a = low.w, b = a + 1u;
      uvec4 lowA = record(uNodes, a * 2u), highA = record(uNodes, a * 2u + 1u);
      uvec4 lowB = record(uNodes, b * 2u), highB = record(uNodes, b * 2u + 1u);
      vec3 la = uintBitsToFloat(lowA.xyz), ha = uintBitsToFloat(highA.xyz), lb = uintBitsToFloat(lowB.xyz), hb = uintBitsToFloat(highB.xyz);
      float nearA = near(la, ha), nearB = near(lb, hb);
      bool first = nearA != FAR, second = nearB != FAR;
      if (first && second) {
        bool swapped = uOrder == 0 ? nearB < nearA
          : uOrder == 1 ? surface(lb, hb) > surface(la, ha)
          : uOrder == 2 ? !holds(la, ha) && holds(lb, hb)
          : uOrder == 4 ? nearB > nearA : false;
        stack[depth] = swapped ? a : b;
        nearOf[depth] = swapped ? nearA : nearB;
        depth++;
        first = !swapped;
        second = swapped;
      }
      if (second) { low = lowB; high = highB; node = b; at = nearB; goesOn = true; }
      else if (first) { low = lowA; high = highA; node = a; at = nearA; goesOn = true; }
    } else if (node < uNodeCount) {
      for (uint i = 0u; i < count; i++) test(low.w + i, instance, node);
    }
#if TWO_LEVEL
    else {
      for (uint i = count; i > 0u; i--) { stack[depth] = INSTANCE | (low.w + i - 1u); nearOf[depth] = at; depth++; }
    }
#endif
    while (!goesOn) {
#if TWO_LEVEL
      if (depth == base) { instance = -1; base = -1; enter(-1); }
#endif
      if (depth == 0) return;
      depth--;
      at = nearOf[depth];
      if (at > best * 1.000001) continue;
      uint next = stack[depth];
#if TWO_LEVEL
      if ((next & INSTANCE) != 0u) {
        uint row = next & ~INSTANCE;
        uvec4 tree = record(uInstances, row * 8u + 6u);
        if (tree.w == 0u) continue;
        entered++;
        enter(int(row));
        next = tree.x;
        low = record(uNodes, next * 2u); high = record(uNodes, next * 2u + 1u);
        at = near(uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz));
        if (at == FAR) { enter(-1); continue; }
        instance = int(row);
        base = depth;
        node = next;
        goesOn = true;
        continue;
      }
#endif
      node = next;
      low = record(uNodes, node * 2u); high = record(uNodes, node * 2u + 1u);
      goesOn = true;
    }
  }
}
void everyTriangle() {
#if TWO_LEVEL
  for (uint i = 0u; i < uInstanceCount && tests < uBrute; i++) {
    uvec4 tree = record(uInstances, i * 8u + 6u);
    enter(int(i));
    for (uint k = 0u; k < tree.w && tests < uBrute; k++) test(tree.z + k, int(i), 0u);
  }
#else
  enter(-1);
  for (uint k = 0u; k < min(uBrute, uTriangleCount); k++) test(k, -1, 0u);
#endif
}
void main() {
  vec2 p = gl_FragCoord.xy / uSize * 2.0 - 1.0;
  O = uEye;
  D = normalize(uForward + p.x * uRight + p.y * uUp);
  best = FAR; hit = uvec4(0u); inner = tests = entered = 0u;
  if (uBrute > 0u) everyTriangle();
  else if (uRootInstance > -2) walk();
  outHit = hit;
  outWork = uvec4(inner, tests, entered, 0u);
}`;

const floats = (rgb) => `vec3(${rgb.map((x) => (x / 255).toFixed(4)).join(",")})`;
const table = (name, colours) => `const vec3 ${name}[5] = vec3[5](${colours.map(floats).join(",")});
vec3 ramp${name}(float share) {
  float x = clamp(share, 0.0, 1.0) * 4.0; int i = min(int(x), 3);
  return mix(${name}[i], ${name}[i + 1], x - float(i));
}`;

const VALUE = `float value(uvec4 work) {
  return uShade == ${SHADES.nodes} ? float(work.x) : uShade == ${SHADES.tests} ? float(work.y) : ${NODE_COST.toFixed(1)} * float(work.x) + float(work.y);
}`;

/** One scene's pixels become colours: the twin of pixelColour. */
export const SHADING = `${RECORDS}
uniform usampler2D uHit, uWork;
uniform vec2 uScale;
uniform vec3 uForward;
uniform int uShade, uDark;
uniform float uMost;
out vec4 outColour;
${table("HEAT", HEAT)}
vec3 hue(float number) {
  float h = fract(number * 0.61803399 + 0.11);
  return 0.35 + 0.6 * (0.5 + 0.5 * cos(6.2831853 * (h - vec3(0.0, 1.0 / 3.0, 2.0 / 3.0))));
}
${VALUE}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy * uScale);
  uvec4 hit = texelFetch(uHit, at, 0), work = texelFetch(uWork, at, 0);
  vec3 c;
  if (uShade >= ${SHADES.nodes}) {
    c = rampHEAT(value(work) / uMost);
  } else if (hit.x == 0u) {
    c = uDark == 1 ? ${floats(BACKGROUND.dark)} : ${floats(BACKGROUND.light)};
  } else if (uShade == ${SHADES.depth}) {
    c = rampHEAT(float(record(uNodes, hit.w * 2u + 1u).w >> 8u) / uMost);
  } else {
    uvec4 rb = record(uTriangles, (hit.x - 1u) * 3u + 1u);
    vec3 a = uintBitsToFloat(record(uTriangles, (hit.x - 1u) * 3u).xyz), b = uintBitsToFloat(rb.xyz);
    vec3 n = cross(b - a, uintBitsToFloat(record(uTriangles, (hit.x - 1u) * 3u + 2u).xyz) - a);
    if (hit.y > 0u) {
      uint i = (hit.y - 1u) * 8u + 3u;
      n = n.x * uintBitsToFloat(record(uInstances, i)).xyz + n.y * uintBitsToFloat(record(uInstances, i + 1u)).xyz
        + n.z * uintBitsToFloat(record(uInstances, i + 2u)).xyz;
    }
    n /= max(max(abs(n.x), abs(n.y)), max(abs(n.z), 1.0e-37));
    n = normalize(n);
    if (uShade == ${SHADES.normal}) c = 0.5 + 0.45 * n;
    else if (uShade == ${SHADES.lit}) c = ${floats(LIT)} * (0.25 + 0.75 * abs(dot(n, uForward)));
    else c = hue(uShade == ${SHADES.part} ? float(rb.w) : hit.y == 0u ? 0.0 : float(record(uInstances, (hit.y - 1u) * 8u + 6u).y)) * (0.45 + 0.55 * abs(dot(n, uForward)));
  }
  outColour = vec4(c, 1.0);
}`;

/** How two trees' work differs. */
export const DIFFERENCE = `${RECORDS}
uniform usampler2D uWorkA, uWorkB;
uniform vec2 uScale;
uniform int uShade;
uniform float uMost;
out vec4 outColour;
${table("DIVERGING", DIVERGING)}
${VALUE}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy * uScale);
  outColour = vec4(rampDIVERGING(0.5 + 0.5 * (value(texelFetch(uWorkB, at, 0)) - value(texelFetch(uWorkA, at, 0))) / uMost), 1.0);
}`;
