//! The cores of a node, and who has them.

use super::events::Time;

/// Who works on the cores of a node: never more than one core each, and all alike. Where there are
/// more of them than cores they share these evenly (egalitarian processor sharing, which a fair
/// scheduler of an operating system comes to).
#[derive(Debug)]
pub struct Processors {
    cores: f64,
    speed: f64,
    /// In the order in which they began.
    at_work: Vec<Work>,
    /// Up to when what is left is counted.
    counted: Time,
    /// Grows with whatever changes who is done when.
    version: u64,
}

#[derive(Debug)]
struct Work {
    process: usize,
    /// Nanoseconds on a core of its own.
    left: f64,
}

/// When somebody is done next, if nothing changes before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Forecast {
    pub at: Time,
    version: u64,
}

/// Less than what times are rounded to.
const NOTHING: f64 = 0.5;

impl Processors {
    pub fn new(cores: u32, speed: f64) -> Self {
        Self { cores: f64::from(cores), speed, at_work: Vec::new(), counted: 0, version: 0 }
    }

    /// A process begins what would take `work` on a core of speed 1.
    pub fn begin(&mut self, now: Time, process: usize, work: Time) -> Forecast {
        self.count(now);
        self.at_work.push(Work { process, left: work as f64 / self.speed });
        self.forecast().expect("somebody is at work")
    }

    /// Who is done if the forecast has come true, and the next one.
    pub fn done(&mut self, now: Time, forecast: Forecast) -> (Vec<usize>, Option<Forecast>) {
        if forecast.version != self.version {
            return (Vec::new(), None);
        }
        self.count(now);
        let done = self.at_work.extract_if(.., |work| work.left <= NOTHING);
        (done.map(|work| work.process).collect(), self.forecast())
    }

    /// Of a core, that each who works has.
    fn share(&self) -> f64 {
        (self.cores / self.at_work.len() as f64).min(1.0)
    }

    fn count(&mut self, now: Time) {
        let had = (now - self.counted) as f64 * self.share();
        self.counted = now;
        for work in &mut self.at_work {
            work.left -= had;
        }
    }

    fn forecast(&mut self) -> Option<Forecast> {
        self.version += 1;
        let least = self.at_work.iter().map(|work| work.left).reduce(f64::min)?;
        let wait = (least.max(0.0) / self.share()).round() as Time;
        Some(Forecast { at: self.counted + wait, version: self.version })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (who, when) of works that begin at these times, to the end.
    fn ends(cores: u32, speed: f64, works: &[(Time, Time)]) -> Vec<(usize, Time)> {
        let mut processors = Processors::new(cores, speed);
        let mut ends = Vec::new();
        let (mut begun, mut forecast) = (0, None::<Forecast>);
        loop {
            let next = works.get(begun).map(|&(at, _)| at);
            match (next, forecast) {
                (Some(at), known) if known.is_none_or(|known| at < known.at) => {
                    forecast = Some(processors.begin(at, begun, works[begun].1));
                    begun += 1;
                }
                (_, Some(known)) => {
                    let (done, next) = processors.done(known.at, known);
                    ends.extend(done.into_iter().map(|process| (process, known.at)));
                    forecast = next;
                }
                (_, None) => return ends,
            }
        }
    }

    #[test]
    fn with_a_core_for_each_nobody_waits() {
        assert_eq!(ends(2, 1.0, &[(0, 100), (10, 30)]), [(1, 40), (0, 100)]);
    }

    #[test]
    fn a_faster_core_takes_less_time() {
        assert_eq!(ends(1, 2.0, &[(0, 100)]), [(0, 50)]);
    }

    #[test]
    fn three_on_two_cores_have_two_thirds_each() {
        assert_eq!(ends(2, 1.0, &[(0, 200), (0, 200), (0, 200)]), [(0, 300), (1, 300), (2, 300)]);
    }

    /// Alone until 50, half a core until the other is done at 110, then alone again.
    #[test]
    fn who_comes_later_slows_who_is_there() {
        assert_eq!(ends(1, 1.0, &[(0, 100), (50, 30)]), [(1, 110), (0, 130)]);
    }

    #[test]
    fn a_forecast_that_was_overtaken_says_nothing() {
        let mut processors = Processors::new(1, 1.0);
        let first = processors.begin(0, 0, 100);
        let second = processors.begin(10, 1, 100);
        assert_eq!(processors.done(100, first), (vec![], None));
        assert_eq!(second.at, 190);
    }
}
