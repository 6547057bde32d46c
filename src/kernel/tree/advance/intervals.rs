//! All times in contact.

use serde::{Deserialize, Serialize};

use super::{AdvanceError, Advancement, Moving, Outcome};
use crate::geometry::motion::Horizon;

/// How finely contact is followed once it is there, in seconds: finite and above 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Resolution(f64);

/// When meshes are in contact, that is, within the tolerance of each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals {
    /// From entering until leaving, in order. Leaving is known to a millionth of the resolution.
    pub enter_leave_s: Vec<[f64; 2]>,
    /// Less than the whole time only if the search had to end ([`Advancement::with_most`]).
    pub known_until_s: f64,
}

/// That many halvings of the resolution.
const HALVINGS: u32 = 20;

impl Resolution {
    pub fn new(seconds: f64) -> Result<Self, AdvanceError> {
        let is_one = seconds.is_finite() && seconds > 0.0;
        is_one.then_some(Self(seconds)).ok_or(AdvanceError::Resolution(seconds))
    }

    pub fn seconds(self) -> f64 {
        self.0
    }
}

impl TryFrom<f64> for Resolution {
    type Error = AdvanceError;

    fn try_from(seconds: f64) -> Result<Self, AdvanceError> {
        Self::new(seconds)
    }
}

impl From<Resolution> for f64 {
    fn from(resolution: Resolution) -> Self {
        resolution.0
    }
}

impl Advancement {
    /// When the sides are in contact, all entries and leavings.
    ///
    /// Entries are those of [`Advancement::first_impact`], with its proof: no triangles touch before
    /// the first of them, nor from one resolution after any leaving until the next entry. From an entry
    /// on, contact is looked for at times one resolution apart, and goes on until one of them shows
    /// none: gaps between two of those that do are not seen, nor is contact that comes back before
    /// the first that does not.
    pub fn contact_intervals(
        &mut self,
        fixed: &[Moving<'_>],
        moving: &[Moving<'_>],
        horizon: Horizon,
        resolution: Resolution,
    ) -> Result<Intervals, AdvanceError> {
        let (end, step) = (horizon.seconds(), resolution.seconds());
        if step < 1e-6 * end {
            return Err(AdvanceError::TooFine(end));
        }
        let mut scene = self.scene(fixed, moving, horizon)?;
        let mut intervals = Vec::new();
        let mut from = 0.0;
        let known_until_s = loop {
            let enter = match self.search(&mut scene, from, end) {
                Outcome::Apart => break end,
                Outcome::Undecided { earliest_s } => break earliest_s,
                Outcome::Impact(impact) => impact.time_s,
            };
            let (mut inside, mut outside) = (enter, (enter + step).min(end));
            while outside < end && self.touches(&mut scene, outside) {
                (inside, outside) = (outside, (outside + step).min(end));
            }
            if self.touches(&mut scene, outside) {
                intervals.push([enter, end]);
                break end;
            }
            from = outside;
            for _ in 0..HALVINGS {
                let middle = 0.5 * (inside + outside);
                let ahead =
                    if self.touches(&mut scene, middle) { &mut inside } else { &mut outside };
                *ahead = middle;
            }
            intervals.push([enter, inside]);
            if from >= end {
                break end;
            }
        };
        Ok(Intervals { enter_leave_s: intervals, known_until_s })
    }
}
