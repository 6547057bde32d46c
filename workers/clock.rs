//! Clocks that the standard library does not have.

use std::time::{Duration, Instant};

/// Nanoseconds since the machine was started, the same in all processes.
pub fn machine_ns() -> u64 {
    read(libc::CLOCK_MONOTONIC)
}

/// Nanoseconds that this thread has run: what else runs on the machine does not count.
pub fn thread_ns() -> u64 {
    read(libc::CLOCK_THREAD_CPUTIME_ID)
}

/// Sleepers are woken late by less than this.
const LATE: Duration = Duration::from_micros(150);

/// To the microsecond.
pub fn sleep_until(moment: Instant) {
    let rest = moment.saturating_duration_since(Instant::now());
    std::thread::sleep(rest.saturating_sub(LATE));
    while Instant::now() < moment {
        std::hint::spin_loop();
    }
}

fn read(clock: libc::clockid_t) -> u64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the call writes one `timespec`, and this is one.
    let failed = unsafe { libc::clock_gettime(clock, &raw mut time) };
    assert_eq!(failed, 0, "every Linux has this clock");
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}
