//! One self-contained page in which a browser traverses the records of a file: what `web` holds, joined with packed scenes.
//!
//! The page asks no network. Its modules are plain JavaScript; here they become one script, in an
//! order in which each stands behind what it imports.

mod below;
mod pack;

pub use below::Below;
pub use pack::{Counts, MOST_BYTES, PackError, Packed, bytes_of, pack};

use super::html::{escaped, filled};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// A scene of a page: a file, or a frame of one.
#[derive(Clone, Debug, Serialize)]
pub struct PageScene {
    /// What the scene is called: the name of its file.
    pub name: String,
    /// Of a sequence: the number of the frame in the source.
    pub frame: Option<i32>,
    /// Facts about the file, as a label and a text.
    pub facts: Vec<(String, String)>,
    /// The name of each row of `GEOM`, empty for one without a name.
    pub parts: Vec<String>,
    /// What the data holds.
    pub counts: Counts,
    /// The packed records.
    #[serde(skip)]
    pub data: Vec<u8>,
}

/// Where a page looks from at first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PageCamera {
    /// Where the camera stands.
    pub eye: [f64; 3],
    /// What it looks at.
    pub target: [f64; 3],
    /// Degrees from edge to edge across the longer side of the picture.
    pub fov: f64,
    /// The axis that points up, 0 to 2.
    pub up: usize,
}

/// How the scenes of a page belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Together {
    /// One scene alone, or frames that follow each other.
    Frames,
    /// Two trees over one model.
    Compare,
}

#[derive(Serialize)]
struct Head<'a> {
    schema: &'static str,
    version: &'static str,
    together: Together,
    camera: Option<PageCamera>,
    scenes: &'a [PageScene],
}

const TEMPLATE: &str = include_str!("web/page.html");
const STYLE: &str = include_str!("web/page.css");

/// In an order in which each stands behind what it imports.
const MODULES: [(&str, &str); MODULE_COUNT] = [
    ("vector", include_str!("web/vector.js")),
    ("data", include_str!("web/data.js")),
    ("tree", include_str!("web/tree.js")),
    ("trace", include_str!("web/trace.js")),
    ("colour", include_str!("web/colour.js")),
    ("shaders", include_str!("web/shaders.js")),
    ("gpu", include_str!("web/gpu.js")),
    ("cpu", include_str!("web/cpu.js")),
    ("camera", include_str!("web/camera.js")),
    ("input", include_str!("web/input.js")),
    ("overlay", include_str!("web/overlay.js")),
    ("histogram", include_str!("web/histogram.js")),
    ("treemap", include_str!("web/treemap.js")),
    ("ray_panel", include_str!("web/ray_panel.js")),
    ("node_panel", include_str!("web/node_panel.js")),
    ("file_panel", include_str!("web/file_panel.js")),
    ("view", include_str!("web/view.js")),
    ("proof", include_str!("web/proof.js")),
    ("main", include_str!("web/main.js")),
];
const MODULE_COUNT: usize = 19;

/// The page as an HTML document.
pub fn page(scenes: &[PageScene], together: Together, camera: Option<PageCamera>) -> String {
    let head = Head { schema: "bvhc.page.v1", version: env!("CARGO_PKG_VERSION"), together, camera, scenes };
    // A name of the model may hold the end of a script, so no angle bracket stands there as itself.
    let head = serde_json::to_string(&head).unwrap_or_default().replace('<', "\\u003c");
    let data: String = scenes
        .iter()
        .enumerate()
        .map(|(i, scene)| {
            format!("<script type=\"text/plain\" id=\"data-{i}\">{}</script>\n", STANDARD.encode(&scene.data))
        })
        .collect();
    let title = escaped(scenes.first().map_or("", |s| &s.name));
    let code = code();
    let parts = [("%TITLE%", &*title), ("%STYLE%", STYLE), ("%HEAD%", &head), ("%DATA%", &data), ("%CODE%", &code)];
    filled(TEMPLATE, parts)
}

/// The modules as one script.
fn code() -> String {
    MODULES.iter().map(|(name, text)| format!("// --- {name}.js\n{}", alone(text))).collect()
}

/// A module without its imports and exports: all of them share the names of one script.
fn alone(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.starts_with("import "));
    lines.map(|line| format!("{}\n", line.strip_prefix("export ").unwrap_or(line))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::View;

    fn scene(name: &str) -> PageScene {
        let view = View { nodes: &[], triangles: &[], geoms: &[], blases: &[], tlas_nodes: &[], instances: &[] };
        let packed = pack(&view).unwrap();
        let name = name.to_string();
        PageScene { name, frame: None, facts: Vec::new(), parts: Vec::new(), counts: packed.counts, data: packed.data }
    }

    #[test]
    fn every_module_is_joined_and_none_imports() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/report/page/web");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter_map(|name| Some(name.strip_suffix(".js")?.to_string()))
            .collect();
        files.sort();
        let mut joined: Vec<&str> = MODULES.iter().map(|(name, _)| *name).collect();
        joined.sort_unstable();
        assert_eq!(files, joined);
        let code = code();
        assert!(!code.lines().any(|line| line.starts_with("import ") || line.starts_with("export ")));
        assert!(!code.contains("</script"));
        // One script has each name once.
        let mut names: Vec<&str> = code
            .lines()
            .filter_map(|line| {
                ["function ", "async function ", "class ", "const ", "let "].iter().find_map(|k| line.strip_prefix(k))
            })
            .map(|rest| rest.split([' ', '(', ';']).next().unwrap_or_default())
            .collect();
        let all = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all);
    }

    #[test]
    fn names_of_files_and_parts_cannot_end_the_script() {
        let mut scene = scene("a</script><b>%DATA%");
        scene.parts = vec!["</script>".to_string()];
        let page = page(&[scene], Together::Frames, None);
        assert_eq!(page.matches("</script>").count(), 3);
        assert!(!page.contains("<b>"));
    }

    #[test]
    fn what_takes_too_much_is_refused_before_it_is_packed() {
        let node = crate::tree::Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 1 };
        let nodes = vec![node; (MOST_BYTES / 32) as usize + 1];
        let view = View { nodes: &nodes, triangles: &[], geoms: &[], blases: &[], tlas_nodes: &[], instances: &[] };
        assert_eq!(pack(&view).unwrap_err(), PackError::TooLarge { bytes: bytes_of(&view), most: MOST_BYTES });
    }

    #[test]
    fn nodes_out_of_order_are_refused() {
        let positions: Vec<[f32; 3]> = (0..22u16).map(|i| [f32::from(i), f32::from(i % 2), 0.0]).collect();
        let triangles: Vec<[u32; 3]> = (0..20).map(|i| [i, i + 1, i + 2]).collect();
        let built = crate::Build::new(&positions, &triangles).unwrap().run().unwrap();
        let view = built.view();
        assert!(pack(&view).is_ok());
        let mut nodes = view.nodes.to_vec();
        nodes[0].first += 2;
        assert!(matches!(pack(&View { nodes: &nodes, ..view }), Err(PackError::Malformed(_))));
    }
}
