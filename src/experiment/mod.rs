//! Measurements that users make: what accuracy costs, what a transport costs, what an engine gets
//! done, and the paper's evaluation.

pub mod accuracy;
pub mod cluster;
mod contact_error;
mod difference;
pub mod evaluation;
pub mod latency;
pub mod throughput;
