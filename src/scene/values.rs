//! Numbers of a scene that are valid by construction.

use std::num::{NonZeroU32, NonZeroU64};
use std::str::FromStr;
use std::time::Duration;

use crate::tree::roots::Cut;

/// A number outside what the quantity allows.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{value} is not {quantity}: write a whole number from {min} to {max}")]
pub struct OutOfRange {
    value: String,
    quantity: &'static str,
    min: i64,
    max: i64,
}

/// `value` if it lies in `min..=max`.
pub(super) fn in_range(
    value: i64,
    quantity: &'static str,
    (min, max): (i64, i64),
) -> Result<u32, OutOfRange> {
    let out_of_range = || OutOfRange { value: value.to_string(), quantity, min, max };
    if value < min || value > max {
        return Err(out_of_range());
    }
    u32::try_from(value).map_err(|_| out_of_range())
}

/// As [`in_range`] with 1 as the minimum.
pub(super) fn positive(
    value: i64,
    quantity: &'static str,
    max: i64,
) -> Result<NonZeroU32, OutOfRange> {
    let number = in_range(value, quantity, (1, max))?;
    Ok(NonZeroU32::new(number).expect("the range starts at 1"))
}

/// q: scenarios that fill a buffer.
pub fn buffer_scenarios(value: i64) -> Result<NonZeroU32, OutOfRange> {
    positive(value, "a number of scenarios", 1 << 20)
}

/// V: kilobytes that fill a buffer.
pub fn buffer_kilobytes(value: i64) -> Result<NonZeroU64, OutOfRange> {
    positive(value, "a number of kilobytes", i64::from(u32::MAX)).map(NonZeroU64::from)
}

/// How often another worker is started in the place of one that died.
pub fn restarts(value: i64) -> Result<u32, OutOfRange> {
    in_range(value, "a number of restarts", (0, 100_000))
}

/// How long a worker may answer nothing, in seconds.
pub fn patience(seconds: f64) -> Result<Duration, NotPatience> {
    match Duration::try_from_secs_f64(seconds) {
        Ok(patience) if !patience.is_zero() && seconds <= 1e6 => Ok(patience),
        _ => Err(NotPatience(seconds)),
    }
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0} is not a time to wait: write a number of seconds above 0, up to 1000000")]
pub struct NotPatience(f64);

/// Number of worker processes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkerCount(NonZeroU32);

impl WorkerCount {
    /// Far above the cores of one machine; a guard against a slip of the keyboard that would start
    /// processes until the machine gives up.
    pub const MAX: u32 = 1024;

    pub fn new(value: i64) -> Result<Self, OutOfRange> {
        positive(value, "a number of workers", i64::from(Self::MAX)).map(Self)
    }

    /// The cores that this process may use.
    pub fn of_this_machine() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
        let workers = u32::try_from(cores).unwrap_or(Self::MAX).clamp(1, Self::MAX);
        Self(NonZeroU32::new(workers).expect("clamped to at least 1"))
    }

    pub fn get(self) -> NonZeroU32 {
        self.0
    }
}

impl FromStr for WorkerCount {
    type Err = OutOfRange;

    fn from_str(text: &str) -> Result<Self, OutOfRange> {
        let not_a_number = |_| OutOfRange {
            value: format!("'{text}'"),
            quantity: "a number of workers",
            min: 1,
            max: i64::from(Self::MAX),
        };
        Self::new(text.parse().map_err(not_a_number)?)
    }
}

/// Where a mesh's tree is cut into the subtrees that are handed out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Distribution(Cut);

impl Distribution {
    /// 16 million roots: more than any tree worth cutting has.
    pub const MAX_DEPTH: u32 = 24;

    /// What the paper found best for its heavy fixed vehicle (section 7.3).
    pub const FIXED: Self = Self(Cut::Depth(12));

    /// What the paper used for its moving car (section 7.3).
    pub const MOVING: Self = Self(Cut::Depth(6));

    /// d of the paper; 0 is the whole tree.
    pub fn at_depth(value: i64) -> Result<Self, OutOfRange> {
        let depth = in_range(value, "a tree depth", (0, i64::from(Self::MAX_DEPTH)))?;
        Ok(Self(Cut::Depth(depth)))
    }

    /// As few subtrees as there can be of at most so many triangles.
    pub fn by_triangles(value: i64) -> Result<Self, OutOfRange> {
        let most = positive(value, "a number of triangles", i64::from(u32::MAX))?;
        Ok(Self(Cut::Triangles(most.get())))
    }

    pub fn cut(self) -> Cut {
        self.0
    }
}

/// Range of depths, in metres, by which the moving mesh is pushed on after its first contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    min: f64,
    max: f64,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "[{min}, {max}] is not a range of depths: write two finite numbers of metres, the smaller \
     first, neither negative"
)]
pub struct NotARange {
    min: f64,
    max: f64,
}

impl Penetration {
    /// Small to middle penetrations, as in section 7 of the paper: 5 mm to 300 mm.
    pub const PAPER: Self = Self { min: 0.005, max: 0.3 };

    pub fn new([min, max]: [f64; 2]) -> Result<Self, NotARange> {
        let valid = min >= 0.0 && min <= max && max.is_finite();
        if valid { Ok(Self { min, max }) } else { Err(NotARange { min, max }) }
    }

    pub fn min(self) -> f64 {
        self.min
    }

    pub fn max(self) -> f64 {
        self.max
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_workers_are_refused_and_one_is_not() {
        assert!(WorkerCount::new(0).is_err());
        assert!(WorkerCount::new(-1).is_err());
        assert!(WorkerCount::new(1 << 40).is_err());
        assert_eq!(WorkerCount::new(1).unwrap().get().get(), 1);
        assert!("two".parse::<WorkerCount>().unwrap_err().to_string().contains("'two'"));
    }

    #[test]
    fn a_penetration_is_an_ordered_finite_range() {
        for bad in [[0.3, 0.1], [-0.1, 0.1], [f64::NAN, 0.1], [0.1, f64::NAN], [0.0, f64::INFINITY]]
        {
            assert!(Penetration::new(bad).is_err(), "{bad:?}");
        }
        assert!(Penetration::new([0.0, 0.0]).is_ok());
    }
}
