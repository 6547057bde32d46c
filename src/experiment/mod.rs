//! Measurements that users make: what accuracy costs, what a transport costs, and what
//! an engine gets done.

pub mod accuracy;
pub mod cluster;
mod contact_error;
mod difference;
pub mod latency;
pub mod throughput;
