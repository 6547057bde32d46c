//! Built trees on disk, so that a mesh is built once (section 5.1: "the data structure can be
//! saved along with the geometry information").

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use bytemuck::Zeroable;

use super::{Block, BuildOptions, ImageError, TreeImage, build};
use crate::mesh::TriangleMesh;

/// How a tree was had.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CacheOutcome {
    /// Without a cache directory.
    Off,
    Hit,
    Built,
    /// A damaged or outdated file was there.
    Rebuilt,
}

/// From the cache if it is there and whole, otherwise built and kept there. A cache that cannot be
/// read or written costs a warning and time, never the answer.
pub fn load_or_build(
    mesh: &TriangleMesh,
    options: BuildOptions,
    directory: Option<&Path>,
) -> (TreeImage, CacheOutcome) {
    let Some(directory) = directory else {
        return (build(mesh, options), CacheOutcome::Off);
    };
    let mesh_hash = mesh.content_hash();
    let path = file_path(directory, mesh_hash, options);
    let outcome = match load(&path, mesh_hash, options) {
        Ok(image) => return (image, CacheOutcome::Hit),
        Err(CacheError::Read(error)) if error.kind() == io::ErrorKind::NotFound => {
            CacheOutcome::Built
        }
        Err(error) => {
            tracing::warn!("{}: {error}; the tree is built again", path.display());
            CacheOutcome::Rebuilt
        }
    };
    let image = build(mesh, options);
    if let Err(error) = store(&path, &image) {
        tracing::warn!("{}: the tree is not kept for the next run: {error}", path.display());
    }
    (image, outcome)
}

/// Where the tree of this mesh and these options is kept.
pub fn file_path(directory: &Path, mesh_hash: u64, options: BuildOptions) -> PathBuf {
    directory.join(format!("{mesh_hash:016x}-{}.tree", options.kind))
}

#[derive(Debug, thiserror::Error)]
enum CacheError {
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    #[error("{0}")]
    Image(#[from] ImageError),
    #[error("{0} bytes are no whole number of blocks")]
    Length(u64),
    #[error("it belongs to another mesh or tree kind")]
    Other,
}

fn load(path: &Path, mesh_hash: u64, options: BuildOptions) -> Result<TreeImage, CacheError> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    if length % size_of::<Block>() as u64 != 0 {
        return Err(CacheError::Length(length));
    }
    // Read, not mapped: a file that another process cuts short must not be a signal.
    let mut blocks = vec![Block::zeroed(); length as usize / size_of::<Block>()];
    file.read_exact(bytemuck::cast_slice_mut(&mut blocks))?;
    let image = TreeImage::from_blocks(blocks)?;
    let header = *image.view().header();
    if header.mesh_hash != mesh_hash || image.view().kind() != options.kind {
        return Err(CacheError::Other);
    }
    Ok(image)
}

/// To a temporary name first: a reader sees the whole file or none.
fn store(path: &Path, image: &TreeImage) -> io::Result<()> {
    let directory = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(directory)?;
    let mut file = tempfile::NamedTempFile::new_in(directory)?;
    file.write_all(bytemuck::cast_slice(image.blocks()))?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}
