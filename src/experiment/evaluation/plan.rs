//! What is measured, in which order.

use std::num::NonZeroU32;

use crate::scene::{EngineOptions, MatchRule, Scene, Slowdown, WorkerCount};
use crate::tree::roots::Cut;

/// An experiment as its file has it, each value checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    pub name: String,
    pub vary: Vary,
    /// Of each point.
    pub samples: NonZeroU32,
    /// Those that are compared, each once.
    pub matchmakers: Vec<MatchRule>,
    /// Names differ.
    pub models: Vec<Models>,
}

/// Two models that are put against each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Models {
    pub name: String,
    /// Its matchmaker does not count.
    pub scene: Scene,
}

impl Models {
    /// Or workers use the geometry in place.
    pub fn sends_subtrees(&self) -> bool {
        !self.scene.engine.transport.has_geometry_in_place()
    }
}

/// What is varied: at least one value, no value twice.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Vary {
    /// Percentage of the scenarios, on one core and without an engine (tables 2 and 3).
    SerialPercent(Vec<u32>),
    /// Percentage of the scenarios (figure 10).
    ScenariosPercent(Vec<u32>),
    /// Depth at which the tree of the fixed mesh is cut (figure 11).
    Depth(Vec<u32>),
    /// q: scenarios in a client's buffer (figure 12).
    Buffer(Vec<NonZeroU32>),
    /// Workers (figure 13), the slow ones as many times slower.
    Units { units: Vec<Units>, slowdown: Slowdown },
}

/// At least one worker, at most [`WorkerCount::MAX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Units {
    #[serde(default)]
    pub fast: u32,
    #[serde(default)]
    pub slow: u32,
}

impl Vary {
    /// How many there are.
    pub fn values(&self) -> usize {
        match self {
            Self::SerialPercent(percent) | Self::ScenariosPercent(percent) => percent.len(),
            Self::Depth(depths) => depths.len(),
            Self::Buffer(scenarios) => scenarios.len(),
            Self::Units { units, .. } => units.len(),
        }
    }

    pub fn is_serial(&self) -> bool {
        matches!(self, Self::SerialPercent(_))
    }
}

/// One sample of one point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Index into [`Evaluation::models`].
    pub models: usize,
    /// Index into the values of [`Evaluation::vary`].
    pub at: usize,
    /// Absent: no engine.
    pub matchmaker: Option<MatchRule>,
    /// From 0.
    pub sample: u32,
}

/// How a step is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// From the first.
    pub scenarios: usize,
    /// Where the fixed and the moving tree are cut.
    pub cuts: [Cut; 2],
    pub engine: EngineOptions,
}

impl Evaluation {
    /// All of them. Models are loaded once, one after the other; then every point has its first
    /// sample before any has its second, so that whatever changes on the machine meanwhile shows as
    /// spread, and not as a difference between points.
    pub fn steps(&self) -> Vec<Step> {
        let rules: Vec<_> = match self.vary.is_serial() {
            true => vec![None],
            false => self.matchmakers.iter().copied().map(Some).collect(),
        };
        let mut steps = Vec::new();
        for models in 0..self.models.len() {
            for sample in 0..self.samples.get() {
                for at in 0..self.vary.values() {
                    let step = |&matchmaker| Step { models, at, matchmaker, sample };
                    steps.extend(rules.iter().map(step));
                }
            }
        }
        steps
    }

    /// Of so many scenarios that there are.
    pub fn setting(&self, step: &Step, scenarios: usize) -> Setting {
        let scene = &self.models[step.models].scene;
        let mut setting = Setting { scenarios, cuts: scene.cuts(), engine: scene.engine.clone() };
        let engine = &mut setting.engine;
        engine.matchmaker = step.matchmaker.unwrap_or_default();
        match &self.vary {
            Vary::SerialPercent(percent) | Vary::ScenariosPercent(percent) => {
                setting.scenarios = part(scenarios, percent[step.at]);
            }
            Vary::Depth(depths) => setting.cuts[0] = Cut::Depth(depths[step.at]),
            Vary::Buffer(full) => engine.buffer_scenarios = full[step.at],
            Vary::Units { units, slowdown } => {
                let Units { fast, slow } = units[step.at];
                let count = WorkerCount::new(i64::from(fast) + i64::from(slow));
                engine.workers = Some(count.expect("checked as it was read"));
                let fast = std::iter::repeat_n(Slowdown::NONE, fast as usize);
                engine.slowdowns =
                    fast.chain(std::iter::repeat_n(*slowdown, slow as usize)).collect();
            }
        }
        setting
    }
}

impl Evaluation {
    /// For a person who waits.
    pub fn describe(&self, step: &Step, scenarios: usize) -> String {
        let value = match &self.vary {
            Vary::SerialPercent(_) | Vary::ScenariosPercent(_) => {
                format!("{} scenarios", self.setting(step, scenarios).scenarios)
            }
            Vary::Depth(depths) => format!("depth {}", depths[step.at]),
            Vary::Buffer(full) => format!("buffer {}", full[step.at]),
            Vary::Units { units, .. } => match units[step.at] {
                Units { fast, slow: 0 } => format!("workers {fast}"),
                Units { fast, slow } => format!("workers {fast} and {slow} slow"),
            },
        };
        let models = &self.models[step.models].name;
        let matchmaker = step.matchmaker.map_or(String::new(), |m| format!(" {}", m.name()));
        format!("{models} {value}{matchmaker} #{}", step.sample + 1)
    }
}

/// Rounded to the nearest, as in tables 2 and 3; at least one.
fn part(scenarios: usize, percent: u32) -> usize {
    ((scenarios * percent as usize + 50) / 100).max(1)
}

impl Setting {
    /// How many times slower than it could each worker is to be.
    pub fn slowdowns(&self) -> Vec<f64> {
        let workers = self.engine.worker_count().get() as usize;
        let given = self.engine.slowdowns.iter().map(|slowdown| slowdown.factor());
        given.chain(std::iter::repeat(1.0)).take(workers).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn embedded(name: &str) -> Evaluation {
        Evaluation::embedded(name).unwrap()
    }

    #[test]
    fn amounts_of_scenarios_are_those_of_tables_2_and_3() {
        let experiment = embedded("serial");
        for (models, amounts) in
            [(0, [749, 1498, 2246, 2995, 3744]), (1, [545, 1089, 1634, 2178, 2723])]
        {
            let all = amounts[4];
            for (at, amount) in amounts.into_iter().enumerate() {
                let step = Step { models, at, matchmaker: None, sample: 0 };
                assert_eq!(experiment.setting(&step, all).scenarios, amount);
            }
        }
    }

    #[test]
    fn every_point_has_all_its_samples_once_and_models_follow_each_other() {
        for name in super::super::NAMES {
            let experiment = embedded(name);
            let steps = experiment.steps();
            let rules = if name == "serial" { 1 } else { 4 };
            assert_eq!(steps.len(), 2 * 3 * experiment.vary.values() * rules, "{name}");
            for (index, step) in steps.iter().enumerate() {
                assert!(!steps[..index].contains(step), "{name}: {step:?} twice");
                assert_eq!(step.matchmaker.is_none(), name == "serial");
            }
            assert!(steps.is_sorted_by_key(|step| (step.models, step.sample)), "{name}");
        }
    }

    #[test]
    fn only_what_is_varied_differs_between_the_points() {
        for (name, differs) in [
            ("scenarios", [true, false, false, false]),
            ("depth", [false, true, false, false]),
            ("buffer", [false, false, true, false]),
            ("units", [false, false, false, true]),
        ] {
            let experiment = embedded(name);
            let setting = |at| {
                let step = Step { models: 0, at, matchmaker: Some(MatchRule::Best), sample: 0 };
                experiment.setting(&step, 1000)
            };
            let (a, b) = (setting(0), setting(1));
            let found = [
                a.scenarios != b.scenarios,
                a.cuts[0] != b.cuts[0],
                a.engine.buffer_scenarios != b.engine.buffer_scenarios,
                a.slowdowns() != b.slowdowns(),
            ];
            assert_eq!(found, differs, "{name}");
            assert_eq!(a.cuts[1], b.cuts[1]);
        }
    }

    #[test]
    fn slow_workers_come_after_the_fast_ones() {
        let mut experiment = embedded("units");
        let slowdown = Slowdown::new(1.5).unwrap();
        experiment.vary = Vary::Units { units: vec![Units { fast: 2, slow: 1 }], slowdown };
        let step = Step { models: 0, at: 0, matchmaker: Some(MatchRule::Lowest), sample: 0 };
        let setting = experiment.setting(&step, 10);
        assert_eq!(setting.slowdowns(), [1.0, 1.0, 1.5]);
        assert_eq!(setting.engine.matchmaker, MatchRule::Lowest);
    }
}
