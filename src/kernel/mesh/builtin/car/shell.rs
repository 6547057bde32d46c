//! The outer surface of the body as functions; `panels` cuts it into sheet metal and glass.
//!
//! Everything is for the left half (y >= 0). The **plan** is the outline seen from above, a path
//! from the middle of the nose (0) over the front corner (1) and along the side to the rear corner
//! (2) and the middle of the tail (3).

use crate::{geometry::Point, mesh::builtin::curve::Curve};

pub(super) const HALF_LENGTH: f64 = 2.25;
/// Where the plan leaves the nose for the side, and the side for the tail: x (m).
pub(super) const FRONT_CORNER: f64 = 1.70;
pub(super) const REAR_CORNER: f64 = -1.70;

/// Cubic Bezier control points (x, y) of the plan around the front and rear corners (m).
const NOSE: [[f64; 2]; 4] =
    [[HALF_LENGTH, 0.0], [2.26, 0.52], [2.12, 0.845], [FRONT_CORNER, 0.865]];
const TAIL: [[f64; 2]; 4] =
    [[REAR_CORNER, 0.865], [-2.08, 0.85], [-2.25, 0.66], [-HALF_LENGTH, 0.0]];

/// (x, half width) along the side.
const SIDE: Curve =
    Curve(&[[REAR_CORNER, 0.865], [-1.0, 0.895], [0.0, 0.90], [0.9, 0.89], [FRONT_CORNER, 0.865]]);
/// (x, height) of the edge between the side and bonnet, windows or boot lid.
pub(super) const BELT: Curve = Curve(&[
    [-2.25, 0.965],
    [-1.7, 0.985],
    [-0.9, 0.965],
    [0.0, 0.93],
    [0.95, 0.885],
    [1.5, 0.81],
    [2.0, 0.715],
    [2.25, 0.64],
]);
/// (x, height) of the edge between the side and the windscreen, roof or rear window.
pub(super) const RAIL: Curve = Curve(&[
    [-1.66, 1.0],
    [-1.3, 1.16],
    [-0.95, 1.30],
    [-0.6, 1.365],
    [-0.1, 1.385],
    [0.22, 1.365],
    [0.5, 1.23],
    [1.06, 0.905],
]);
/// (x, how far the middle of the glass or roof lies ahead of its side edges).
const BULGE: Curve =
    Curve(&[[-1.66, -0.13], [-0.8, -0.06], [-0.2, 0.0], [0.3, 0.08], [1.06, 0.17]]);
/// (height above the ground, how far the lower body is drawn in), before the shoulder.
const TUCK: Curve =
    Curve(&[[0.15, 0.075], [0.26, 0.03], [0.45, 0.006], [0.58, 0.0], [0.75, 0.012], [1.0, 0.03]]);
/// (height, how far nose and tail lean back in their middle).
const NOSE_RAKE: Curve =
    Curve(&[[0.15, 0.10], [0.25, 0.02], [0.45, 0.0], [0.52, 0.02], [0.64, 0.08], [0.75, 0.15]]);
const TAIL_RAKE: Curve =
    Curve(&[[0.25, 0.08], [0.36, 0.01], [0.55, 0.0], [0.64, 0.03], [0.90, 0.05], [0.965, 0.075]]);

/// Height over which the side rounds over into its upper edge, and by how much (m).
const SHOULDER: f64 = 0.09;
const SHOULDER_INSET: f64 = 0.055;
/// Windows stand back from the shoulder's edge by this (m).
const LEDGE: f64 = 0.012;

/// Position on the plan of the side at `x`.
pub(super) fn plan_of(x: f64) -> f64 {
    1.0 + (FRONT_CORNER - x) / (FRONT_CORNER - REAR_CORNER)
}

/// Point of the plan and its outward normal (x, y).
fn plan(s: f64) -> ([f64; 2], [f64; 2]) {
    if s < 1.0 {
        bezier(NOSE, s)
    } else if s > 2.0 {
        bezier(TAIL, s - 2.0)
    } else {
        let x = FRONT_CORNER + (s - 1.0) * (REAR_CORNER - FRONT_CORNER);
        ([x, SIDE.at(x)], [0.0, 1.0])
    }
}

/// Height of the upper edge of the lower body.
pub(super) fn top_of_body(s: f64) -> f64 {
    let s = if s > 3.0 { 6.0 - s } else { s.abs() };
    BELT.at(plan(s).0[0])
}

/// Point of the lower body at a place on the plan, at a height, `depth` metres under the skin.
///
/// Beyond the middle of nose (0) and tail (3) the plan goes on along the right half.
pub(super) fn body(s: f64, z: f64, depth: f64) -> Point {
    if !(0.0..=3.0).contains(&s) {
        let [x, y, z] = body(if s < 0.0 { -s } else { 6.0 - s }, z, depth);
        return [x, -y, z];
    }
    let (p, normal) = plan(s);
    let over = (1.0 - (BELT.at(p[0]) - z) / SHOULDER).max(0.0);
    let inset = depth + TUCK.at(z) + SHOULDER_INSET * over * over;
    let rake = match s {
        s if s < 1.0 => -(1.0 - s * s) * NOSE_RAKE.at(z),
        s if s > 2.0 => (1.0 - (3.0 - s) * (3.0 - s)) * TAIL_RAKE.at(z),
        _ => 0.0,
    };
    [p[0] - normal[0] * inset + rake, p[1] - normal[1] * inset, z]
}

/// Point of the window surface of the side.
pub(super) fn greenhouse(x: f64, z: f64, depth: f64) -> Point {
    let belt = BELT.at(x);
    let foot = body(plan_of(x), belt, LEDGE)[1];
    let above = z - belt;
    [x, foot - above * (0.42 + 0.30 * above) - depth, z]
}

/// Point of windscreen, roof and rear window; `x` at their side edge, `w` in [-1, 1] across.
pub(super) fn canopy(x: f64, w: f64, depth: f64) -> Point {
    let z = RAIL.at(x);
    let edge = greenhouse(x, z, 0.0)[1];
    let arch = 1.0 - w * w;
    [x + BULGE.at(x) * arch, w * edge, z + 0.045 * arch - depth]
}

/// Point of the bonnet: from its rear edge (0) to the nose (1), `w` in [-1, 1] across.
pub(super) fn bonnet(along: f64, w: f64, depth: f64) -> Point {
    let arch = 1.0 - w * w;
    let rear = [1.10 + 0.20 * arch, w * body(plan_of(1.10), BELT.at(1.10), 0.0)[1]];
    deck(rear, w.abs(), w, along, 0.055 * (1.0 - along * along) * arch - depth)
}

/// Point of the boot lid: from the rear window (0) to the tail (1), `w` in [-1, 1] across.
pub(super) fn boot(along: f64, w: f64, depth: f64) -> Point {
    let arch = 1.0 - w * w;
    let x = -1.62;
    let rear = [x - 0.13 * arch, w * body(plan_of(x), BELT.at(x), 0.0)[1]];
    deck(rear, 3.0 - w.abs(), w, along, 0.05 * (1.0 - along * along) * arch - depth)
}

/// Ruled between a straight edge at the glass and the upper edge of the body at `s`.
fn deck(inner: [f64; 2], s: f64, w: f64, along: f64, lift: f64) -> Point {
    let top = top_of_body(s);
    let outer = body(s, top, 0.0);
    let outer = [outer[0], outer[1] * w.signum()];
    let p = [0, 1].map(|k| inner[k] + (outer[k] - inner[k]) * along);
    let z = BELT.at(inner[0]) + (top - BELT.at(inner[0])) * along;
    let bow = 0.05 * along * (1.0 - along) * (1.0 - w * w);
    [p[0], p[1], z + lift + bow]
}

/// Point and normal (to the left of the way, turned outward) of a cubic Bezier curve.
fn bezier(control: [[f64; 2]; 4], t: f64) -> ([f64; 2], [f64; 2]) {
    let r = 1.0 - t;
    let point = [0, 1].map(|k| {
        let [a, b, c, d] = control.map(|p| p[k]);
        r * r * r * a + 3.0 * r * r * t * b + 3.0 * r * t * t * c + t * t * t * d
    });
    let [dx, dy] = [0, 1].map(|k| {
        let [a, b, c, d] = control.map(|p| p[k]);
        r * r * (b - a) + 2.0 * r * t * (c - b) + t * t * (d - c)
    });
    let norm = (dx * dx + dy * dy).sqrt();
    (point, [dy / norm, -dx / norm])
}
