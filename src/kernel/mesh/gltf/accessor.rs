use super::buffers::Bytes;
use super::document::{Accessor, Document};
use crate::geometry::Point;
use crate::mesh::{FormatError, Problem};

/// The elements of one accessor, all of them inside the bytes that they are read from.
pub struct View<'a> {
    bytes: &'a [u8],
    stride: usize,
    pub count: usize,
    component: Component,
    normalized: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The divisor of normalized integers.
    fn largest(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 => 1.0,
        }
    }

    fn read(self, bytes: &[u8]) -> f64 {
        let word = || [bytes[0], bytes[1]];
        let long = || [bytes[0], bytes[1], bytes[2], bytes[3]];
        match self {
            Self::I8 => i8::from_le_bytes([bytes[0]]).into(),
            Self::U8 => bytes[0].into(),
            Self::I16 => i16::from_le_bytes(word()).into(),
            Self::U16 => u16::from_le_bytes(word()).into(),
            Self::U32 => u32::from_le_bytes(long()).into(),
            Self::F32 => f32::from_le_bytes(long()).into(),
        }
    }
}

/// The vertex positions: three floats, or three small integers where the exporter quantized.
pub fn positions<'a>(
    document: &Document,
    buffers: &'a [Bytes],
    index: usize,
) -> Result<View<'a>, FormatError> {
    let view = view(document, buffers, index, "VEC3", 3)?;
    match view.component {
        Component::U32 => Err(wrong_component(index)),
        _ => Ok(view),
    }
}

/// The vertex indices of triangles.
pub fn indices<'a>(
    document: &Document,
    buffers: &'a [Bytes],
    index: usize,
) -> Result<View<'a>, FormatError> {
    let view = view(document, buffers, index, "SCALAR", 1)?;
    match view.component {
        Component::U8 | Component::U16 | Component::U32 if !view.normalized => Ok(view),
        _ => Err(wrong_component(index)),
    }
}

fn wrong_component(index: usize) -> FormatError {
    Problem::Malformed("the component type does not fit its use".into())
        .at_element("accessors", index)
}

fn view<'a>(
    document: &Document,
    buffers: &'a [Bytes],
    index: usize,
    kind: &str,
    components: usize,
) -> Result<View<'a>, FormatError> {
    let Some(accessor) = document.accessors.get(index) else {
        return Err(missing("accessor", index));
    };
    let at_accessor = |problem: Problem| problem.at_element("accessors", index);
    if accessor.sparse.is_some() {
        let (what, remedy) = ("a sparse accessor".into(), "export the file without morphing");
        return Err(at_accessor(Problem::Unsupported { what, remedy }));
    }
    if accessor.kind != kind {
        let problem = format!("has type {}, must be {kind}", accessor.kind);
        return Err(at_accessor(Problem::Malformed(problem)));
    }
    let component = Component::of(accessor.component_type).ok_or_else(|| wrong_component(index))?;
    let (bytes, stride) = window(document, buffers, accessor, index)?;
    let size = component.bytes() * components;
    let stride = stride.unwrap_or(size);
    if stride < size {
        return Err(at_accessor(Problem::Malformed(format!("stride {stride} is below {size}"))));
    }
    let held = if bytes.len() < size { 0 } else { (bytes.len() - size) / stride + 1 };
    if held < accessor.count {
        let (promised, found) = (accessor.count as u64, held as u64);
        return Err(at_accessor(super::count("elements", promised, found)));
    }
    Ok(View { bytes, stride, count: accessor.count, component, normalized: accessor.normalized })
}

/// The bytes from the accessor's start to the end of its buffer view, and the view's stride.
fn window<'a>(
    document: &Document,
    buffers: &'a [Bytes],
    accessor: &Accessor,
    index: usize,
) -> Result<(&'a [u8], Option<usize>), FormatError> {
    let Some(view_index) = accessor.buffer_view else {
        let problem = Problem::Malformed("has no bufferView, so no data".into());
        return Err(problem.at_element("accessors", index));
    };
    let view = document.buffer_views.get(view_index);
    let view = view.ok_or_else(|| missing("bufferView", view_index))?;
    let buffer = buffers.get(view.buffer).ok_or_else(|| missing("buffer", view.buffer))?.get();
    let rest = buffer.get(view.byte_offset..).unwrap_or_default();
    let Some(bytes) = rest.get(..view.byte_length) else {
        let problem = super::count("bytes", view.byte_length as u64, rest.len() as u64);
        return Err(problem.at_element("bufferViews", view_index));
    };
    Ok((bytes.get(accessor.byte_offset..).unwrap_or_default(), view.byte_stride))
}

pub fn missing(what: &str, index: usize) -> FormatError {
    Problem::Malformed(format!("there is no {what} {index}")).in_file()
}

impl View<'_> {
    pub fn points(&self) -> impl ExactSizeIterator<Item = Point> {
        let size = self.component.bytes();
        (0..self.count).map(move |element| {
            let start = element * self.stride;
            [0, 1, 2].map(|axis| self.coordinate(&self.bytes[start + axis * size..]))
        })
    }

    fn coordinate(&self, bytes: &[u8]) -> f64 {
        let value = self.component.read(bytes);
        if self.normalized { (value / self.component.largest()).max(-1.0) } else { value }
    }

    /// Of an accessor from [`indices`].
    pub fn indices(&self) -> impl Iterator<Item = u32> {
        // Every component type of indices is an unsigned integer below 2^32.
        (0..self.count).map(|i| self.component.read(&self.bytes[i * self.stride..]) as u32)
    }
}
