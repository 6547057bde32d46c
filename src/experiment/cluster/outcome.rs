//! What a simulated run comes to.

use super::events::Time;

/// Times in nanoseconds, as long as they are added up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Of the master's processor.
    pub analysis: Time,
    pub matching: Time,
    pub sending: Time,
    pub receiving: Time,
    /// Not of the processor: the master waits until what it sends is taken.
    pub blocked: Time,
    /// The master's link, to the workers.
    pub link: Time,
    /// Of all workers' processors together, each in its own speed.
    pub computing: Time,
    pub placing: Time,
    /// Of subtrees, over all workers: from the master, and from each other.
    pub bytes_sent: f64,
    pub bytes_fetched: f64,
    pub tasks: u64,
    /// First task to be sent.
    pub first_task: Option<Time>,
    pub last_answer: Time,
}

/// One simulated run.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Outcome {
    /// First task sent to last answer received.
    pub time_s: f64,
    /// Weighted serial time over this time: the paper's speedup (section 7.2).
    pub speedup: f64,
    /// What `speedup` is at most, if nothing but computing took time.
    pub speedup_bound: f64,
    /// Serial time on a core of the first node over this time, and what that is at most: the paper's
    /// n1 + n2 t1 / t2 (section 7.1.1).
    pub over_first: f64,
    pub bound: f64,
    /// Of subtrees, by the master, and by workers to each other.
    pub bytes_sent: f64,
    pub bytes_fetched: f64,
    /// What the master sends over the bytes of both trees (section 7.2).
    pub relative_data_transfer: f64,
    /// What compressing all subtrees takes the master before, on one core.
    pub packing_s: f64,
    pub tasks: u64,
    pub utilisation: Utilisation,
    pub memory: MemoryUse,
}

/// Parts of the time.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Utilisation {
    pub master: f64,
    pub master_analysis: f64,
    pub master_matching: f64,
    pub master_sending: f64,
    /// Part of the time that the master waits for what it sends to be taken.
    pub master_blocked: f64,
    /// The master's, towards the workers.
    pub link: f64,
    /// Mean over the workers: computing scenarios, and taking subtrees.
    pub computing: f64,
    pub placing: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct MemoryUse {
    /// Over the memory of its node; above 1 there is none left.
    pub fullest: f64,
    pub fullest_node: usize,
    /// Peaks of all nodes together.
    pub bytes: f64,
}

impl MemoryUse {
    pub fn is_exceeded(&self) -> bool {
        self.fullest > 1.0
    }
}
