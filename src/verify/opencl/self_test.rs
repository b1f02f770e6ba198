//! Is a device to be believed? It traces rays through small scenes before it traces any file, and the CPU knows the answers. So a driver that compiles a kernel
//! wrongly is told from a file that is wrong, and no file is blamed for it.

use super::context::{Context, Options};
use super::trace::OpenCl;
use crate::build::{BuildOptions, Executor, NoProgress};
use crate::cache::Image;
use crate::compile::compile;
use crate::geom::Ray;
use crate::trace::rays::grid::GridScene;
use crate::verify::{Cpu, Device, DeviceError, HitRecord, Query};
use std::time::Instant;

/// Scenes of whole numbers, one of them with instances. No sum or product rounds in them, so that a device may only differ in the last bits of a quotient.
const SCENES: u64 = 4;
/// Rays through each scene. They are few enough that a device that computes `f64` in integers on a processor answers within a second.
const RAYS: usize = 64;

impl Context {
    /// Open device `index` of [`list_devices`](super::list_devices).
    ///
    /// # Errors
    /// Where there is no OpenCL or no such device, where it is unusable, and where it answers rays of a known scene otherwise than the CPU.
    pub fn open(index: usize, options: Options) -> Result<Context, DeviceError> {
        let mut context = Context::new(index, options)?;
        #[cfg(feature = "testing")]
        if context.options.believed {
            return Ok(context);
        }
        context.brute_rate = self_test(&context)?;
        Ok(context)
    }
}

/// Triangle tests that the device does in a second without a tree, in the scene where it is quickest: a driver may compile the kernel in the first one.
///
/// # Errors
/// [`DeviceError::SelfTest`] where the device's answers are not those of the CPU, and where it cannot trace at all.
fn self_test(context: &Context) -> Result<f64, DeviceError> {
    let exec = Executor::sequential();
    let (mut wrong, mut first, mut asked, mut rate) = (0, None, 0, 0.0_f64);
    for seed in 0..SCENES {
        let GridScene { scene, rays } = GridScene::new(seed, RAYS);
        let unasked = |why: String| DeviceError::Unusable {
            device: context.info.summary(),
            reason: format!("a scene of its self-test has no tree: {why}"),
        };
        let built = compile(scene, &BuildOptions::default(), &exec, &NoProgress).map_err(|e| unasked(e.to_string()))?;
        let image = Image::new(&built, &exec).map_err(|e| unasked(e.to_string()))?;
        let mut device = OpenCl::new(context, image.view())?;
        // By the tree, and without it, where the same triangle may be met in another slot.
        for query in [Some(Query::Closest), Some(Query::Any), None] {
            let expected = Cpu::new(image.view(), &exec).trace(&rays, query.unwrap_or(Query::Closest))?;
            let answers = match query {
                Some(query) => device.trace(&rays, query)?,
                None => {
                    let slots = device.slots().unwrap_or_default();
                    let tests = slots.iter().map(|count| f64::from(*count)).sum::<f64>() * rays.len() as f64;
                    let began = Instant::now();
                    let answers = device.brute_force(&rays)?;
                    rate = rate.max(tests / began.elapsed().as_secs_f64());
                    answers
                }
            };
            asked += answers.len();
            for ((ray, expected), got) in rays.iter().zip(expected).zip(answers) {
                let expected =
                    HitRecord { triangle: if query.is_none() { got.triangle } else { expected.triangle }, ..expected };
                let same = match context.deviation {
                    None => got == expected,
                    Some(_) => got.is_hit() == expected.is_hit(),
                };
                if !same {
                    wrong += 1;
                    first.get_or_insert_with(|| told(ray, expected, got));
                }
            }
        }
    }
    match first {
        None => Ok(rate),
        Some(first) => Err(DeviceError::SelfTest { device: context.info.summary(), asked, wrong, first }),
    }
}

fn told(ray: &Ray, expected: HitRecord, got: HitRecord) -> String {
    let hit = |record: HitRecord| match record.is_hit() {
        true => format!("record {} of TRIS at t = {}", record.triangle, f32::from_bits(record.t)),
        false => "no hit".to_owned(),
    };
    format!("from {:?} along {:?}: {}, not {}", ray.origin, ray.direction, hit(got), hit(expected))
}
