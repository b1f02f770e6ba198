"""Hold what every command prints with --json against the schemas, and the schemas against documents that are wrong.

Called by test.sh. A real document must be valid, and must have no field that its schema does not name. Then each value of each document is
replaced by one of another type, and each required field is taken out: all of these must be invalid.
"""

import argparse
import base64
import copy
import json
import shutil
import struct
import subprocess
import sys
from pathlib import Path

from jsonschema import Draft202012Validator

HERE = Path(__file__).resolve().parent
SAMPLES = HERE.parent / "samples"
VECTORS = HERE / "vectors"
# Fields that hold anything of their type cannot tell one number from another; what is tested is types and presence.
OTHER_TYPE = {dict: [], list: {}, str: 1, int: "text", float: "text", bool: "text", type(None): {}}
# A list of thousands of equal elements says no more than its first ones.
MOST_ELEMENTS = 12


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("--tool", "--scratch"):
        parser.add_argument(option, required=True)
    arguments = parser.parse_args()
    schemas = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in (HERE / "schema").glob("*.json")}
    for name, schema in schemas.items():
        Draft202012Validator.check_schema(schema)
        assert schema["title"] == name, "%s has the title %s" % (name, schema["title"])

    scratch = Path(arguments.scratch)
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    used, failures, mutants = set(), 0, 0
    for label, document in documents(Path(arguments.tool).resolve(), scratch):
        name = document.get("schema", "bvhc.error.v1")
        used.add(name)
        try:
            mutants += judge(document, schemas[name])
            print("ok    %s is %s" % (label, name))
        except (AssertionError, KeyError) as error:
            failures += 1
            print("FAIL  %s: %s: %s" % (label, name, error))
    for name in sorted(set(schemas) - used):
        failures += 1
        print("FAIL  no command printed %s" % name)
    print("%d schemas, %d wrong documents, %d failures" % (len(schemas), mutants, failures))
    sys.exit(1 if failures else 0)


def documents(tool, scratch):
    """What the commands print, each with the command."""

    def run(*arguments, errors=False):
        command = [str(a) for a in arguments] + ["--json"]
        done = subprocess.run([str(tool)] + command, cwd=scratch, capture_output=True, text=True)
        label = "bvhc " + " ".join(a.replace(str(HERE.parent), "…") for a in command)[:70]
        yield label, json.loads(done.stdout)
        if errors:
            lines = [line for line in done.stderr.splitlines() if line.startswith("{")]
            assert lines, "%s printed no error: %s" % (label, done.stderr)
            yield from ((label + " (stderr)", json.loads(line)) for line in lines)

    # A statement that is not known, and a model that stands at a moment of an animation.
    (scratch / "odd.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nF 1 2 3\n", encoding="utf-8")
    (scratch / "moves.gltf").write_text(json.dumps(moving()), encoding="utf-8")
    yield from run("build", "odd.obj", "moves.gltf", "-n", "-o", "odd/")
    yield from run("build", "odd.obj", "-o", "odd.bvhc", errors=True)
    yield from run("build", "moves.gltf", "-o", "moves.bvhc", "--clip", "Rise", "--time", "1.5")
    yield from run("build", "moves.gltf", "-o", "clip.bvhc", "--clip", "Rise", "--fps", "2")
    yield from run("build", "odd.obj", "-o", "effort.bvhc", "--record-effort")
    yield from run("stats", "effort.bvhc")
    yield from run("stats", "clip.bvhc", "--frames")
    yield from run("stats", "clip.bvhc", "--frames", "--against-fresh")
    yield from run("stats", "clip.bvhc", "--frames", "--rays", "0")
    yield from run("verify", "clip.bvhc", "--device", "cpu", "--rays", "1000")
    yield from run("convert", "clip.bvhc", "-o", "first.bvhc", "--frame", "0")
    yield from run("build", SAMPLES / "helicopter/heli.####.obj", "--frames", "1-2", "-o", "heli.bvhc", "--codec", "compact")
    yield from run("info", "odd.bvhc", "moves.bvhc", "clip.bvhc", "heli.bvhc")
    models = [SAMPLES / "pillar.obj", SAMPLES / "forest.gltf"]
    yield from run("build", *models, "-n", "-o", "out/")
    yield from run("build", *models, "missing.obj", "-o", "out/", errors=True)
    yield from run("build", *models, "-o", "out/")
    yield from run("convert", "out/forest.bvhc", "-o", "small.bvhc", "--codec", "zstd")
    yield from run("convert", VECTORS / "valid/unknown-ancillary-section.bvhc", "-o", "stripped.bvhc", "--strip-unknown")
    yield from run("convert", "out/forest.bvhc", "-o", "wide.bvhc", "--nodes", "compact8")
    yield from run("stats", "wide.bvhc")
    yield from run("verify", "wide.bvhc", "--device", "cpu", "--rays", "2000")
    files = ["out/pillar.bvhc", "out/forest.bvhc", "small.bvhc", "stripped.bvhc"]
    yield from run("info", *files, VECTORS / "invalid/E0206-meta-encoding.bvhc")
    yield from run("stats", *files)
    yield from run("stats", "small.bvhc", "--epo", "off", "--rays", "256")
    conditions = ["--fail-if", "sah > +2%", "--fail-if", "depth > 1", "--fail-if", "visits < -1"]
    yield from run("stats", "--compare", files[0], files[1], "--rays", "256", *conditions)
    picture = ["--size", "24x16", "-o", "picture.png"]
    yield from run("view", files[0], *picture, "--shade", "cost", "--boxes", "2")
    yield from run("view", files[1], *picture, "--shade", "instance")
    yield from run("view", "clip.bvhc", "--frame", "0", *picture)
    yield from run("view", "--compare", files[1], files[2], *picture)
    eye = ["--camera", "0,5,9,0,0,0,40"]
    pages = [[files[0]], ["clip.bvhc", *eye], ["--compare", files[1], files[2]]]
    for shown in pages:
        yield from run("view", *shown, "--html", "page.html")
        yield "the head of that page", head_of(scratch / "page.html")
    yield from run("view", files[0], "--tree", "--depth", "2")
    yield from run("view", files[1], "--tree")
    yield from run("check", *files, *sorted((VECTORS / "invalid").glob("*.bvhc")))
    for command in (["info"], ["check"], ["stats"], ["verify", "--device", "cpu", "--rays", "500"], ["verify", "--accuracy", "--rays", "200"]):
        yield from run(*command, "odd.bvhc", "gone.bvhc", errors=True)
    yield from run("stats", "clip.bvhc", "gone.bvhc", "--frames", "--rays", "0", errors=True)
    yield from run("explain", "--list")
    yield from run("explain", "E0402")
    on_cpu = ["--device", "cpu"]
    yield from run("verify", *files[:2], "--rays", "2000", *on_cpu)
    yield from run("verify", files[0], "--rays", "2000", "--any-hit", "--source", models[0], *on_cpu)
    yield from run("verify", break_a_box(scratch, scratch / files[0]), "--rays", "20000", *on_cpu)
    yield from run("verify", files[1], "--ray", "0,5,0,1,-0.1,0", *on_cpu)
    yield from run("verify", files[0], "--ray", "0,0.5,-9,0,0,1", *on_cpu)
    yield from run("verify", *files[:2], "--accuracy", "--rays", "500")
    yield from run("verify", "--list-devices")
    chart = ["--rays", "64", "--rounds", "1"]
    all_of_it = ["-o", "chart.html", "--accuracy-rays", "200", "--recipe", "--method sweep --reinsert 1"]
    yield from run("chart", "odd.obj", "clip.bvhc", *chart, *all_of_it)
    yield from run("chart", SAMPLES / "pillar.obj", *chart, "--accuracy-rays", "0", "--budget", "0s")
    yield from run("chart", "--stability=ball,gait,nan,F29", "--sizes", "60,120", "--rays", "64", "--rounds", "1", "--png", "stability.png")


def head_of(page):
    """What a page says of its scenes."""
    text = page.read_text(encoding="utf-8")
    head = text.split('<script type="application/json" id="head">')[1].split("</script>")[0]
    return json.loads(head)


def moving():
    """A triangle that rises from 1 s to 2 s."""
    floats = struct.pack("<17f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 2, 0, 0, 0, 0, 0, 1)
    views, accessors = [], []
    for kind, count, offset, length in (("VEC3", 3, 0, 36), ("SCALAR", 2, 36, 8), ("VEC3", 2, 44, 24)):
        accessors.append({"bufferView": len(views), "componentType": 5126, "type": kind, "count": count})
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": length})
    channel = {"sampler": 0, "target": {"node": 0, "path": "translation"}}
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 68, "uri": "data:;base64," + base64.b64encode(floats).decode()}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "animations": [{"name": "Rise", "channels": [channel], "samplers": [{"input": 1, "output": 2}]}],
    }


def break_a_box(scratch, path):
    """The file with a box that is too small, every hash made right again: verify must find a wrong hit and blame a record."""
    import blake3

    data = bytearray(path.read_bytes())
    count, table = struct.unpack_from("<I", data, 40)[0], struct.unpack_from("<Q", data, 48)[0]
    entries = [table + 128 * i for i in range(count)]
    node = next(e for e in entries if data[e : e + 4] == b"NODE")
    offset, length = struct.unpack_from("<QQ", data, node + 16)
    first = offset + 32 * 2  # the first child of the root
    low, high = struct.unpack_from("<3f", data, first), struct.unpack_from("<3f", data, first + 16)
    struct.pack_into("<3f", data, first + 16, *((a + b) / 2 for a, b in zip(low, high)))
    digest = blake3.blake3(bytes(data[offset : offset + length])).digest()
    data[node + 64 : node + 128] = digest + digest

    # content_id, then file_id over everything else.
    content = b""
    for e in sorted((e for e in entries if struct.unpack_from("<I", data, e + 8)[0] & 4), key=lambda e: bytes(data[e : e + 8])):
        content += bytes(data[e : e + 8]) + bytes(data[e + 12 : e + 14]) + bytes(2)
        content += bytes(data[e + 48 : e + 52]) + bytes(data[e + 32 : e + 40]) + bytes(data[e + 64 : e + 96])
    data[96:128] = blake3.blake3(content, derive_key_context="bvhc v1 content id").digest()
    header = bytes(data[:64]) + bytes(32) + bytes(data[96:256])
    whole = header + bytes(data[table : table + 128 * count])
    data[64:96] = blake3.blake3(whole, derive_key_context="bvhc v1 file id").digest()
    broken = scratch / "broken.bvhc"
    broken.write_bytes(data)
    return broken


def judge(document, schema):
    """Fail where the document is not what the schema says, or a wrong one passes; how many wrong ones were tried."""
    strict = copy.deepcopy(schema)
    close(strict)
    validator = Draft202012Validator(strict)
    for error in validator.iter_errors(document):
        raise AssertionError("/%s: %s" % ("/".join(map(str, error.absolute_path)), error.message[:200]))

    tried = 0
    validator = Draft202012Validator(schema)
    for mutant, what in wrong(document, schema, schema):
        assert not validator.is_valid(mutant(document)), "%s, and yet it is valid" % what
        tried += 1
    return tried


def close(schema):
    """Allow no field without a name. Published schemas do allow them: fields may be added."""
    if isinstance(schema, dict):
        for key, value in schema.items():
            if key not in ("const", "enum", "required"):
                close(value)
        if schema.get("type") == "object":
            schema["additionalProperties"] = False
    elif isinstance(schema, list):
        for value in schema:
            close(value)


def wrong(value, schema, root, path=()):
    """Ways to make a document wrong: functions of the document, and what they do, in words."""
    yield (lambda document: put(document, path, OTHER_TYPE[type(value)])), "%s has another type" % "/".join(map(str, path))
    if isinstance(value, dict):
        for key in sorted(required(value, schema, root)):
            yield (lambda document, key=key: put(document, path + (key,), None, take_out=True)), "%s is gone" % "/".join(
                map(str, path + (key,))
            )
        for key, inner in value.items():
            yield from wrong(inner, part(value, key, schema, root), root, path + (key,))
    elif isinstance(value, list):
        for i, inner in enumerate(value[:MOST_ELEMENTS]):
            yield from wrong(inner, resolve(value, schema, root).get("items", {}), root, path + (i,))


def resolve(value, schema, root):
    """The branch of a schema that a value goes by."""
    while "$ref" in schema:
        schema = root["$defs"][schema["$ref"].rsplit("/", 1)[1]]
    for branch in schema.get("oneOf", []) + schema.get("anyOf", []):
        if Draft202012Validator({**branch, "$defs": root.get("$defs", {})}).is_valid(value):
            return resolve(value, branch, root)
    return schema


def required(value, schema, root):
    return resolve(value, schema, root).get("required", [])


def part(value, key, schema, root):
    return resolve(value, schema, root).get("properties", {}).get(key, {})


def put(document, path, new, take_out=False):
    """A copy of the document with another value at this place, or none."""
    if not path:
        return new
    changed = copy.copy(document)
    if take_out and len(path) == 1:
        del changed[path[0]]
    else:
        changed[path[0]] = put(document[path[0]], path[1:], new, take_out)
    return changed


if __name__ == "__main__":
    main()
