use std::fmt;
use std::path::Path;

use super::raw::RawMesh;
use super::text::{Lines, without_byte_order_mark, words};
use super::{FormatError, MeshError, Problem, TriangleMesh, gltf, obj, ply, stl, vrml};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Ply,
    Obj,
    Stl,
    Glb,
    Gltf,
    Vrml,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ply => "PLY",
            Self::Obj => "OBJ",
            Self::Stl => "STL",
            Self::Glb => "GLB",
            Self::Gltf => "glTF",
            Self::Vrml => "VRML97",
        })
    }
}

impl Format {
    /// By the extension; by the content where the extension says nothing. Content that is
    /// plainly of another format than the extension says is refused.
    pub fn of(path: &Path, bytes: &[u8]) -> Result<Self, FormatError> {
        if bytes.is_empty() {
            return Err(Problem::EmptyFile.in_file());
        }
        match (Self::from_extension(path), Self::sniff(bytes)) {
            (Some(expected), Some(found)) if expected != found => {
                Err(Problem::WrongType { expected, found }.in_file())
            }
            (Some(format), _) | (None, Some(format)) => Ok(format),
            (None, None) => Err(Problem::UnknownFormat.in_file()),
        }
    }

    /// Reads and validates one file's bytes; `directory` is where its sibling files are.
    pub fn parse(self, bytes: &[u8], directory: &Path) -> Result<TriangleMesh, MeshError> {
        let RawMesh { vertices, faces } = match self {
            Self::Ply => ply::read(bytes)?,
            Self::Obj => obj::read(bytes)?,
            Self::Stl => stl::read(bytes)?,
            Self::Glb => gltf::read_glb(bytes, directory)?,
            Self::Gltf => gltf::read_gltf(bytes, directory)?,
            Self::Vrml => vrml::read(bytes)?,
        };
        TriangleMesh::new(vertices, faces)
    }

    fn from_extension(path: &Path) -> Option<Self> {
        match path.extension()?.to_ascii_lowercase().to_str()? {
            "ply" => Some(Self::Ply),
            "obj" => Some(Self::Obj),
            "stl" => Some(Self::Stl),
            "glb" => Some(Self::Glb),
            "gltf" => Some(Self::Gltf),
            "wrl" | "wrz" => Some(Self::Vrml),
            _ => None,
        }
    }

    fn sniff(bytes: &[u8]) -> Option<Self> {
        let text = without_byte_order_mark(bytes);
        match text {
            [b'p', b'l', b'y', b'\r' | b'\n', ..] => Some(Self::Ply),
            [b'g', b'l', b'T', b'F', ..] => Some(Self::Glb),
            [0x1f, 0x8b, ..] => Some(Self::Vrml),
            _ if text.starts_with(b"#VRML") => Some(Self::Vrml),
            _ if stl::is_stl(bytes) => Some(Self::Stl),
            _ if text.trim_ascii_start().starts_with(b"{") => Some(Self::Gltf),
            _ => looks_like_obj(text).then_some(Self::Obj),
        }
    }
}

/// OBJ has no signature: its first statement has to be one that such files begin
/// with.
fn looks_like_obj(text: &[u8]) -> bool {
    const OPENINGS: [&[u8]; 10] =
        [b"v", b"vn", b"vt", b"f", b"o", b"g", b"s", b"mtllib", b"usemtl", b"l"];
    if text.iter().take(1024).any(|byte| *byte == 0) {
        return false;
    }
    let statements = Lines::new(text).map(|(_, line)| line);
    let first = statements.filter_map(|line| words(line).next()).find(|word| word[0] != b'#');
    first.is_some_and(|word| OPENINGS.contains(&word))
}
