//! A run as one HTML page to look at: everything in it, nothing fetched from anywhere.
//!
//! What is drawn is made in `viewer/`; here is what it draws.

mod body;
mod earlier;
mod page;
mod scenarios;
mod sections;

pub use body::ViewBody;
pub use earlier::{Differs, EarlierError, EarlierRun};
pub use page::{content_security_policy, page};
pub use scenarios::{Collected, Detail, MOST_LISTED, MOST_SHOWN, ViewCurve, ViewScenario};

use serde::Serialize;

use crate::effects::layout::Layout;
use crate::effects::layout::{Column, Kind};
use crate::geometry::Point;
use crate::tree::{Accuracy, ByNumber, TreeKind};
use body::BodyHeader;
use sections::{Section, Sections};

/// What is to be seen.
#[derive(Debug)]
pub struct View<'a> {
    /// The fixed and the moving one.
    pub bodies: [ViewBody<'a>; 2],
    pub accuracy: Accuracy,
    pub transport: &'static str,
    /// Whether workers read the trees where the master has them.
    pub shares_memory: bool,
    pub workers: usize,
    /// Of what effects say.
    pub layout: &'a Layout,
    pub motion: Option<ViewMotion>,
    /// Along which depths of penetration are measured; world axes.
    pub penetration_direction: Option<Point>,
    /// The scenario whose crash deforms the vehicles in those after it.
    pub deform_after: Option<u32>,
    pub collected: Collected,
}

#[derive(Clone, Copy, Debug, Serialize)]
pub struct ViewMotion {
    pub duration_s: f64,
    /// What counts as contact.
    pub tolerance_m: f64,
}

/// Raised when something that the page reads changes.
const SCHEMA_VERSION: u32 = 1;

#[derive(Serialize)]
struct Header {
    schema_version: u32,
    bumper: &'static str,
    accuracy: Accuracy,
    tree: TreeKind,
    transport: &'static str,
    shares_memory: bool,
    workers: usize,
    bodies: [BodyHeader; 2],
    /// Answered, of which the page lists the first.
    scenarios: u32,
    listed: usize,
    /// Of those that are listed, shown in full.
    detailed: usize,
    colliding: u32,
    pairs: u64,
    columns: Vec<ColumnHeader>,
    #[serde(skip_serializing_if = "Option::is_none")]
    motion: Option<ViewMotion>,
    #[serde(skip_serializing_if = "Option::is_none")]
    penetration_direction: Option<Point>,
    #[serde(skip_serializing_if = "Option::is_none")]
    deform_after: Option<u32>,
    sections: Vec<Section>,
}

#[derive(Serialize)]
struct ColumnHeader {
    name: &'static str,
    kind: &'static str,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    choices: &'static [&'static str],
}

impl From<&Column> for ColumnHeader {
    fn from(column: &Column) -> Self {
        let (kind, choices): (_, &[_]) = match column.kind {
            Kind::Flag => ("flag", &[]),
            Kind::Count => ("count", &[]),
            Kind::Number => ("number", &[]),
            Kind::Choice(choices) => ("choice", choices),
        };
        Self { name: column.name, kind, choices }
    }
}

impl View<'_> {
    /// As the page reads it.
    pub fn payload(&self) -> Vec<u8> {
        let (Collected { listed, .. }, [fixed, moving]) = (&self.collected, &self.bodies);
        let mut sections = Sections::default();
        let bodies = [fixed.write(0, &mut sections), moving.write(1, &mut sections)];
        let centers = [fixed.center(), moving.center()];
        let by_number = [fixed, moving].map(|body| ByNumber::new(body.tree));
        scenarios::write(listed, self.layout, centers, by_number, &mut sections);
        sections.finish(|sections| Header {
            schema_version: SCHEMA_VERSION,
            bumper: env!("CARGO_PKG_VERSION"),
            accuracy: self.accuracy,
            tree: fixed.tree.kind(),
            transport: self.transport,
            shares_memory: self.shares_memory,
            workers: self.workers,
            bodies,
            scenarios: self.collected.scenarios,
            listed: listed.len(),
            detailed: listed.iter().filter(|scenario| scenario.detail.is_some()).count(),
            colliding: self.collected.colliding,
            pairs: self.collected.pairs,
            columns: self.layout.columns().map(ColumnHeader::from).collect(),
            motion: self.motion,
            penetration_direction: self.penetration_direction,
            deform_after: self.deform_after,
            sections,
        })
    }
}
