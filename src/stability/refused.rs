//! What no builder may take, and records that no reader may follow.

use super::scenes::Failure;
use crate::build::{BuildOptions, NoProgress, Preset};
use crate::cache::{CacheError, Codec, Image, Meta, OpenOptions, View, WriteOptions, to_bytes};
use crate::compile::compile;
use crate::exec::Executor;
use crate::geom::Affine;
use crate::scene::Scene;
use crate::trace::closest_hit;
use crate::trace::rays::Sampler;
use serde::Serialize;

/// Something that is refused, and what else would happen.
#[derive(Clone, Copy, Debug)]
pub struct Refused {
    /// Its number in the list of failures.
    pub id: &'static str,
    /// In one word.
    pub name: &'static str,
    /// What it does to what takes it.
    pub breaks: &'static str,
    harm: Harm,
}

#[derive(Clone, Copy, Debug)]
enum Harm {
    /// A coordinate of a vertex.
    Coordinate(f32),
    /// An instance's transform.
    Transform([[f64; 4]; 3]),
    /// The records of a tree.
    Records(fn(&mut Image)),
    /// A file that ends too soon.
    Cut,
}

/// What became of one of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refusal {
    /// As [`Refused::id`].
    pub id: &'static str,
    /// As [`Refused::name`].
    pub name: &'static str,
    /// As [`Refused::breaks`].
    pub breaks: &'static str,
    /// By which words it was refused, each time in the same ones; `None` where it was taken, or taken by some.
    pub refusal: Option<String>,
}

const fn refused(id: &'static str, name: &'static str, harm: Harm, breaks: &'static str) -> Refused {
    Refused { id, name, breaks, harm }
}

/// All of them, in the order of their numbers.
pub const REFUSED: [Refused; 9] = [
    refused("F18-nan", "nan", Harm::Coordinate(f32::NAN), "comparisons: every box around it is none"),
    refused("F18-inf", "infinite", Harm::Coordinate(f32::INFINITY), "areas: one triangle costs more than all others"),
    refused("F18-minus-inf", "minus-infinite", Harm::Coordinate(f32::NEG_INFINITY), "areas: ∞ - ∞ is no number"),
    refused("F38-cycle", "cycle", Harm::Records(cycle), "walks: a node below itself is never left"),
    refused(
        "F38-shared",
        "shared-child",
        Harm::Records(shared),
        "walks: what is below two nodes is visited twice, and so on",
    ),
    refused("F38-count", "endless-leaf", Harm::Records(endless), "memory: a leaf of more triangles than there are"),
    refused("F38-outside", "child-outside", Harm::Records(outside), "memory: a child behind the last node"),
    refused("F38-cut", "cut-file", Harm::Cut, "lengths that are believed: a file that ends in the middle of its nodes"),
    refused(
        "F40-singular",
        "singular",
        Harm::Transform([[1.0, 0.0, 0.0, 12.0], [0.0, 0.0, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0]]),
        "inverses: there is none, and rays become NaN",
    ),
];

/// The scene that is harmed, its size and rays that are sent into it.
const SOUND: &str = "F36";
const SIZE: usize = 240;
const RAYS: u64 = 200;

fn cycle(image: &mut Image) {
    let root = image.nodes[0];
    let inner = (2..image.nodes.len()).rfind(|i| image.nodes[*i].count == 0).expect("an inner node");
    image.nodes[inner].first = root.first;
}

fn shared(image: &mut Image) {
    let inner: Vec<usize> = (2..image.nodes.len()).filter(|i| image.nodes[*i].count == 0).collect();
    image.nodes[inner[0]].first = image.nodes[inner[inner.len() - 1]].first;
}

fn endless(image: &mut Image) {
    let leaf = (2..image.nodes.len()).find(|i| image.nodes[*i].count > 0).expect("a leaf");
    image.nodes[leaf].count = u32::MAX;
}

fn outside(image: &mut Image) {
    image.nodes[0].first = image.nodes.len() as u32 - 1;
}

impl Refused {
    /// Give it to every recipe, or to writer, reader and rays.
    pub fn tried(&self, exec: &Executor) -> Refusal {
        let mut scene = Failure::named(SOUND).map(|sound| sound.scene(SIZE)).unwrap_or_default();
        let refusal = match self.harm {
            Harm::Coordinate(bad) => {
                scene.meshes[0].positions[7][1] = bad;
                by_every_recipe(&scene, exec)
            }
            Harm::Transform(rows) => {
                let flat = crate::scene::Instance { transform: Affine { rows }, ..scene.instances[0].clone() };
                scene.instances.push(flat);
                by_every_recipe(&scene, exec)
            }
            Harm::Records(harm) => harmed(&scene, Some(harm), exec),
            Harm::Cut => harmed(&scene, None, exec),
        };
        Refusal { id: self.id, name: self.name, breaks: self.breaks, refusal }
    }
}

fn by_every_recipe(scene: &Scene, exec: &Executor) -> Option<String> {
    let mut words = None;
    for recipe in super::recipes() {
        let refusal = compile(scene.clone(), &recipe.options, exec, &NoProgress).err()?;
        words = Some(told(&refusal));
    }
    words
}

/// By the writer, or by the reader where only the end is missing. Rays in harmed records have to end, in whatever they end.
fn harmed(scene: &Scene, harm: Option<fn(&mut Image)>, exec: &Executor) -> Option<String> {
    let options = BuildOptions::preset(Preset::Draft);
    let accel = compile(scene.clone(), &options, exec, &NoProgress).ok()?;
    let mut image = Image::new(&accel, exec).ok()?;
    let file = |image: &Image| {
        let options = WriteOptions { check: true, ..WriteOptions::of_build(Codec::Raw) };
        to_bytes(image, &Meta::default(), &options, exec)
    };
    let refusal: CacheError = match harm {
        Some(harm) => {
            harm(&mut image);
            let view: View<'_> = image.view();
            Sampler::new(scene).mixed(RAYS, 1).iter().for_each(|ray| _ = closest_hit(&view, ray));
            file(&image).err()?
        }
        None => {
            let bytes = file(&image).ok()?;
            crate::Cache::from_slice(&bytes[..bytes.len() / 2], &OpenOptions::default()).err()?
        }
    };
    Some(told(&refusal))
}

/// An error with what is behind it.
fn told(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut behind = error.source();
    while let Some(error) = behind {
        text = format!("{text}: {error}");
        behind = error.source();
    }
    text
}
