use super::seeds::{seeds, spread_over_sphere};
use super::{Bodies, Direction, Penetration, PenetrationError, View, last_exit};
use crate::effects::contacts::sort;
use crate::geometry::{Point, Pose};
use crate::tree::descent::Pair;

/// How long to search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Effort {
    /// Directions spread over the sphere, tried after those that the contacts suggest. More never
    /// make the result longer.
    pub directions: u32,
}

impl Default for Effort {
    fn default() -> Self {
        Self { directions: 128 }
    }
}

/// An upper bound on the least translation out of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastTranslation {
    /// Moved by this, nothing touches nor is inside; m.
    pub translation: Point,
    /// Its length, m.
    pub length: f64,
    /// Poses that were asked about.
    pub queries: u32,
}

impl Penetration {
    /// The shortest translation of the moving mesh out of contact among those that were tried, each
    /// along one direction to the first place where nothing touches and no part is inside. The same
    /// every time.
    ///
    /// A direction is given up as soon as a contact on its way lasts beyond the best so far, most by
    /// the contacts of the first pose; from each better one found, directions round it are tried,
    /// nearer and nearer (pattern search, Hooke & Jeeves 1961).
    pub fn least_translation<B: Bodies>(
        &mut self,
        bodies: &mut B,
        pose: &Pose,
        effort: Effort,
    ) -> Result<LeastTranslation, PenetrationError<B::Error>> {
        let mut first = std::mem::take(&mut self.first_pairs);
        first.clear();
        let found = bodies.pairs(pose, &mut first).and_then(|()| {
            sort(&mut first);
            let seeds = seeds(bodies, pose, &first);
            let mut search =
                Search { depths: self, bodies, pose, first: &mut first, queries: 1, best: None };
            seeds.into_iter().try_for_each(|seed| search.consider(&seed).map(drop))?;
            search.refine()?;
            for index in 0..effort.directions {
                if search.consider(&spread_over_sphere(index))? {
                    search.refine()?;
                }
            }
            Ok(search.found())
        });
        self.first_pairs = first;
        found?.ok_or(PenetrationError::TooFar)
    }
}

struct Search<'a, B> {
    depths: &'a mut Penetration,
    bodies: &'a mut B,
    pose: &'a Pose,
    /// Pairs of the pose without translation.
    first: &'a mut [Pair],
    queries: u32,
    best: Option<(Direction, f64)>,
}

impl<B: Bodies> Search<'_, B> {
    /// Whether the direction is better than all before it.
    fn consider(&mut self, direction: &Direction) -> Result<bool, B::Error> {
        let limit = self.best.map_or(f64::INFINITY, |(_, length)| length);
        let view = View::along(direction);
        let lasts = |search: &mut Self| {
            last_exit(search.bodies, search.pose, &view, search.first, limit) >= limit
        };
        if limit == 0.0 || lasts(self) {
            return Ok(false);
        }
        let Self { depths, bodies, pose, queries, .. } = self;
        let depth = depths.depth_below(*bodies, pose, direction, limit, queries)?;
        self.best = depth.map(|[_, free_at]| (*direction, free_at)).or(self.best);
        Ok(depth.is_some())
    }

    /// Tries directions round the best one.
    fn refine(&mut self) -> Result<(), B::Error> {
        const WIDEST: f64 = 0.3;
        const NARROWEST: f64 = 1e-4;
        const WORTHWHILE: f64 = 1.0 - 1e-6;
        let mut angle = WIDEST;
        while angle > NARROWEST {
            let Some((direction, length)) = self.best else { return Ok(()) };
            let [u, v] = direction.across();
            for (x, y) in [(1.0, 0.0), (-0.5, 0.75_f64.sqrt()), (-0.5, -0.75_f64.sqrt())] {
                for side in [angle, -angle] {
                    let turned = direction.vector() + side * (x * u + y * v);
                    let Some(turned) = Direction::of(turned) else { continue };
                    self.consider(&turned)?;
                }
            }
            let is_better = self.best.is_some_and(|(_, now)| now < length * WORTHWHILE);
            angle *= if is_better { 1.0 } else { 0.5 };
        }
        Ok(())
    }

    fn found(&self) -> Option<LeastTranslation> {
        let (direction, length) = self.best?;
        let translation = (direction.vector() * length).into();
        Some(LeastTranslation { translation, length, queries: self.queries })
    }
}
