use super::channels::Channels;
use super::keys::{Keys, of_all};
use super::sampler::keys;
use super::scope::Scope;
use crate::scene::gltf::document::Document;
use crate::scene::gltf::reader::Reader;
use crate::scene::{Animation, AnimationChoice, KeyTimes, SceneError};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Every animation of a file, with the times of the keys that move something of the scene. Memory is charged and stays charged.
pub fn list(reader: &mut Reader, scope: &Scope) -> Result<Vec<Animation>, SceneError> {
    let document = reader.document;
    let animation =
        |number| -> Result<Animation, SceneError> { Ok(named(document, number, times(reader, number, scope)?)) };
    (0..document.animations.len() as u32).map(animation).collect()
}

/// The number of the animation that is meant. The refusal lists the animations; one that cannot be read has no times there.
pub fn choose(reader: &mut Reader, choice: &AnimationChoice, scope: &Scope) -> Result<u32, SceneError> {
    let document = reader.document;
    let all = 0..document.animations.len() as u32;
    let is_meant = |number: &u32| match choice {
        AnimationChoice::Only => true,
        AnimationChoice::Number(meant) => number == meant,
        AnimationChoice::Name(name) => !name.is_empty() && document.animation_name(*number) == *name,
    };
    let mut meant = all.clone().filter(is_meant);
    let (first, others) = (meant.next(), meant.count() as u64);
    if let Some(number) = first.filter(|_| others == 0) {
        return Ok(number);
    }
    let found = others + u64::from(first.is_some());
    let mut animation = |number| {
        let keys = times(reader, number, scope).unwrap_or_default();
        named(document, number, keys)
    };
    let animations: Vec<Animation> = all.take(MOST_LISTED).map(&mut animation).collect();
    let count = document.animations.len() as u64;
    Err(SceneError::NoSuchAnimation {
        path: reader.source.path.to_owned(),
        asked: choice.clone(),
        found,
        count,
        animations,
    })
}

/// Animations of which a refusal tells the times: reading them takes time, and a message has an end.
const MOST_LISTED: usize = 32;

fn named(document: &Document, number: u32, keys: Option<KeyTimes>) -> Animation {
    Animation { number, name: document.animation_name(number), keys }
}

fn times(reader: &mut Reader, number: u32, scope: &Scope) -> Result<Option<KeyTimes>, SceneError> {
    // Channels often share the accessor of their keys.
    let mut read: BTreeMap<usize, Keys> = BTreeMap::new();
    for channel in Channels::choose(reader.document, number, scope, reader.source)?.heeded {
        if let Entry::Vacant(entry) = read.entry(channel.input) {
            entry.insert(keys(reader, &channel)?);
        }
    }
    Ok(of_all(read.values()))
}
