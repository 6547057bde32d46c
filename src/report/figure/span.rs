//! The extent of an axis, and where its ticks are.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::number::tick;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Linear,
    Log,
    Names,
}

/// Where an axis begins and ends. All scales are one type, so that a chart is compiled once.
#[derive(Clone, Debug)]
pub(in crate::report) struct Span {
    kind: Kind,
    /// Values, or exponents of ten.
    ends: [f64; 2],
    /// With their labels.
    ticks: Vec<(f64, String)>,
    /// Light lines between the ticks.
    between: Vec<f64>,
}

const TICKS: f64 = 6.0;
/// Of decades, with a label each.
const MOST_DECADES: i32 = 9;
/// Characters of all names of an axis together.
const NAMES_WIDTH: usize = 110;
const MOST_NAMES: usize = 40;
/// Beyond the greatest value, of the whole.
const MARGIN: f64 = 0.05;

impl Span {
    /// All values, and zero.
    pub fn linear(values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = values.fold([0.0, 0.0], |[low, high], v| [v.min(low), v.max(high)]);
        let high = if low == high { 1.0 } else { high };
        let margin = MARGIN * (high - low);
        let beyond = |end: f64, margin: f64| if end == 0.0 { 0.0 } else { end + margin };
        let ends = [beyond(low, -margin), beyond(high, margin)];
        let ticks = labelled(evenly(ends));
        Self { kind: Kind::Linear, ends, ticks, between: Vec::new() }
    }

    /// All values, which are above zero.
    pub fn log(values: impl Iterator<Item = f64>) -> Self {
        let exponents = values.map(f64::log10);
        let ends = exponents
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], e| [e.min(low), e.max(high)]);
        let ends = if ends[0] <= ends[1] { ends } else { [0.0, 1.0] };
        let margin = (MARGIN * (ends[1] - ends[0])).max(0.02);
        Self::of_exponents([ends[0] - margin, ends[1] + margin])
    }

    /// From ten to the first to ten to the second.
    pub fn of_exponents(ends: [f64; 2]) -> Self {
        let is_inside = |value: &f64| (ends[0]..=ends[1]).contains(&value.log10());
        let [first, last] = [ends[0].ceil() as i32, ends[1].floor() as i32];
        let within = |digits: &[f64]| -> Vec<f64> {
            let decades = first - 1..=last;
            let all = decades.flat_map(|e| digits.iter().map(move |d| d * 10_f64.powi(e)));
            all.filter(is_inside).collect()
        };
        let every = (last - first) / MOST_DECADES + 1;
        let ticks: Vec<f64> = if last - first >= 2 {
            (first..=last).step_by(every as usize).map(|e| 10_f64.powi(e)).collect()
        } else {
            let few = within(&[1.0, 2.0, 5.0]);
            let values = ends.map(|end| 10_f64.powf(end));
            if few.len() >= 3 { few } else { evenly(values) }
        };
        let between = match every {
            1 => within(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]),
            _ => (first..=last).map(|e| 10_f64.powi(e)).collect(),
        };
        Self { kind: Kind::Log, ends, ticks: labelled(ticks), between }
    }

    /// A place for each name.
    pub fn names(names: &[String]) -> Self {
        let every = names.len() / MOST_NAMES + 1;
        let longest = (NAMES_WIDTH * every / names.len().max(1)).max(4);
        let tick = |(number, name): (usize, &String)| (number as f64, shortened(name, longest));
        let ticks = names.iter().enumerate().step_by(every).map(tick).collect();
        let ends = [-0.6, names.len().max(1) as f64 - 0.4];
        Self { kind: Kind::Names, ends, ticks, between: Vec::new() }
    }

    /// Without labels and lines below a value.
    pub fn labelled_from(mut self, least: f64) -> Self {
        self.ticks.retain(|(value, _)| *value >= least);
        self.between.retain(|value| *value >= least);
        self
    }

    /// Where bars stand: zero, where there is such a place.
    pub fn foot(&self) -> f64 {
        if self.kind == Kind::Log { self.value(self.ends[0]) } else { 0.0 }
    }

    fn value(&self, place: f64) -> f64 {
        if self.kind == Kind::Log { 10_f64.powf(place) } else { place }
    }

    pub fn is_names(&self) -> bool {
        self.kind == Kind::Names
    }
}

/// At most so many characters.
pub(super) fn shortened(text: &str, longest: usize) -> String {
    if text.chars().count() <= longest {
        return text.to_owned();
    }
    let start: String = text.chars().take(longest - 1).collect();
    start + "…"
}

fn labelled(ticks: Vec<f64>) -> Vec<(f64, String)> {
    ticks.into_iter().map(|value| (value, tick(value))).collect()
}

/// Multiples of 1, 2 or 5 times a power of ten.
fn evenly([low, high]: [f64; 2]) -> Vec<f64> {
    let least = (high - low) / TICKS;
    let decade = 10_f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0].map(|digit| digit * decade).into_iter().find(|step| *step >= least);
    let step = step.unwrap_or(10.0 * decade);
    let [first, last] = [(low / step).ceil() as i64, (high / step).floor() as i64];
    (first..=last).map(|count| count as f64 * step).collect()
}

impl Ranged for Span {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let place = if self.kind == Kind::Log { value.log10() } else { *value };
        let share = (place - self.ends[0]) / (self.ends[1] - self.ends[0]);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match hint.weight().allow_light_points() {
            true => self.between.clone(),
            false => self.ticks.iter().map(|(value, _)| *value).collect(),
        }
    }

    fn range(&self) -> Range<f64> {
        self.value(self.ends[0])..self.value(self.ends[1])
    }
}

impl ValueFormatter<f64> for Span {
    fn format_ext(&self, value: &f64) -> String {
        let tick = self.ticks.iter().find(|(at, _)| at == value);
        tick.map_or_else(String::new, |(_, label)| label.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(span: &Span) -> Vec<&str> {
        span.ticks.iter().map(|(_, label)| label.as_str()).collect()
    }

    fn linear(values: &[f64]) -> Span {
        Span::linear(values.iter().copied())
    }

    fn log(values: &[f64]) -> Span {
        Span::log(values.iter().copied())
    }

    #[test]
    fn linear_axes_hold_zero_and_have_round_ticks() {
        assert_eq!(labels(&linear(&[3.0, 25.0])), ["0", "5", "10", "15", "20", "25"]);
        assert_eq!(labels(&linear(&[0.31])), ["0", "0.1", "0.2", "0.3"]);
        assert_eq!(labels(&linear(&[-2.0, 4.0])), ["-2", "0", "2", "4"]);
        assert_eq!(linear(&[5.0]).ends[0], 0.0);
    }

    #[test]
    fn logarithmic_axes_have_decades_or_what_there_is_room_for() {
        assert_eq!(labels(&log(&[1.0, 1000.0])), ["1", "10", "100", "1,000"]);
        assert_eq!(labels(&log(&[3.0, 60.0])), ["5", "10", "20", "50"]);
        assert_eq!(labels(&log(&[4.1, 4.9])), ["4", "4.5", "5"]);
        let wide = log(&[1e-20, 1e20]);
        assert!((4..=10).contains(&wide.ticks.len()), "{:?}", labels(&wide));
    }

    #[test]
    fn every_axis_has_ticks_and_holds_its_values() {
        let values = [1e-200, 1e-9, 0.5, 1.0, 1.0 + 1e-15, 2.0, 97.0, 1e6, 1e200];
        for low in values {
            for high in values.into_iter().filter(|high| *high >= low) {
                for span in [linear(&[low, high]), log(&[low, high])] {
                    assert!((2..=12).contains(&span.ticks.len()), "{low} {high} {span:?}");
                    for value in [low, high].iter().chain(span.ticks.iter().map(|(v, _)| v)) {
                        let pixel = span.map(value, (0, 1000));
                        assert!((0..=1000).contains(&pixel), "{low} {high} {span:?} {pixel}");
                    }
                }
            }
        }
    }

    #[test]
    fn no_values_are_an_axis_too() {
        for span in [linear(&[]), linear(&[0.0]), log(&[]), Span::names(&[])] {
            assert!(span.range().start < span.range().end, "{span:?}");
        }
    }

    #[test]
    fn long_and_many_names_are_shortened() {
        let names: Vec<String> = (0..100).map(|n| format!("a rather long name {n}")).collect();
        let span = Span::names(&names);
        assert!(span.ticks.len() <= MOST_NAMES);
        assert_eq!(Span::names(&names[..1]).ticks[0].1, names[0]);
        assert_eq!(shortened("größer", 4), "grö…");
    }
}
