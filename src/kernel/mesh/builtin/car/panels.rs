//! Sheet metal and glass: the shell cut along the joints that a car has.

use super::{
    AXLE_HEIGHT, FRONT_AXLE, REAR_AXLE,
    shell::{
        BELT, FRONT_CORNER, RAIL, REAR_CORNER, body, bonnet, boot, canopy, greenhouse, plan_of,
        top_of_body,
    },
};
use crate::{
    geometry::Point,
    mesh::builtin::{
        assembly::Assembly,
        budget::Detail,
        curve::Curve,
        placement::Placement,
        sheet::{Ends, Sheet},
        turn::turn,
    },
};

/// Wheel arches (m).
const ARCH_RADIUS: f64 = 0.365;
/// Lower edges of wings and doors, and of the sill below them (m above the ground).
const DOOR_FOOT: f64 = 0.27;
const SILL_FOOT: f64 = 0.16;
/// Half the gap between two panels (m).
const GAP: f64 = 0.003;
/// How far a panel's edge is folded inward (m).
const FLANGE: f64 = 0.018;
/// How far glass lies under the sheet metal (m).
const GLASS_DEPTH: f64 = 0.016;
/// How far the windows of the front doors are up.
const FRONT_WINDOW_UP: f64 = 0.3;
/// The pillars between the windows, x (m).
const PILLAR_B: [f64; 2] = [-0.20, -0.29];
const PILLAR_C: [f64; 2] = [-0.93, -0.99];
/// First and last x of the side windows (m).
const WINDOWS: [f64; 2] = [0.70, -1.27];
/// (x, width of the frame between a side window and the rail above it).
const FRAME: Curve =
    Curve(&[[-1.62, 0.09], [-1.0, 0.085], [-0.7, 0.06], [0.1, 0.06], [0.4, 0.085], [1.0, 0.10]]);

/// A panel over the unit square: `at(a, b, depth)` is a point `depth` metres under the outer face,
/// which looks along b x a. From `Detail::Parts` on its edges are folded inward.
fn panel(
    detail: Detail,
    spans: [usize; 2],
    at: impl Fn(f64, f64, f64) -> Point + 'static,
) -> Sheet {
    /// The fold leans outward by this share of the panel, so that its corners do not collapse.
    const LEAN: f64 = 0.002;
    let [rows, columns] = spans.map(|n| n as f64);
    if detail == Detail::Outline {
        return Sheet::new(spans, Ends::OPEN, move |u, v| at(u / rows, v / columns, 0.0));
    }
    // One more span on each side is the fold; `beyond` is how far into it.
    let split = |t: f64, count: f64| {
        let inside = (t - 1.0).clamp(0.0, count);
        let beyond = t - 1.0 - inside;
        (inside / count + LEAN * beyond, beyond.abs())
    };
    Sheet::new(spans.map(|n| n + 2), Ends::OPEN, move |u, v| {
        let ((a, du), (b, dv)) = (split(u, rows), split(v, columns));
        at(a, b, FLANGE * du.max(dv))
    })
}

/// A panel of the lower body between two places on the plan and two heights.
pub(super) fn band(
    detail: Detail,
    plan: [f64; 2],
    foot: f64,
    top: impl Fn(f64) -> f64 + 'static,
) -> Sheet {
    panel(detail, [1, 3], move |a, b, depth| {
        let s = between(plan, b);
        body(s, between([foot, top(s)], a), depth)
    })
}

/// The same along the side, between two x, the larger first.
fn side_band(detail: Detail, x: [f64; 2], foot: f64) -> Sheet {
    let plan = [plan_of(x[0] - GAP), plan_of(x[1] + GAP)];
    band(detail, plan, foot, |s| top_of_body(s) - GAP)
}

/// The part of a wing over a wheel.
fn arch(detail: Detail, axle: f64) -> Sheet {
    panel(detail, [1, 6], move |a, b, depth| {
        let [cos, sin] = turn(b / 2.0);
        let x = axle + (ARCH_RADIUS - GAP) * cos;
        let foot = AXLE_HEIGHT + ARCH_RADIUS * sin;
        body(plan_of(x), between([foot, BELT.at(x) - GAP], a), depth)
    })
}

/// The flared lip of a wheel arch and the liner behind it.
fn arch_lining(axle: f64) -> [Sheet; 2] {
    let ring = move |t: f64, radius: f64| {
        let [cos, sin] = turn(t / 2.0);
        [axle + radius * cos, AXLE_HEIGHT + radius * sin]
    };
    let lip = Sheet::new([3, 6], Ends::OPEN, move |u, v| {
        const SECTION: [[f64; 2]; 4] =
            [[0.0, 0.03], [-0.006, -0.008], [0.014, -0.008], [0.035, 0.002]];
        let row = (u as usize).min(2);
        let [rise, out] =
            [0, 1].map(|k| between([SECTION[row][k], SECTION[row + 1][k]], u - row as f64));
        let [x, z] = ring(v / 6.0, ARCH_RADIUS + rise);
        body(plan_of(x), z, out)
    });
    let liner = Sheet::new([1, 6], Ends::OPEN, move |u, v| {
        let [x, z] = ring(v / 6.0, ARCH_RADIUS + 0.01);
        let outer = body(plan_of(x), z, 0.012)[1];
        [x, between([0.56, outer], u), z]
    });
    [lip, liner.finer(0.4, 1.0)]
}

/// A piece of the window surface between two x (the larger first) and two heights.
fn pane(
    detail: Detail,
    x: [f64; 2],
    depth: f64,
    foot: impl Fn(f64) -> f64 + 'static,
    top: impl Fn(f64) -> f64 + 'static,
) -> Sheet {
    panel(detail, [1, 4], move |a, b, fold| {
        let x = between(x, b);
        greenhouse(x, between([foot(x), top(x)], a), depth + fold)
    })
}

/// The glass of a side window, wound up to a share of its height.
fn window(detail: Detail, x: [f64; 2], up: f64) -> Sheet {
    let foot = |x| BELT.at(x) + 0.005;
    pane(detail, x, GLASS_DEPTH, foot, move |x| between([foot(x), window_top(x)], up))
}

fn window_top(x: f64) -> f64 {
    RAIL.at(x) - FRAME.at(x)
}

fn pillar(detail: Detail, x: [f64; 2]) -> Sheet {
    pane(detail, x, 0.0, |x| BELT.at(x) - 0.01, |x| window_top(x) + 0.004)
}

/// A piece of windscreen, roof or rear window between two x (the smaller first).
fn canopy_panel(detail: Detail, x: [f64; 2], width: f64, depth: f64) -> Sheet {
    panel(detail, [4, 3], move |a, b, fold| {
        canopy(between(x, b), between([-width, width], a), depth + fold)
    })
}

fn left_side(detail: Detail) -> Assembly {
    let mut side = Assembly::default();
    let mut put = |sheet: Sheet| side.put(sheet, Placement::HERE);
    let front_arch_rear = FRONT_AXLE - ARCH_RADIUS;
    let rear_arch_front = REAR_AXLE + ARCH_RADIUS;
    let [b_front, b_rear] = PILLAR_B;
    let b_middle = (b_front + b_rear) / 2.0;
    put(arch(detail, FRONT_AXLE));
    put(side_band(detail, [front_arch_rear, 0.80], DOOR_FOOT));
    put(side_band(detail, [0.80, b_middle], DOOR_FOOT));
    put(side_band(detail, [b_middle, rear_arch_front], DOOR_FOOT));
    put(arch(detail, REAR_AXLE));
    let sill = [plan_of(front_arch_rear), plan_of(rear_arch_front)];
    put(band(detail, sill, SILL_FOOT, |_| DOOR_FOOT - GAP));
    put(window(detail, [WINDOWS[0], b_front], FRONT_WINDOW_UP));
    put(window(detail, [b_rear, PILLAR_C[0]], 1.0));
    put(window(detail, [PILLAR_C[1], WINDOWS[1]], 1.0));
    put(pillar(detail, PILLAR_B));
    put(pillar(detail, PILLAR_C));
    put(pillar(detail, [0.98, WINDOWS[0]]));
    put(pillar(detail, [WINDOWS[1], -1.60]));
    put(pane(detail, [1.04, -1.63], 0.0, window_top, |x| RAIL.at(x)).finer(1.0, 1.5));
    if detail >= Detail::Parts {
        for axle in [FRONT_AXLE, REAR_AXLE] {
            arch_lining(axle).into_iter().for_each(&mut put);
        }
    }
    if detail == Detail::Full {
        put(pane(detail, [0.93, -1.50], -0.006, |x| BELT.at(x) - 0.004, |x| BELT.at(x) + 0.014));
        for x in [[0.78, b_middle], [b_middle - 0.02, -0.90]] {
            let strip = [plan_of(x[0]), plan_of(x[1])];
            put(panel(detail, [1, 3], move |a, b, fold| {
                body(between(strip, b), between([0.46, 0.50], a), fold - 0.012)
            }));
        }
    }
    side
}

/// Bumpers, bonnet, roof, boot lid, windscreen and rear window, from the left to the right.
fn middle(detail: Detail) -> Assembly {
    let mut middle = Assembly::default();
    let mut put = |sheet: Sheet| middle.put(sheet, Placement::HERE);
    let nose = plan_of(FRONT_AXLE + ARCH_RADIUS);
    let tail = plan_of(REAR_AXLE - ARCH_RADIUS);
    put(panel(detail, [4, 3], |a, b, fold| bonnet(b, between([-0.995, 0.995], a), fold)));
    put(panel(detail, [4, 3], |a, b, fold| boot(b, between([0.995, -0.995], a), fold)));
    put(canopy_panel(detail, [-0.72, 0.24], 1.0, 0.0));
    put(canopy_panel(detail, [0.225, 1.04], 0.985, GLASS_DEPTH));
    put(canopy_panel(detail, [-1.61, -0.705], 0.985, GLASS_DEPTH));
    // Below the joints between the glass and the lids.
    put(panel(detail, [4, 1], |a, b, fold| {
        let w = between([-0.98, 0.98], a);
        join(canopy(1.02, w, 0.03), bonnet(0.03, w, 0.03), b, fold)
    }));
    put(panel(detail, [4, 1], |a, b, fold| {
        let w = between([0.98, -0.98], a);
        join(canopy(-1.60, w, 0.03), boot(0.03, w, 0.03), b, fold)
    }));
    // Nose: lip, bumper, and the corners beside the openings for air and lamps.
    put(bumper(detail, [-nose, nose], [0.16, 0.26]));
    put(bumper(detail, [-nose, nose], [0.41, 0.535]));
    for [s, t] in [[-nose, -0.52], [0.52, nose]] {
        put(bumper(detail, [s, t], [0.266, 0.404]));
    }
    put(bumper(detail, [6.0 - tail, tail].map(|s| 6.0 - s), [0.24, 0.62]));
    put(band(detail, [2.36, 3.64], 0.626, |s| top_of_body(s) - GAP));
    for [s, t] in [[tail, 2.03], [3.97, 6.0 - tail]] {
        put(band(detail, [s, t], 0.626, |s| top_of_body(s) - GAP));
    }
    for [s, t] in [[-nose, -0.97], [0.97, nose]] {
        put(band(detail, [s, t], 0.541, |s| top_of_body(s) - GAP));
    }
    middle
}

/// On the way from one point to another, `depth` metres lower.
fn join(from: Point, to: Point, t: f64, depth: f64) -> Point {
    let [x, y, z] = [0, 1, 2].map(|k| between([from[k], to[k]], t));
    [x, y, z - depth]
}

fn bumper(detail: Detail, plan: [f64; 2], height: [f64; 2]) -> Sheet {
    panel(detail, [2, 6], move |a, b, fold| body(between(plan, b), between(height, a), fold))
}

pub(super) fn panels(detail: Detail) -> Assembly {
    let mut panels = Assembly::default();
    panels.include_on_both_sides(&left_side(detail));
    panels.include(&middle(detail), Placement::HERE);
    panels
}

/// A strip between two places on the plan and two shares of the height from `foot` to the
/// body's upper edge, `depth` under the skin: lenses, slats.
pub(super) fn strip(
    detail: Detail,
    plan: [f64; 2],
    foot: f64,
    shares: [f64; 2],
    depth: f64,
) -> Sheet {
    panel(detail, [1, 2], move |a, b, fold| {
        let s = between(plan, b);
        let z = between([foot, top_of_body(s) - GAP], between(shares, a));
        body(s, z, depth + fold)
    })
}

fn between([from, to]: [f64; 2], t: f64) -> f64 {
    from + (to - from) * t
}

const _: () =
    assert!(FRONT_AXLE + ARCH_RADIUS > FRONT_CORNER && REAR_AXLE - ARCH_RADIUS > REAR_CORNER);
