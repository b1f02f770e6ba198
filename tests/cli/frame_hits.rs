//! Hits in the frames of a sequence, and the way back from them to the model.

use crate::Place;
use crate::sequences::waves;
use bvhc::cache::{Cache, Sequence};
use bvhc::geom::Ray;

/// A hit in a frame leads back to what the still file of that frame says of it.
#[test]
fn hits_in_frames_lead_back_to_the_model() {
    let place = Place::new();
    waves(&place, 1..4);
    for frame in 1..4 {
        let text = String::from_utf8(place.read(&format!("in/wave.{frame:03}.obj"))).unwrap();
        place.write(&format!("in/wave.{frame:03}.obj"), text.replacen("f ", "o sea\nusemtl water\nf ", 1));
    }
    place.ok("build in/wave.%03d.obj -o wave.bvhc --vertices");
    let sequence = Sequence::open(place.path("wave.bvhc")).unwrap();
    let (mut hits, mut told) = (0, 0);
    for index in 0..3 {
        place.ok(&format!("convert wave.bvhc -o still.bvhc --frame {}", index + 1));
        let (frame, still) = (sequence.frame(index).unwrap(), Cache::open(place.path("still.bvhc")).unwrap());
        let bounds = still.header().scene_bounds();
        for i in 0..400u16 {
            let share = [f32::from(i % 20) / 20.0 + 0.02, f32::from(i / 20) / 20.0 + 0.02];
            let at = |axis: usize, share: f32| bounds.min[axis] + share * (bounds.max[axis] - bounds.min[axis]);
            let tall = bounds.max[1] + 1.0;
            let ray = Ray::new([at(0, share[0]), tall, at(2, share[1])], [0.0, -1.0, 0.0]);
            let (Some(hit), Some(same)) = (frame.closest_hit(&ray).unwrap(), still.closest_hit(&ray).unwrap()) else {
                continue;
            };
            assert_eq!((hit.prim, hit.t), (same.prim, same.t));
            assert_eq!(sequence.name_of(&frame, &hit), still.name(same.geom));
            assert_eq!(sequence.material_of(&frame, &hit), still.material(same.geom));
            assert_eq!(sequence.normal_of(&frame, &hit), still.normal(&same));
            let vertices = sequence.vertices_of(&frame, &hit);
            assert_eq!(vertices, still.vertices().get(same.triangle).copied());
            assert!(vertices.is_some());
            told += usize::from(sequence.material_of(&frame, &hit) == "water");
            hits += 1;
        }
    }
    assert!(hits > 100 && told > 0, "{hits} {told}");
}
