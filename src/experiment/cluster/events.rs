//! What happens next in a simulation.

use std::collections::BTreeMap;

/// Nanoseconds since the simulated run began.
pub type Time = u64;

/// Events in the order of their times; those of one time in the order in which they were put in, so
/// that a simulation repeats to the bit.
#[derive(Debug)]
pub struct Events<E> {
    now: Time,
    put_in: u64,
    pending: BTreeMap<(Time, u64), E>,
}

impl<E> Default for Events<E> {
    fn default() -> Self {
        Self { now: 0, put_in: 0, pending: BTreeMap::new() }
    }
}

impl<E> Events<E> {
    pub fn now(&self) -> Time {
        self.now
    }

    /// `at` is not before now.
    pub fn put(&mut self, at: Time, event: E) {
        assert!(at >= self.now, "an event of the past");
        self.pending.insert((at, self.put_in), event);
        self.put_in += 1;
    }

    /// The next event, whose time is now from then on.
    pub fn take(&mut self) -> Option<E> {
        let ((at, _), event) = self.pending.pop_first()?;
        self.now = at;
        Some(event)
    }
}

/// Of seconds, to the nearest nanosecond.
pub fn nanoseconds(seconds: f64) -> Time {
    (seconds * 1e9).round() as Time
}

pub fn seconds(time: Time) -> f64 {
    time as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_come_by_time_and_those_of_one_time_as_they_were_put_in() {
        let mut events = Events::default();
        for (at, event) in [(5, 'c'), (2, 'a'), (5, 'd'), (2, 'b')] {
            events.put(at, event);
        }
        let taken: Vec<_> =
            std::iter::from_fn(|| events.take().map(|event| (events.now(), event))).collect();
        assert_eq!(taken, [(2, 'a'), (2, 'b'), (5, 'c'), (5, 'd')]);
    }

    #[test]
    #[should_panic(expected = "of the past")]
    fn nothing_happens_in_the_past() {
        let mut events = Events::default();
        events.put(5, ());
        events.take();
        events.put(4, ());
    }
}
