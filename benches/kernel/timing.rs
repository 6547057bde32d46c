//! Time of many calls.

use std::hint::black_box;

#[derive(Default)]
pub struct Timings(Vec<f64>);

impl Timings {
    pub fn time<T>(&mut self, call: impl FnOnce() -> T) -> T {
        let start = thread_seconds();
        let answer = black_box(call());
        self.0.push((thread_seconds() - start) * 1e3);
        answer
    }

    pub fn mean_ms(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    pub fn quantile_ms(&mut self, q: f64) -> f64 {
        self.0.sort_unstable_by(f64::total_cmp);
        self.0[((self.0.len() - 1) as f64 * q).round() as usize]
    }
}

/// Processor time of this thread: what else runs on the machine does not count.
fn thread_seconds() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the call writes one `timespec`, and this is one.
    let failed = unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &raw mut time) };
    assert_eq!(failed, 0, "every Linux has this clock");
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
