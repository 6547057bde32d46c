//! Scenarios for the page: a row for each that is listed, and all there is to see of those that fit.

use crate::effects::layout::{ABSENT, Kind, Layout};
use crate::geometry::{Point, Pose};
use crate::scheduler::client_manager::ScenarioResult;
use crate::tree::ByNumber;
use crate::tree::descent::Pair;

use super::sections::{Sections, zigzag};

/// Scenarios that are listed, from the first.
pub const MOST_LISTED: usize = 50_000;

/// Pairs of all scenarios that are shown in full. One takes about 0.7 bytes of the page, so that two
/// vehicles of 440,000 triangles with as many pairs stay below 12 MB.
pub const MOST_SHOWN: usize = 5_000_000;

/// What a point of a curve counts for.
const POINT: usize = 16;

#[derive(Clone, Debug)]
pub struct ViewScenario {
    pub number: u32,
    pub pose: Pose,
    pub pair_count: u32,
    pub worker: u32,
    /// What effects say, in the order of their layout.
    pub columns: Vec<u64>,
    /// Absent where there is no more room.
    pub detail: Option<Detail>,
}

#[derive(Clone, Debug, Default)]
pub struct Detail {
    pub pairs: Vec<Pair>,
    pub curves: Vec<ViewCurve>,
    /// In contact from a time to another, in seconds.
    pub intervals: Vec<[f64; 2]>,
}

#[derive(Clone, Debug, Default)]
pub struct ViewCurve {
    pub is_closed: bool,
    /// World axes, metres.
    pub points: Vec<Point>,
}

impl Detail {
    fn of(result: &ScenarioResult<'_>) -> Self {
        let mut detail = Self { pairs: result.pairs.to_vec(), ..Self::default() };
        for (table, rows) in result.effects.tables() {
            let rows = rows.chunks_exact(table.columns.len());
            match table.name {
                "curves" => rows.for_each(|row| detail.add_point(row)),
                "contact_intervals" => {
                    detail.intervals.extend(rows.map(|row| [row[0], row[1]].map(f64::from_bits)));
                }
                _ => {}
            }
        }
        detail
    }

    /// A row has the number of the curve, that of the point, whether it is closed, and the place.
    fn add_point(&mut self, row: &[u64]) {
        if row[1] == 0 {
            self.curves.push(ViewCurve { is_closed: row[2] == 1, points: Vec::new() });
        }
        if let Some(curve) = self.curves.last_mut() {
            curve.points.push([row[3], row[4], row[5]].map(f64::from_bits));
        }
    }

    fn size(&self) -> usize {
        self.pairs.len() + POINT * self.curves.iter().map(|curve| curve.points.len()).sum::<usize>()
    }
}

/// Results as they come, no more of them than a page can hold.
#[derive(Debug, Default)]
pub struct Collected {
    pub listed: Vec<ViewScenario>,
    pub scenarios: u32,
    pub colliding: u32,
    pub pairs: u64,
    size: usize,
}

impl Collected {
    pub fn add(&mut self, result: &ScenarioResult<'_>, pose: Pose) {
        self.scenarios += 1;
        self.colliding += u32::from(result.pair_count > 0);
        self.pairs += u64::from(result.pair_count);
        if self.listed.len() == MOST_LISTED {
            return;
        }
        let detail = Detail::of(result);
        let fits = self.size + detail.size() <= MOST_SHOWN;
        self.size += if fits { detail.size() } else { 0 };
        self.listed.push(ViewScenario {
            number: result.scenario,
            pose,
            pair_count: result.pair_count,
            worker: result.worker,
            columns: result.effects.columns().map(|(_, word)| word).collect(),
            detail: fits.then_some(detail),
        });
    }
}

/// `centers`: of the fixed and of the moving body, which the page's coordinates are relative to.
pub(super) fn write(
    scenarios: &[ViewScenario],
    layout: &Layout,
    centers: [Point; 2],
    by_number: [ByNumber<'_>; 2],
    sections: &mut Sections,
) {
    sections.varint("numbers", scenarios.iter().map(|scenario| scenario.number));
    sections.varint("pairs", scenarios.iter().map(|scenario| scenario.pair_count));
    sections.varint("workers", scenarios.iter().map(|scenario| scenario.worker));
    let poses: Vec<_> = scenarios.iter().map(|scenario| centred(&scenario.pose, centers)).collect();
    sections.f32("poses", poses.as_flattened());
    for (at, column) in layout.columns().enumerate() {
        let values = scenarios.iter().map(|scenario| number(column.kind, scenario.columns[at]));
        sections.f64(format!("column.{}", column.name), &values.collect::<Vec<_>>());
    }
    let details = || scenarios.iter().map(|scenario| scenario.detail.as_ref());
    // One more than there are; 0 where nothing was kept.
    let kept = |detail: Option<&Detail>| detail.map_or(0, |detail| 1 + detail.pairs.len() as u32);
    sections.varint("kept", details().map(kept));
    let all = || details().flatten();
    sections.varint("contacts", all().flat_map(|detail| contacts(&detail.pairs, &by_number)));
    sections.varint("curves", all().map(|detail| detail.curves.len() as u32));
    let curves = || all().flat_map(|detail| &detail.curves);
    let length = |curve: &ViewCurve| 2 * curve.points.len() as u32 + u32::from(curve.is_closed);
    sections.varint("curve_lengths", curves().map(length));
    let place = |point: &Point| [0, 1, 2].map(|k| (point[k] - centers[0][k]) as f32);
    let points: Vec<_> = curves().flat_map(|curve| &curve.points).map(place).collect();
    sections.f32("curve_points", points.as_flattened());
    sections.varint("intervals", all().map(|detail| detail.intervals.len() as u32));
    let times: Vec<_> = all().flat_map(|detail| detail.intervals.clone()).collect();
    sections.f64("interval_times", times.as_flattened());
}

/// Takes coordinates relative to the centre of the moving body to such of the fixed one's: row by row
/// the rotation, then the translation.
fn centred(pose: &Pose, [fixed, moving]: [Point; 2]) -> [f32; 12] {
    let at = pose.apply(moving);
    let mut numbers = [0.0; 12];
    let translation = [0, 1, 2].map(|k| at[k] - fixed[k]);
    let all = pose.rotation.iter().chain(&translation);
    numbers.iter_mut().zip(all).for_each(|(number, &value)| *number = value as f32);
    numbers
}

/// No number if it is absent; a choice as its position.
fn number(kind: Kind, word: u64) -> f64 {
    match kind {
        _ if word == ABSENT => f64::NAN,
        Kind::Number => f64::from_bits(word),
        Kind::Flag | Kind::Count | Kind::Choice(_) => word as f64,
    }
}

/// Pairs of ranks in ascending order, each relative to the one before: of the moving triangle, from
/// that of the pair before.
fn contacts(pairs: &[Pair], by_number: &[ByNumber<'_>; 2]) -> Vec<u32> {
    let ranks = |pair: &Pair| [0, 1].map(|side: usize| by_number[side].rank(pair[side]) as i32);
    let mut ranks: Vec<_> = pairs.iter().map(ranks).collect();
    ranks.sort_unstable();
    let mut last = [0; 2];
    let relative = |pair: &[i32; 2]| {
        let before = std::mem::replace(&mut last, *pair);
        [(pair[0] - before[0]) as u32, zigzag(pair[1] - before[1])]
    };
    ranks.iter().flat_map(relative).collect()
}
