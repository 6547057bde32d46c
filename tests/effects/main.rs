//! What scenes can ask for, against closed forms, sampling and brute force.

mod crush;
mod deform;
#[path = "../oracle/mod.rs"]
mod oracle;
mod refit;
