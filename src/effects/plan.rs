//! Which steps a scene calls for, in their order.

use serde::{Deserialize, Serialize};

use super::layout::Layout;
use super::segments::Segments;
use super::{Effect, Ranges};
use crate::tree::descent::Pair;

/// What is computed of every scenario that needs it, and nothing else is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Triangles of the fixed and of the moving mesh whose contacts do not count.
    pub ignore: Vec<[Ranges; 2]>,
    /// After the pairs are known. Later steps may need what earlier ones find out.
    pub steps: Vec<Step>,
}

/// A step, with what it was asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Step {
    Segments,
}

/// Of all tables that any step can have.
pub const TABLES: &[&str] = &["segments", "curves"];

impl Step {
    pub fn effect(&self) -> Box<dyn Effect> {
        match self {
            Self::Segments => Box::new(Segments::default()),
        }
    }
}

impl Plan {
    /// There is nothing to be done but to find the pairs.
    pub fn is_empty(&self) -> bool {
        self.ignore.is_empty() && self.steps.is_empty()
    }

    pub fn layout(&self) -> Layout {
        Layout { steps: self.steps.iter().map(|step| step.effect().layout()).collect() }
    }

    pub fn ignores(&self, [fixed, moving]: Pair) -> bool {
        self.ignore.iter().any(|[a, b]| a.contains(fixed) && b.contains(moving))
    }
}
