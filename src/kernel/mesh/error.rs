use std::fmt;
use std::path::{Path, PathBuf};

use super::Format;

#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    #[error("{}: {error}", path.display())]
    InFile { path: PathBuf, error: Box<MeshError> },
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    #[error("is not a regular file, give a mesh file")]
    NotAFile,
    #[error(transparent)]
    Format(#[from] FormatError),
    #[error("vertex {index}: coordinate {value} is not a finite number")]
    NotFinite { index: usize, value: f64 },
    #[error(
        "triangle {face}: vertex index {index} is out of range (the mesh has {vertices} vertices)"
    )]
    IndexOutOfRange { face: usize, index: u64, vertices: usize },
    #[error("the mesh has no faces")]
    Empty,
    #[error("{0} is too many: at most {max} vertices and faces", max = u32::MAX / 4)]
    TooMany(usize),
    #[error(
        "no such built-in mesh: {0} (there are builtin:car, builtin:tracked, builtin:blocks and builtin:slivers)"
    )]
    UnknownBuiltin(String),
    #[error(
        "built-in meshes have no option {0:?} (there is triangles=N, as in builtin:car?triangles=20000)"
    )]
    UnknownBuiltinOption(String),
    #[error("triangles={0} is not a whole number of triangles")]
    BuiltinNotACount(String),
    #[error(
        "triangles={triangles} is out of range: this built-in mesh has {min} to {max} triangles"
    )]
    BuiltinBudget { triangles: u32, min: u32, max: u32 },
}

impl MeshError {
    pub(super) fn in_file(self, path: &Path) -> Self {
        Self::InFile { path: path.to_owned(), error: Box::new(self) }
    }
}

/// What is wrong with the content of a file, and where.
#[derive(Debug, thiserror::Error)]
#[error("{place}{problem}")]
pub struct FormatError {
    pub place: Place,
    pub problem: Problem,
}

/// The finest place that a reader can name: lines count from 1, bytes and elements from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    File,
    Line(usize),
    Byte(usize),
    Element(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, "line {line}: "),
            Self::Byte(byte) => write!(f, "byte {byte}: "),
            Self::Element(name) => write!(f, "{name}: "),
        }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum Problem {
    #[error("the file is empty")]
    EmptyFile,
    #[error(
        "neither the extension nor the content is of a known format (PLY, OBJ, STL, GLB, glTF, VRML97)"
    )]
    UnknownFormat,
    #[error("the content is {found}, not {expected} as the extension says")]
    WrongType { expected: Format, found: Format },
    #[error("the header promises {promised} {what}, the file has {unit} for {found}")]
    Count { what: String, promised: u64, unit: &'static str, found: u64 },
    #[error("{bytes} bytes follow the last element that the header promises")]
    Trailing { bytes: usize },
    #[error("the file ends within {0}")]
    EndsWithin(String),
    #[error("'{0}' is not a number")]
    NotANumber(String),
    #[error("'{0}' is not an index")]
    NotAnIndex(String),
    #[error("coordinate {0} is not a finite number")]
    NotFinite(f64),
    #[error("its transforms take a vertex beyond all finite numbers")]
    Overflow,
    #[error("vertex index {index} is out of range (there are {vertices} vertices)")]
    IndexOutOfRange { index: i64, vertices: usize },
    #[error("a face needs at least 3 vertices, this one has {0}")]
    FewCorners(usize),
    #[error("found {found}, expected {expected}")]
    Unexpected { found: String, expected: &'static str },
    #[error("{0}")]
    Malformed(String),
    #[error("{what} is not supported: {remedy}")]
    Unsupported { what: String, remedy: &'static str },
    #[error("{0}")]
    TooLarge(String),
}

impl Problem {
    pub(super) fn at(self, place: Place) -> FormatError {
        FormatError { place, problem: self }
    }

    pub(super) fn in_file(self) -> FormatError {
        self.at(Place::File)
    }

    pub(super) fn at_line(self, line: usize) -> FormatError {
        self.at(Place::Line(line))
    }

    pub(super) fn at_byte(self, byte: usize) -> FormatError {
        self.at(Place::Byte(byte))
    }

    pub(super) fn at_element(self, list: &str, index: usize) -> FormatError {
        self.at(Place::Element(format!("{list}[{index}]")))
    }

    pub(super) fn unexpected(found: &[u8], expected: &'static str) -> Self {
        Self::Unexpected { found: format!("'{}'", excerpt(found)), expected }
    }
}

/// Foreign bytes as a short printable text.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    const LONGEST: usize = 32;
    let shown = &bytes[..bytes.len().min(LONGEST)];
    let dots = if bytes.len() > LONGEST { "..." } else { "" };
    format!("{}{dots}", shown.escape_ascii())
}
