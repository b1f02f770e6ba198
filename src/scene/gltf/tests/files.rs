//! Containers, and buffers inside and outside of the model's file.

use super::*;
use crate::scene::read;

fn glb(version: u32, chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, data) in chunks {
        body.extend((data.len() as u32).to_le_bytes());
        body.extend(*kind);
        body.extend(*data);
    }
    let mut bytes = b"glTF".to_vec();
    bytes.extend(version.to_le_bytes());
    bytes.extend((12 + body.len() as u32).to_le_bytes());
    [bytes, body].concat()
}

#[test]
fn glb_containers() {
    let json = edited(|d| d["buffers"][0] = json!({ "byteLength": 76 })).to_string().into_bytes();
    let bin = [square_bytes(), vec![0; 3]].concat();
    let try_glb = |bytes: Vec<u8>| read_bytes(bytes, "test.glb", None, None, &options());
    let good = glb(2, &[(b"JSON", &json), (b"BIN\0", &bin)]);
    assert_eq!(try_glb(good.clone()).unwrap().instanced_triangles(), 1);
    assert!(try_glb(glb(2, &[(b"JSON", &json), (b"XTRA", b"1234"), (b"BIN\0", &bin)])).is_ok());

    let reason = |bytes: Vec<u8>| try_glb(bytes).unwrap_err().to_string();
    assert!(reason(glb(2, &[(b"JSON", &json)])).contains("buffer 0 has no data"));
    assert!(reason(glb(2, &[(b"BIN\0", &bin)])).contains("no JSON chunk"));
    assert!(reason(glb(2, &[(b"JSON", &json), (b"JSON", &json)])).contains("two JSON chunks"));
    assert!(reason(glb(1, &[])).contains("reader of glTF 1.0"));
    for cut in 4..good.len() {
        assert!(try_glb(good[..cut].to_vec()).is_err(), "cut at {cut}");
    }
}

/// A folder with `square.bin` beside, below and above the model.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("model/sub dir")).unwrap();
    for place in ["model/square.bin", "model/sub dir/a b.bin", "outside.bin"] {
        std::fs::write(folder.path().join(place), square_bytes()).unwrap();
    }
    folder
}

fn read_from(folder: &tempfile::TempDir, uri: &str, allow_outside: bool) -> Result<Scene, SceneError> {
    let path = folder.path().join("model/model.gltf");
    std::fs::write(&path, edited(|d| d["buffers"][0]["uri"] = uri.into()).to_string()).unwrap();
    read(&path, &ReadOptions { allow_outside, ..options() })
}

#[test]
fn external_buffers_are_inputs() {
    let folder = folder();
    let scene = read_from(&folder, "sub%20dir/a%20b.bin", false).unwrap();
    assert_eq!(scene.inputs.iter().map(|i| i.name.as_str()).collect::<Vec<_>>(), ["model.gltf", "sub dir/a b.bin"]);
    assert_eq!(scene.inputs[1].path, folder.path().join("model/sub dir/a b.bin"));
    assert_eq!((scene.inputs[1].len, scene.inputs[1].blake3), (76, *blake3::hash(&square_bytes()).as_bytes()));
    assert!(read_from(&folder, "sub%20dir/../square.bin", false).is_ok());

    let missing = read_from(&folder, "nowhere.bin", false).unwrap_err();
    assert_eq!(missing.kind(), ErrorKind::Io);
    assert!(missing.to_string().contains("nowhere.bin, which cannot be opened"), "{missing}");
}

#[test]
fn buffers_outside_the_folder_need_permission() {
    let folder = folder();
    let outside = folder.path().join("outside.bin").display().to_string();
    let uris =
        ["../outside.bin", "%2e%2e/outside.bin", "sub dir/../../outside.bin", &outside, &format!("file://{outside}")];
    for uri in uris {
        let refused = read_from(&folder, uri, false).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::BadModel);
        assert!(matches!(&refused, SceneError::OutsideFolder { uri: named, .. } if named == uri), "{refused}");
        let scene = read_from(&folder, uri, true).unwrap_or_else(|e| panic!("{uri}: {e}"));
        // The way there from the model's folder, never the absolute path.
        let name = &scene.inputs[1].name;
        assert_eq!(name, "../outside.bin");
        assert!(folder.path().join("model").join(name).is_file(), "{uri}");
    }
    for uri in ["..\\outside.bin", "C:\\outside.bin", "\\\\server\\x.bin"] {
        assert!(matches!(read_from(&folder, uri, false), Err(SceneError::OutsideFolder { .. })), "{uri}");
    }
    for uri in ["http://example.org/square.bin", "https:square.bin", "ftp://x/y"] {
        for allow in [false, true] {
            assert!(read_from(&folder, uri, allow).unwrap_err().to_string().contains("only files"), "{uri}");
        }
    }
    assert!(read_from(&folder, "a%00b", true).is_err() && read_from(&folder, "%ff", true).is_err());
}

/// The name of the file that a reference led to.
fn led_to(folder: &tempfile::TempDir, uri: &str, allow_outside: bool) -> String {
    read_from(folder, uri, allow_outside).unwrap_or_else(|e| panic!("{uri}: {e}")).inputs[1].name.clone()
}

#[test]
fn references_are_read_as_meant_and_else_as_exporters_write_them() {
    let folder = folder();
    for name in ["rock#1.bin", "rock?2.bin", "50%25.bin", "char:rock.bin", "twin"] {
        std::fs::write(folder.path().join("model").join(name), square_bytes()).unwrap();
    }
    for (uri, name) in [
        ("sub dir\\a b.bin", "sub dir/a b.bin"),
        ("sub%20dir%5Ca%20b.bin", "sub dir/a b.bin"),
        (".\\sub dir\\a b.bin", "./sub dir/a b.bin"),
        ("./square.bin", "square.bin"),
        ("nowhere/../square.bin", "square.bin"),
        ("square.bin?v=3#part", "square.bin"),
        ("rock#1.bin", "rock#1.bin"),
        ("rock%231.bin", "rock#1.bin"),
        ("rock?2.bin", "rock?2.bin"),
        ("50%25.bin", "50%25.bin"),
        ("char:rock.bin", "char:rock.bin"),
        ("twin#2.bin", "twin"),
    ] {
        assert_eq!(led_to(&folder, uri, false), name, "{uri}");
    }
    // A file whose name has the backslash itself goes first.
    #[cfg(unix)]
    {
        std::fs::write(folder.path().join("model").join("sub dir\\a b.bin"), square_bytes()).unwrap();
        assert_eq!(led_to(&folder, "sub dir\\a b.bin", false), "sub dir\\a b.bin");
    }
    let missing = read_from(&folder, "sub dir\\nowhere.bin", false).unwrap_err();
    assert!(missing.kind() == ErrorKind::Io && missing.to_string().contains("nowhere.bin"), "{missing}");
    assert!(read_from(&folder, "", false).unwrap_err().to_string().contains("no file name"));
}

#[test]
fn file_addresses_may_name_this_machine_and_no_other() {
    let folder = folder();
    let outside = folder.path().join("outside.bin").display().to_string();
    for uri in [format!("file:{outside}"), format!("FILE://localhost{outside}"), format!("file://{outside}?a#b")] {
        assert_eq!(led_to(&folder, &uri, true), "../outside.bin", "{uri}");
    }
    assert_eq!(led_to(&folder, "file:square.bin", true), "square.bin");
    let other = read_from(&folder, &format!("file://elsewhere{outside}"), true).unwrap_err();
    assert!(other.to_string().contains("another machine"), "{other}");
}

#[cfg(unix)]
#[test]
fn symbolic_links_may_not_lead_out() {
    let folder = folder();
    std::os::unix::fs::symlink("../outside.bin", folder.path().join("model/link.bin")).unwrap();
    std::os::unix::fs::symlink("square.bin", folder.path().join("model/inner.bin")).unwrap();
    assert!(read_from(&folder, "inner.bin", false).is_ok());
    assert!(read_from(&folder, "link.bin", false).unwrap_err().to_string().contains("symbolic link"));
    assert!(read_from(&folder, "link.bin", true).is_ok());
}

#[test]
fn a_model_from_memory_has_no_folder() {
    assert!(error(&edited(|d| d["buffers"][0]["uri"] = "square.bin".into())).contains("does not come from a folder"));
}

#[test]
fn data_uris() {
    let with = |uri: &str| edited(|d| d["buffers"][0]["uri"] = uri.into());
    let percent: String = square_bytes().iter().map(|b| format!("%{b:02x}")).collect();
    read_json(&with(&format!("data:,{percent}")));
    read_json(&with(data_uri(&square_bytes()).trim_end_matches('=')));
    assert!(error(&with("data:;base64,!!!!")).contains("not base64"));
    assert!(error(&with("data:;base64")).contains("no comma"));
    assert!(error(&with("data:;base64,")).contains("has 0 bytes"));
    read_json(&with(&data_uri(&square_bytes()).replacen("data:application/octet-stream;", "DATA:model/x;a=b;", 1)));

    // No error shows the data, whatever is wrong with them.
    let payload = "QUJD".repeat(3000);
    for uri in [
        format!("data:;base64,{payload}!"),
        format!("data:{payload}"),
        format!("data;base64,{payload}"),
        format!("data;base64,{}", &payload[..900]),
        format!("da ta:;base64,{payload}"),
        payload.clone(),
    ] {
        let text = error(&with(&uri));
        assert!(!text.contains("QUJDQUJD") && text.len() < 300, "{text}");
    }
}

#[test]
fn memory_is_limited() {
    let text = square().to_string().into_bytes();
    let limit = ReadOptions { max_memory: text.len() as u64 * 2, ..options() };
    let refused = read_bytes(text, "test.gltf", None, None, &limit).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Limit);
}

#[test]
fn every_buffer_that_is_used_counts_towards_the_limit() {
    // Two nodes that are instanced by the numbers of one buffer, or of two. The documents differ in one digit.
    let size = 60_000;
    let document = |second: u32| {
        let big = || json!({ "byteLength": size, "uri": data_uri(&vec![0; size]) });
        let view = |buffer: u32| json!({ "buffer": buffer, "byteLength": 12 });
        let place = |view: u32| json!({ "bufferView": view, "componentType": 5126, "type": "VEC3", "count": 1 });
        let node = |accessor: u32| {
            let places = json!({ "attributes": { "TRANSLATION": accessor } });
            json!({ "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": places } })
        };
        let mut document = square();
        let mut append = |list: &str, more: [Value; 2]| document[list].as_array_mut().unwrap().extend(more);
        append("buffers", [big(), big()]);
        append("bufferViews", [view(1), view(2)]);
        append("accessors", [place(4), place(5)]);
        document["nodes"] = json!([node(4), node(second)]);
        document.to_string().into_bytes()
    };
    let least = |text: Vec<u8>| {
        let is_read = |max_memory: u64| {
            let options = ReadOptions { max_memory, ..options() };
            read_bytes(text.clone(), "test.gltf", None, None, &options).is_ok()
        };
        let (mut refused, mut read) = (0, 10_000_000);
        assert!(is_read(read));
        while read - refused > 1 {
            let middle = (refused + read) / 2;
            *(if is_read(middle) { &mut read } else { &mut refused }) = middle;
        }
        read
    };
    let (one, two) = (least(document(4)), least(document(5)));
    assert!(two >= one + size as u64, "{two} bytes for two buffers, {one} for one");
}
