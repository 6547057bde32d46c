use crate::scene::{Compression, MatchRule, StartFrom, SubtreesFrom};

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
    /// Bytes of subtrees that the master sent to single workers, compressed if they were.
    pub bytes_sent: u64,
    /// `bytes_sent` over the bytes of both trees (section 7.2 of the paper).
    pub relative_data_transfer: f64,
    pub transfer: TransferReport,
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
    /// Where workers are on several machines; the first is the master's.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<NodeReport>,
}

/// Workers that have memory in common. What goes to and from the master's own crosses no link.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct NodeReport {
    /// The name of its machine.
    pub host: String,
    pub workers: u32,
    /// Bytes of subtrees that the master has sent to it.
    pub geometry_bytes_copied: u64,
    /// Bytes of subtrees that it has had from other nodes.
    pub bytes_from_nodes: u64,
    /// `geometry_bytes_copied` over the bytes of both trees.
    pub relative_data_transfer: f64,
    /// Bytes of all messages from the master to its leader, since the engine began.
    pub link_bytes_sent: u64,
    /// Bytes of all messages from its leader to the master.
    pub link_bytes_received: u64,
}

/// How subtrees went to the workers, where they are sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct TransferReport {
    pub compress: Compression,
    /// What compressing took the master before the first scenario, on all cores.
    pub compress_s: f64,
    /// Of all subtrees of both trees, once each: as they are.
    pub bytes_plain: u64,
    /// And as they are sent.
    pub bytes_packed: u64,
    pub subtrees_from: SubtreesFrom,
    /// Bytes of subtrees that workers, or nodes, had from each other.
    pub bytes_from_workers: u64,
    /// Subtrees that another worker was to give and did not: the master has sent them.
    pub not_fetched: u32,
}

impl TransferReport {
    fn followed_by(&self, then: &Self) -> Self {
        Self {
            compress_s: self.compress_s + then.compress_s,
            bytes_plain: self.bytes_plain + then.bytes_plain,
            bytes_packed: self.bytes_packed + then.bytes_packed,
            bytes_from_workers: self.bytes_from_workers + then.bytes_from_workers,
            not_fetched: self.not_fetched + then.not_fetched,
            ..*then
        }
    }
}

impl EngineReport {
    /// Of two runs of one engine, the scenarios of the second numbered from `first` on.
    pub fn followed_by(self, then: Self, first: u32) -> Self {
        let mut set_aside = self.set_aside;
        set_aside.extend(then.set_aside.iter().map(|scenario| first + scenario));
        let bytes_sent = self.bytes_sent + then.bytes_sent;
        let workers = self.workers.iter().zip(&then.workers);
        Self {
            completed: self.completed + then.completed,
            set_aside,
            bytes_sent,
            relative_data_transfer: self.relative_data_transfer + then.relative_data_transfer,
            transfer: self.transfer.followed_by(&then.transfer),
            first_result_s: self.first_result_s,
            scenarios_s: self.scenarios_s + then.scenarios_s,
            pre_analysis_s: self.pre_analysis_s + then.pre_analysis_s,
            matching_s: self.matching_s + then.matching_s,
            start_workers_s: self.start_workers_s.max(then.start_workers_s),
            workers: workers.map(|(a, b)| a.followed_by(b)).collect(),
            nodes: self.nodes.iter().zip(&then.nodes).map(|(a, b)| a.followed_by(b)).collect(),
            ..then
        }
    }
}

impl NodeReport {
    /// What is of the engine is of both runs already.
    fn followed_by(&self, then: &Self) -> Self {
        Self {
            geometry_bytes_copied: self.geometry_bytes_copied + then.geometry_bytes_copied,
            bytes_from_nodes: self.bytes_from_nodes + then.bytes_from_nodes,
            relative_data_transfer: self.relative_data_transfer + then.relative_data_transfer,
            ..then.clone()
        }
    }
}

impl WorkerReport {
    fn followed_by(&self, then: &Self) -> Self {
        Self {
            scenarios: self.scenarios + then.scenarios,
            batches: self.batches + then.batches,
            compute_s: self.compute_s + then.compute_s,
            geometry_bytes_copied: self.geometry_bytes_copied + then.geometry_bytes_copied,
            bytes_from_workers: self.bytes_from_workers + then.bytes_from_workers,
            message_bytes: self.message_bytes + then.message_bytes,
            died: self.died || then.died,
            restarts: self.restarts + then.restarts,
        }
    }
}

#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct WorkerReport {
    pub scenarios: u32,
    pub batches: u32,
    pub compute_s: f64,
    /// Bytes of subtrees that the master has sent to it: 0 where they are used in place.
    pub geometry_bytes_copied: u64,
    /// Bytes of subtrees that it has had from other workers.
    pub bytes_from_workers: u64,
    /// Bytes of all messages to and from it.
    pub message_bytes: u64,
    pub died: bool,
    /// Workers that took the place of one that died.
    pub restarts: u32,
}
