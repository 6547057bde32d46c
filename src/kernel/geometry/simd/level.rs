use std::sync::OnceLock;

/// Which instructions the kernel uses; all give the same pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SimdLevel {
    Portable,
    Avx2,
    Avx512,
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SimdError {
    #[error("BUMPER_SIMD is {0:?}: give portable, avx2 or avx512, or leave it out")]
    Unknown(String),
    #[error("BUMPER_SIMD asks for {0}, which this processor does not have")]
    Missing(SimdLevel),
}

impl std::fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        })
    }
}

impl std::str::FromStr for SimdLevel {
    type Err = SimdError;

    fn from_str(text: &str) -> Result<Self, SimdError> {
        [Self::Portable, Self::Avx2, Self::Avx512]
            .into_iter()
            .find(|level| level.to_string() == text)
            .ok_or_else(|| SimdError::Unknown(text.to_owned()))
    }
}

impl SimdLevel {
    /// Those that this processor has, the slowest first.
    pub fn available() -> Vec<Self> {
        [Self::Portable, Self::Avx2, Self::Avx512].into_iter().filter(|l| l.is_here()).collect()
    }

    /// What the environment variable `BUMPER_SIMD` asks for, or else the best one there is.
    pub fn from_environment() -> Result<Self, SimdError> {
        match std::env::var_os("BUMPER_SIMD") {
            Some(text) => {
                let level: Self = text.to_string_lossy().parse()?;
                if level.is_here() { Ok(level) } else { Err(SimdError::Missing(level)) }
            }
            None => Ok(Self::best()),
        }
    }

    /// As [`SimdLevel::from_environment`], asked once. A variable that cannot be followed is
    /// reported and otherwise ignored: every level gives the same answers.
    pub fn chosen() -> Self {
        static CHOSEN: OnceLock<SimdLevel> = OnceLock::new();
        *CHOSEN.get_or_init(|| {
            Self::from_environment().unwrap_or_else(|error| {
                let best = Self::best();
                tracing::warn!("{error}; using {best}");
                best
            })
        })
    }

    fn best() -> Self {
        Self::available().pop().unwrap_or(Self::Portable)
    }

    #[cfg(target_arch = "x86_64")]
    pub(super) fn is_here(self) -> bool {
        let avx2 = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("popcnt");
        let avx512 = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512vl");
        match self {
            Self::Portable => true,
            Self::Avx2 => avx2,
            Self::Avx512 => avx2 && avx512,
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    pub(super) fn is_here(self) -> bool {
        self == Self::Portable
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_named_as_the_variable_wants_them() {
        for level in [SimdLevel::Portable, SimdLevel::Avx2, SimdLevel::Avx512] {
            assert_eq!(level.to_string().parse(), Ok(level));
        }
        assert_eq!("sse9".parse::<SimdLevel>(), Err(SimdError::Unknown("sse9".into())));
        assert!(SimdLevel::available().contains(&SimdLevel::Portable));
    }
}
