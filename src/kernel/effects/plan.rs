//! Which steps a scene calls for, in their order.

use serde::{Deserialize, Serialize};

use super::clearance::{ClearanceEffect, ClearanceOptions};
use super::crush::{CrushEffect, CrushOptions};
use super::inside::ContainmentEffect;
use super::layout::Layout;
use super::motion::{MotionEffect, MotionOptions};
use super::penetration::{PenetrationEffect, PenetrationOptions};
use super::response::{ResponseEffect, ResponseOptions};
use super::segments::Segments;
use super::volume::VolumeEffect;
use super::{Effect, Ranges};
use crate::mesh::TriangleMesh;
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
    Containment,
    Clearance(ClearanceOptions),
    Penetration(PenetrationOptions),
    Volume,
    Motion(Box<MotionOptions>),
    Response(Box<ResponseOptions>),
    Crush(Box<CrushOptions>),
}

/// Of all tables that any step can have.
pub const TABLES: &[&str] = &["segments", "curves", "near_pairs", "contact_intervals"];

/// An effect in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Description {
    pub effect: &'static str,
    /// The scenarios that need it.
    pub needed_where: &'static str,
    /// What in a scene calls for it.
    pub called_for_by: &'static str,
}

const fn description(
    effect: &'static str,
    needed_where: &'static str,
    called_for_by: &'static str,
) -> Description {
    Description { effect, needed_where, called_for_by }
}

/// In the order in which they run.
pub const DESCRIPTIONS: [Description; 8] = [
    description("contacts.segments", "triangles touch", "`effects.segments = true`"),
    description(
        "containment",
        "no triangles touch",
        "`effects.containment`, or volume and penetration, which need it",
    ),
    description("clearance", "no triangles touch", "`effects.clearance`"),
    description("penetration", "the meshes overlap", "`effects.penetration`"),
    description("volume", "the meshes overlap", "`effects.volume = true`"),
    description("motion", "neither is inside the other", "`motion.duration_s`"),
    description(
        "response",
        "triangles touch, or a motion brings them to it",
        "masses and inertias of both and a velocity, or `effects.response`",
    ),
    description("crush", "there is an impact", "`effects.crush`"),
];

impl Step {
    pub fn effect(&self) -> Box<dyn Effect> {
        match self {
            Self::Segments => Box::new(Segments::default()),
            Self::Containment => Box::new(ContainmentEffect::default()),
            Self::Clearance(options) => Box::new(ClearanceEffect::new(*options)),
            Self::Penetration(options) => Box::new(PenetrationEffect::new(*options)),
            Self::Volume => Box::new(VolumeEffect::default()),
            Self::Motion(options) => Box::new(MotionEffect::new(MotionOptions::clone(options))),
            Self::Response(options) => Box::new(ResponseEffect::new(**options)),
            Self::Crush(options) => Box::new(CrushEffect::new(**options)),
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

    /// How many trees steps need beside the fixed and the moving one.
    pub fn part_count(&self) -> usize {
        let of_step = |step: &Step| match step {
            Step::Motion(options) => options.parts.iter().map(Vec::len).sum(),
            _ => 0,
        };
        self.steps.iter().map(of_step).sum()
    }

    /// The meshes that steps need beside the fixed and the moving one, in their order.
    pub fn parts(&self, meshes: [&TriangleMesh; 2]) -> Vec<TriangleMesh> {
        let motions = self.steps.iter().filter_map(|step| match step {
            Step::Motion(options) => Some(options),
            _ => None,
        });
        let of_side = |(mesh, parts): (&TriangleMesh, _)| -> Vec<TriangleMesh> {
            let parts: &Vec<super::motion::PartTree> = parts;
            parts.iter().map(|part| mesh.of_triangles(part.triangles.iter())).collect()
        };
        motions
            .flat_map(|options| meshes.into_iter().zip(&options.parts).flat_map(of_side))
            .collect()
    }
}
