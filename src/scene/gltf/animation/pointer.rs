use super::scope::Scope;
use crate::scene::gltf::extensions::{Treatment, extension};

/// Whether the property that a pointer of `KHR_animation_pointer` names decides where triangles of the scene are. Materials, cameras and
/// lights do not, nor do nodes that carry nothing else.
pub fn moves_geometry(pointer: &str, scope: &Scope) -> bool {
    let mut parts = pointer.split('/').skip(1);
    let (list, index) = (parts.next(), parts.next().and_then(|i| i.parse::<u32>().ok()));
    match (list, index) {
        (Some("nodes"), Some(node)) => scope.carries(node) && is_of_place(parts.next(), parts.next()),
        (Some("meshes"), Some(mesh)) => scope.shows(mesh) && parts.next() == Some("weights"),
        _ => false,
    }
}

/// Whether a node's property is of those that place what it carries, or may be.
fn is_of_place(property: Option<&str>, name: Option<&str>) -> bool {
    match property {
        None | Some("camera" | "name" | "extras") => false,
        Some("extensions") => {
            name.and_then(extension).is_none_or(|row| !matches!(row.treatment, Treatment::Passed | Treatment::Played))
        }
        Some(_) => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_places_triangles_matters() {
        let scope = Scope::new(vec![true, false], [3].into());
        for (pointer, moves) in [
            ("/nodes/0/translation", true),
            ("/nodes/0/weights/1", true),
            ("/nodes/0/extensions/KHR_node_visibility/visible", true),
            ("/nodes/0/extensions/ACME_gizmo/way", true),
            ("/nodes/0/extensions/KHR_lights_punctual/light", false),
            ("/nodes/0/extensions/KHR_node_selectability/selectable", false),
            ("/nodes/1/translation", false),
            ("/nodes/7/translation", false),
            ("/nodes/x/translation", false),
            ("/nodes/0", false),
            ("/meshes/3/weights", true),
            ("/meshes/3/weights/0", true),
            ("/meshes/4/weights", false),
            ("/materials/0/pbrMetallicRoughness/baseColorFactor", false),
            ("/cameras/0/perspective/yfov", false),
            ("/extensions/KHR_lights_punctual/lights/0/color", false),
            ("nodes/0/translation/", false),
            ("", false),
        ] {
            assert_eq!(moves_geometry(pointer, &scope), moves, "{pointer}");
        }
    }
}
