use crate::scene::{MatchRule, StartFrom};

/// Times in seconds.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct EngineReport {
    pub transport: &'static str,
    pub matchmaker: MatchRule,
    pub start_from: StartFrom,
    /// Results delivered to the sink.
    pub completed: u32,
    pub interrupted: bool,
    /// Scenarios at which every worker died, and that have no result.
    pub set_aside: Vec<u32>,
    /// Bytes of images, copied once to where every worker can read them.
    pub bytes_published: u64,
    /// Bytes of subtrees that were sent to single workers.
    pub bytes_sent: u64,
    /// `bytes_sent` over the bytes of both trees (section 7.2 of the paper).
    pub relative_data_transfer: f64,
    pub publish_s: f64,
    /// First process started to last worker ready. Loading, building, publishing and the first
    /// scenarios overlap with it.
    pub start_workers_s: f64,
    /// Start of the run to the first answers.
    pub first_result_s: f64,
    /// First batch sent to last result received.
    pub scenarios_s: f64,
    /// Within `scenarios_s`, in the master: finding the pairs of subtrees that meet.
    pub pre_analysis_s: f64,
    /// Within `scenarios_s`, in the master: choosing a client for each scenario.
    pub matching_s: f64,
    pub workers: Vec<WorkerReport>,
}

#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct WorkerReport {
    pub scenarios: u32,
    pub batches: u32,
    pub compute_s: f64,
    /// Bytes of subtrees sent to it: 0 where they are used in place.
    pub geometry_bytes_copied: u64,
    /// Bytes of all messages to and from it.
    pub message_bytes: u64,
    pub died: bool,
    /// Workers that took the place of one that died.
    pub restarts: u32,
}
