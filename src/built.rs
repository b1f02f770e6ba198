//! [`Built`]: what a build made, to be traced, asked and written.

use crate::cache::{self, CacheError, Codec, Image, Meta, RecordsById, View, WriteOptions, WriteSummary, side_flags};
use crate::compile::Placing;
use crate::exec::Executor;
use crate::geom::Ray;
use crate::layout::CompactNode;
use crate::scene::ReadReport;
use crate::trace::wide::WideView;
use crate::trace::{BatchError, Hit, Malformed, TurnedView, any_hit, closest_hit};
use std::path::Path;
use std::sync::OnceLock;

/// A program's arrays may break a rule that no model that is read can break, so that records are checked in release builds, too.
fn checked(codec: Codec) -> WriteOptions {
    WriteOptions { codec, ..WriteOptions::default() }
}

/// A finished build: to be traced, written, or both.
#[derive(Debug)]
pub struct Built {
    image: Image,
    meta: Meta,
    report: ReadReport,
    placing: Placing,
    exec: Executor,
    by_id: OnceLock<RecordsById>,
}

impl Built {
    pub(crate) fn new(image: Image, meta: Meta, report: ReadReport, placing: Placing, exec: Executor) -> Built {
        Built { image, meta, report, placing, exec, by_id: OnceLock::new() }
    }

    /// Write a cache file in the place of `path`, whatever is there, in one step: at any time the old file or the new one is there.
    ///
    /// # Errors
    /// Where the file cannot be written, or its records break a rule of the format.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<WriteSummary, CacheError> {
        self.write_as(path, Codec::Raw)
    }

    /// [`Built::write`] with a codec.
    ///
    /// # Errors
    /// As [`Built::write`].
    pub fn write_as(&self, path: impl AsRef<Path>, codec: Codec) -> Result<WriteSummary, CacheError> {
        cache::write_file(path.as_ref(), &self.image, &self.meta, &checked(codec), &self.exec)
    }

    /// The file's bytes.
    ///
    /// # Errors
    /// Where names or notes exceed the format's limits, or records break a rule of the format.
    pub fn to_bytes(&self) -> Result<Vec<u8>, CacheError> {
        cache::to_bytes(&self.image, &self.meta, &checked(Codec::Raw), &self.exec)
    }

    /// The records, as traversal and the file have them.
    pub fn view(&self) -> View<'_> {
        self.image.view()
    }

    /// Its compact trees, if the build was to make them.
    fn wide(&self) -> Option<WideView<'_, 8, CompactNode>> {
        self.image.compact.as_ref().map(|trees| trees.view(&self.view()))
    }

    /// Its turned subtrees, if the build was to look for them and found some.
    fn turned(&self) -> Option<TurnedView<'_>> {
        self.image.turns.as_ref().map(|turns| turns.view(&self.view()))
    }

    /// The nearest point where the ray meets the scene, as [`Cache::closest_hit`](crate::Cache::closest_hit) answers for the file.
    ///
    /// # Errors
    /// None: what was built is a tree.
    pub fn closest_hit(&self, ray: &Ray) -> Result<Option<Hit>, Malformed> {
        match (self.wide(), self.turned()) {
            (Some(wide), _) => wide.closest_hit(ray),
            (None, Some(turned)) => turned.closest_hit(ray),
            (None, None) => closest_hit(&self.view(), ray),
        }
    }

    /// Whether the ray meets anything.
    ///
    /// # Errors
    /// As [`Built::closest_hit`].
    pub fn any_hit(&self, ray: &Ray) -> Result<bool, Malformed> {
        match (self.wide(), self.turned()) {
            (Some(wide), _) => wide.any_hit(ray),
            (None, Some(turned)) => turned.any_hit(ray),
            (None, None) => any_hit(&self.view(), ray),
        }
    }

    /// The nearest hit of each of many rays, on the build's threads: `hits[i]` becomes the answer to `rays[i]`.
    ///
    /// # Errors
    /// Where there are not as many places for hits as rays; no hit is touched then.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) -> Result<(), BatchError> {
        match (self.wide(), self.turned()) {
            (Some(wide), _) => wide.closest_hits(rays, hits, &self.exec),
            (None, Some(turned)) => turned.closest_hits(rays, hits, &self.exec),
            (None, None) => self.view().closest_hits(rays, hits, &self.exec),
        }
    }

    /// What reading the model left out or changed; all 0 for arrays.
    pub fn read_report(&self) -> &ReadReport {
        &self.report
    }

    /// What it cost to put meshes where their instances stand: triangles that lost their area there, and how far rounding moves corners.
    pub fn placing(&self) -> &Placing {
        &self.placing
    }

    /// Which place of a mesh was hit: what [`Build::add_instance`](crate::Build::add_instance) returned for it, or the number of the model's node. `None` where that is not told: of the
    /// one mesh of [`Build::new`](crate::Build::new), of an only instance that stands where its mesh does, and of OBJ models far from the origin.
    pub fn node(&self, hit: &Hit) -> Option<u32> {
        self.view().node(hit, |id| self.record(id))
    }

    /// The normal of the triangle that a ray hit, in world space and not of length 1, as [`Opened::normal`](crate::Opened::normal) has it. `None` where
    /// the record that the hit names is no triangle of its part and number.
    pub fn normal(&self, hit: &Hit) -> Option<[f64; 3]> {
        self.view().normal(hit, self.is_mirrored(hit.geom), |id| self.record(id))
    }

    /// The name of the part that a hit numbers: of arrays that of their mesh. Empty where it has none.
    pub fn name(&self, geom: u32) -> &str {
        self.image.names.get(geom as usize).map_or("", String::as_str)
    }

    /// The name of the part's material; empty where it has none.
    pub fn material(&self, geom: u32) -> &str {
        self.image.materials.get(geom as usize).map_or("", String::as_str)
    }

    /// Which vertices the triangle has that was hit, as [`Opened::vertices`](crate::Opened::vertices) numbers them; `None` where the build was not asked for
    /// them by [`Build::vertices`](crate::Build::vertices).
    pub fn vertices(&self, hit: &Hit) -> Option<[u32; 3]> {
        self.image.vertices.get(hit.triangle).copied()
    }

    /// Whether the transform that was baked into a part's positions mirrors.
    pub fn is_mirrored(&self, geom: u32) -> bool {
        self.image.sides.get(geom as usize).is_some_and(|side| side & side_flags::MIRRORED != 0)
    }

    fn record(&self, id: u32) -> Option<usize> {
        self.by_id.get_or_init(|| RecordsById::new(&self.image.instances)).record(id)
    }

    /// Why the builder chose what it chose, for people; empty where nothing was chosen.
    pub fn notes(&self) -> &[String] {
        &self.meta.notes
    }
}
