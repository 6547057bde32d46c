use std::fmt;
use std::path::{Path, PathBuf};

use super::builtin::Builtin;
use super::{Format, MeshError, TriangleMesh};

/// Where a mesh comes from: a file, or `builtin:NAME[?triangles=N]`.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshSource {
    File(PathBuf),
    Builtin(Builtin),
}

impl std::str::FromStr for MeshSource {
    type Err = MeshError;

    fn from_str(text: &str) -> Result<Self, MeshError> {
        match text.strip_prefix("builtin:") {
            Some(name) => Ok(Self::Builtin(name.parse()?)),
            None => Ok(Self::File(text.into())),
        }
    }
}

impl fmt::Display for MeshSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => path.display().fmt(f),
            Self::Builtin(builtin) => write!(f, "builtin:{builtin}"),
        }
    }
}

impl MeshSource {
    /// Coordinates are kept as the file has them: its units are taken for metres, its axes stay.
    pub fn load(&self) -> Result<TriangleMesh, MeshError> {
        Ok(self.load_with_format()?.0)
    }

    /// The format is None for a built-in mesh.
    pub(super) fn load_with_format(&self) -> Result<(TriangleMesh, Option<Format>), MeshError> {
        match self {
            Self::File(path) => {
                let (mesh, format) = load(path).map_err(|error| error.in_file(path))?;
                Ok((mesh, Some(format)))
            }
            Self::Builtin(builtin) => Ok((builtin.mesh(), None)),
        }
    }
}

fn load(path: &Path) -> Result<(TriangleMesh, Format), MeshError> {
    let bytes = read_regular(path)?;
    let directory = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let format = Format::of(path, &bytes)?;
    Ok((format.parse(&bytes, directory)?, format))
}

/// Pipes and devices may never end: they are refused before the first read.
pub(super) fn read_regular(path: &Path) -> Result<Vec<u8>, MeshError> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(MeshError::NotAFile);
    }
    Ok(std::fs::read(path)?)
}
