/// Times in seconds.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct EngineReport {
    pub transport: &'static str,
    /// Results delivered to the sink.
    pub completed: u32,
    pub interrupted: bool,
    /// Bytes of both images, copied once to where every worker can read them.
    pub bytes_published: u64,
    pub publish_s: f64,
    /// First process started to last worker ready. Publishing and the first scenarios overlap
    /// with it.
    pub start_workers_s: f64,
    /// First batch sent to last result received.
    pub scenarios_s: f64,
    pub pre_analysis_s: f64,
    pub workers: Vec<WorkerReport>,
}

#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct WorkerReport {
    pub scenarios: u32,
    pub batches: u32,
    pub compute_s: f64,
    /// Bytes of tree images copied into or for this worker: 0 where they are used in place.
    pub geometry_bytes_copied: u64,
    /// Bytes of batches and results.
    pub message_bytes: u64,
    pub died: bool,
}
