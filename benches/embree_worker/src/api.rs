//! The parts of Embree 4's public interface that the worker calls, of building (`rtcore_builder.h`) and of scenes, declared by hand.

use std::ffi::{c_char, c_int, c_uint, c_void};

pub type Device = *mut c_void;
pub type Bvh = *mut c_void;
pub type Allocator = *mut c_void;
pub type Scene = *mut c_void;
pub type Geometry = *mut c_void;

pub const QUALITY_LOW: c_int = 0;
pub const QUALITY_MEDIUM: c_int = 1;
pub const QUALITY_HIGH: c_int = 2;

/// `RTCBuildPrimitive`.
#[repr(C, align(32))]
#[derive(Clone, Copy, Default)]
pub struct Primitive {
    pub lower: [f32; 3],
    pub geometry: c_uint,
    pub upper: [f32; 3],
    pub primitive: c_uint,
}

/// `RTCBounds`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Default)]
pub struct Bounds {
    pub lower: [f32; 3],
    pub pad0: f32,
    pub upper: [f32; 3],
    pub pad1: f32,
}

pub type CreateNode = unsafe extern "C" fn(Allocator, c_uint, *mut c_void) -> *mut c_void;
pub type SetNodeChildren = unsafe extern "C" fn(*mut c_void, *mut *mut c_void, c_uint, *mut c_void);
pub type SetNodeBounds = unsafe extern "C" fn(*mut c_void, *const *const Bounds, c_uint, *mut c_void);
pub type CreateLeaf = unsafe extern "C" fn(Allocator, *const Primitive, usize, *mut c_void) -> *mut c_void;
pub type SplitPrimitive = unsafe extern "C" fn(*const Primitive, c_uint, f32, *mut Bounds, *mut Bounds, *mut c_void);
pub type Progress = unsafe extern "C" fn(*mut c_void, f64) -> bool;

/// `RTCBuildArguments`.
#[repr(C)]
pub struct BuildArguments {
    pub byte_size: usize,
    pub quality: c_int,
    pub flags: c_int,
    pub max_branching_factor: c_uint,
    pub max_depth: c_uint,
    pub sah_block_size: c_uint,
    pub min_leaf_size: c_uint,
    pub max_leaf_size: c_uint,
    pub traversal_cost: f32,
    pub intersection_cost: f32,
    pub bvh: Bvh,
    pub primitives: *mut Primitive,
    pub primitive_count: usize,
    pub primitive_array_capacity: usize,
    pub create_node: CreateNode,
    pub set_node_children: SetNodeChildren,
    pub set_node_bounds: SetNodeBounds,
    pub create_leaf: CreateLeaf,
    pub split_primitive: Option<SplitPrimitive>,
    pub build_progress: Option<Progress>,
    pub user: *mut c_void,
}

/// The functions, looked up once. The library stays loaded for as long as the process lives.
#[derive(Clone, Copy)]
pub struct Library {
    pub new_device: unsafe extern "C" fn(*const c_char) -> Device,
    pub device_error: unsafe extern "C" fn(Device) -> c_int,
    pub new_bvh: unsafe extern "C" fn(Device) -> Bvh,
    pub build: unsafe extern "C" fn(*const BuildArguments) -> *mut c_void,
    pub release_bvh: unsafe extern "C" fn(Bvh),
    pub allocate: unsafe extern "C" fn(Allocator, usize, usize) -> *mut c_void,
}

impl Library {
    pub fn load(path: &str) -> Result<Library, libloading::Error> {
        // SAFETY: the user names a library that is Embree 4; its initialisers are run as by any program linked with it, and the
        // types above are those of its public headers.
        unsafe {
            let library = libloading::Library::new(path)?;
            let functions = Library {
                new_device: *library.get(b"rtcNewDevice\0")?,
                device_error: *library.get(b"rtcGetDeviceError\0")?,
                new_bvh: *library.get(b"rtcNewBVH\0")?,
                build: *library.get(b"rtcBuildBVH\0")?,
                release_bvh: *library.get(b"rtcReleaseBVH\0")?,
                allocate: *library.get(b"rtcThreadLocalAlloc\0")?,
            };
            std::mem::forget(library);
            Ok(functions)
        }
    }
}

/// The functions for scenes.
#[derive(Clone, Copy)]
pub struct SceneLibrary {
    pub new_scene: unsafe extern "C" fn(Device) -> Scene,
    pub set_scene_flags: unsafe extern "C" fn(Scene, c_int),
    pub set_scene_quality: unsafe extern "C" fn(Scene, c_int),
    pub new_geometry: unsafe extern "C" fn(Device, c_int) -> Geometry,
    pub set_geometry_quality: unsafe extern "C" fn(Geometry, c_int),
    pub new_buffer: unsafe extern "C" fn(Geometry, c_int, c_uint, c_int, usize, usize) -> *mut c_void,
    pub update_buffer: unsafe extern "C" fn(Geometry, c_int, c_uint),
    pub commit_geometry: unsafe extern "C" fn(Geometry),
    pub attach: unsafe extern "C" fn(Scene, Geometry) -> c_uint,
    pub commit_scene: unsafe extern "C" fn(Scene),
    pub scene_bounds: unsafe extern "C" fn(Scene, *mut Bounds),
}

impl SceneLibrary {
    pub fn load(path: &str) -> Result<SceneLibrary, libloading::Error> {
        // SAFETY: as for the functions above.
        unsafe {
            let library = libloading::Library::new(path)?;
            let functions = SceneLibrary {
                new_scene: *library.get(b"rtcNewScene\0")?,
                set_scene_flags: *library.get(b"rtcSetSceneFlags\0")?,
                set_scene_quality: *library.get(b"rtcSetSceneBuildQuality\0")?,
                new_geometry: *library.get(b"rtcNewGeometry\0")?,
                set_geometry_quality: *library.get(b"rtcSetGeometryBuildQuality\0")?,
                new_buffer: *library.get(b"rtcSetNewGeometryBuffer\0")?,
                update_buffer: *library.get(b"rtcUpdateGeometryBuffer\0")?,
                commit_geometry: *library.get(b"rtcCommitGeometry\0")?,
                attach: *library.get(b"rtcAttachGeometry\0")?,
                commit_scene: *library.get(b"rtcCommitScene\0")?,
                scene_bounds: *library.get(b"rtcGetSceneBounds\0")?,
            };
            std::mem::forget(library);
            Ok(functions)
        }
    }
}

/// `RTCRayHit`, with room for whatever levels of instances the library was compiled for.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct RayHit {
    origin: [f32; 3],
    least: f32,
    direction: [f32; 3],
    time: f32,
    greatest: f32,
    mask: c_uint,
    id: c_uint,
    flags: c_uint,
    normal: [f32; 3],
    weights: [f32; 2],
    primitive: c_uint,
    geometry: c_uint,
    instances: [c_uint; 13],
}

/// `RTC_INVALID_GEOMETRY_ID`.
const NOTHING: c_uint = c_uint::MAX;

impl RayHit {
    /// A ray of origin, least distance, direction, greatest distance, which has hit nothing yet.
    #[inline(always)]
    pub fn of(&[a, b, c, least, d, e, f, greatest]: &[f32; 8]) -> RayHit {
        RayHit {
            origin: [a, b, c],
            least,
            direction: [d, e, f],
            time: 0.0,
            greatest,
            mask: c_uint::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            weights: [0.0; 2],
            primitive: NOTHING,
            geometry: NOTHING,
            instances: [NOTHING; 13],
        }
    }

    pub fn is_hit(&self) -> bool {
        self.geometry != NOTHING
    }

    /// Distance and triangle of the hit.
    pub fn found(&self) -> Option<(f32, u32)> {
        self.is_hit().then_some((self.greatest, self.primitive))
    }

    /// `rtcOccluded1` says so by a distance of minus infinity.
    pub fn is_occluded(&self) -> bool {
        self.greatest < 0.0
    }
}

/// The functions for rays.
#[derive(Clone, Copy)]
pub struct TraceLibrary {
    pub intersect: unsafe extern "C" fn(Scene, *mut RayHit, *mut c_void),
    pub occluded: unsafe extern "C" fn(Scene, *mut RayHit, *mut c_void),
}

impl TraceLibrary {
    pub fn load(path: &str) -> Result<TraceLibrary, libloading::Error> {
        // SAFETY: as for the functions above.
        unsafe {
            let library = libloading::Library::new(path)?;
            let functions = TraceLibrary {
                intersect: *library.get(b"rtcIntersect1\0")?,
                occluded: *library.get(b"rtcOccluded1\0")?,
            };
            std::mem::forget(library);
            Ok(functions)
        }
    }
}
