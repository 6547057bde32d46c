//! What it costs to know where two triangles meet, beside knowing that they do, on one core.
//!
//! ```text
//! cargo bench --bench contact
//! ```
//!
//! Pairs that meet, made at random. The error of every certified answer is checked to be small; that
//! it holds is for the tests.

#[path = "kernel/timing.rs"]
#[expect(dead_code, reason = "means are for the benchmarks of the kernel")]
mod timing;

use std::hint::black_box;

use anyhow::{Result, ensure};
use bumper::geometry::boxes::bounds;
use bumper::geometry::contact::{certified, plain_f32, plain_f64};
use bumper::geometry::triangle::{StaticFilter, triangles_intersect};
use bumper::geometry::{Point, Triangle};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use timing::Timings;

type Pair = [Triangle; 2];
type Shape = fn(Point) -> Point;

const PAIRS: usize = 2000;
const ROUNDS: usize = 50;

fn main() -> Result<()> {
    println!("nanoseconds a pair            test  plain f32  plain f64  certified  median error");
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let shapes: [(&str, Shape); 4] = [
        ("ordinary", |p| p),
        ("10,000 km away", |p| p.map(|c| c + 1e7)),
        ("in one plane", |[x, y, _]| [x, y, 0.25]),
        ("too large for the bounds", |p| p.map(|c| c * 1e40)),
    ];
    for (name, shape) in shapes {
        let pairs = meeting(&mut random, shape);
        let errors = checked_errors(&pairs)?;
        let times = [
            time(&pairs, |[a, b]| triangles_intersect(a, b, &filter([a, b])) as usize),
            time(&pairs, |[a, b]| plain_f32(a, b).map_or(0, |c| c.points().len())),
            time(&pairs, |[a, b]| plain_f64(a, b).map_or(0, |c| c.points().len())),
            time(&pairs, |[a, b]| certified(a, b).map_or(0, |c| c.corners().len())),
        ];
        let times = times.map(|ns| format!("{ns:>9.0}")).join("  ");
        println!("{name:24} {times}  {:>12.1e}", errors[errors.len() / 2]);
    }
    Ok(())
}

/// Random triangles within a box of three units, their points mapped, that meet in twos.
fn meeting(random: &mut ChaCha8Rng, shape: Shape) -> Vec<Pair> {
    let mut number = || random.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0;
    let mut triangle = || {
        let middle: Point = [(); 3].map(|()| number());
        [(); 3].map(|()| shape(middle.map(|c| c + 0.5 * number())))
    };
    let pairs = std::iter::repeat_with(|| [triangle(), triangle()]);
    pairs.filter(|[a, b]| triangles_intersect(a, b, &filter([a, b]))).take(PAIRS).collect()
}

fn checked_errors(pairs: &[Pair]) -> Result<Vec<f64>> {
    let mut errors = Vec::new();
    for [a, b] in pairs {
        let Some(contact) = certified(a, b) else { anyhow::bail!("a pair is not found to meet") };
        let largest = a.iter().chain(b).flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
        ensure!(contact.error() <= 1e-11 * largest, "an error of {:e}", contact.error());
        errors.push(contact.error());
    }
    errors.sort_by(f64::total_cmp);
    Ok(errors)
}

fn filter([a, b]: [&Triangle; 2]) -> StaticFilter {
    let (low, high) = bounds(a.iter().chain(b));
    StaticFilter::for_extent([0, 1, 2].map(|k| high[k] - low[k]))
}

/// Nanoseconds a pair, in the median of rounds over all pairs.
fn time(pairs: &[Pair], call: impl Fn(&Pair) -> usize) -> f64 {
    let mut timings = Timings::default();
    for _ in 0..ROUNDS {
        timings.time(|| pairs.iter().map(|pair| call(black_box(pair))).sum::<usize>());
    }
    timings.quantile_us(0.5) * 1e3 / pairs.len() as f64
}
