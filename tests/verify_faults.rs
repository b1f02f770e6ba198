//! Faults planted in files and in traversals are found within the default ray budget, on the CPU and on OpenCL, and the report names the
//! record that is to blame.

mod common;

use bvhc::build::{BuildOptions, Executor, Levels, Method, NoProgress, Preset};
use bvhc::cache::{Cache, Image, Meta, OpenOptions, View, WriteOptions, to_bytes};
use bvhc::compile::compile;
use bvhc::geom::Ray;
use bvhc::scene::Scene;
use bvhc::trace::rays::RaySet;
use bvhc::trace::{Observer, try_any_hit, try_closest_hit};
use bvhc::verify::{Class, Cpu, Device, DeviceError, HitRecord, Outcome, Plan, Query, Subject, run, scene_of_file};
use bvhc_core::trace::Fault as Mistake;
#[cfg(feature = "opencl")]
use common::devices::opencl;
use common::devices::others;
use common::faults::{Fault, plant};
use common::scenes::sample;

/// The threads of the machine.
static EXEC: Executor = Executor::current();

fn build(scene: &Scene) -> Image {
    let levels = if scene.instances.len() > 1 { Levels::Two } else { Levels::One };
    let options = BuildOptions { method: Method::Sbvh, levels, ..BuildOptions::preset(Preset::Best) };
    Image::new(&compile(scene.clone(), &options, &EXEC, &NoProgress).expect("a tree"), &EXEC).unwrap()
}

/// Written and opened again, with hashes that agree: the container cannot tell.
fn stored(image: &Image) -> Cache {
    let unchecked = WriteOptions { check: false, ..WriteOptions::default() };
    let bytes = to_bytes(image, &Meta::default(), &unchecked, &EXEC).expect("a file");
    Cache::from_bytes(&bytes, &OpenOptions::default()).expect("a valid container")
}

/// A twentieth of the default number of rays, and a fifth of the oracle's work.
fn plan() -> Plan {
    Plan { rays: Plan::default().rays / 20, oracle_work: Plan::ORACLE_WORK / 5, ..Plan::default() }
}

/// All rays that are aimed at triangles by default, and no others: some faults show in one triangle of thousands.
fn aimed() -> Plan {
    let all = Plan::default();
    let at = all.sets.iter().position(|set| *set == RaySet::Triangles).expect("a default set");
    Plan { rays: all.rays_of(at), sets: vec![RaySet::Triangles], ..plan() }
}

fn verify(plan: &Plan, cache: &Cache, scene: &Scene) -> Outcome {
    let subject = Subject::new(cache.view(), scene, &EXEC);
    run(&subject, &mut Cpu::new(cache.view(), &EXEC), &mut others(cache.view()), plan, &NoProgress).expect("a verdict")
}

/// The scene that the model holds, or the one that the faulty file itself says that it holds.
enum Against {
    Source,
    File,
}

fn found(sample_name: &str, fault: Fault, against: Against) {
    let scene = sample(sample_name);
    let mut image = build(&scene);
    let planted = plant(&mut image, fault).expect("something to break");
    let cache = stored(&image);
    let own = scene_of_file(&cache.view(), cache.names()).expect("a scene");
    let plan = if fault == Fault::MovedVertex { aimed() } else { plan() };
    let outcome = verify(&plan, &cache, if matches!(against, Against::Source) { &scene } else { &own });
    assert!(!outcome.is_right(), "{fault:?} in {sample_name}");
    for device in &outcome.devices {
        let mismatch = device.first_mismatch.as_ref().expect("a mismatch on every device");
        let blame = mismatch.blame.as_ref().unwrap_or_else(|| panic!("nothing is to blame: {mismatch:#?}"));
        println!(
            "{fault:?} in {sample_name} on {}: ray {} of {:?} {}; {blame}",
            device.name,
            mismatch.index,
            mismatch.set,
            mismatch.class.words()
        );
        assert_eq!(blame.section, planted.section, "{blame}");
        assert!(planted.records.contains(&blame.record), "{planted:?}, but {blame}");
    }
}

#[test]
fn a_sound_file_is_right() {
    for name in ["corrugated_roof.obj", "forest.glb"] {
        let scene = sample(name);
        let cache = stored(&build(&scene));
        let outcome = verify(&plan(), &cache, &scene);
        assert!(outcome.is_right(), "{name}: {:#?}", outcome.first_mismatch());
        for device in &outcome.devices {
            let total = device.total();
            assert_eq!((total.rays, total.hits > total.rays / 4), (plan().rays, true), "{total:?}");
        }
        assert!(outcome.oracle.rays > 1000 && outcome.oracle.agree > outcome.oracle.rays / 2, "{:?}", outcome.oracle);
    }
}

#[test]
fn a_shrunk_box_is_found() {
    found("corrugated_roof.obj", Fault::ShrunkBox, Against::File);
    found("forest.glb", Fault::ShrunkBox, Against::Source);
}

#[test]
fn a_shrunk_box_of_the_top_level_is_found() {
    found("forest.glb", Fault::ShrunkTopBox, Against::File);
}

#[test]
fn swapped_children_are_found() {
    found("corrugated_roof.obj", Fault::SwappedChildren, Against::File);
    found("corrugated_roof.obj", Fault::SwappedBoxes, Against::Source);
    found("forest.glb", Fault::SwappedChildren, Against::File);
}

#[test]
fn a_moved_vertex_is_found_against_the_source() {
    found("corrugated_roof.obj", Fault::MovedVertex, Against::Source);
    found("forest.glb", Fault::MovedVertex, Against::Source);
}

#[test]
fn a_dropped_duplicate_reference_is_found() {
    found("corrugated_roof.obj", Fault::DroppedReference, Against::File);
    found("corrugated_roof.obj", Fault::DroppedReference, Against::Source);
}

#[test]
fn a_wrong_instance_matrix_is_found() {
    found("forest.glb", Fault::WrongMatrix, Against::File);
    found("forest.glb", Fault::WrongMatrix, Against::Source);
}

/// The CPU's traversal with a mistake in it.
struct Broken<'a, M>(View<'a>, std::marker::PhantomData<M>);

impl<M: Observer + Default> Device for Broken<'_, M> {
    fn name(&self) -> &str {
        "broken"
    }

    fn description(&self) -> String {
        "the CPU's traversal with a mistake planted in it".into()
    }

    fn deviation(&self) -> Option<String> {
        None
    }

    fn trace(&mut self, rays: &[Ray], query: Query) -> Result<Vec<HitRecord>, DeviceError> {
        let one = |ray: &Ray| match query {
            Query::Closest => try_closest_hit(&self.0, ray, &mut M::default()).expect("a tree").into(),
            Query::Any => HitRecord::any(try_any_hit(&self.0, ray, &mut M::default()).expect("a tree")),
        };
        Ok(rays.iter().map(one).collect())
    }
}

#[derive(Default)]
struct SignOfZero;
impl Observer for SignOfZero {
    const FAULT: Option<Mistake> = Some(Mistake::SignOfZero);
}

#[derive(Default)]
struct Order;
impl Observer for Order {
    const FAULT: Option<Mistake> = Some(Mistake::Order);
}

/// A traversal that goes wrong on sound records is found beside the CPU's, and by the oracle alone where it is the reference.
fn found_in_traversal<M: Observer + Default>(sample_name: &str, plan: &Plan) {
    let scene = sample(sample_name);
    let cache = stored(&build(&scene));
    let broken = || Broken::<M>(cache.view(), std::marker::PhantomData);
    let subject = Subject::new(cache.view(), &scene, &EXEC);
    let beside = run(&subject, &mut Cpu::new(cache.view(), &EXEC), &mut [Box::new(broken())], plan, &NoProgress)
        .expect("a verdict");
    let alone = run(&subject, &mut broken(), &mut [], plan, &NoProgress).expect("a verdict");
    assert_eq!(beside.devices[0].total().mismatches(), 0);
    for device in [&beside.devices[1], &alone.devices[0]] {
        let mismatch = device.first_mismatch.as_ref().expect("a mismatch");
        let blame = mismatch.blame.as_ref().expect("a leaf that it should have reached");
        println!("{sample_name}: {:?} {}; {blame}", mismatch.set, mismatch.class.words());
        // Beside the CPU, another copy of a triangle that stands in several leaves is a difference already.
        assert!(matches!(mismatch.class, Class::Missed | Class::Farther | Class::Bits), "{mismatch:?}");
        assert!(blame.why.contains("the traversal is not") && blame.section == "NODE", "{blame}");
    }
}

#[test]
fn a_broken_octant_is_found() {
    found_in_traversal::<SignOfZero>("corrugated_roof.obj", &plan());
    found_in_traversal::<SignOfZero>("forest.glb", &plan());
}

#[test]
fn a_broken_order_of_children_is_found() {
    found_in_traversal::<Order>("corrugated_roof.obj", &plan());
    found_in_traversal::<Order>("forest.glb", &aimed());
}

/// The same for the kernel: compiled with a mistake, it is found beside the CPU.
#[cfg(feature = "opencl")]
#[test]
fn a_broken_kernel_is_found() {
    use bvhc::verify::opencl::{Fault as Mistake, OpenCl, Options};
    for mistake in [Mistake::WrongOctant, Mistake::DroppedChild] {
        let options = Options { fault: Some(mistake), believed: true, ..Options::default() };
        let Some(context) = opencl(options) else { return };
        for name in ["corrugated_roof.obj", "forest.glb"] {
            let scene = sample(name);
            let cache = stored(&build(&scene));
            let subject = Subject::new(cache.view(), &scene, &EXEC);
            let broken: Box<dyn Device> = Box::new(OpenCl::new(context, cache.view()).expect("it fits"));
            let mut cpu = Cpu::new(cache.view(), &EXEC);
            let outcome = run(&subject, &mut cpu, &mut [broken], &plan(), &NoProgress).expect("a verdict");
            assert_eq!(outcome.devices[0].total().mismatches(), 0);
            let mismatch = outcome.devices[1].first_mismatch.as_ref().expect("a mismatch");
            let blame = mismatch.blame.as_ref().expect("a leaf that it should have reached");
            println!("{mistake:?} in {name}: {:?} {}; {blame}", mismatch.set, mismatch.class.words());
            assert!(blame.why.contains("the traversal is not") && blame.section == "NODE", "{blame}");
        }
    }
}

/// What `bvhc check` refuses does not crash verification: traversal gives up, and the report says on which ray.
#[test]
fn a_malformed_tree_is_told_and_not_walked() {
    let scene = sample("corrugated_roof.obj");
    let mut image = build(&scene);
    let broken = image.nodes[2].first as usize;
    image.nodes[broken].first = u32::MAX - 1;
    image.nodes[broken].count = 0;
    let cache = stored(&image);
    let outcome = verify(&plan(), &cache, &scene);
    assert_eq!(outcome.devices[0].total().malformed, 1);
    let mismatch = outcome.first_mismatch().expect("a ray");
    let again = Cpu::new(cache.view(), &EXEC).trace(&[mismatch.ray], mismatch.query);
    assert!(matches!(again, Err(DeviceError::Malformed { .. })), "{mismatch:?}");
}
