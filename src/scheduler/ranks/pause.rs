//! How long to sleep before ranks are looked at again.

use std::time::Duration;

/// Ranks can only be looked at. While they talk, waiting costs little time; while they do not, little
/// of a core.
#[derive(Clone, Copy, Debug)]
pub struct Pause(Duration);

const SHORTEST: Duration = Duration::from_micros(50);
const LONGEST: Duration = Duration::from_millis(1);

impl Default for Pause {
    fn default() -> Self {
        Self(SHORTEST)
    }
}

impl Pause {
    /// Nothing has come; twice as long as the last time, unless something is on its way.
    pub fn next(&mut self, is_busy: bool) -> Duration {
        let now = if is_busy { SHORTEST } else { self.0 };
        self.0 = (2 * now).min(LONGEST);
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_grows_while_nothing_comes_and_is_short_again_when_something_does() {
        let mut pause = Pause::default();
        assert_eq!(pause.next(false), SHORTEST);
        assert_eq!(pause.next(false), 2 * SHORTEST);
        assert_eq!((0..20).map(|_| pause.next(false)).last(), Some(LONGEST));
        assert_eq!(pause.next(true), SHORTEST);
    }
}
