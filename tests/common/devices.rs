use bvhc::cache::View;
use bvhc::verify::Device;

/// The OpenCL device that a user would get, or `None` with a line that says so. It stays open to the end of the process.
#[cfg(feature = "opencl")]
pub fn opencl(options: bvhc::verify::opencl::Options) -> Option<&'static bvhc::verify::opencl::Context> {
    use bvhc::verify::DeviceError;
    use bvhc::verify::opencl::{Context, list_devices, preferred};
    match list_devices() {
        Ok(devices) => {
            let info = preferred(&devices).expect("a usable device");
            let context = Context::open(info.index, options).expect("it opens");
            assert_eq!(context.info(), info);
            Some(Box::leak(Box::new(context)))
        }
        Err(error @ (DeviceError::NoLibrary { .. } | DeviceError::NoDevice { .. })) => {
            println!("skipped on OpenCL: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// The devices beside the CPU: one that runs OpenCL, where there is one.
#[cfg(feature = "opencl")]
pub fn others(view: View<'_>) -> Vec<Box<dyn Device + '_>> {
    use bvhc::verify::opencl::OpenCl;
    let context = opencl(Default::default());
    context.into_iter().map(|c| Box::new(OpenCl::new(c, view).expect("it fits")) as Box<dyn Device + '_>).collect()
}

#[cfg(not(feature = "opencl"))]
pub fn others(_: View<'_>) -> Vec<Box<dyn Device + '_>> {
    println!("skipped on OpenCL: this build has none");
    Vec::new()
}
