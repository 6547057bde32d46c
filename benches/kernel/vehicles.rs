//! Two vehicles, indexed in every way, and the poses in which they are timed.

use std::num::NonZeroU32;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use bumper::geometry::Pose;
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::scene::read_poses;
use bumper::tree::{BuildOptions, TreeImage, TreeKind, build};

use crate::contender::Index;
use crate::{Source, parry, poses};

/// Number of pairs and their hash.
pub type Answer = (usize, u64);

pub struct Vehicles {
    pub name: String,
    pub fixed: TriangleMesh,
    pub moving: TriangleMesh,
    /// In the order of [`crate::contender::Contender::index`].
    pub indexes: Vec<Index>,
    /// Of each index: seconds to build both, bytes a triangle (the peer does not tell).
    pub builds: Vec<(f64, Option<f64>)>,
    pub poses: Vec<Pose>,
    /// Apart by about a millimetre.
    pub near: Vec<Pose>,
    pub truth: Option<Vec<Answer>>,
}

impl Vehicles {
    pub fn new(source: &Source, count: NonZeroU32) -> Result<Self> {
        let load =
            |source: &str| -> Result<TriangleMesh> { Ok(source.parse::<MeshSource>()?.load()?) };
        let (fixed, moving) = (load(&source.fixed)?, load(&source.moving)?);
        let triangles = (fixed.faces().len() + moving.faces().len()) as f64;
        let (mut indexes, mut builds) = (Vec::new(), Vec::new());
        let start = Instant::now();
        indexes.push(Index::Peer(Box::new(parry::Peer::new(&fixed, &moving))));
        builds.push((start.elapsed().as_secs_f64(), None));
        for kind in TreeKind::ALL {
            let start = Instant::now();
            let images = [&fixed, &moving].map(|mesh| build(mesh, BuildOptions { kind }));
            let seconds = start.elapsed().as_secs_f64();
            let index = Index::Ours(images);
            builds.push((seconds, index.bytes().map(|bytes| bytes as f64 / triangles)));
            indexes.push(index);
        }
        let Some(Index::Ours([a, b])) = indexes.last() else { unreachable!("the fastest is last") };
        let poses = match &source.poses {
            Some(path) => read_poses(path, Some(count))?,
            None => poses::random((&fixed, a), (&moving, b), count)?,
        };
        let near = poses::near_misses(&a.view(), &b.view(), &poses)?;
        let truth =
            source.truth.as_deref().map(|path| read_truth(path, poses.len())).transpose()?;
        let name = format!("{} against {}", source.fixed, source.moving);
        Ok(Self { name, fixed, moving, indexes, builds, poses, near, truth })
    }

    /// Another index of the same content, elsewhere in memory.
    pub fn copy(&self, index: usize) -> Index {
        match &self.indexes[index] {
            Index::Ours(images) => Index::Ours(images.each_ref().map(TreeImage::clone)),
            Index::Peer(_) => Index::Peer(Box::new(parry::Peer::new(&self.fixed, &self.moving))),
        }
    }
}

/// Rows of pose, number of pairs, hash, under a header.
fn read_truth(path: &Path, count: usize) -> Result<Vec<Answer>> {
    let text = std::fs::read_to_string(path)?;
    let rows = text.lines().skip(1).take(count);
    rows.map(|row| {
        let mut fields = row.split(',').skip(1);
        let mut field = || fields.next().context("a row has three fields");
        Ok((field()?.parse()?, u64::from_str_radix(field()?, 16)?))
    })
    .collect()
}
