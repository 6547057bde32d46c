//! `run.json`: what a run answers and with what, beside its scene: enough to know whether a later one
//! would answer the same.

use serde::{Deserialize, Serialize};

use super::Versions;
use crate::geometry::Pose;
use crate::mesh::TriangleMesh;

const SCHEMA_VERSION: u32 = 1;

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunIdentity {
    schema_version: u32,
    bumper: String,
    /// Hashes of what the meshes hold, offsets in them.
    fixed_mesh: String,
    moving_mesh: String,
    /// Hash of the poses, bit for bit.
    poses: String,
    pub scenarios: usize,
    /// Whether the pairs themselves are wanted.
    pub contacts: bool,
}

impl RunIdentity {
    pub fn new(
        fixed: &TriangleMesh,
        moving: &TriangleMesh,
        poses: &[Pose],
        contacts: bool,
    ) -> Self {
        let hash = |mesh: &TriangleMesh| format!("{:016x}", mesh.content_hash());
        let poses_hash = xxhash_rust::xxh3::xxh3_64(bytemuck::cast_slice(poses));
        Self {
            schema_version: SCHEMA_VERSION,
            bumper: Versions::this().bumper.to_owned(),
            fixed_mesh: hash(fixed),
            moving_mesh: hash(moving),
            poses: format!("{poses_hash:016x}"),
            scenarios: poses.len(),
            contacts,
        }
    }

    pub fn parse(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("string keys and plain values") + "\n"
    }

    /// In what a run that is to go on differs from the one that began.
    pub fn difference(&self, begun: &Self) -> Option<String> {
        if (self.schema_version, &self.bumper) != (begun.schema_version, &begun.bumper) {
            return Some(format!(
                "it was begun by bumper {}, this is {}",
                begun.bumper, self.bumper
            ));
        }
        let differs = [
            ("the fixed mesh", self.fixed_mesh != begun.fixed_mesh),
            ("the moving mesh", self.moving_mesh != begun.moving_mesh),
            ("the number of scenarios", self.scenarios != begun.scenarios),
            ("a pose", self.poses != begun.poses),
            ("whether contacts are written", self.contacts != begun.contacts),
        ];
        let (what, _) = differs.into_iter().find(|(_, differs)| *differs)?;
        Some(format!("{what} is not what it was"))
    }
}
