//! What a scene can ask of a scenario, each effect against an independent oracle.

mod clearance;
mod crush;
mod deform;
mod motion;
#[path = "../oracle/mod.rs"]
mod oracle;
mod plan;
#[path = "../random/mod.rs"]
mod random;
mod refit;
mod solids;
