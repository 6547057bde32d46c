//! What a scene asks for, and the plan that this makes.

use std::num::NonZeroU32;

use super::{Plan, Ranges, Step};
use crate::mesh::TriangleMesh;

/// What a scene asks for, each value checked by itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Asked {
    pub pairs: PairsAsked,
    /// So many pairs of a scenario are kept, from the first; absent: all.
    pub most_contacts: Option<NonZeroU32>,
    /// Parts of the fixed and of the moving mesh whose contacts do not count.
    pub ignore: Vec<[Ranges; 2]>,
    pub segments: bool,
}

/// What is found of the triangles that touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PairsAsked {
    /// Whether there is a pair.
    Overlap,
    #[default]
    Contacts,
}

impl PairsAsked {
    pub fn name(self) -> &'static str {
        match self {
            Self::Overlap => "overlap",
            Self::Contacts => "contacts",
        }
    }
}

/// What a scene lacks for what it asks.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}`: {reason}")]
pub struct Unplannable {
    /// Of the scene file.
    pub key: String,
    pub reason: String,
}

impl Unplannable {
    pub(super) fn new(key: impl Into<String>, reason: impl Into<String>) -> Self {
        Self { key: key.into(), reason: reason.into() }
    }
}

impl Asked {
    /// The steps, in their order, of scenarios of a fixed and a moving mesh.
    pub fn plan(&self, meshes: [&TriangleMesh; 2]) -> Result<Plan, Unplannable> {
        self.check_parts(meshes)?;
        let mut steps = Vec::new();
        if self.segments {
            steps.push(Step::Segments);
        }
        Ok(Plan { ignore: self.ignore.clone(), steps })
    }

    /// Whether it is enough to know of one pair.
    pub fn overlap_is_enough(&self) -> bool {
        self.pairs == PairsAsked::Overlap && self.ignore.is_empty() && !self.segments
    }

    /// Whether all pairs are wanted and nothing else.
    pub fn is_contacts_only(&self) -> bool {
        *self == Self { most_contacts: self.most_contacts, ..Self::default() }
    }

    /// Pairs of a scenario that are kept.
    pub fn most_pairs(&self) -> u32 {
        self.most_contacts.map_or(u32::MAX, NonZeroU32::get)
    }

    fn check_parts(&self, meshes: [&TriangleMesh; 2]) -> Result<(), Unplannable> {
        for (side, name) in [(0, "fixed"), (1, "moving")] {
            let triangles = meshes[side].faces().len();
            let last = self.ignore.iter().map(|pair| pair[side].last()).max();
            if last.is_some_and(|last| last as usize >= triangles) {
                let reason = format!(
                    "has a triangle {} and the mesh only {triangles}, counted from 0",
                    last.unwrap_or_default()
                );
                return Err(Unplannable::new(format!("{name}.parts"), reason));
            }
        }
        Ok(())
    }
}
