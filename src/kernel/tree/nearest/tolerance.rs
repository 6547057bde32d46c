/// How much above the true smallest distance the reported one may be: the larger of both parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Parts", into = "Parts")]
pub struct Tolerance {
    absolute_m: f64,
    relative: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotATolerance {
    #[error("an absolute tolerance of {0} m: give a length that is not negative")]
    Absolute(f64),
    #[error("a relative tolerance of {0}: give a part of the distance, at least 0 and below 1")]
    Relative(f64),
}

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Parts {
    #[serde(default)]
    absolute_m: f64,
    #[serde(default)]
    relative: f64,
}

impl Tolerance {
    /// Only what rounding makes of a distance.
    pub const NONE: Self = Self { absolute_m: 0.0, relative: 0.0 };

    /// `absolute_m` in metres; `relative` as a part of the distance that is reported.
    pub fn new(absolute_m: f64, relative: f64) -> Result<Self, NotATolerance> {
        if !(absolute_m >= 0.0 && absolute_m.is_finite()) {
            return Err(NotATolerance::Absolute(absolute_m));
        }
        if !(0.0..1.0).contains(&relative) {
            return Err(NotATolerance::Relative(relative));
        }
        Ok(Self { absolute_m, relative })
    }

    /// At this distance, metres.
    pub fn at(&self, distance_m: f64) -> f64 {
        self.absolute_m.max(self.relative * distance_m)
    }
}

impl TryFrom<Parts> for Tolerance {
    type Error = NotATolerance;

    fn try_from(parts: Parts) -> Result<Self, NotATolerance> {
        Self::new(parts.absolute_m, parts.relative)
    }
}

impl From<Tolerance> for Parts {
    fn from(Tolerance { absolute_m, relative }: Tolerance) -> Self {
        Self { absolute_m, relative }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerance_is_checked_wherever_it_comes_from() {
        let absolute = |bad| Tolerance::new(bad, 0.0).unwrap_err().to_string();
        assert!(absolute(-1.0).contains("-1 m") && absolute(f64::NAN).contains("NaN m"));
        assert_eq!(Tolerance::new(0.0, 1.0), Err(NotATolerance::Relative(1.0)));
        let written = serde_json::to_string(&Tolerance::new(0.001, 0.25).unwrap()).unwrap();
        assert_eq!(serde_json::from_str(&written).ok(), Tolerance::new(0.001, 0.25).ok());
        assert_eq!(
            serde_json::from_str(r#"{"relative": 0.5}"#).ok(),
            Tolerance::new(0.0, 0.5).ok()
        );
        let refused = serde_json::from_str::<Tolerance>(r#"{"relative": 2.0}"#).unwrap_err();
        assert!(refused.to_string().contains("a relative tolerance of 2"));
    }

    #[test]
    fn larger_part_counts() {
        let tolerance = Tolerance::new(0.01, 0.1).unwrap();
        assert_eq!([0.0, 0.05, 1.0].map(|d| tolerance.at(d)), [0.01, 0.01, 0.1]);
    }
}
