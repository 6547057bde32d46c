//! Bounds on how far points get: an instant of a trajectory, and what holds from then until a later
//! one.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::Pose;

/// A trajectory at an instant, with bounds that hold until a later one.
#[derive(Clone, Debug)]
pub struct Span {
    pub(super) pose: Pose,
    pub(super) duration: f64,
    pub(super) cg: Vector3<f64>,
    pub(super) velocity: Vector3<f64>,
    pub(super) acceleration: Vector3<f64>,
    pub(super) spin: Vector3<f64>,
    pub(super) fastest_spin: f64,
    pub(super) spin_change: f64,
    /// Mesh axes to world axes, the part's motion not in it.
    pub(super) body: Matrix3<f64>,
    /// Bound on how much longer the start's rotation makes a vector.
    pub(super) stretch: f64,
    pub(super) part: Option<PartState>,
}

/// Mesh axes.
#[derive(Clone, Debug)]
pub(super) struct PartState {
    pub rotation: Matrix3<f64>,
    pub offset: Vector3<f64>,
    /// A point of the axis, at the start and now.
    pub pivot: Vector3<f64>,
    pub pivot_now: Vector3<f64>,
    pub axis: Vector3<f64>,
    pub rate: f64,
    pub fastest_turn: f64,
    pub turn_change: f64,
    pub velocity: Vector3<f64>,
    pub fastest_slide: f64,
    pub slide_change: f64,
}

/// Points of a mesh within a radius of one of them, as a trajectory carries them.
#[derive(Clone, Copy, Debug)]
pub struct Carried {
    /// Where the point is, and its velocity.
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    /// Of the other points within the radius no velocity differs more from that, m/s.
    pub spread: f64,
    /// Over the span, no velocity differs more from that of the centre of gravity, m/s.
    pub whirl: f64,
    /// Over the span, no acceleration differs more from that of the centre of gravity, m/s².
    pub bend: f64,
    cg_velocity: Vector3<f64>,
    cg_acceleration: Vector3<f64>,
}

/// Within `t` of the span's start the points get at most `speed t + acceleration t^2 / 2` further
/// along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    pub speed: f64,
    pub acceleration: f64,
}

/// More than the roundings of a bound can take from it.
const UP: f64 = 1.0 + 1.0 / (1_u64 << 40) as f64;
const ROUNDING: f64 = 1.0 / (1_u64 << 48) as f64;

impl Span {
    /// Mesh axes to world axes at the start of the span.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    pub fn duration_s(&self) -> f64 {
        self.duration
    }

    /// The points within `radius` metres of one of the mesh, all in mesh axes.
    pub fn carry(&self, center: &Vector3<f64>, radius: f64) -> Carried {
        let position = Vector3::from(self.pose.apply((*center).into()));
        let lever = position - self.cg;
        let mut velocity = self.velocity + self.spin.cross(&lever);
        let mut turning = self.spin.norm();
        // Of points of the part in the mesh: how far they get, how fast, and how that changes.
        let (mut shift, mut slip, mut slip_change) = (0.0, 0.0, 0.0);
        if let Some(part) = &self.part {
            velocity += self.body * part.velocity_of(center);
            turning += part.rate.abs();
            let arm = part.axis.cross(&(center - part.pivot)).norm() + radius;
            slip = self.stretch * (part.fastest_turn * arm + part.fastest_slide);
            let turned = (part.fastest_turn * self.duration).min(2.0);
            shift = self.stretch * (turned * arm + part.fastest_slide * self.duration);
            let swing = part.turn_change + part.fastest_turn * part.fastest_turn;
            slip_change = self.stretch * (swing * arm + part.slide_change);
        }
        let arm = lever.norm() + self.stretch * radius + shift;
        let spin = self.fastest_spin;
        let bend = (self.spin_change + spin * spin) * arm + 2.0 * spin * slip + slip_change;
        Carried {
            position,
            velocity,
            spread: self.stretch * radius * turning * UP,
            whirl: (spin * arm + slip) * UP,
            bend: bend * UP,
            cg_velocity: self.velocity,
            cg_acceleration: self.acceleration,
        }
    }

    /// Bound on the speed of the points within `radius` of one of the mesh, over the span.
    pub fn speed(&self, center: &Vector3<f64>, radius: f64) -> f64 {
        let at_end = self.velocity + self.acceleration * self.duration;
        let of_cg = self.velocity.norm().max(at_end.norm());
        (of_cg + self.carry(center, radius).whirl) * UP
    }

    /// The same of their speed along a direction of unit length; below zero for points that only go
    /// the other way.
    pub fn speed_along(&self, direction: &Vector3<f64>, center: &Vector3<f64>, radius: f64) -> f64 {
        let growths = self.carry(center, radius).growth(direction);
        let largest = growths.map(|g| g.speed.max(g.speed + g.acceleration * self.duration));
        let [first, second] = largest;
        let least = first.min(second);
        least + least.abs() * ROUNDING
    }
}

impl PartState {
    /// Of a point given where it is at time 0.
    fn velocity_of(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let lever = self.rotation * point + self.offset - self.pivot_now;
        self.axis.cross(&lever) * self.rate + self.velocity
    }
}

impl Carried {
    /// Two bounds that both hold, along a direction of unit length: the first good for times that are
    /// short beside a turn of the body, the second for long ones.
    pub fn growth(&self, direction: &Vector3<f64>) -> [Growth; 2] {
        let along = |v: &Vector3<f64>| v.dot(direction) + ROUNDING * v.abs().sum();
        let acceleration = along(&self.cg_acceleration);
        [
            Growth {
                speed: along(&self.velocity) + self.spread,
                acceleration: acceleration + self.bend,
            },
            Growth { speed: along(&self.cg_velocity) + self.whirl, acceleration },
        ]
    }
}

/// A lower bound on when `speed t + acceleration t^2 / 2` first is `gap`: infinite if it certainly
/// never is, 0 for a gap that is not above 0.
pub fn earliest_crossing(gap: f64, speed: f64, acceleration: f64) -> f64 {
    if gap.is_nan() || gap <= 0.0 {
        return 0.0;
    }
    let products = [speed * speed, 2.0 * acceleration * gap];
    // Never below the true one: then what is subtracted from is not too small, or it divides.
    let discriminant = products[0] + products[1] + ROUNDING * (products[0] + products[1].abs());
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    let root = discriminant.sqrt();
    let time = if speed > 0.0 {
        2.0 * gap / (speed + root)
    } else if acceleration > 0.0 {
        // No cancellation, and so the error of the root is a relative one.
        (root - speed) / acceleration
    } else {
        f64::INFINITY
    };
    time * (1.0 - 4.0 * ROUNDING)
}
