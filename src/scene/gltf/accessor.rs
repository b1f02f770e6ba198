use super::buffers::Buffers;
use super::document::{Accessor, Document};
use super::extensions::{MESHOPT, compressed};
use super::reader::Reader;
use crate::geom::Point;
use crate::scene::SceneError;
use crate::scene::error::clipped;
use crate::scene::pose;
use crate::scene::source::Source;

/// Most elements of an accessor that has no data of its own, only zeros and sparse replacements: nothing in the file
/// bounds its count.
pub(super) const MAX_ZERO_ELEMENTS: u64 = 1 << 24;

/// What an accessor's elements must be to be read.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    kind: Kind,
    components: &'static [Component],
}

/// How many numbers an element has.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Scalar,
    Vec3,
    Vec4,
    Mat4,
}

/// How a number is stored.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

use Component::{F32, I8, I16, U8, U16, U32};

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Kind::Scalar => "SCALAR",
            Kind::Vec3 => "VEC3",
            Kind::Vec4 => "VEC4",
            Kind::Mat4 => "MAT4",
        }
    }

    fn width(self) -> usize {
        match self {
            Kind::Scalar => 1,
            Kind::Vec3 => 3,
            Kind::Vec4 => 4,
            Kind::Mat4 => 16,
        }
    }
}

impl Component {
    /// By the number that stands for it in the file.
    fn from_code(code: u32) -> Option<Component> {
        Some(match code {
            5120 => I8,
            5121 => U8,
            5122 => I16,
            5123 => U16,
            5125 => U32,
            5126 => F32,
            _ => return None,
        })
    }

    fn name(self) -> &'static str {
        match self {
            I8 => "BYTE",
            U8 => "UNSIGNED_BYTE",
            I16 => "SHORT",
            U16 => "UNSIGNED_SHORT",
            U32 => "UNSIGNED_INT",
            F32 => "FLOAT",
        }
    }
}

impl Shape {
    pub const INDICES: Shape = Shape { kind: Kind::Scalar, components: &[U8, U16, U32] };
    /// With `KHR_mesh_quantization`; read whether or not the file declares it.
    pub const POSITIONS: Shape = Shape { kind: Kind::Vec3, components: &[F32, I8, U8, I16, U16] };
    pub const JOINTS: Shape = Shape { kind: Kind::Vec4, components: &[U8, U16] };
    pub const WEIGHTS: Shape = Shape { kind: Kind::Vec4, components: &[F32, U8, U16] };
    pub const INVERSE_BIND: Shape = Shape { kind: Kind::Mat4, components: &[F32] };
    pub const TRANSLATION: Shape = Shape { kind: Kind::Vec3, components: &[F32] };
    pub const ROTATION: Shape = Shape { kind: Kind::Vec4, components: &[F32, I8, I16] };
    pub const KEYED_ROTATION: Shape = Shape { kind: Kind::Vec4, components: &[F32, I8, U8, I16, U16] };
    pub const MORPH_WEIGHTS: Shape = Shape { kind: Kind::Scalar, components: &[F32, I8, U8, I16, U16] };
    pub const TIMES: Shape = Shape { kind: Kind::Scalar, components: &[F32] };
}

/// How one element's numbers are encoded.
#[derive(Clone, Copy)]
pub(super) struct Encoding {
    component: Component,
    normalized: bool,
}

impl Encoding {
    fn size(self) -> usize {
        match self.component {
            I8 | U8 => 1,
            I16 | U16 => 2,
            U32 | F32 => 4,
        }
    }

    /// Number `i` of an element, as a double since a normalized integer seldom is a float; integers by the specification's equations
    /// (glTF 2.0, 3.11, and `KHR_mesh_quantization`). Short bytes, which callers rule out, read as 0.
    fn number(self, element: &[u8], i: usize) -> f64 {
        let bytes = &element[i * self.size()..];
        let scaled = |value: f64, max: f64| if self.normalized { (value / max).max(-1.0) } else { value };
        match self.component {
            F32 => bytes.first_chunk().map_or(0.0, |b| f64::from(f32::from_le_bytes(*b))),
            I8 => scaled(f64::from(bytes[0] as i8), 127.0),
            U8 => scaled(f64::from(bytes[0]), 255.0),
            I16 => scaled(bytes.first_chunk().map_or(0.0, |b| f64::from(i16::from_le_bytes(*b))), 32767.0),
            U16 => scaled(bytes.first_chunk().map_or(0.0, |b| f64::from(u16::from_le_bytes(*b))), 65535.0),
            U32 => bytes.first_chunk().map_or(0.0, |b| f64::from(u32::from_le_bytes(*b))),
        }
    }

    fn numbers<const N: usize>(self, element: &[u8]) -> [f64; N] {
        std::array::from_fn(|i| self.number(element, i))
    }

    /// Whether every number that is so encoded is a float.
    fn is_exact(self) -> bool {
        self.component == F32 || !self.normalized
    }

    fn index(self, element: &[u8]) -> u32 {
        match self.component {
            U8 => u32::from(element[0]),
            U16 => element.first_chunk().map_or(0, |b| u32::from(u16::from_le_bytes(*b))),
            _ => element.first_chunk().map_or(0, |b| u32::from_le_bytes(*b)),
        }
    }
}

/// Read an accessor of numbers, `N` to an element. Memory for the result is charged and stays charged.
pub(super) fn numbers<const N: usize>(
    reader: &mut Reader,
    index: usize,
    shape: Shape,
) -> Result<Vec<[f64; N]>, SceneError> {
    read(reader, index, shape, [0.0; N], Encoding::numbers).map(|(values, _)| values)
}

/// Read an accessor of positions, rounded to `f32`, and what that leaves off, empty where nothing. Memory is charged and stays charged.
pub(super) fn positions(reader: &mut Reader, index: usize) -> Result<(Vec<Point>, Vec<Point>), SceneError> {
    let shape = Shape::POSITIONS;
    let rounded = |encoding: Encoding, element: &[u8]| match encoding.component {
        F32 => floats(element),
        _ => pose::split(encoding.numbers(element)).0,
    };
    let left_off = |encoding: Encoding, element: &[u8]| pose::split(encoding.numbers(element)).1;
    let (positions, encoding) = read(reader, index, shape, Point::default(), rounded)?;
    if encoding.is_exact() {
        return Ok((positions, Vec::new()));
    }
    let (remainders, _) = read(reader, index, shape, Point::default(), left_off)?;
    Ok((positions, remainders))
}

/// Three floats as they stand there.
fn floats(element: &[u8]) -> Point {
    element.first_chunk::<12>().map_or(Point::default(), |bytes| {
        [0, 4, 8].map(|at| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]))
    })
}

/// Read an accessor of joint numbers, four to an element. Memory for the result is charged and stays charged.
pub(super) fn joints(reader: &mut Reader, index: usize) -> Result<Vec<[u32; 4]>, SceneError> {
    let decode =
        |encoding: Encoding, element: &[u8]| [0, 1, 2, 3].map(|i| encoding.index(&element[i * encoding.size()..]));
    read(reader, index, Shape::JOINTS, [0; 4], decode).map(|(values, _)| values)
}

/// Read an accessor of numbers whose integers are normalized, which the specification demands of joint weights and of the values of keys, whether the
/// accessor says so or not. Memory for the result is charged and stays charged.
pub(super) fn fractions<const N: usize>(
    reader: &mut Reader,
    index: usize,
    shape: Shape,
) -> Result<Vec<[f64; N]>, SceneError> {
    let decode = |encoding: Encoding, element: &[u8]| Encoding { normalized: true, ..encoding }.numbers(element);
    read(reader, index, shape, [0.0; N], decode).map(|(values, _)| values)
}

/// Read an accessor of indices, and the value that means "restart" for its type.
pub(super) fn indices(reader: &mut Reader, index: usize) -> Result<(Vec<u32>, u32), SceneError> {
    let (values, encoding) = read(reader, index, Shape::INDICES, 0, Encoding::index)?;
    let restart = match encoding.component {
        U8 => u8::MAX.into(),
        U16 => u16::MAX.into(),
        _ => u32::MAX,
    };
    Ok((values, restart))
}

/// The number of elements, if the accessor exists.
pub(super) fn count(reader: &Reader, index: usize) -> Result<u64, SceneError> {
    get(reader.document, index, reader.source).map(|a| a.count.0)
}

/// Whether the accessor has anything to read without a decoder: its own bytes, or sparse values.
pub(super) fn has_data(document: &Document, index: usize) -> bool {
    document.accessors.get(index).is_some_and(|a| a.buffer_view.is_some() || a.sparse.is_some())
}

fn get<'d>(document: &'d Document, index: usize, source: &Source) -> Result<&'d Accessor, SceneError> {
    document.accessors.get(index).ok_or_else(|| {
        let count = document.accessors.len();
        SceneError::malformed(source.path, format!("it uses accessor {index}, but there are {count}"))
    })
}

fn read<T: Clone + Send>(
    reader: &mut Reader,
    index: usize,
    shape: Shape,
    zero: T,
    decode: impl Fn(Encoding, &[u8]) -> T + Sync,
) -> Result<(Vec<T>, Encoding), SceneError> {
    let Reader { document, buffers, source } = reader;
    let accessor = get(document, index, source)?;
    let component = Component::from_code(accessor.component_type.0);
    let encoding = match component.filter(|c| shape.components.contains(c)) {
        Some(component) if accessor.kind == shape.kind.name() => {
            Encoding { component, normalized: accessor.normalized == Some(true) }
        }
        _ => {
            let found = component.map_or("an unknown component type", Component::name);
            let wanted: Vec<_> = shape.components.iter().map(|c| c.name()).collect();
            let (kind, wanted) = (clipped(&accessor.kind), wanted.join(" or "));
            let reason = format!(
                "accessor {index} holds {kind} of {found}; its use here needs {} of {wanted}",
                shape.kind.name()
            );
            return Err(SceneError::malformed(source.path, reason));
        }
    };
    let (count, size) = (accessor.count.0, encoding.size() * shape.kind.width());

    // Take the elements from the view, or start from zeros.
    let mut values = match accessor.buffer_view {
        Some(view) => {
            let (view, offset) = (view.0 as usize, accessor.byte_offset.map_or(0, |o| o.0));
            let what = format!("accessor {index}");
            let run = Run { what: &what, view, offset, count, size, may_stride: true };
            let elements = Elements::find(run, document, buffers, source)?;
            source.charge(count.saturating_mul(size_of::<T>() as u64), &what)?;
            source.exec().generate(elements.count, |i| decode(encoding, elements.get(i)))
        }
        None if count > MAX_ZERO_ELEMENTS => {
            return Err(SceneError::TooMany {
                line: None,
                path: source.path.to_owned(),
                what: format!("accessor {index} has {count} elements and no data"),
                limit: MAX_ZERO_ELEMENTS,
            });
        }
        None => {
            source.charge(count * size_of::<T>() as u64, &format!("accessor {index}"))?;
            vec![zero; count as usize]
        }
    };

    // Put the sparse values in their places.
    if let Some(sparse) = &accessor.sparse {
        // More replacements than elements would cost time that nothing charges, again at each use of the accessor.
        if sparse.count.0 > count {
            let reason = format!("accessor {index} replaces {} elements, but has {count}", sparse.count.0);
            return Err(SceneError::malformed(source.path, reason));
        }
        let component = Component::from_code(sparse.indices.component_type.0);
        let Some(component) = component.filter(|c| Shape::INDICES.components.contains(c)) else {
            let reason = format!("the sparse indices of accessor {index} are not unsigned integers");
            return Err(SceneError::malformed(source.path, reason));
        };
        let places = Encoding { component, normalized: false };
        let what = format!("the sparse indices of accessor {index}");
        let (view, offset) = (sparse.indices.buffer_view.0 as usize, sparse.indices.byte_offset.map_or(0, |o| o.0));
        let run = Run { what: &what, view, offset, count: sparse.count.0, size: places.size(), may_stride: false };
        let elements = Elements::find(run, document, buffers, source)?;
        let places: Vec<u32> = elements.iter().map(|e| places.index(e)).collect();
        let what = format!("the sparse values of accessor {index}");
        let (view, offset) = (sparse.values.buffer_view.0 as usize, sparse.values.byte_offset.map_or(0, |o| o.0));
        let run = Run { what: &what, view, offset, count: sparse.count.0, size, may_stride: false };
        let elements = Elements::find(run, document, buffers, source)?;
        for (place, element) in places.into_iter().zip(elements.iter()) {
            let Some(value) = values.get_mut(place as usize) else {
                let reason = format!("accessor {index} replaces element {place}, but has {count}");
                return Err(SceneError::malformed(source.path, reason));
            };
            *value = decode(encoding, element);
        }
    }
    Ok((values, encoding))
}

/// Elements as the document describes them.
struct Run<'w> {
    /// What errors call them.
    what: &'w str,
    view: usize,
    offset: u64,
    count: u64,
    /// Bytes of one.
    size: usize,
    /// Whether the view's stride holds for them.
    may_stride: bool,
}

/// A run of equally spaced elements, proved to lie inside its buffer view.
struct Elements<'b> {
    bytes: &'b [u8],
    count: usize,
    stride: usize,
    size: usize,
}

impl<'b> Elements<'b> {
    fn find(
        run: Run,
        document: &Document,
        buffers: &'b mut Buffers,
        source: &mut Source,
    ) -> Result<Elements<'b>, SceneError> {
        let Run { what, view, offset, count, size, may_stride } = run;
        if let Some(json) = document.buffer_views.get(view) {
            let mut names = json.extensions.iter().flat_map(|e| e.keys());
            let packed = names.find(|n| MESHOPT.contains(&n.as_str()));
            if let Some(extension) = packed.filter(|e| document.requires(e) && !source.options.ignores(e)) {
                return Err(compressed(extension, source));
            }
        }
        let stride = match document.buffer_views.get(view).and_then(|v| v.byte_stride) {
            Some(stride) if may_stride && stride.0 != 0 => usize::try_from(stride.0).unwrap_or(usize::MAX),
            _ => size,
        };
        if stride < size {
            let reason =
                format!("{what} has elements of {size} bytes, but the byteStride of buffer view {view} is {stride}");
            return Err(SceneError::malformed(source.path, reason));
        }
        let bytes = buffers.view(document, view, source)?;
        let end = match count {
            0 => Some(offset),
            _ => (count - 1).checked_mul(stride as u64).and_then(|b| b.checked_add(size as u64)?.checked_add(offset)),
        };
        match end {
            Some(end) if end <= bytes.len() as u64 => {
                Ok(Elements { bytes: &bytes[offset as usize..end as usize], count: count as usize, stride, size })
            }
            _ => {
                let reason = format!(
                    "{what} has {count} elements of {stride} bytes from byte {offset} on, but buffer view {view} has {} bytes",
                    bytes.len()
                );
                Err(SceneError::malformed(source.path, reason))
            }
        }
    }

    fn get(&self, i: usize) -> &'b [u8] {
        &self.bytes[i * self.stride..i * self.stride + self.size]
    }

    fn iter(&self) -> impl Iterator<Item = &'b [u8]> {
        (0..self.count).map(|i| self.get(i))
    }
}
