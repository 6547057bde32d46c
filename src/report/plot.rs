//! Figures as SVG.

use std::error::Error;

use plotters::coord::Shift;
use plotters::coord::ranged1d::Ranged;
use plotters::prelude::*;

/// A line of a figure: its name, and (x, y).
pub struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// What a figure says beside its lines.
pub struct Labels {
    pub title: &'static str,
    pub x: &'static str,
    pub y: &'static str,
}

/// Colours that colour-blind people can tell apart (Okabe & Ito 2008).
pub(super) const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(213, 94, 0),
    RGBColor(86, 180, 233),
    RGBColor(204, 121, 167),
    RGBColor(120, 120, 120),
    RGBColor(0, 0, 0),
];

pub(super) const SIZE: (u32, u32) = (960, 600);

/// Both axes logarithmic.
pub fn log_log(labels: &Labels, series: &[Series]) -> Result<String, Box<dyn Error>> {
    let (x, y) = (range(series, |p| p.0), range(series, |p| p.1));
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = frame(&area, labels)
            .build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale())?;
        chart.configure_mesh().x_desc(labels.x).y_desc(labels.y).draw()?;
        draw(&mut chart, series, false)?;
        legend(&mut chart, SeriesLabelPosition::UpperLeft)?;
        area.present()?;
    }
    Ok(svg)
}

/// Both axes from zero.
pub fn linear(labels: &Labels, series: &[Series]) -> Result<String, Box<dyn Error>> {
    let (x, y) = (range(series, |p| p.0), range(series, |p| p.1));
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = frame(&area, labels).build_cartesian_2d(0.0..1.05 * x.1, 0.0..1.1 * y.1)?;
        chart.configure_mesh().x_desc(labels.x).y_desc(labels.y).draw()?;
        draw(&mut chart, series, true)?;
        legend(&mut chart, SeriesLabelPosition::UpperLeft)?;
        area.present()?;
    }
    Ok(svg)
}

/// x from zero, y logarithmic.
pub fn log_y(labels: &Labels, series: &[Series]) -> Result<String, Box<dyn Error>> {
    let (x, y) = (range(series, |p| p.0), range(series, |p| p.1));
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let y = 0.7 * y.0..1.5 * y.1;
        let mut chart = frame(&area, labels).build_cartesian_2d(0.0..1.05 * x.1, y.log_scale())?;
        chart
            .configure_mesh()
            .x_desc(labels.x)
            .y_desc(labels.y)
            .x_label_formatter(&|x| format!("{x}"))
            .y_label_formatter(&|y| format!("{y}"))
            .draw()?;
        draw(&mut chart, series, false)?;
        legend(&mut chart, SeriesLabelPosition::LowerRight)?;
        area.present()?;
    }
    Ok(svg)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn frame<'a, 'b>(area: &'b Area<'a>, labels: &Labels) -> ChartBuilder<'b, 'b, SVGBackend<'a>> {
    let mut builder = ChartBuilder::on(area);
    builder
        .caption(labels.title, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(70);
    builder
}

fn key(colour: RGBColor) -> impl Fn((i32, i32)) -> PathElement<(i32, i32)> {
    move |(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], colour.stroke_width(2))
}

/// Each series in its colour, with a mark at every point if wanted.
fn draw<'a, X, Y>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>,
    series: &[Series],
    marks: bool,
) -> Result<(), Box<dyn Error>>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
    SVGBackend<'a>: 'a,
{
    for (index, one) in series.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        if marks {
            let marks = one.points.iter().map(|&point| Circle::new(point, 4, colour.filled()));
            chart.draw_series(marks)?;
        }
        let line = LineSeries::new(one.points.iter().copied(), colour.stroke_width(2));
        chart.draw_series(line)?.label(&one.name).legend(key(colour));
    }
    Ok(())
}

fn legend<'a, C: CoordTranslate>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, C>,
    position: SeriesLabelPosition,
) -> Result<(), Box<dyn Error>>
where
    SVGBackend<'a>: 'a,
{
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .position(position)
        .draw()?;
    Ok(())
}

/// The least and the greatest value above zero, a little apart.
fn range(series: &[Series], of: impl Fn(&(f64, f64)) -> f64) -> (f64, f64) {
    let values = || series.iter().flat_map(|one| one.points.iter().map(&of)).filter(|v| *v > 0.0);
    let low = values().fold(f64::INFINITY, f64::min);
    let high = values().fold(0.0, f64::max);
    if low < high { (low, high) } else { (0.5 * high.max(1e-9), 2.0 * high.max(1e-9)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LABELS: Labels = Labels { title: "Title", x: "bytes", y: "us" };

    #[test]
    fn figures_name_their_axes_and_lines() {
        let one = |name: &str, points: &[(f64, f64)]| Series {
            name: name.to_owned(),
            points: points.to_vec(),
        };
        let series = [one("a line", &[(64.0, 3.0), (1e6, 400.0)]), one("a point", &[(64.0, 9.0)])];
        for svg in [log_log, linear, log_y].map(|draw| draw(&LABELS, &series)) {
            let svg = svg.unwrap();
            for words in ["<svg", "Title", "bytes", "us", "a line", "a point"] {
                assert!(svg.contains(words), "{words}");
            }
        }
        assert!(log_log(&LABELS, &[]).is_ok(), "nothing to draw is no failure");
    }
}
