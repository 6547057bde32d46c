//! What a scene can ask of a scenario; one file an effect.
//!
//! A [`Plan`] is the list of steps that a scene calls for, and nothing else is computed. Every step
//! but the first is an [`Effect`], and a scenario that does not need it skips it.

mod asked;
mod calculator;
pub mod clearance;
pub mod contacts;
pub mod crush;
pub mod inside;
mod kept;
pub mod layout;
pub mod motion;
mod parts;
pub mod penetration;
mod plan;
pub mod response;
mod segments;
pub mod volume;

pub use asked::{
    Asked, BodyAsked, CrushAsked, MotionAsked, PairsAsked, ResponseAsked, Unplannable,
};
pub use calculator::{Effects, Question};
pub use parts::{NotRanges, Ranges};
pub use plan::{DESCRIPTIONS, Description, Plan, Step, TABLES};

use crate::geometry::{Point, Pose};
use crate::tree::descent::{Descent, DescentError, Pair};
use crate::tree::{ByNumber, TreeView};
pub use kept::Kept;
use layout::{Note, StepLayout};

/// One step of a plan, with what it keeps from scenario to scenario.
pub trait Effect {
    fn layout(&self) -> StepLayout;

    /// Whether the scenario needs it, by what is known of it.
    fn is_called_for(&self, known: &Known) -> bool;

    /// How much work it was, in the unit of its layout.
    fn run(
        &mut self,
        scenario: &mut Scenario<'_>,
        known: &mut Known,
        note: &mut Note<'_>,
    ) -> Result<u64, DescentError>;
}

/// What effects are asked about.
pub struct Scenario<'a> {
    pub fixed: TreeView<'a>,
    pub moving: TreeView<'a>,
    pub pose: Pose,
    /// Sorted, without those that are ignored; empty where only overlap is asked for.
    pub pairs: &'a [Pair],
    pub descent: &'a mut Descent,
    /// Trees beside both, in the order of the plan.
    pub parts: &'a [TreeView<'a>],
    /// Of the fixed and of the moving mesh.
    pub kept: &'a mut [Kept; 2],
}

impl Scenario<'_> {
    /// The fixed and the moving mesh's triangles, the moving ones not placed.
    pub fn by_number(&mut self) -> [ByNumber<'_>; 2] {
        let [fixed, moving] = self.kept;
        [fixed.by_number(&self.fixed), moving.by_number(&self.moving)]
    }
}

/// What earlier steps have found out about a scenario.
#[derive(Clone, Copy, Debug, Default)]
pub struct Known {
    /// Some triangles touch.
    pub touching: bool,
    /// Nothing touches, and a part of one mesh is inside the other.
    pub inside: bool,
    /// Where and when both collide, if a motion or an impact was asked for.
    pub collision: Option<Collision>,
    pub impact: Option<response::Impact>,
}

impl Known {
    pub fn overlapping(&self) -> bool {
        self.touching || self.inside
    }
}

/// Where and when two bodies collide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    pub time_s: f64,
    /// World axes.
    pub point: Point,
    /// From the fixed body to the moving one, of unit length.
    pub normal: Point,
}
