//! What helps: the command line's words for the library's errors, which name no flag themselves.

use super::failure::Failure;
use crate::scene::{Resemblance, SceneError};
use crate::verify::DeviceError;
use std::error::Error;

/// An error's text and its source as a failure's action and facts.
pub fn told(failure: Failure, error: &impl Error) -> Failure {
    match error.source() {
        Some(source) => failure.fact(source.to_string()),
        None => failure,
    }
}

/// For a model that was not read.
pub fn for_scene(error: &SceneError) -> Option<String> {
    let text = match error {
        SceneError::MissingBuffer { .. } => "put the file there, or export the model as one .glb file",
        SceneError::OutsideFolder { .. } => "if you trust this model, allow it with --allow-outside",
        SceneError::NotObj { resembles, .. } | SceneError::InPlaceOfData { resembles, .. } => match resembles {
            Resemblance::LfsPointer => "it is a Git LFS pointer; fetch the file that it stands for: git lfs pull",
            Resemblance::WebPage => "it looks like a web page; download the file itself once more",
            Resemblance::Capitals => "keywords of OBJ are in small letters; export the model once more",
            Resemblance::Json => "it looks like a glTF; name it so: *.gltf",
            Resemblance::Nothing => "export the model once more as OBJ or glTF",
        },
        SceneError::Degenerate { .. } => "leave them out with --degenerate drop",
        SceneError::NoSuchAnimation { count: 0, .. } => {
            "what has no animations stands at rest: leave out --animation and --time"
        }
        SceneError::NoSuchAnimation { .. } => "choose one of them by its number: --animation NUMBER",
        SceneError::UnknownFormat { .. } => "convert it to one of these",
        SceneError::UnsupportedExtension { extension, ignorable: true, .. } if extension == "CESIUM_RTC" => {
            return Some(format!("build the model around its own origin: --ignore-extension {extension}"));
        }
        SceneError::UnsupportedExtension { extension, ignorable: true, .. } => {
            return Some(format!(
                "export the model without it, or read it as if it were not there: --ignore-extension {extension}"
            ));
        }
        SceneError::UnsupportedExtension { .. } => {
            "decode the model once, for example with: npx @gltf-transform/cli cp in.glb out.glb"
        }
        SceneError::UnsupportedVersion { .. } => "export it as glTF 2.0",
        SceneError::Memory { .. } => "raise it with --max-memory",
        _ => return None,
    };
    Some(text.to_string())
}

/// For a device that gave no answer.
pub fn for_device(error: &DeviceError) -> Option<&'static str> {
    Some(match error {
        DeviceError::NoLibrary { .. } => {
            "install an ICD loader and a driver (Debian: apt install ocl-icd-libopencl1 pocl-opencl-icd), or pass --device cpu"
        }
        DeviceError::NoDevice { .. } => "install a driver (Debian: apt install pocl-opencl-icd), or pass --device cpu",
        DeviceError::NoSuchDevice { .. } => "bvhc verify --list-devices",
        DeviceError::Unusable { .. } => "bvhc verify --list-devices, then --device with another, or --device cpu",
        DeviceError::OutOfMemory { .. } => {
            "pass --device cpu, or build the file with fewer references (bvhc build --method binned)"
        }
        DeviceError::Build { .. } => "update the driver and report this log, or pass --device cpu",
        DeviceError::Runtime { .. } => "try again, update the driver, or pass --device cpu",
        DeviceError::Malformed { .. } => "bvhc check FILE",
    })
}
