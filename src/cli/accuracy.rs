//! `bumper accuracy`: every level of accuracy on the same scenarios.

use std::path::Path;

use anyhow::{Context, anyhow};
use serde::Serialize;

use super::args::AccuracyArgs;
use super::failure::Failure;
use super::prepare::{self, Poses};
use super::request::scene_of;
use super::{files, interrupt, report, terminal};
use crate::experiment::accuracy::{self, AccuracyRow, Load, Measured};
use crate::geometry::simd::SimdLevel;
use crate::report::source::Source;
use crate::report::{Machine, SceneSummary, Versions};
use crate::scene::Scene;
use crate::tree::BuildOptions;

pub(super) fn run(args: AccuracyArgs) -> Result<(), Failure> {
    let interrupt = interrupt::on_ctrl_c().context("cannot listen to Ctrl-C")?;
    let scene = scene_of(&args.scene)?;
    if let Some(level) = args.scene.accuracy {
        return Err(Failure::usage(anyhow!(
            "--accuracy {level}: this compares several: give them as --levels {level},..."
        )));
    }
    let poses = Poses::of(&scene.scenarios)?;
    args.out.as_deref().map_or(Ok(()), files::make_folder)?;
    let meshes = prepare::load(&scene)?;
    interrupt::check(&interrupt)?;
    let trees = prepare::build(&meshes, BuildOptions { kind: scene.tree }, None);
    let poses = poses.place(&meshes, &trees, &interrupt)?;
    interrupt::check(&interrupt)?;
    let levels = if args.levels.is_empty() { accuracy::all_levels() } else { args.levels };
    let load = Load {
        fixed: trees.fixed().image.view(),
        moving: trees.moving().image.view(),
        poses: &poses,
        levels: &levels,
        simd: SimdLevel::chosen(),
    };
    let bar = terminal::scenario_bar("comparing", poses.len());
    let measured = accuracy::measure(&load, &|| bar.inc(1), &interrupt);
    bar.finish_and_clear();
    let measured = measured?;
    if measured.scenarios == 0 && !poses.is_empty() {
        return Err(interrupt::before_results());
    }
    let report = Report::new(&scene, &measured, poses.len());
    if let Some(out) = &args.out {
        report::write_output(out, Source::Accuracy, &report.to_json())?;
    }
    let text = if args.json { report.to_json() } else { table(&report) };
    terminal::print(&text).context("cannot print the figures")?;
    if report.interrupted {
        let (done, asked) = (report.scenarios, poses.len());
        return Err(Failure::Interrupted(format!("{done} of {asked} scenarios were compared")));
    }
    Ok(())
}

/// `accuracy.json`.
#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    versions: Versions,
    interrupted: bool,
    scenarios: usize,
    scenarios_asked: usize,
    colliding: u32,
    /// Exact pairs, over all scenarios.
    pairs: u64,
    simd: SimdLevel,
    levels: &'a [AccuracyRow],
    scene: SceneSummary,
    machine: Machine,
}

impl<'a> Report<'a> {
    const SCHEMA_VERSION: u32 = 1;

    fn new(scene: &Scene, measured: &'a Measured, asked: usize) -> Self {
        Self {
            schema_version: Self::SCHEMA_VERSION,
            versions: Versions::this(),
            interrupted: measured.scenarios < asked,
            scenarios: measured.scenarios,
            scenarios_asked: asked,
            colliding: measured.colliding,
            pairs: measured.pairs,
            simd: SimdLevel::chosen(),
            levels: &measured.rows,
            scene: scene.into(),
            machine: Machine::this(),
        }
    }

    fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("string keys and plain values") + "\n"
    }

    fn title(&self) -> String {
        let (fixed, moving) = (&self.scene.fixed.mesh, &self.scene.moving.mesh);
        let name = |mesh: &str| {
            Path::new(mesh).file_stem().map_or(mesh.to_owned(), |n| n.display().to_string())
        };
        format!(
            "{} against {}: {} scenarios, {} trees, {}",
            name(fixed),
            name(moving),
            self.scenarios,
            self.scene.tree,
            self.simd
        )
    }
}

fn table(report: &Report<'_>) -> String {
    let mut text =
        format!("{}; {} colliding, {} pairs\n", report.title(), report.colliding, report.pairs);
    text += "processor time of a scenario, the fastest of three warm runs of its pose\n\n";
    text += &format!(
        "{:10} {:>9} {:>9} {:>9} {:>8} {:>6} {:>6} {:>8} {:>13} {:>9} {:>9} {:>7} {:>8} {:>8} \
         {:>8}\n",
        "",
        "mean",
        "median",
        "p99",
        "over",
        "false",
        "false",
        "pairs",
        "pairs",
        "contact",
        "points m",
        "points",
        "N_b",
        "N_p",
        "left",
    );
    text += &format!(
        "{:10} {:>9} {:>9} {:>9} {:>8} {:>6} {:>6} {:>8} {:>13} {:>9} {:>9} {:>7} {:>8} {:>8} \
         {:>8}\n",
        "level",
        "us",
        "us",
        "us",
        "exact",
        "hits",
        "misses",
        "missing",
        "extra",
        "median",
        "worst",
        "none",
        "",
        "",
        "open",
    );
    for row in report.levels {
        let metres = |error: Option<f64>| error.map_or("-".to_owned(), |m| format!("{m:.1e}"));
        text += &format!(
            "{:10} {:>9.2} {:>9.2} {:>9.2} {:>8.3} {:>6} {:>6} {:>8} {:>13} {:>9} {:>9} {:>7} \
             {:>8.0} {:>8.0} {:>8}\n",
            row.level.to_string(),
            row.time_us.mean,
            row.time_us.median,
            row.time_us.p99,
            row.over_exact,
            row.false_hits,
            row.false_misses,
            row.missing,
            row.extra,
            metres(row.contact_error_m.map(|error| error.median)),
            metres(row.contact_error_m.map(|error| error.worst)),
            row.without_contact.map_or("-".to_owned(), |pairs| pairs.to_string()),
            row.box_tests,
            row.triangle_tests,
            row.left_open.map_or("-".to_owned(), |tests| format!("{tests:.1}")),
        );
    }
    if let Some(signs) = report.levels.iter().find_map(|row| row.signs) {
        text += &format!(
            "\nsigns of the exact test in the mean scenario, by the stage that decided them:\n\
             {:.1} filter, {:.1} structure, {:.1} grid, {:.1} expansions, {:.1} integers\n",
            signs.filter, signs.structure, signs.grid, signs.expansions, signs.integers,
        );
    }
    text
}
