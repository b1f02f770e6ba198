#!/usr/bin/env bash
# three.js 0.187.0, GLTFLoader: a morph target that has normals only makes the whole mesh larger.
#
# Expected: a target has any subset of the attributes; what it does not have it does not change (glTF 2.0, section 3.7.2.2). A target
# of normals alone moves no vertex.
# Seen: where another target of the primitive has positions, the base positions are put in for the missing ones, and since targets are
# differences they are added: with weight 1 every vertex stands at twice its place, the triangle is 4 times as large. Alone in its primitive,
# the same target does no harm.
# Hurts: faces whose targets carry only normals for some shapes; boxes and hits are far off, and grow with the distance from the origin.
# bvhc: such a target moves nothing (src/scene/gltf/tests/morphs.rs, targets_without_positions_keep_them…).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
npm --prefix "$work" install --silent --no-audit --no-fund three@0.187.0
cat > "$work/run.mjs" <<'JS'
import { REVISION, Vector3 } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

globalThis.ProgressEvent ??= class {}; // what browsers have: the loader reports by it
const corners = [[1, 1, 0], [2, 1, 0], [1, 2, 0]];
const arrays = [corners, Array(3).fill([0, 0, 1]), Array(3).fill([0, 0, 1]), Array(3).fill([0.5, 0, 0])];
const data = new Float32Array(arrays.flat(2));
const accessors = arrays.map((rows, i) => ({
  bufferView: 0, byteOffset: 36 * i, componentType: 5126, count: 3, type: 'VEC3',
  min: [0, 1, 2].map((k) => Math.min(...rows.map((r) => r[k]))), max: [0, 1, 2].map((k) => Math.max(...rows.map((r) => r[k]))),
}));
const uri = 'data:application/octet-stream;base64,' + Buffer.from(data.buffer).toString('base64');
// Accessors: 0 positions, 1 normals, 2 a target's positions, 3 a target's normals.
const model = (targets, weights) => JSON.stringify({
  asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1 }, targets }], weights }],
  accessors, bufferViews: [{ buffer: 0, byteLength: data.byteLength }], buffers: [{ byteLength: data.byteLength, uri }],
});
console.log('revision', REVISION);
for (const [name, targets, weights] of [
  ['normals alone', [{ NORMAL: 3 }], [1]],
  ['beside one with positions', [{ POSITION: 2, NORMAL: 3 }, { NORMAL: 3 }], [0, 1]],
]) {
  const { scene } = await new Promise((done, failed) => new GLTFLoader().parse(model(targets, weights), '', done, failed));
  const mesh = scene.children[0];
  console.log(`${name}:`, [0, 1, 2].map((i) => mesh.getVertexPosition(i, new Vector3()).toArray().join(' ')).join(', '));
}
JS
node "$work/run.mjs" | tee "$work/out"
expected='revision 187
normals alone: 1 1 0, 2 1 0, 1 2 0
beside one with positions: 2 2 0, 4 2 0, 2 4 0'
if [ "$(cat "$work/out")" != "$expected" ]; then
    printf 'CHANGED: GLTFLoader of three.js 0.187.0 poses such targets otherwise. Seen before:\n%s\n' "$expected" >&2
    exit 1
fi
echo "as described: the second mesh is twice as large and moved; both should stand at 1 1 0, 2 1 0, 1 2 0"
