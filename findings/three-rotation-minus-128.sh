#!/usr/bin/env bash
# three.js 0.187.0, GLTFLoader: a rotation key of normalised bytes that has -128 makes its node 3 % larger.
#
# Expected: a normalised signed byte c is max(c / 127, -1), so -128 and -127 are both -1 (glTF 2.0, section 3.11).
# A half turn stored as (0, -128, 0, 0) is the half turn (0, -1, 0, 0).
# Seen: keys are divided by 127 without the lower bound. The quaternion is 1.00787 long, and the node's matrix is no rotation any
# more: a point at distance 1 goes to distance 1.03162. From -127 the same turn comes out right. Vertex attributes have the bound in the same
# library, so a file can be right at rest and wrong when played.
# Hurts: compact animations; hits of a posed model move by 3 % of its size for just these keys.
# bvhc: one decoder with the bound for vertices, keys, targets and matrices (src/scene/gltf/tests/animation.rs,
# integers_of_rotations_are_normalized_and_the_lowest_is_minus_one).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
npm --prefix "$work" install --silent --no-audit --no-fund three@0.187.0
cat > "$work/run.mjs" <<'JS'
import { AnimationMixer, REVISION, Vector3 } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

globalThis.ProgressEvent ??= class {}; // what browsers have: the loader reports by it
function model(turn) {
  const data = Buffer.alloc(52);
  [0, 0, 0, 1, 0, 0, 0, 1, 0].forEach((x, i) => data.writeFloatLE(x, 4 * i)); // a triangle
  [0, 1].forEach((t, i) => data.writeFloatLE(t, 36 + 4 * i)); // the times of two keys
  [...turn, ...turn].forEach((x, i) => data.writeInt8(x, 44 + i));
  return JSON.stringify({
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    animations: [{ samplers: [{ input: 1, output: 2 }], channels: [{ sampler: 0, target: { node: 0, path: 'rotation' } }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 0] },
      { bufferView: 1, componentType: 5126, count: 2, type: 'SCALAR', min: [0], max: [1] },
      { bufferView: 2, componentType: 5120, normalized: true, count: 2, type: 'VEC4' },
    ],
    bufferViews: [[0, 36], [36, 8], [44, 8]].map(([byteOffset, byteLength]) => ({ buffer: 0, byteOffset, byteLength })),
    buffers: [{ byteLength: 52, uri: 'data:application/octet-stream;base64,' + data.toString('base64') }],
  });
}
console.log('revision', REVISION);
for (const turn of [[0, -127, 0, 0], [0, -128, 0, 0], [-128, 0, 0, 0]]) {
  const gltf = await new Promise((done, failed) => new GLTFLoader().parse(model(turn), '', done, failed));
  const mixer = new AnimationMixer(gltf.scene);
  mixer.clipAction(gltf.animations[0]).play();
  mixer.setTime(0);
  gltf.scene.updateMatrixWorld(true);
  const node = gltf.scene.children[0];
  const far = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((p) => new Vector3(...p).applyMatrix4(node.matrixWorld).length().toFixed(5));
  console.log(`${turn}: length ${node.quaternion.length().toFixed(5)}, the axes become ${far.join(' ')} long`);
}
JS
node "$work/run.mjs" | tee "$work/out"
expected='revision 187
0,-127,0,0: length 1.00000, the axes become 1.00000 1.00000 1.00000 long
0,-128,0,0: length 1.00787, the axes become 1.03162 1.00000 1.03162 long
-128,0,0,0: length 1.00787, the axes become 1.00000 1.03162 1.03162 long'
if [ "$(cat "$work/out")" != "$expected" ]; then
    printf 'CHANGED: GLTFLoader of three.js 0.187.0 reads -128 otherwise. Seen before:\n%s\n' "$expected" >&2
    exit 1
fi
echo "as described: -128 stretches by 1.03162 across the axis of the turn; -127 does not"
