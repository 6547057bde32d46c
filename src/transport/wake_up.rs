//! Looking for messages, and falling asleep without missing one.

use std::sync::atomic::{AtomicU32, Ordering, fence};
use std::time::{Duration, Instant};

/// How [`MasterEnd::wait`](super::MasterEnd::wait) and
/// [`WorkerEnd::receive`](super::WorkerEnd::receive) look for messages before they sleep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WakeUp {
    /// Sleep at once.
    #[default]
    Block,
    /// Look again and again for at most [`SPIN`]. Pays where a core is free for it.
    SpinThenBlock,
    /// Never sleep. For measuring, and for cores that nobody else wants.
    BusyPoll,
}

/// Longest search of [`WakeUp::SpinThenBlock`]: about what it costs to be woken.
pub const SPIN: Duration = Duration::from_micros(50);

impl WakeUp {
    pub const ALL: [Self; 3] = [Self::Block, Self::SpinThenBlock, Self::BusyPoll];

    pub fn name(self) -> &'static str {
        match self {
            Self::Block => "block",
            Self::SpinThenBlock => "spin-then-block",
            Self::BusyPoll => "busy-poll",
        }
    }

    pub(super) fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|wake_up| wake_up.name() == name)
    }

    /// What `look` finds, which is told how often it has looked before; `None` when it is time to
    /// sleep, or past the `deadline`. Looks at least once.
    pub(super) fn search<T, E>(
        self,
        deadline: Option<Instant>,
        mut look: impl FnMut(u32) -> Result<Option<T>, E>,
    ) -> Result<Option<T>, E> {
        let begin = Instant::now();
        let longest = match self {
            Self::Block => Duration::ZERO,
            Self::SpinThenBlock => SPIN,
            Self::BusyPoll => Duration::MAX,
        };
        for looked in (0..=u32::MAX).cycle() {
            let found = look(looked)?;
            if found.is_some() || longest.is_zero() {
                return Ok(found);
            }
            let now = Instant::now();
            if now - begin >= longest || deadline.is_some_and(|deadline| now >= deadline) {
                break;
            }
            std::hint::spin_loop();
        }
        Ok(None)
    }
}

/// Whether one side sleeps, so that the other rings only when it must.
///
/// The sleeper says so and then looks for messages once more; the other side leaves a message and
/// then looks whether anybody sleeps. A sequentially consistent fence between the two steps of
/// each makes sure that at least one of them sees what the other did.
#[derive(Debug, Default)]
#[repr(transparent)]
pub(super) struct Asleep(AtomicU32);

impl Asleep {
    /// To be followed by a last look, and by [`wake`](Self::wake) when awake again.
    pub(super) fn fall(&self) {
        self.0.store(1, Ordering::Relaxed);
        fence(Ordering::SeqCst);
    }

    pub(super) fn wake(&self) {
        self.0.store(0, Ordering::Relaxed);
    }

    /// To be called after a message was left: whether to ring. One of several callers is told to.
    pub(super) fn has_to_be_rung(&self) -> bool {
        fence(Ordering::SeqCst);
        self.0.load(Ordering::Relaxed) != 0 && self.0.swap(0, Ordering::Relaxed) != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_mode_looks_as_long_as_it_says() {
        let look = |wake_up: WakeUp, limit: Option<Duration>| {
            let begin = Instant::now();
            let deadline = limit.map(|limit| begin + limit);
            let found = wake_up.search::<(), ()>(deadline, |_| Ok(None)).unwrap();
            (found, begin.elapsed())
        };
        assert_eq!(look(WakeUp::Block, None).0, None);
        assert!(look(WakeUp::SpinThenBlock, None).1 >= SPIN);
        let long = Duration::from_millis(2);
        assert!(look(WakeUp::BusyPoll, Some(long)).1 >= long);
    }

    #[test]
    fn what_is_found_ends_the_search() {
        for wake_up in WakeUp::ALL {
            assert_eq!(wake_up.search::<_, ()>(None, |_| Ok(Some(1))), Ok(Some(1)));
            assert_eq!(WakeUp::from_name(wake_up.name()), Some(wake_up));
        }
        let third = WakeUp::BusyPoll.search::<_, ()>(None, |n| Ok((n == 2).then_some(n)));
        assert_eq!(third, Ok(Some(2)));
    }

    #[test]
    fn only_one_who_sleeps_is_rung_and_only_once() {
        let side = Asleep::default();
        assert!(!side.has_to_be_rung());
        side.fall();
        assert!(side.has_to_be_rung());
        assert!(!side.has_to_be_rung());
        side.fall();
        side.wake();
        assert!(!side.has_to_be_rung());
    }
}
