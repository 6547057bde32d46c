//! Cases on which geometry in floating point goes wrong, with their truth, and how bumper answers
//! them. `data/README.md` tells what is in the built-in suite, the form of a suite's file and what
//! "exact" means.

mod check;
pub mod continuous;
mod text;

use std::fs;
use std::io;
use std::path::Path;

pub use check::{Report, Row, Way, Wrong, check};
pub use text::Problem;

use crate::geometry::contact::Kind;
use crate::geometry::{Point, Pose, Triangle};
use crate::mesh::{FormatError, TriangleMesh, gzip};
use crate::tree::descent::Pair;

/// Two triangles: do their closed hulls meet?
#[derive(Clone, Debug, PartialEq)]
pub struct PairCase {
    /// From 1, in the suite's file.
    pub line: usize,
    pub family: String,
    /// What they have in common.
    pub common: Option<Kind>,
    pub a: Triangle,
    pub b: Triangle,
}

impl PairCase {
    pub fn intersect(&self) -> bool {
        self.common.is_some()
    }
}

/// Two meshes at a pose: which triangles meet?
#[derive(Clone, Debug, PartialEq)]
pub struct MeshCase {
    /// Where it begins.
    pub line: usize,
    pub name: String,
    pub fixed: TriangleMesh,
    pub moving: TriangleMesh,
    /// (w, x, y, z) of which `pose` is made.
    pub quaternion: [f64; 4],
    pub pose: Pose,
    /// Ascending.
    pub pairs: Vec<Pair>,
}

impl MeshCase {
    /// The name without the number at its end.
    pub fn family(&self) -> &str {
        match self.name.rsplit_once('_') {
            Some((family, number)) if number.bytes().all(|b| b.is_ascii_digit()) => family,
            _ => &self.name,
        }
    }
}

/// A point and where a pose puts it, to be met bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct TransformCase {
    pub line: usize,
    pub quaternion: [f64; 4],
    pub translation: Point,
    pub point: Point,
    /// Row major, of the quaternion.
    pub rotation: [f64; 9],
    pub placed: Point,
}

/// The cases of one file, at least one.
#[derive(Clone, Debug, PartialEq)]
pub enum Cases {
    Pairs(Vec<PairCase>),
    Meshes(Vec<MeshCase>),
    Transforms(Vec<TransformCase>),
}

#[derive(Clone, Debug, PartialEq)]
pub struct Suite {
    /// Its file.
    pub name: String,
    pub cases: Cases,
}

#[derive(Debug, thiserror::Error)]
pub enum SuiteError {
    #[error("{file}: cannot be read: {source}")]
    Read { file: String, source: io::Error },
    #[error("{file}: is not a regular file, give a file of hard cases")]
    NotAFile { file: String },
    #[error("{file}: {source}")]
    Compressed { file: String, source: FormatError },
    #[error("{file}: there is no case in it")]
    Empty { file: String },
    #[error("{file}:{line}: {problem}")]
    Line { file: String, line: usize, problem: Problem },
}

impl Suite {
    /// Of a file in one of the three forms, which its first line tells; it may be compressed.
    pub fn read(path: &Path) -> Result<Self, SuiteError> {
        let file = path.display().to_string();
        Self::parse(&content(path)?, &file)
    }

    /// As [`Suite::read`], of the content of a file that errors call `name`.
    pub fn parse(bytes: &[u8], name: &str) -> Result<Self, SuiteError> {
        Ok(Self { name: name.to_owned(), cases: parsed(bytes, name, text::parse)? })
    }

    /// 12,800 pairs of triangles, 60 of meshes and 2,000 placed points.
    pub fn built_in() -> [Self; 3] {
        [
            Self { name: "built-in pairs".into(), cases: Cases::Pairs(pair_cases()) },
            Self { name: "built-in meshes".into(), cases: Cases::Meshes(mesh_cases()) },
            Self {
                name: "built-in transforms".into(),
                cases: Cases::Transforms(transform_cases()),
            },
        ]
    }

    pub fn len(&self) -> usize {
        match &self.cases {
            Cases::Pairs(cases) => cases.len(),
            Cases::Meshes(cases) => cases.len(),
            Cases::Transforms(cases) => cases.len(),
        }
    }

    /// Never.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Of a regular file: pipes and devices may never end.
fn content(path: &Path) -> Result<Vec<u8>, SuiteError> {
    let file = path.display().to_string();
    let read = || fs::metadata(path)?.is_file().then(|| fs::read(path)).transpose();
    match read() {
        Ok(Some(bytes)) => Ok(bytes),
        Ok(None) => Err(SuiteError::NotAFile { file }),
        Err(source) => Err(SuiteError::Read { file, source }),
    }
}

/// What is in a file that errors call `name`, which may be compressed.
fn parsed<T>(
    bytes: &[u8],
    name: &str,
    parse: impl FnOnce(&[u8]) -> text::Parsed<Option<T>>,
) -> Result<T, SuiteError> {
    let file = || name.to_owned();
    let text = gzip::decompressed(bytes)
        .map_err(|source| SuiteError::Compressed { file: file(), source })?;
    match parse(&text) {
        Ok(Some(cases)) => Ok(cases),
        Ok(None) => Err(SuiteError::Empty { file: file() }),
        Err((line, problem)) => Err(SuiteError::Line { file: file(), line, problem }),
    }
}

/// The triangle pairs of the built-in suite.
pub fn pair_cases() -> Vec<PairCase> {
    // Compressed files one after the other are one.
    let packed = [
        include_bytes!("data/pairs-0.txt.gz").as_slice(),
        include_bytes!("data/pairs-1.txt.gz").as_slice(),
    ];
    match built_in(&packed.concat()) {
        Cases::Pairs(cases) => cases,
        _ => unreachable!("these are pairs"),
    }
}

/// The mesh pairs of the built-in suite.
pub fn mesh_cases() -> Vec<MeshCase> {
    match built_in(include_bytes!("data/meshes.txt.gz")) {
        Cases::Meshes(cases) => cases,
        _ => unreachable!("these are meshes"),
    }
}

/// The placed points of the built-in suite.
pub fn transform_cases() -> Vec<TransformCase> {
    match built_in(include_bytes!("data/transforms.txt.gz")) {
        Cases::Transforms(cases) => cases,
        _ => unreachable!("these are placed points"),
    }
}

fn built_in(packed: &[u8]) -> Cases {
    let suite = Suite::parse(packed, "built-in suite");
    suite.unwrap_or_else(|error| panic!("it was right when it was built in: {error}")).cases
}
