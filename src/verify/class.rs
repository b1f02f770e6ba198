//! What an answer is beside the right one, and how many are what.

use serde::Serialize;

/// How many of a device's answers were what. Every ray that is in none of the classes agrees with the reference bit for bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Counts {
    /// How many were asked about.
    pub rays: u64,
    /// Closest hits; with any-hit alone, rays that hit anything.
    pub hits: u64,

    /// Another triangle at the same distance, by the oracle's word.
    pub ties: u64,
    /// The ray passes an edge within rounding: a hit and a miss are both right.
    pub grazing: u64,
    /// So near to an edge of a moved instance that rounding its matrix to `f32` decides: either answer is right.
    pub unsure: u64,
    /// The same triangle with other last bits, on a device that says that its arithmetic differs.
    pub rounding: u64,
    /// Unlike the reference, and beyond the number of differences that the oracle judges; only on such a device.
    pub unjudged: u64,

    /// Nothing, where something is certainly hit.
    pub missed: u64,
    /// A triangle behind the nearest hit.
    pub farther: u64,
    /// A triangle that the ray certainly misses at that distance.
    pub false_hits: u64,
    /// Not the reference's bits, on a device whose arithmetic gives them.
    pub bits: u64,
    /// Found otherwise through the tree than without it, by the same triangle test.
    pub tree: u64,
    /// The shadow ray says otherwise than the closest hit.
    pub any_hit: u64,
    /// The walk gave up on a malformed tree. The device was asked nothing more.
    pub malformed: u64,

    /// Spent in the device for closest hits, transfers included.
    pub seconds: f64,
    /// Spent in the device for any hits.
    pub any_seconds: f64,
    /// Rays that the device traced without the tree, too, how many it answered otherwise then, and the time that took.
    pub brute_rays: u64,
    /// Of these the ones that were answered otherwise.
    pub brute_unlike: u64,
    /// Spent in the device for these.
    pub brute_seconds: f64,
}

impl Counts {
    /// Answers that no right device gives: the last seven counts.
    pub fn mismatches(&self) -> u64 {
        self.missed + self.farther + self.false_hits + self.bits + self.tree + self.any_hit + self.malformed
    }

    /// Count an answer of that class.
    pub fn add(&mut self, class: Class) {
        *match class {
            Class::Tie => &mut self.ties,
            Class::Grazing => &mut self.grazing,
            Class::Unsure => &mut self.unsure,
            Class::Rounding => &mut self.rounding,
            Class::Unjudged => &mut self.unjudged,
            Class::Missed => &mut self.missed,
            Class::Farther => &mut self.farther,
            Class::False => &mut self.false_hits,
            Class::Bits => &mut self.bits,
            Class::Tree => &mut self.tree,
            Class::AnyHit => &mut self.any_hit,
            Class::Malformed => &mut self.malformed,
        } += 1;
    }

    pub(super) fn plus(&self, other: &Counts) -> Counts {
        Counts {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            ties: self.ties + other.ties,
            grazing: self.grazing + other.grazing,
            unsure: self.unsure + other.unsure,
            rounding: self.rounding + other.rounding,
            unjudged: self.unjudged + other.unjudged,
            missed: self.missed + other.missed,
            farther: self.farther + other.farther,
            false_hits: self.false_hits + other.false_hits,
            bits: self.bits + other.bits,
            tree: self.tree + other.tree,
            any_hit: self.any_hit + other.any_hit,
            malformed: self.malformed + other.malformed,
            seconds: self.seconds + other.seconds,
            any_seconds: self.any_seconds + other.any_seconds,
            brute_rays: self.brute_rays + other.brute_rays,
            brute_unlike: self.brute_unlike + other.brute_unlike,
            brute_seconds: self.brute_seconds + other.brute_seconds,
        }
    }
}

/// How an answer differs; see the fields of [`Counts`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Class {
    /// [`Counts::ties`].
    Tie,
    /// [`Counts::grazing`].
    Grazing,
    /// [`Counts::unsure`].
    Unsure,
    /// [`Counts::rounding`].
    Rounding,
    /// [`Counts::unjudged`].
    Unjudged,
    /// [`Counts::missed`].
    Missed,
    /// [`Counts::farther`].
    Farther,
    /// [`Counts::false_hits`].
    False,
    /// [`Counts::bits`].
    Bits,
    /// [`Counts::tree`].
    Tree,
    /// [`Counts::any_hit`].
    AnyHit,
    /// [`Counts::malformed`].
    Malformed,
}

impl Class {
    /// Whether no right device answers so.
    pub fn is_mismatch(self) -> bool {
        !matches!(self, Class::Tie | Class::Grazing | Class::Unsure | Class::Rounding | Class::Unjudged)
    }

    /// As a sentence's end: "the device …".
    pub fn words(self) -> &'static str {
        match self {
            Class::Tie => "found another triangle at the same distance",
            Class::Grazing => "decided otherwise about an edge that the ray passes within rounding",
            Class::Unsure => "decided otherwise where rounding an instance's matrix decides",
            Class::Rounding => "found the same hit with other last bits",
            Class::Unjudged => "answered otherwise, and was not judged",
            Class::Missed => "missed a hit",
            Class::Farther => "returned a hit behind the nearest one",
            Class::False => "returned a hit that is none",
            Class::Bits => "answered with other bits, which its arithmetic does not excuse",
            Class::Tree => "found otherwise through the tree than without it",
            Class::AnyHit => "answered otherwise for any hit than for the closest hit",
            Class::Malformed => "could not walk the tree to its end",
        }
    }
}
