//! Figures of what accuracy costs.

use plotters::style::Color;

use super::figure::{
    self, Canvas, DrawError, FigureError, INK, Legend, Look, Place, RADIUS, Span, Table, WIDTH,
    number,
};

/// Error against time, both logarithmic, and the Pareto front: no level to the left of it is as
/// accurate.
#[derive(Clone, Debug, PartialEq)]
pub struct AccuracyPlot {
    pub title: String,
    pub marks: Vec<Mark>,
}

/// A level of accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    pub name: String,
    pub time_us: f64,
    /// 0 has a band of its own.
    pub error: f64,
    /// Marks of one group look alike.
    pub group: usize,
}

/// The group that has no errors.
pub const EXACT: usize = 2;

/// Decades between the band of zero error and the least error, and above the greatest.
const GAP: f64 = 0.6;
/// Height of that band in decades.
const BAND: f64 = 1.0;
const TIME: &str = "processor time of a scenario, mean (us)";
const ERROR: &str = "wrong pairs for each pair that there is";

impl AccuracyPlot {
    pub const NAME: &str = "accuracy";

    pub fn to_svg(&self) -> Result<String, FigureError> {
        Ok(figure::as_file(&self.draw()?, &self.title))
    }

    /// For a page, whose text colour it takes.
    pub fn to_inline_svg(&self) -> Result<String, FigureError> {
        Ok(figure::within_page(&self.draw()?, &self.title))
    }

    pub fn numbers(&self) -> Table {
        let row = |mark: &Mark| vec![mark.name.clone(), number(mark.time_us), number(mark.error)];
        Table {
            title: String::new(),
            columns: ["level", TIME, ERROR].map(str::to_owned).to_vec(),
            rows: self.marks.iter().map(row).collect(),
        }
    }

    /// Whether it can be drawn.
    pub fn check(&self) -> Result<(), FigureError> {
        for (point, mark) in self.marks.iter().enumerate() {
            let (figure, series) = (Self::NAME.to_owned(), mark.name.clone());
            if !figure::is_usable(mark.time_us) || !figure::is_usable(mark.error) {
                return Err(FigureError::OutOfRange { figure, series, point });
            }
            if mark.time_us <= 0.0 || mark.error < 0.0 {
                return Err(FigureError::NotPositive { figure, series, point });
            }
        }
        Ok(())
    }

    fn draw(&self) -> Result<String, FigureError> {
        self.check()?;
        let mut svg = String::new();
        draw(&mut svg, &self.title, &self.marks)
            .map_err(|source| FigureError::Draw { figure: Self::NAME.to_owned(), source })?;
        Ok(svg)
    }
}

fn draw(svg: &mut String, title: &str, marks: &[Mark]) -> Result<(), DrawError> {
    let errors = || marks.iter().map(|mark| mark.error).filter(|e| *e > 0.0).map(f64::log10);
    let low = errors().fold(f64::INFINITY, f64::min).min(0.0).floor();
    let high = errors().fold(f64::NEG_INFINITY, f64::max).max(0.0);
    let [bottom, zero] = [low - GAP - BAND, low - GAP - 0.5 * BAND].map(|e| 10_f64.powf(e));
    let height = |error: f64| if error > 0.0 { error } else { zero };
    let times = marks.iter().map(|mark| mark.time_us.log10());
    let ends = times.map(|time| [time; 2]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let ends = ends.unwrap_or([0.0, 1.0]);
    let [fastest, slowest] = [ends[0] - 0.23, ends[1] + 0.28];

    let canvas = Canvas::new(svg, Legend::default());
    let x = Span::of_exponents([fastest, slowest]);
    let y = Span::of_exponents([bottom.log10(), (high + GAP).max(low + 2.0)]);
    let y = y.labelled_from(10_f64.powf(low - 0.1));
    let chart = canvas.frame(title, [TIME, ERROR], x, y)?;
    let at = |time_us: f64, error: f64| chart.backend_coord(&(time_us, height(error)));
    let [left, right] = [fastest, slowest].map(|exponent| 10_f64.powf(exponent));
    let [top, foot] = [10_f64.powf(low - GAP), bottom];
    let corners = [chart.backend_coord(&(left, top)), chart.backend_coord(&(right, foot))];
    canvas.draw_rectangle(corners, Look::of(EXACT).colour.mix(0.15))?;
    let front = pareto(marks);
    let line = front.iter().map(|&i| at(marks[i].time_us, marks[i].error)).collect();
    canvas.draw_path(line, INK.mix(0.35).stroke_width(2))?;
    let places: Vec<_> = marks.iter().map(|m| at(m.time_us, m.error)).collect();
    for (mark, &place) in marks.iter().zip(&places) {
        canvas.mark(Look::of(mark.group), place)?;
    }
    let band = at(left, 0.0);
    canvas.text("no error", (band.0 + 8, band.1))?;
    let names: Vec<_> = marks.iter().map(|mark| mark.name.as_str()).collect();
    for (name, (corner, _)) in names.iter().zip(without_overlap(&names, &places)) {
        canvas.text(name, corner)?;
    }
    canvas.present()
}

/// Marks that are faster than all that are as accurate, from the fastest.
fn pareto(marks: &[Mark]) -> Vec<usize> {
    let mut by_time: Vec<usize> = (0..marks.len()).collect();
    by_time.sort_by(|&i, &j| marks[i].time_us.total_cmp(&marks[j].time_us));
    let mut least = f64::INFINITY;
    by_time.retain(|&i| {
        let is_better = marks[i].error < least;
        least = least.min(marks[i].error);
        is_better
    });
    by_time
}

/// Left end of the middle line, and width.
type Placed = (Place, i32);

/// Beside its mark, where neither marks nor other names are; to the right if there is no such place.
fn without_overlap(names: &[&str], marks: &[Place]) -> Vec<Placed> {
    const HALF_LINE: i32 = 8;
    let mut placed: Vec<Placed> = Vec::new();
    for (name, &(x, y)) in names.iter().zip(marks) {
        let width = 7 * name.len() as i32;
        let beside = RADIUS + 5;
        let above = RADIUS + HALF_LINE + 2;
        // First where the Pareto front, which falls, does not pass.
        let candidates = [
            (x + beside, y - HALF_LINE - 2),
            (x - width / 2, y - above),
            (x + beside, y),
            (x - width / 2, y + above),
            (x - beside - width, y),
            (x + beside, y + above),
            (x - beside - width, y - above),
            (x - beside - width, y + above),
            (x + beside, y + 2 * above),
            (x + beside, y - 2 * above),
        ];
        let is_free = |&(left, middle): &Place| {
            let clear_of = |from: i32, to: i32, at: i32, half: i32| {
                to < left || left + width < from || (at - middle).abs() > HALF_LINE + half
            };
            marks.iter().all(|&(mx, my)| clear_of(mx - RADIUS, mx + RADIUS, my, RADIUS))
                && placed.iter().all(|&((l, m), w)| clear_of(l, l + w, m, HALF_LINE))
                && left > 90
                && left + width < WIDTH as i32 - 20
        };
        let place = candidates.into_iter().find(is_free).unwrap_or(candidates[0]);
        placed.push((place, width));
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(time_us: f64, error: f64) -> Mark {
        Mark { name: format!("level {time_us}"), time_us, error, group: 0 }
    }

    #[test]
    fn the_front_is_made_of_those_that_nothing_beats() {
        let marks = [mark(3.0, 0.0), mark(1.0, 10.0), mark(2.0, 20.0), mark(4.0, 0.0)];
        assert_eq!(pareto(&marks), [1, 0]);
    }

    fn plot(marks: &[Mark]) -> AccuracyPlot {
        AccuracyPlot { title: "A scene".to_owned(), marks: marks.to_vec() }
    }

    #[test]
    fn every_level_is_named_and_zero_error_has_its_band() {
        let svg = plot(&[mark(3.0, 0.0), mark(1.0, 10.0)]).to_svg().unwrap();
        for words in ["A scene", "level 3", "level 1", "no error", "processor time"] {
            assert!(svg.contains(words), "{words}");
        }
        plot(&[]).to_svg().unwrap();
    }

    #[test]
    fn times_and_errors_that_cannot_be_are_refused() {
        for bad in [mark(0.0, 1.0), mark(1.0, -1.0), mark(f64::NAN, 1.0), mark(1.0, 1e300)] {
            assert!(plot(std::slice::from_ref(&bad)).to_svg().is_err(), "{bad:?}");
        }
    }

    #[test]
    fn names_of_marks_in_one_place_do_not_overlap() {
        let places = [(400, 300), (402, 301), (401, 299)];
        let placed = without_overlap(&["exact", "f64", "f32"], &places);
        for (i, &((x, y), width)) in placed.iter().enumerate() {
            for &((other_x, other_y), other_width) in &placed[..i] {
                let apart = x + width < other_x || other_x + other_width < x;
                assert!(apart || (y - other_y).abs() >= 16);
            }
        }
    }
}
