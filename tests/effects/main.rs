//! What a scene can ask of a scenario, each effect against an independent oracle.

mod solids;
mod crush;
mod deform;
mod oracle;
mod refit;
mod motion;
mod clearance;
