//! Effects against oracles that know nothing of trees.

mod clearance;
