//! Ctrl-C: the first asks to stop, the second leaves at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::failure::Failure;

const EXIT_CODE: i32 = 130;

/// A flag that the first Ctrl-C (or SIGTERM) sets.
pub(super) fn on_ctrl_c() -> std::io::Result<Arc<AtomicBool>> {
    let interrupt = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // In this order: the exit looks at what the first signal left behind.
        flag::register_conditional_shutdown(signal, EXIT_CODE, Arc::clone(&interrupt))?;
        flag::register(signal, Arc::clone(&interrupt))?;
    }
    Ok(interrupt)
}

/// Fails if the run is to stop before it has results.
pub(super) fn check(interrupt: &AtomicBool) -> Result<(), Failure> {
    if interrupt.load(Ordering::Relaxed) { Err(before_results()) } else { Ok(()) }
}

pub(super) fn before_results() -> Failure {
    Failure::Interrupted("no scenario was answered, nothing was written".to_owned())
}
