//! glTF: the document is changed as JSON and its buffers as bytes and numbers, so that it stays a document with buffers.

use super::{Bytes, Dice, word};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};

/// A document, and the binary part of a GLB.
struct Model {
    json: Value,
    bin: Option<Vec<u8>>,
}

const PREFIX: &str = "data:application/octet-stream;base64,";

impl Model {
    fn of(bytes: &[u8]) -> Option<Model> {
        let Some(chunks) = bytes.strip_prefix(b"glTF") else {
            return Some(Model { json: serde_json::from_slice(bytes).ok().filter(Value::is_object)?, bin: None });
        };
        let number = |at: usize| chunks.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
        let end = 16usize.checked_add(number(8)?)?;
        let json = serde_json::from_slice(chunks.get(16..end)?).ok().filter(Value::is_object)?;
        let bin = number(end).and_then(|len| chunks.get(end + 8..end.checked_add(8 + len)?)).unwrap_or_default();
        Some(Model { json, bin: Some(bin.to_vec()) })
    }

    fn bytes(&self) -> Vec<u8> {
        let mut text = serde_json::to_vec(&self.json).unwrap_or_default();
        let Some(bin) = &self.bin else { return text };
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((28 + text.len() as u32 + bin.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", bin)] {
            out.extend((chunk.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(chunk);
        }
        out
    }
}

pub fn change(input: &mut Vec<u8>, dice: &mut Dice, raw: &mut Bytes) {
    change_with(input, dice, raw, &[]);
}

/// Mostly what poses: skins, joints, weights, targets, nodes.
pub fn change_pose(input: &mut Vec<u8>, dice: &mut Dice, raw: &mut Bytes) {
    change_with(
        input,
        dice,
        raw,
        &["/skin", "/nodes", "JOINTS", "WEIGHTS", "targets", "weights", "/accessors", "/animations"],
    );
}

fn change_with(input: &mut Vec<u8>, dice: &mut Dice, raw: &mut Bytes, focus: &[&str]) {
    let model = if dice.one_in(24) { None } else { Model::of(input) };
    let Some(mut model) = model else { return raw.change(input) };
    for _ in 0..1 + dice.below(3) {
        match dice.below(8) {
            0 | 1 => of_buffers(&mut model, dice, raw),
            2 => put_in(&mut model.json, dice),
            _ => of_values(&mut model.json, dice, focus),
        }
    }
    let changed = model.bytes();
    if changed.len() <= raw.room {
        *input = changed;
    } else {
        raw.change(input);
    }
}

/// The places of a document, as JSON pointers.
fn places(value: &Value, at: &str, out: &mut Vec<String>) {
    let mut visit = |key: &str, inner: &Value| {
        let place = format!("{at}/{}", key.replace('~', "~0").replace('/', "~1"));
        places(inner, &place, out);
        out.push(place);
    };
    match value {
        Value::Object(members) => members.iter().for_each(|(key, inner)| visit(key, inner)),
        Value::Array(items) => items.iter().enumerate().for_each(|(i, inner)| visit(&i.to_string(), inner)),
        _ => {}
    }
}

/// Replace, drop, double or exchange a value.
fn of_values(json: &mut Value, dice: &mut Dice, focus: &[&str]) {
    let mut all = Vec::new();
    places(json, "", &mut all);
    let chosen: Vec<&String> = all.iter().filter(|place| focus.iter().any(|word| place.contains(word))).collect();
    let among = if chosen.is_empty() || dice.one_in(3) { all.iter().collect() } else { chosen };
    if among.is_empty() {
        return;
    }
    let place = among[dice.below(among.len())];
    match dice.below(10) {
        0 => remove(json, place),
        1 => {
            let from = among[dice.below(among.len())];
            let copy = json.pointer(from).cloned();
            if let (Some(value), Some(copy)) = (json.pointer_mut(place), copy) {
                *value = copy;
            }
        }
        2 => {
            if let Some(Value::Array(items)) = json.pointer_mut(parent(place))
                && !items.is_empty()
                && items.len() < 64
            {
                let item = items[dice.below(items.len())].clone();
                items.insert(dice.below(items.len() + 1), item);
            }
        }
        _ => {
            if let Some(value) = json.pointer_mut(place) {
                *value = other(value, dice);
            }
        }
    }
}

fn parent(place: &str) -> &str {
    place.rsplit_once('/').map_or("", |(parent, _)| parent)
}

fn remove(json: &mut Value, place: &str) {
    let key = place.rsplit('/').next().unwrap_or_default().replace("~1", "/").replace("~0", "~");
    match json.pointer_mut(parent(place)) {
        Some(Value::Object(members)) => drop(members.remove(&key)),
        Some(Value::Array(items)) => {
            if let Ok(i) = key.parse::<usize>()
                && i < items.len()
            {
                items.remove(i);
            }
        }
        _ => {}
    }
}

/// Another value in the place of this one; mostly of its type.
fn other(value: &Value, dice: &mut Dice) -> Value {
    const WHOLE: [i64; 22] = [
        0,
        1,
        -1,
        2,
        3,
        4,
        5,
        6,
        12,
        16,
        255,
        256,
        5120,
        5121,
        5123,
        5125,
        5126,
        65_535,
        1 << 31,
        (1 << 32) - 1,
        1 << 32,
        i64::MAX,
    ];
    const REAL: [f64; 16] =
        [0.0, -0.0, 0.5, 1.0, -1.0, 2.0, 1e-46, 1e-30, 1e20, 3.4e38, 3.5e38, 1e300, -1e39, 1e15, 0.1, 1e-310];
    if dice.one_in(20) {
        return dice_value(dice);
    }
    match value {
        Value::Number(n) => match (dice.below(4), n.as_i64(), n.as_f64()) {
            (0, Some(whole), _) => json!(whole.wrapping_add(1)),
            (1, Some(whole), _) => json!(whole.wrapping_sub(1)),
            (2, _, Some(real)) => json!(real * dice.of(&[-1.0, 2.0, 0.5, 1e6, 1e-6])),
            (_, Some(_), _) => json!(dice.of(&WHOLE)),
            _ => json!(dice.of(&REAL)),
        },
        Value::String(text) => {
            const WORDS: [&str; 12] = [
                "SCALAR",
                "VEC2",
                "VEC3",
                "VEC4",
                "MAT4",
                "2.0",
                "POSITION",
                "KHR_mesh_quantization",
                "EXT_mesh_gpu_instancing",
                "KHR_draco_mesh_compression",
                "data:,",
                "",
            ];
            let mut chars: Vec<char> = text.chars().take(4096).collect();
            if chars.is_empty() || dice.one_in(2) {
                return json!(WORDS[dice.below(WORDS.len())]);
            }
            let at = dice.below(chars.len());
            chars[at] = dice.of(&['\\', '/', '%', 'ä', '\u{0}', ' ', '.', 'A', '=']);
            json!(chars.into_iter().collect::<String>())
        }
        Value::Bool(flag) => json!(!flag),
        Value::Array(items) if !items.is_empty() => {
            let mut items = items.clone();
            match dice.below(3) {
                0 => items.truncate(dice.below(items.len())),
                1 => items.reverse(),
                _ => items.push(items[0].clone()),
            }
            Value::Array(items)
        }
        _ => dice_value(dice),
    }
}

fn dice_value(dice: &mut Dice) -> Value {
    let choices = [json!(null), json!(0), json!([]), json!({}), json!("x"), json!([[[[]]]]), json!(1e39), json!(true)];
    choices[dice.below(choices.len())].clone()
}

/// A member that the format knows, at a place where it may stand.
fn put_in(json: &mut Value, dice: &mut Dice) {
    let small = |dice: &mut Dice| json!(dice.below(6));
    let list = ["nodes", "accessors", "bufferViews", "meshes", "skins", "scenes"][dice.below(6)];
    let (i, j, k) = (dice.below(6), dice.below(6), dice.below(6));
    let sparse = json!({"count": i, "indices": {"bufferView": j, "componentType": 5121}, "values": {"bufferView": k}});
    let instancing = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": i, "ROTATION": j, "SCALE": k}}});
    let members: Vec<(&str, Value)> = match list {
        "nodes" => vec![
            ("mesh", json!(i)),
            ("skin", json!(j)),
            ("children", json!([k, i])),
            ("weights", json!([0.5, 1, -3])),
            ("matrix", json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 5, 5, 1])),
            ("scale", json!([1, 1, 0])),
            ("translation", json!([5e5, 0, -4e6])),
            ("rotation", json!([0, 0, 3, 4])),
            ("extensions", instancing),
            ("extensions", json!({"KHR_node_visibility": {"visible": false}})),
        ],
        "accessors" => vec![
            ("sparse", sparse),
            ("normalized", json!(true)),
            ("byteOffset", json!(j)),
            ("count", json!(k)),
            ("componentType", json!(dice.of(&[5120, 5121, 5122, 5123, 5125, 5126]))),
        ],
        "bufferViews" => {
            vec![("byteStride", json!(4 * dice.below(70))), ("byteOffset", json!(i)), ("byteLength", json!(12))]
        }
        "meshes" => vec![("weights", json!([1, 0.25])), ("name", json!("m"))],
        "skins" => vec![("inverseBindMatrices", json!(i)), ("joints", json!([j, k])), ("skeleton", json!(0))],
        _ => vec![("nodes", json!([i, j])), ("name", json!("s"))],
    };
    let (key, value) = members[dice.below(members.len())].clone();
    // Within a mesh, its primitives have more to be changed.
    if list == "meshes" && dice.one_in(2) {
        let inner = [("mode", json!(dice.below(8))), ("indices", small(dice)), ("targets", json!([{"POSITION": 0}]))];
        let (key, value) = inner[dice.below(3)].clone();
        let member = pick(json, list, dice).and_then(|mesh| mesh.get_mut("primitives")?.get_mut(0)?.as_object_mut());
        if let Some(primitive) = member {
            if dice.one_in(3) {
                let name = ["JOINTS_0", "WEIGHTS_0", "JOINTS_1", "WEIGHTS_1", "POSITION"][dice.below(5)];
                if let Some(attributes) = primitive.get_mut("attributes").and_then(Value::as_object_mut) {
                    attributes.insert(name.to_owned(), small(dice));
                }
            } else {
                primitive.insert(key.to_owned(), value);
            }
        }
        return;
    }
    if let Some(item) = pick(json, list, dice) {
        item.insert(key.to_owned(), value);
    }
}

fn pick<'a>(json: &'a mut Value, list: &str, dice: &mut Dice) -> Option<&'a mut Map<String, Value>> {
    let items = json.get_mut(list)?.as_array_mut()?;
    let i = dice.below(items.len());
    items.get_mut(i)?.as_object_mut()
}

/// Words and bytes of a buffer. Its stated length follows, most of the time.
fn of_buffers(model: &mut Model, dice: &mut Dice, raw: &mut Bytes) {
    let Model { json, bin } = model;
    let Some(buffers) = json.get_mut("buffers").and_then(Value::as_array_mut) else { return };
    let i = dice.below(buffers.len());
    let Some(buffer) = buffers.get_mut(i).and_then(Value::as_object_mut) else { return };
    let embedded = buffer.get("uri").and_then(Value::as_str).and_then(|uri| uri.split_once("base64,"));
    let decoded = embedded.and_then(|(_, text)| STANDARD.decode(text).ok());
    let (mut bytes, in_text) = match (decoded, bin.as_ref()) {
        (Some(bytes), _) => (bytes, true),
        (None, Some(bin)) => (bin.clone(), false),
        _ => return,
    };
    if dice.one_in(5) {
        raw.change(&mut bytes);
    } else if dice.one_in(6) {
        // An element of zeros: no weight, no direction, no area.
        let at = 4 * dice.below(bytes.len() / 4);
        bytes.iter_mut().skip(at).take(dice.of(&[4, 12, 16])).for_each(|byte| *byte = 0);
    } else {
        for _ in 0..1 + dice.below(3) {
            let at = 4 * dice.below(bytes.len() / 4);
            if let Some(four) = bytes.get_mut(at..at + 4) {
                let old = u32::from_le_bytes([four[0], four[1], four[2], four[3]]);
                // Indices and joints are small, positions are floats.
                let new = if dice.one_in(3) { dice.roll() as u32 & 0x0303_0303 } else { word(old, dice) };
                four.copy_from_slice(&new.to_le_bytes());
            }
        }
    }
    if !dice.one_in(6) {
        buffer.insert("byteLength".to_owned(), json!(bytes.len()));
    }
    if in_text {
        buffer.insert("uri".to_owned(), json!(format!("{PREFIX}{}", STANDARD.encode(&bytes))));
    } else {
        *bin = Some(bytes);
    }
}
