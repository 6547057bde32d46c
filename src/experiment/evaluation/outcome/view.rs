//! Samples as figures and tables.

use super::super::plan::{Evaluation, Models, Vary};
use super::super::sample::{Parallel, Sample};
use super::super::speed::Spread;
use crate::report::figure::{Axis, Figure, Point, Series, Table};
use crate::scene::MatchRule;

const SERIAL: &str = "run time on one core, s";
const SPEEDUP: &str = "speedup";
const TRANSFER: &str = "relative data transfer";
const BEST_POSSIBLE: &str = "best possible";

/// How figures and tables look at the samples.
pub(super) struct View<'a> {
    pub evaluation: &'a Evaluation,
    pub samples: &'a [Sample],
    /// Of this machine.
    pub cores: usize,
}

impl<'a> View<'a> {
    /// Those of a point.
    fn of(
        &self,
        models: &'a Models,
        at: usize,
        matchmaker: Option<MatchRule>,
    ) -> impl Iterator<Item = &'a Sample> {
        self.samples.iter().filter(move |sample| {
            (sample.at, sample.matchmaker) == (at, matchmaker) && sample.models == models.name
        })
    }

    fn spread(
        &self,
        models: &'a Models,
        at: usize,
        matchmaker: Option<MatchRule>,
        value: impl Fn(&Sample) -> Option<f64>,
    ) -> Option<Spread> {
        let values: Vec<f64> = self.of(models, at, matchmaker).filter_map(value).collect();
        Spread::of(&values)
    }

    /// Any that was measured at this value.
    fn any(&self, models: &Models, at: usize) -> Option<&'a Sample> {
        self.samples.iter().find(|sample| sample.at == at && sample.models == models.name)
    }

    /// Of a value that is varied: where it is drawn, and its name.
    fn x(&self, sample: &Sample) -> (f64, String) {
        let at = sample.at;
        match &self.evaluation.vary {
            Vary::SerialPercent(percent) | Vary::ScenariosPercent(percent) => {
                let label = format!("{} [{}%]", sample.scenarios, percent[at]);
                (sample.scenarios as f64, label)
            }
            Vary::Depth(depths) => (f64::from(depths[at]), depths[at].to_string()),
            Vary::Buffer(full) => (f64::from(full[at].get()), full[at].to_string()),
            Vary::Units { units, .. } => {
                let weighted = sample.parallel.as_ref().map_or(0.0, |run| run.best_possible);
                let mut label = match (units[at].fast, units[at].slow) {
                    (fast, 0) => format!("{fast}"),
                    (fast, slow) => format!("{fast} + {slow} slow = {weighted:.1}"),
                };
                if self.is_oversubscribed(sample) {
                    label += " *";
                }
                (weighted, label)
            }
        }
    }

    pub(super) fn is_oversubscribed(&self, sample: &Sample) -> bool {
        sample.parallel.as_ref().is_some_and(|run| run.workers as usize > self.cores)
    }

    fn x_label(&self) -> &'static str {
        match self.evaluation.vary {
            Vary::SerialPercent(_) | Vary::ScenariosPercent(_) => "scenarios",
            Vary::Depth(_) => "depth of the fixed mesh's subtrees (d)",
            Vary::Buffer(_) => "scenarios in a buffer (q)",
            Vary::Units { .. } => "processing units, in fast cores",
        }
    }

    fn x_axis(&self) -> Axis {
        match self.evaluation.vary {
            Vary::Buffer(_) => Axis::log(self.x_label()),
            _ => Axis::linear(self.x_label()),
        }
    }

    pub(super) fn figures(&self) -> Vec<Figure> {
        let all = &self.evaluation.models;
        if self.evaluation.vary.is_serial() {
            let series =
                all.iter().map(|one| self.series(one, &one.name, None, |s| Some(s.serial_s)));
            return vec![Figure {
                name: self.evaluation.name.clone(),
                title: "Run time on one core, without an engine".to_owned(),
                x: self.x_axis(),
                y: Axis::linear(SERIAL),
                series: series.filter(|one| !one.points.is_empty()).collect(),
            }];
        }
        let mut figures = Vec::new();
        for models in all.iter().filter(|models| self.is_measured(models)) {
            figures.push(self.figure(models, SPEEDUP, |run| run.speedup));
            if models.sends_subtrees() {
                figures.push(self.figure(models, TRANSFER, |run| run.relative_data_transfer));
            }
        }
        figures
    }

    fn is_measured(&self, models: &Models) -> bool {
        self.samples.iter().any(|sample| sample.models == models.name)
    }

    /// A line for each matchmaker.
    fn figure(&self, models: &Models, what: &str, value: impl Fn(&Parallel) -> f64) -> Figure {
        let value = |sample: &Sample| sample.parallel.as_ref().map(&value);
        let rules = &self.evaluation.matchmakers;
        let line = |rule: &MatchRule| self.series(models, rule.name(), Some(*rule), value);
        let mut series: Vec<Series> = rules.iter().map(line).collect();
        if what == SPEEDUP {
            let at = 0..self.evaluation.vary.values();
            let bound = at.filter_map(|at| {
                let sample = self.any(models, at)?;
                Some(Point::at(self.x(sample).0, sample.parallel.as_ref()?.best_possible))
            });
            series.push(joined(BEST_POSSIBLE, bound.collect()));
        }
        Figure {
            name: format!("{}-{}-{}", self.evaluation.name, models.name, what.replace(' ', "-")),
            title: format!("{}: {what}", title(models)),
            x: self.x_axis(),
            y: Axis::linear(what),
            series,
        }
    }

    fn series(
        &self,
        models: &Models,
        name: &str,
        matchmaker: Option<MatchRule>,
        value: impl Fn(&Sample) -> Option<f64> + Copy,
    ) -> Series {
        let point = |at| {
            let spread = self.spread(models, at, matchmaker, value)?;
            let x = self.x(self.of(models, at, matchmaker).next()?).0;
            Some(Point { x, y: spread.mean, spread: Some([spread.least, spread.most]) })
        };
        joined(name, (0..self.evaluation.vary.values()).filter_map(point).collect())
    }

    pub(super) fn tables(&self) -> Vec<Table> {
        let measured = self.evaluation.models.iter().filter(|models| self.is_measured(models));
        if self.evaluation.vary.is_serial() {
            return measured.map(|models| self.serial_table(models)).collect();
        }
        let both = |models| {
            [
                self.table(models, SPEEDUP, |run| run.speedup),
                self.table(models, TRANSFER, |run| run.relative_data_transfer),
            ]
        };
        measured.flat_map(both).collect()
    }

    fn serial_table(&self, models: &Models) -> Table {
        let row = |at| {
            let serial = self.spread(models, at, None, |sample| Some(sample.serial_s))?;
            let (scenarios, label) = self.x(self.any(models, at)?);
            let seconds = [serial.mean, serial.least, serial.most].map(|s| format!("{s:.3}"));
            let rate = format!("{:.0}", scenarios / serial.mean);
            Some([label].into_iter().chain(seconds).chain([rate]).collect())
        };
        let columns = ["scenarios", SERIAL, "least", "most", "scenarios/s"];
        Table {
            title: title(models),
            columns: columns.map(str::to_owned).to_vec(),
            rows: (0..self.evaluation.vary.values()).filter_map(row).collect(),
        }
    }

    /// A column for each matchmaker: mean, least and most.
    fn table(&self, models: &Models, what: &str, value: impl Fn(&Parallel) -> f64) -> Table {
        let rules = &self.evaluation.matchmakers;
        let is_speedup = what == SPEEDUP;
        let row = |at| {
            let any = self.any(models, at)?;
            let mut cells = vec![self.x(any).1];
            for rule in rules {
                let value = |sample: &Sample| sample.parallel.as_ref().map(&value);
                let spread = self.spread(models, at, Some(*rule), value);
                cells.push(spread.map_or("-".to_owned(), |Spread { mean, least, most }| {
                    format!("{mean:.2} ({least:.2}-{most:.2})")
                }));
            }
            if is_speedup {
                cells.push(format!("{:.2}", any.parallel.as_ref()?.best_possible));
            }
            Some(cells)
        };
        let mut columns = vec![self.x_label().to_owned()];
        columns.extend(rules.iter().map(|rule| rule.name().to_owned()));
        columns.extend(is_speedup.then(|| BEST_POSSIBLE.to_owned()));
        Table {
            title: format!("{}: {what}", title(models)),
            columns,
            rows: (0..self.evaluation.vary.values()).filter_map(row).collect(),
        }
    }
}

fn title(models: &Models) -> String {
    let scene = &models.scene;
    format!("{} ({} against {})", models.name, scene.moving.mesh, scene.fixed.mesh)
}

/// From left to right.
fn joined(name: &str, mut points: Vec<Point>) -> Series {
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    Series { name: name.to_owned(), points }
}
