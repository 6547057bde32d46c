//! Figures of what accuracy costs.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::plot::{COLOURS, SIZE};

/// A level of accuracy.
pub struct Mark {
    pub name: String,
    pub time_us: f64,
    /// 0 has a band of its own.
    pub error: f64,
    /// Marks of one group have one colour.
    pub group: usize,
}

/// Decades between the band of zero error and the least error, and above the greatest.
const GAP: f64 = 0.6;
/// Height of that band in decades.
const BAND: f64 = 1.0;
const FONT: (&str, u32) = ("sans-serif", 14);
const RADIUS: i32 = 5;

/// Error against time, both logarithmic, and the Pareto front: no level to the left of it is as
/// accurate.
pub fn error_against_time(title: &str, marks: &[Mark]) -> Result<String, Box<dyn Error>> {
    let positive = || marks.iter().map(|mark| mark.error).filter(|e| *e > 0.0).map(f64::log10);
    let low = positive().fold(f64::INFINITY, f64::min).min(0.0).floor();
    let high = positive().fold(f64::NEG_INFINITY, f64::max).max(0.0);
    let zero = low - GAP - 0.5 * BAND;
    let height = |error: f64| if error > 0.0 { error.log10() } else { zero };
    let times = || marks.iter().map(|mark| mark.time_us);
    let fastest = times().fold(f64::INFINITY, f64::min) / 1.7;
    let slowest = times().fold(0.0, f64::max) * 1.9;

    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            .caption(title, ("sans-serif", 20))
            .margin(14)
            .margin_right(24)
            .x_label_area_size(46)
            .y_label_area_size(78)
            .build_cartesian_2d(
                (fastest..slowest).log_scale(),
                low - GAP - BAND..(high + GAP).max(low + 2.0),
            )?;
        let label = |exponent: &f64| match *exponent {
            e if e < low - 0.01 || (e - e.round()).abs() > 0.01 => String::new(),
            e => format!("1e{:.0}", e + 0.0),
        };
        let decades = (high + GAP - low).ceil() as usize + 3;
        chart
            .configure_mesh()
            .x_desc("processor time of a scenario, mean (us)")
            .y_desc("wrong pairs for each pair that there is")
            .x_label_formatter(&|us| format!("{us}"))
            .y_labels(decades)
            .y_label_formatter(&label)
            .light_line_style(BLACK.mix(0.05))
            .x_max_light_lines(9)
            .y_max_light_lines(1)
            .label_style(FONT)
            .draw()?;
        chart.draw_series([Rectangle::new(
            [(fastest, low - GAP - BAND), (slowest, low - GAP)],
            COLOURS[2].mix(0.12).filled(),
        )])?;
        let front = pareto(marks);
        let line = front.iter().map(|&i| (marks[i].time_us, height(marks[i].error)));
        chart.draw_series(LineSeries::new(line, BLACK.mix(0.35).stroke_width(2)))?;
        let points = marks.iter().map(|mark| {
            let at = (mark.time_us, height(mark.error));
            Circle::new(at, RADIUS, COLOURS[mark.group % COLOURS.len()].filled())
        });
        chart.draw_series(points)?;
        let places: Vec<_> =
            marks.iter().map(|m| chart.backend_coord(&(m.time_us, height(m.error)))).collect();
        let band = chart.backend_coord(&(fastest, zero));
        let style = FONT.into_font().color(&BLACK);
        let no_error = style.pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new("no error", (band.0 + 8, band.1), no_error))?;
        let names: Vec<_> = marks.iter().map(|mark| mark.name.as_str()).collect();
        for (name, (corner, _)) in names.iter().zip(without_overlap(&names, &places)) {
            let style = FONT.into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
            area.draw(&Text::new(*name, corner, style))?;
        }
        area.present()?;
    }
    Ok(svg)
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

type Pixel = (i32, i32);
/// Left end of the middle line, and width.
type Placed = (Pixel, i32);

/// Beside its mark, where neither marks nor other names are; to the right if there is no such place.
fn without_overlap(names: &[&str], marks: &[Pixel]) -> Vec<Placed> {
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
        ];
        let is_free = |&(left, middle): &Pixel| {
            let clear_of = |from: i32, to: i32, at: i32, half: i32| {
                to < left || left + width < from || (at - middle).abs() > HALF_LINE + half
            };
            marks.iter().all(|&(mx, my)| clear_of(mx - RADIUS, mx + RADIUS, my, RADIUS))
                && placed.iter().all(|&((l, m), w)| clear_of(l, l + w, m, HALF_LINE))
                && left > 90
                && left + width < SIZE.0 as i32 - 20
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

    #[test]
    fn every_level_is_named_and_zero_error_has_its_band() {
        let svg = error_against_time("A scene", &[mark(3.0, 0.0), mark(1.0, 10.0)]).unwrap();
        for words in ["A scene", "level 3", "level 1", "no error", "processor time"] {
            assert!(svg.contains(words), "{words}");
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
