//! Random numbers, poses and triangles that are the same on every machine.

use bumper::geometry::{Point, Pose, Triangle};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

pub struct Random(ChaCha8Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// In [-1, 1).
    pub fn number(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn word(&mut self) -> u32 {
        self.0.next_u32()
    }

    pub fn below(&mut self, n: u32) -> u32 {
        self.word() % n
    }

    pub fn point(&mut self) -> Point {
        [(); 3].map(|()| self.number())
    }

    /// Shifted by no more than this along each axis.
    pub fn pose(&mut self, away: f64) -> Pose {
        let q = [(); 4].map(|()| self.number());
        let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        Pose::from_quaternion(q.map(|c| c / length), self.point().map(|c| away * c))
    }

    /// Corners on a coarse grid: coincident, coplanar, touching, collinear and equal ones abound, as
    /// do pairs at equal distances.
    pub fn on_grid(&mut self, count: usize, cells: u32) -> Vec<Triangle> {
        let corner = |random: &mut Self| [(); 3].map(|()| f64::from(random.below(cells)) * 0.25);
        (0..count).map(|_| [(); 3].map(|()| corner(self))).collect()
    }
}
