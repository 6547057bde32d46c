//! What more workers meet first: the master's processor, its link, or the memory of a node.

use serde::Serialize;

use super::sweep::{Simulated, Varied};

/// Part of the time from which something that all workers share counts as saturated: what waits for
/// it then waits for ten times what it takes (a queue's mean wait grows as 1 / (1 - utilisation)).
const SATURATED: f64 = 0.9;

/// Of one series of a sweep over units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Saturation {
    pub series: String,
    /// `master`, `link` or `memory`; absent: nothing up to the largest cluster.
    pub first: Option<&'static str>,
    /// Of the smallest cluster where it is so, or of the largest.
    pub workers: usize,
    /// Of what is used most there, and what that is.
    pub most_used: &'static str,
    pub utilisation: f64,
}

impl Saturation {
    /// `series`: the runs of one series, in ascending order of workers.
    pub fn of(name: &str, series: &[&Simulated]) -> Option<Self> {
        let seen = |run: &&&Simulated| run.is_out_of_memory() || shared(run).1 >= SATURATED;
        let (run, is_reached) = match series.iter().find(seen) {
            Some(run) => (run, true),
            None => (series.last()?, false),
        };
        let (what, utilisation) = match run.is_out_of_memory() {
            true => ("memory", run.mean(|outcome| outcome.memory.fullest)),
            false => shared(run),
        };
        Some(Self {
            series: name.to_owned(),
            first: is_reached.then_some(what),
            workers: run.workers,
            most_used: what,
            utilisation,
        })
    }

    pub fn sentence(&self) -> String {
        let Self { series, workers, most_used, utilisation, .. } = self;
        let percent = 100.0 * utilisation;
        match self.first {
            Some(what) => {
                format!("{series}: {what} saturates first, at {workers} workers ({percent:.0} %)")
            }
            None => format!(
                "{series}: nothing saturates up to {workers} workers; {most_used} is used most \
                 ({percent:.0} %)"
            ),
        }
    }
}

/// What is used most of what all workers share. A master that waits for the link to take what it
/// sends does nothing else meanwhile.
fn shared(run: &Simulated) -> (&'static str, f64) {
    let master = run.mean(|outcome| outcome.utilisation.master);
    let blocked = run.mean(|outcome| outcome.utilisation.master_blocked);
    let link = run.mean(|outcome| outcome.utilisation.link);
    let what = if link >= master { "link" } else { "master" };
    (what, link.max(master + blocked))
}

/// The runs of a sweep over units, by workers.
pub fn by_workers<'a>(runs: impl Iterator<Item = &'a Simulated>) -> Vec<&'a Simulated> {
    let mut runs: Vec<_> = runs.filter(|run| run.varied == Varied::Units).collect();
    runs.sort_by_key(|run| run.workers);
    runs
}
