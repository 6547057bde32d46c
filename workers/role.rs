//! What a worker is for.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

use super::WorkerError;
use crate::scene::Slowdown;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// Answers scenarios.
    Compute(Slowdown),
    /// Says when it has got what it was handed, on this core if there is such a one.
    Echo { core: usize },
}

/// As the argument of a worker process.
impl Display for Role {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Compute(slowdown) => write!(f, "compute:{slowdown}"),
            Self::Echo { core } => write!(f, "echo:{core}"),
        }
    }
}

impl FromStr for Role {
    type Err = WorkerError;

    fn from_str(text: &str) -> Result<Self, WorkerError> {
        let (role, value) = text.split_once(':').ok_or(WorkerError::Usage)?;
        match role {
            "compute" => Ok(Self::Compute(value.parse().map_err(|_| WorkerError::Usage)?)),
            "echo" => Ok(Self::Echo { core: value.parse().map_err(|_| WorkerError::Usage)? }),
            _ => Err(WorkerError::Usage),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_role_is_read_as_it_was_written() {
        let slow = Slowdown::new(2.5).unwrap();
        for role in [Role::Compute(Slowdown::NONE), Role::Compute(slow), Role::Echo { core: 1 }] {
            assert_eq!(role.to_string().parse::<Role>().unwrap(), role);
        }
        for wrong in ["", "compute", "compute:0.5", "echo:x", "sing:1"] {
            assert!(wrong.parse::<Role>().is_err(), "{wrong}");
        }
    }
}
