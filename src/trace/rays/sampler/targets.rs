use crate::geom::Point;
use crate::random::Random;
use crate::scene::Scene;
use crate::trace::brute::Source;

/// A scene's triangles, to be drawn at random: which, and its corners in world space.
pub(super) struct Targets<'a> {
    scene: &'a Scene,
    /// Triangles in all instances before this one, and the total at the end.
    before: Vec<u64>,
    /// Triangles in all meshes that have an instance before this one, and the total at the end; and each mesh's instances.
    before_mesh: Vec<u64>,
    places: Vec<Vec<u32>>,
}

impl<'a> Targets<'a> {
    pub fn new(scene: &'a Scene) -> Targets<'a> {
        let (mut before, mut places) = (vec![0], vec![Vec::new(); scene.meshes.len()]);
        for (number, instance) in scene.instances.iter().enumerate() {
            let mesh = instance.mesh as usize;
            places[mesh].push(number as u32);
            before.push(before[number] + scene.meshes[mesh].triangles.len() as u64);
        }
        let mut before_mesh = vec![0];
        for (number, (mesh, places)) in scene.meshes.iter().zip(&places).enumerate() {
            let triangles = if places.is_empty() { 0 } else { mesh.triangles.len() as u64 };
            before_mesh.push(before_mesh[number] + triangles);
        }
        Targets { scene, before, before_mesh, places }
    }

    pub fn is_empty(&self) -> bool {
        self.before.last() == Some(&0)
    }

    /// Any triangle of any instance, each as likely: what is placed often is met often.
    pub fn of_instances(&self, random: &mut Random) -> (Source, [[f64; 3]; 3]) {
        let Some((instance, triangle)) = draw(&self.before, random) else { return STAND_IN };
        self.at(instance, triangle)
    }

    /// Any triangle of any mesh, each as likely, in any of the mesh's instances: each record of a file gets its share.
    pub fn of_meshes(&self, random: &mut Random) -> (Source, [[f64; 3]; 3]) {
        let Some((mesh, triangle)) = draw(&self.before_mesh, random) else { return STAND_IN };
        let places = &self.places[mesh];
        self.at(places[random.below(places.len() as u64) as usize] as usize, triangle)
    }

    fn at(&self, instance: usize, triangle: u64) -> (Source, [[f64; 3]; 3]) {
        let place = &self.scene.instances[instance];
        let corners: [Point; 3] = self.scene.meshes[place.mesh as usize].corners(triangle as usize);
        let source = Source { instance: instance as u32, triangle: triangle as u32 };
        (source, corners.map(|p| place.transform.transform_point(p.map(f64::from))))
    }
}

/// What an empty scene gives.
const STAND_IN: (Source, [[f64; 3]; 3]) =
    (Source { instance: 0, triangle: 0 }, [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);

/// A group and a number within it, of groups that begin at these numbers; `None` where all are empty.
fn draw(before: &[u64], random: &mut Random) -> Option<(usize, u64)> {
    let total = *before.last()?;
    if total == 0 {
        return None;
    }
    let pick = random.below(total);
    let group = before.partition_point(|&b| b <= pick) - 1;
    Some((group, pick - before[group]))
}
