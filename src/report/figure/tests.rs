use proptest::prelude::*;

use super::*;

fn figure(series: &[(&str, &[[f64; 2]])]) -> Figure {
    let one = |(name, points): &(&str, &[[f64; 2]])| Series {
        name: (*name).to_owned(),
        points: points.iter().map(|&[x, y]| Point::at(x, y)).collect(),
    };
    Figure {
        name: "a_figure".to_owned(),
        title: "Title".to_owned(),
        x: Axis::linear("bytes"),
        y: Axis::log("time (us)"),
        series: series.iter().map(one).collect(),
    }
}

fn bars() -> Figure {
    let names = ["load", "build"].map(str::to_owned).to_vec();
    let x = Axis { label: "stage".to_owned(), scale: Scale::Names(names) };
    Figure { x, y: Axis::linear("s"), ..figure(&[("", &[[0.0, 3.0], [1.0, 0.0]])]) }
}

/// Opening tags of a document whose tags must be closed in order and whose attributes must be in
/// quotation marks without `<`.
pub(in crate::report) fn elements(svg: &str) -> usize {
    let (mut open, mut count) = (Vec::new(), 0);
    for part in svg.split('<').skip(1) {
        let (tag, _text) = part.split_once('>').unwrap_or_else(|| panic!("unclosed <{part}"));
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name), "{svg}"),
            None => {
                count += 1;
                let name = tag.split([' ', '/', '\n']).next().unwrap();
                if !tag.ends_with('/') {
                    open.push(name);
                }
            }
        }
    }
    assert!(open.is_empty(), "{open:?} stay open");
    count
}

#[test]
fn figures_name_their_axes_and_series() {
    let lines = figure(&[("a line", &[[64.0, 3.0], [1e6, 400.0]]), ("a point", &[[64.0, 9.0]])]);
    let scales = [Scale::Linear, Scale::Log];
    for x in &scales {
        for y in &scales {
            let mut figure = lines.clone();
            (figure.x.scale, figure.y.scale) = (x.clone(), y.clone());
            let svg = figure.to_svg().unwrap();
            elements(&svg);
            for words in ["<title>Title</title>", "role=\"img\"", "bytes", "time (us)", "a point"] {
                assert!(svg.contains(words), "{words}");
            }
        }
    }
    let svg = bars().to_svg().unwrap();
    assert!(svg.contains("load") && svg.contains("build") && svg.contains("stage"), "{svg}");
}

#[test]
fn nothing_to_draw_is_no_failure() {
    for series in [&[][..], &[("empty", &[][..])], &[("one", &[[1.0, 1.0]])]] {
        elements(&figure(series).to_svg().unwrap());
    }
    let none = Axis { label: String::new(), scale: Scale::Names(Vec::new()) };
    elements(&Figure { x: none, ..figure(&[]) }.to_svg().unwrap());
}

#[test]
fn the_spread_of_samples_is_drawn() {
    let strokes = |figure: &Figure| figure.to_svg().unwrap().matches("<polyline").count();
    for mut figure in [figure(&[("", &[[1.0, 1.0], [2.0, 3.0]])]), bars()] {
        let without = strokes(&figure);
        figure.series[0].points[0].spread = Some([1.0, 3.0]);
        assert_eq!(strokes(&figure), without + 3, "a bar and two ends");
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_by_name() {
    let refused = |figure: &Figure, words: &[&str]| {
        let error = figure.to_svg().unwrap_err().to_string();
        for word in words {
            assert!(error.contains(word), "`{word}` is missing in: {error}");
        }
    };
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 1e-310] {
        for point in [[bad, 1.0], [1.0, bad]] {
            let words = ["a_figure", "line", "point 1", "1e200"];
            refused(&figure(&[("line", &[[1.0, 1.0], point])]), &words);
        }
        let mut spread = figure(&[("line", &[[1.0, 1.0]])]);
        spread.series[0].points[0].spread = Some([1.0, bad]);
        refused(&spread, &["point 0"]);
    }
    refused(&figure(&[("line", &[[1.0, 0.0]])]), &["line", "above zero", "logarithmic"]);
    let mut figure = figure(&[("line", &[[1.0, 1.0]])]);
    figure.series[0].points[0].spread = Some([2.0, 1.0]);
    refused(&figure, &["least", "most"]);
    let mut between = bars();
    between.series[0].points[0].x = 0.5;
    refused(&between, &["none of the names"]);
    between.series[0].points[0].x = 2.0;
    refused(&between, &["none of the names"]);
    refused(&Figure { y: bars().x, ..bars() }, &["x axis"]);
    for name in ["", "../up", "a b", "a/b", ".", &"n".repeat(101)] {
        refused(&Figure { name: name.to_owned(), ..bars() }, &["stem of a file"]);
    }
}

#[test]
fn hostile_text_stays_text() {
    let mut hostile = figure(&[("</text><script>\"'&\u{1}\u{ffff}", &[[1.0, 1.0]])]);
    hostile.title = "</title><script src=\"x\">".to_owned();
    hostile.y.label = "stroke=\"#020300\" \u{0}".to_owned();
    for svg in [hostile.to_svg().unwrap(), hostile.to_inline_svg().unwrap()] {
        assert!(!svg.contains("<script"), "{svg}");
        assert!(svg.chars().all(|c| c == '\n' || !c.is_control() && c != '\u{ffff}'), "{svg}");
        assert!(svg.contains("stroke=&quot;#020300&quot;"), "{svg}");
        elements(&svg);
    }
}

#[test]
fn series_differ_in_mark_and_dash_without_colour() {
    let looks: Vec<_> = (0..64).map(Look::of).collect();
    for (number, look) in looks.iter().enumerate() {
        assert!(!looks[..number].contains(look), "{number}");
    }
    let names: Vec<String> = (0..8).map(|n| format!("series {n}")).collect();
    let points: &[[f64; 2]] = &[[1.0, 1.0], [2.0, 2.0]];
    let lines: Vec<_> = names.iter().map(|name| (name.as_str(), points)).collect();
    let svg = figure(&lines).to_svg().unwrap();
    let dashes: std::collections::BTreeSet<&str> = svg
        .split("stroke-dasharray=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap())
        .collect();
    assert_eq!(dashes.len(), 7, "and one without");
}

#[test]
fn text_has_the_colour_of_the_page() {
    let svg = bars().to_inline_svg().unwrap();
    assert!(svg.contains("fill=\"currentColor\"") && svg.contains("stroke=\"currentColor\""));
    assert!(!svg.contains("#010203") && !svg.contains("http") && !svg.contains("<style"));
    let file = bars().to_svg().unwrap();
    assert!(file.contains("prefers-color-scheme") && file.contains("xmlns="));
}

#[test]
fn figures_survive_json() {
    let mut figure = figure(&[("line", &[[0.1, 1.0 / 3.0], [1e-7, 2.0]])]);
    figure.series[0].points[0].spread = Some([0.25, 0.5]);
    for figure in [figure, bars()] {
        let json = serde_json::to_string(&figure).unwrap();
        assert_eq!(serde_json::from_str::<Figure>(&json).unwrap(), figure, "{json}");
    }
    let json = serde_json::to_value(bars()).unwrap();
    assert_eq!(json["x"]["scale"]["names"][1], "build");
    assert_eq!(json["y"]["scale"], "linear");
    let unknown = r#"{"x": 1, "y": 2, "z": 3}"#;
    assert!(serde_json::from_str::<Point>(unknown).unwrap_err().to_string().contains('z'));
}

#[test]
fn points_of_one_name_are_one_series() {
    let points = [("a", 1.0), ("b", 2.0), ("a", 3.0)];
    let series = Series::grouped(points.map(|(name, x)| (name.to_owned(), Point::at(x, x))));
    let shape: Vec<_> = series.iter().map(|one| (one.name.as_str(), one.points.len())).collect();
    assert_eq!(shape, [("a", 2), ("b", 1)]);
}

proptest! {
    #[test]
    fn any_numbers_are_drawn_or_refused(
        points in prop::collection::vec((any::<f64>(), any::<f64>()), 0..5),
        x_is_log: bool,
        y_is_log: bool,
    ) {
        let scale = |is_log| if is_log { Scale::Log } else { Scale::Linear };
        let points: Vec<[f64; 2]> = points.into_iter().map(|(x, y)| [x, y]).collect();
        let mut figure = figure(&[("line", &points)]);
        (figure.x.scale, figure.y.scale) = (scale(x_is_log), scale(y_is_log));
        if let Ok(svg) = figure.to_svg() {
            elements(&svg);
            prop_assert!(!svg.contains("NaN") && !svg.contains("21474"), "{}", svg);
        }
    }
}

#[test]
fn columns_of_a_text_are_as_wide_as_their_widest_cell() {
    let table = Table {
        title: "title".to_owned(),
        columns: vec!["a".to_owned(), "long".to_owned()],
        rows: vec![vec!["1234".to_owned(), "5".to_owned()]],
    };
    assert_eq!(table.to_text(), "title\n     a  long\n  1234     5\n");
}
