//! The search for the earliest contact: a queue of pairs of places by the time until which each is
//! proven to be apart.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::Vector3;

use super::boxes::{BoxTree, Spot};
use super::shape::{Margin, Separation, Shape, unit};
use super::{AdvanceError, Advancement, Impact, Moving, Outcome, Tolerance, Work};
use crate::geometry::distance::{Nearest, triangle_distance};
use crate::geometry::motion::{Horizon, Rounding, Span, Trajectory};

/// Two places that are apart until a time.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    time: f64,
    /// The larger of both; earlier if it is small, so that one of two contacts at a time is found
    /// without looking for the other.
    size: f64,
    /// A tree of the fixed side, and one of the moving side.
    bodies: [u32; 2],
    spots: [Spot; 2],
    next: Next,
}

/// What is done when an entry's time comes.
#[derive(Clone, Copy, Debug)]
enum Next {
    /// The places were far from each other: see how far they are then.
    Advance,
    /// Goes to the children of the one on this side.
    Open(usize),
    /// They are triangles.
    Touch,
}

/// Boxes are opened when their distance is below so much of the larger one's size.
const NEAR: f64 = 0.25;

struct Body<'q> {
    boxes: BoxTree<'q>,
    trajectory: &'q Trajectory,
    /// The trajectory from when it was last asked for until the end.
    span: Span,
    from: f64,
    rounding: Rounding,
}

/// What takes part in a query.
pub struct Scene<'q> {
    sides: [Vec<Body<'q>>; 2],
    children: Vec<Spot>,
    /// What counts as contact, in metres.
    tolerance: f64,
    rounding: f64,
    margin: Margin,
    to: f64,
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Entry {}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Entry {
    /// The greatest comes first: the earliest, and then a total order, so that every run is alike.
    fn cmp(&self, other: &Self) -> Ordering {
        let by_time = other.time.total_cmp(&self.time);
        let by_size = || other.size.total_cmp(&self.size);
        let by_place = || (other.bodies, other.spots).cmp(&(self.bodies, self.spots));
        by_time.then_with(by_size).then_with(by_place)
    }
}

/// Entries that a queue keeps room for after a search that had more.
const KEPT: usize = 1 << 16;

impl Advancement {
    /// The first impact from a time on until another.
    pub(super) fn search(&mut self, scene: &mut Scene<'_>, from: f64, to: f64) -> Outcome {
        // At half the tolerance: then there is a direction between what has met.
        scene.look_until(to, 0.5 * scene.tolerance);
        Self::run(&mut self.queue, &mut self.work, scene, from, self.most_bounds)
    }

    /// Whether anything is within the tolerance at a time.
    pub(super) fn touches(&mut self, scene: &mut Scene<'_>, at: f64) -> bool {
        scene.look_until(at, scene.tolerance + scene.rounding);
        let found = Self::run(&mut self.queue, &mut self.work, scene, at, u64::MAX);
        matches!(found, Outcome::Impact(_))
    }

    fn run(
        queue: &mut BinaryHeap<Entry>,
        work: &mut Work,
        scene: &mut Scene<'_>,
        from: f64,
        most_bounds: u64,
    ) -> Outcome {
        queue.clear();
        queue.shrink_to(KEPT);
        let [fixed, moving] = [0, 1].map(|side| scene.sides[side].len() as u32);
        for bodies in (0..fixed).flat_map(|a| (0..moving).map(move |b| [a, b])) {
            let spots = scene.bodies(bodies).map(|body| body.boxes.top());
            let before = queue.len();
            scene.push(queue, work, Place { bodies, spots, time: from });
            work.swept_apart += u64::from(queue.len() == before);
        }
        while let Some(entry) = queue.pop() {
            if work.bounds >= most_bounds {
                return Outcome::Undecided { earliest_s: entry.time };
            }
            let Entry { bodies, spots, time, .. } = entry;
            let place = Place { bodies, spots, time };
            match entry.next {
                Next::Advance => scene.push(queue, work, place),
                Next::Open(side) => scene.open(queue, work, place, side),
                Next::Touch => {
                    if let Some(impact) = scene.touch(queue, work, place) {
                        return Outcome::Impact(impact);
                    }
                }
            }
        }
        Outcome::Apart
    }
}

/// Where two trees are compared, and when.
#[derive(Clone, Copy)]
struct Place {
    bodies: [u32; 2],
    spots: [Spot; 2],
    time: f64,
}

impl<'q> Scene<'q> {
    pub fn new(
        fixed: &[Moving<'q>],
        moving: &[Moving<'q>],
        horizon: Horizon,
        tolerance: Tolerance,
    ) -> Result<Self, AdvanceError> {
        let side = |name, side: &[Moving<'q>]| {
            let body = |(tree, moving): (usize, &Moving<'q>)| {
                Body::new(moving, horizon).map_err(|source| AdvanceError::Motion {
                    side: name,
                    tree,
                    source,
                })
            };
            side.iter().enumerate().map(body).collect::<Result<Vec<_>, _>>()
        };
        let sides = [side("fixed", fixed)?, side("moving", moving)?];
        let worst = |of: fn(&Rounding) -> f64| -> f64 {
            let of_side = |side: &Vec<Body<'q>>| {
                side.iter().map(|body| of(&body.rounding)).fold(0.0, f64::max)
            };
            sides.iter().map(of_side).sum()
        };
        let rounding = worst(|rounding| rounding.position_m);
        let margin = Margin { gap_m: rounding, speed_m_s: worst(|rounding| rounding.speed_m_s) };
        // Shorter distances have squares that underflow.
        let tolerance = tolerance.metres().max(4.0 * rounding).max(1e-100);
        let to = horizon.seconds();
        Ok(Self { sides, children: Vec::new(), tolerance, rounding, margin, to })
    }

    fn look_until(&mut self, to: f64, gap_m: f64) {
        self.to = to;
        self.margin.gap_m = gap_m;
        for body in self.sides.iter_mut().flatten() {
            body.from = f64::NAN;
        }
    }

    fn bodies(&self, [a, b]: [u32; 2]) -> [&Body<'q>; 2] {
        [&self.sides[0][a as usize], &self.sides[1][b as usize]]
    }

    /// A place of one side, at a time.
    fn shape(&mut self, side: usize, place: &Place) -> Shape {
        let body = &mut self.sides[side][place.bodies[side] as usize];
        if body.from != place.time {
            body.span = body.trajectory.span(place.time, self.to);
            body.from = place.time;
        }
        match place.spots[side] {
            Spot::Triangle(rank) => {
                Shape::of_triangle(&body.boxes.tree().corners(rank), &body.span)
            }
            spot => {
                let bounds = body.boxes.bounds(spot).expect("only triangles have no box");
                Shape::of_box(&bounds, &body.span)
            }
        }
    }

    fn push(&mut self, queue: &mut BinaryHeap<Entry>, work: &mut Work, place: Place) {
        let shapes = [self.shape(0, &place), self.shape(1, &place)];
        self.push_shapes(queue, work, place, [&shapes[0], &shapes[1]]);
    }

    fn push_shapes(
        &self,
        queue: &mut BinaryHeap<Entry>,
        work: &mut Work,
        place: Place,
        [a, b]: [&Shape; 2],
    ) {
        work.bounds += 1;
        let separation = a.separation(b, None, self.margin);
        let Some(time) = self.next_time(&place, &separation) else { return };
        let size = a.size.max(b.size);
        let next = match place.spots {
            [Spot::Triangle(_), Spot::Triangle(_)] => Next::Touch,
            _ if separation.gap > NEAR * size && time > place.time => Next::Advance,
            [Spot::Triangle(_), _] => Next::Open(1),
            [_, Spot::Triangle(_)] => Next::Open(0),
            _ => Next::Open(usize::from(b.size > a.size)),
        };
        let Place { bodies, spots, .. } = place;
        queue.push(Entry { time, size, bodies, spots, next });
    }

    /// When places may be in contact, if that is before the end.
    fn next_time(&self, place: &Place, separation: &Separation) -> Option<f64> {
        let time = later(place.time, separation.time);
        // Apart at the end itself, by less than a step of the time.
        let is_over = time > self.to || place.time >= self.to && separation.time > 0.0;
        (!is_over).then_some(time)
    }

    fn open(&mut self, queue: &mut BinaryHeap<Entry>, work: &mut Work, place: Place, side: usize) {
        let other = self.shape(1 - side, &place);
        let mut children = std::mem::take(&mut self.children);
        self.bodies(place.bodies)[side].boxes.children(place.spots[side], &mut children);
        for &child in &children {
            let mut place = place;
            place.spots[side] = child;
            let opened = self.shape(side, &place);
            let shapes = if side == 0 { [&opened, &other] } else { [&other, &opened] };
            self.push_shapes(queue, work, place, shapes);
        }
        self.children = children;
    }

    /// Two triangles at the time until which they are apart: their contact, or a later time.
    fn touch(
        &mut self,
        queue: &mut BinaryHeap<Entry>,
        work: &mut Work,
        place: Place,
    ) -> Option<Impact> {
        let [a, b] = [self.shape(0, &place), self.shape(1, &place)];
        work.distances += 1;
        let nearest = triangle_distance(&a.corners(), &b.corners());
        if nearest.distance <= self.tolerance {
            return Some(self.impact(&place, &nearest, [&a, &b]));
        }
        let [p, q] = nearest.points.map(Vector3::from);
        work.bounds += 1;
        let separation = a.separation(&b, Some(unit(q - p)), self.margin);
        let time = self.next_time(&place, &separation)?;
        if time <= place.time {
            // Never where the tolerance is above rounding; it would go on like this.
            return Some(self.impact(&place, &nearest, [&a, &b]));
        }
        let Place { bodies, spots, .. } = place;
        queue.push(Entry { time, size: 0.0, bodies, spots, next: Next::Touch });
        None
    }

    fn impact(&self, place: &Place, nearest: &Nearest, [a, b]: [&Shape; 2]) -> Impact {
        let bodies = self.bodies(place.bodies);
        let id = |side: usize| match place.spots[side] {
            Spot::Triangle(rank) => bodies[side].boxes.tree().triangles()[rank as usize].id,
            _ => unreachable!("triangles touch"),
        };
        let [p, q] = nearest.points.map(Vector3::from);
        let normal = if nearest.distance > self.rounding { unit(q - p) } else { face_normal(a, b) };
        Impact {
            time_s: place.time,
            distance_m: nearest.distance,
            trees: place.bodies.map(|body| body as usize),
            pair: [id(0), id(1)],
            points: nearest.points,
            normal: normal.into(),
        }
    }
}

/// That of a triangle, or against the motion, or any: from the first to the second as far as can be
/// told.
fn face_normal(a: &Shape, b: &Shape) -> Vector3<f64> {
    let away = unit(a.mean_velocity() - b.mean_velocity());
    let towards = if away == Vector3::zeros() { unit(b.middle() - a.middle()) } else { away };
    let candidates = [a.normal(), b.normal(), towards, Vector3::x()];
    let found = candidates.into_iter().find(|n| *n != Vector3::zeros());
    let normal = found.unwrap_or_else(Vector3::x);
    if normal.dot(&towards) < 0.0 { -normal } else { normal }
}

/// The sum, and nothing above it.
fn later(time: f64, by: f64) -> f64 {
    let sum = time + by;
    if by > 0.0 && sum.is_finite() { sum.next_down().max(time) } else { sum }
}

impl<'q> Body<'q> {
    fn new(
        moving: &Moving<'q>,
        horizon: Horizon,
    ) -> Result<Self, crate::geometry::motion::MotionError> {
        let boxes = BoxTree::new(*moving.tree);
        let trajectory = moving.trajectory;
        let rounding = trajectory.rounding(boxes.reach(), horizon)?;
        let span = trajectory.span(0.0, horizon.seconds());
        Ok(Self { boxes, trajectory, span, from: f64::NAN, rounding })
    }
}
