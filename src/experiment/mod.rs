//! Measurements that users make: what a transport costs, and what an engine gets done.

pub mod latency;
pub mod throughput;
