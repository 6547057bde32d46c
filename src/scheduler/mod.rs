//! The master's side (section 6.4 of the paper): pure state machines, and the client manager that
//! drives them.
//!
//! | | |
//! |---|---|
//! | [`client_manager`] | starts, feeds, watches and ends the workers; the only one with I/O and a clock |
//! | [`jobs_submitter`] | pre-analysis: a pose becomes two indicators |
//! | [`indicator`] | bounding volume vectors of scenarios and clients |
//! | [`node`] | memory of one worker, or of all workers of a machine, and what is in it |
//! | [`takers`] | clients that take scenarios, so filed that thousands cost little |
//! | [`matchmaker`] | picks a client for a scenario |
//! | [`pace`] | how fast clients are, and who is too slow for what is left |
//! | [`local_client`] | what one worker was given and has not answered |
//! | [`sources`] | where a worker gets a subtree that it lacks |
//! | [`assignment`] | all of them together, and what nobody has been given yet |
//! | [`launch`] | how a worker comes to life: as a process, or as a thread |
//! | [`ranks`] | workers on several machines, each of which has one copy of what it needs |
//! | [`collection`], [`result_order`] | replies become results in scenario order |

pub mod assignment;
mod bits;
pub mod client_manager;
pub mod collection;
mod engine_report;
pub mod indicator;
pub mod jobs_submitter;
pub mod launch;
pub mod local_client;
pub mod matchmaker;
mod memory;
pub mod node;
pub mod pace;
pub mod ranks;
pub mod result_order;
pub mod sources;
pub mod takers;
mod worker_process;
mod worker_thread;
