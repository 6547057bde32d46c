//! Time of many calls.

use std::hint::black_box;

use bumper::workers::clock::thread_ns;

/// Nanoseconds of processor time.
#[derive(Default)]
pub struct Timings(Vec<u64>);

impl Timings {
    pub fn time<T>(&mut self, call: impl FnOnce() -> T) -> T {
        let start = thread_ns();
        let answer = black_box(call());
        self.0.push(thread_ns() - start);
        answer
    }

    pub fn mean_us(&self) -> f64 {
        self.0.iter().sum::<u64>() as f64 / self.0.len() as f64 * 1e-3
    }

    /// NaN where nothing was timed, as the mean.
    pub fn quantile_us(&mut self, q: f64) -> f64 {
        self.0.sort_unstable();
        let Some(last) = self.0.len().checked_sub(1) else { return f64::NAN };
        self.0[(last as f64 * q).round() as usize] as f64 * 1e-3
    }
}
