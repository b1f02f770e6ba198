#!/usr/bin/env bash
# three.js 0.187.0, OBJLoader: one line or point statement turns all faces of its object into lines or points, and no ray hits them.
#
# Expected: p, l and f are elements of their own, and an object may have any mix of them (Wavefront's "Object Files", format 3.0). Two faces
# stay two triangles, whatever stands beside them.
# Seen: an object has one kind. With "l 1 4" before or behind two faces, the object becomes LineSegments of 8 points: the faces' corners
# are taken as ends of line pieces, and the triangles are gone. With "p 1" it becomes Points. There is no warning. Without these
# statements the same object is a mesh that the same ray hits.
# Hurts: scans and CAD exports with leftover edges ("loose geometry"): a model loses whole objects.
# bvhc: keeps the faces, skips lines and points, and counts them in a warning (tests/independent/corners_obj.py, case
# "other_elements").
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
npm --prefix "$work" install --silent --no-audit --no-fund three@0.187.0
cat > "$work/run.mjs" <<'JS'
import { Raycaster, REVISION, Vector3 } from 'three';
import { OBJLoader } from 'three/addons/loaders/OBJLoader.js';

const vertices = 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no thing\n';
const faces = 'f 1 2 3\nf 1 2 4\n';
console.log('revision', REVISION);
for (const [name, elements] of [
  ['faces alone', faces],
  ['a line behind', faces + 'l 1 4\n'],
  ['a line before', 'l 1 4\n' + faces],
  ['a point behind', faces + 'p 1\n'],
]) {
  const group = new OBJLoader().parse(vertices + elements);
  group.updateMatrixWorld(true);
  const raycaster = new Raycaster(new Vector3(0.2, 0.2, 5), new Vector3(0, 0, -1));
  raycaster.params.Line.threshold = 0.01;
  raycaster.params.Points.threshold = 0.01;
  const objects = group.children.map((o) => `${o.type} of ${o.geometry.attributes.position.count} points`);
  console.log(`${name}: ${objects.join(', ')}, ${raycaster.intersectObject(group, true).length} hits`);
}
JS
node "$work/run.mjs" | tee "$work/out"
expected='revision 187
faces alone: Mesh of 6 points, 1 hits
a line behind: LineSegments of 8 points, 0 hits
a line before: LineSegments of 8 points, 0 hits
a point behind: Points of 7 points, 0 hits'
if [ "$(cat "$work/out")" != "$expected" ]; then
    printf 'CHANGED: OBJLoader of three.js 0.187.0 reads such objects otherwise. Seen before:\n%s\n' "$expected" >&2
    exit 1
fi
echo "as described: one line or point statement takes the two triangles away"
