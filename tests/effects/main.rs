//! Effects against what is known of them otherwise.

mod motion;
