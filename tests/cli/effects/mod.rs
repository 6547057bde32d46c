//! What a scene asks for beside the pairs that touch, from the scene file to the results.

mod agreement;
mod closed_forms;
mod contacts;
mod free;
mod impacts;
mod refused;
mod scenes;

use std::io::Write;

use parquet::record::{Field, Row};

use super::*;

/// A run and everything that it wrote.
struct Run {
    summary: Value,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    /// `scenarios.csv` as it is, and the bytes of each table by its name.
    csv: String,
    tables: BTreeMap<String, Vec<u8>>,
}

impl Run {
    fn of(place: &Place, scene: &str, arguments: &[&str]) -> Self {
        let out = tempfile::tempdir_in(place.0.path()).unwrap();
        let path = out.path().to_str().unwrap();
        let workers: &[&str] =
            if arguments.contains(&"--workers") { &[] } else { &["--workers", "2"] };
        let run = [&["run", scene, "--no-cache", "--out", path], workers, arguments].concat();
        succeeded(&place.run(&run));
        Self::read(out.path())
    }

    fn read(out: &Path) -> Self {
        let csv = fs::read_to_string(out.join("scenarios.csv")).unwrap();
        let mut lines = csv.lines().map(|line| line.split(',').map(str::to_owned).collect());
        let files = fs::read_dir(out).unwrap().map(|entry| entry.unwrap().path());
        let tables = files.filter(|file| file.extension().is_some_and(|end| end == "parquet"));
        let table = |file: PathBuf| {
            (file.file_stem().unwrap().to_str().unwrap().to_owned(), fs::read(&file).unwrap())
        };
        Self {
            summary: json(&out.join("summary.json")),
            header: lines.next().unwrap(),
            rows: lines.collect(),
            tables: tables.map(table).collect(),
            csv,
        }
    }

    /// The cells of a column, one a scenario; empty where there is no value.
    fn cells(&self, name: &str) -> Vec<&str> {
        let at = self.header.iter().position(|column| column == name);
        let at = at.unwrap_or_else(|| panic!("no column {name} in {:?}", self.header));
        self.rows.iter().map(|row| row[at].as_str()).collect()
    }

    fn numbers(&self, name: &str) -> Vec<Option<f64>> {
        let number = |cell: &str| (!cell.is_empty()).then(|| cell.parse().unwrap());
        self.cells(name).into_iter().map(number).collect()
    }

    /// Of one scenario that has it.
    fn number(&self, name: &str, scenario: usize) -> f64 {
        self.numbers(name)[scenario].unwrap_or_else(|| panic!("scenario {scenario} has no {name}"))
    }

    fn vector(&self, names: [&str; 3], scenario: usize) -> [f64; 3] {
        names.map(|name| self.number(name, scenario))
    }

    /// The effects of the summary, each with the number of scenarios that needed it.
    fn effects(&self) -> Vec<(&str, u64)> {
        let of = |effect: &'_ Value| effect["scenarios"].as_u64().unwrap();
        let effects = self.summary["effects"].as_array().unwrap().iter();
        effects.map(|effect| (effect["effect"].as_str().unwrap(), of(effect))).collect()
    }

    fn table_names(&self) -> Vec<&str> {
        self.tables.keys().map(String::as_str).collect()
    }

    /// The rows of a table, each number as f64.
    fn table(&self, name: &str) -> Vec<BTreeMap<String, f64>> {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&self.tables[name]).unwrap();
        let reader = SerializedFileReader::new(file);
        let number = |field: &Field| match field {
            Field::UInt(n) => f64::from(*n),
            Field::Double(x) => *x,
            Field::Bool(flag) => f64::from(u8::from(*flag)),
            other => panic!("{other:?} in {name}"),
        };
        let row = |row: Row| {
            row.get_column_iter().map(|(name, field)| (name.clone(), number(field))).collect()
        };
        reader.unwrap().get_row_iter(None).unwrap().map(|r| row(r.unwrap())).collect()
    }
}

/// The text of an OBJ file of closed boxes, each from its lowest to its highest corner, faces outward;
/// twelve triangles a box.
fn boxes(corners: &[[[f64; 3]; 2]]) -> String {
    const QUADS: [[usize; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut text = String::new();
    for ends in corners {
        for corner in 0..8_usize {
            let [x, y, z] = [0, 1, 2].map(|axis: usize| ends[corner >> axis & 1][axis]);
            text += &format!("v {x} {y} {z}\n");
        }
    }
    for first in (0..corners.len()).map(|n| 8 * n + 1) {
        for [a, b, c, d] in QUADS.map(|quad| quad.map(|corner| first + corner)) {
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    text
}

/// Of the given half length of its edges, about the origin.
fn cube(half: f64) -> String {
    boxes(&[[[-half; 3], [half; 3]]])
}

/// Poses that only translate.
fn moved_to(places: &[[f64; 3]]) -> String {
    let rows = places.iter().map(|[x, y, z]| format!("1,0,0,0,{x},{y},{z}\n"));
    [HEADER.to_owned()].into_iter().chain(rows).collect()
}

fn near(found: f64, expected: f64, error: f64) {
    assert!((found - expected).abs() <= error, "{found} is not {expected} to {error}");
}
