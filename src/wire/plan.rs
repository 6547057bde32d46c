//! A plan of effects as bytes. It goes to each worker once a run, so it is text.

use serde::{Deserialize, Serialize};

use super::WireError;
use crate::effects::Plan;

/// A plan, and by which numbers its worker knows the trees that are neither the fixed nor the moving
/// one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanMessage {
    pub plan: Plan,
    pub parts: Vec<u32>,
}

impl PlanMessage {
    pub fn to_bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).expect("string keys and finite numbers")
    }

    pub fn parse(bytes: &[u8]) -> Result<Self, WireError> {
        serde_json::from_slice(bytes).map_err(|error| WireError::Plan(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::effects::{Ranges, Step};

    fn message() -> PlanMessage {
        let ranges = |first, last| Ranges::new(vec![[first, last]]).unwrap();
        let plan = Plan { ignore: vec![[ranges(0, 3), ranges(7, 9)]], steps: vec![Step::Segments] };
        PlanMessage { plan, parts: vec![3, 4] }
    }

    #[test]
    fn a_plan_is_read_as_it_was_written() {
        assert_eq!(PlanMessage::parse(&message().to_bytes()), Ok(message()));
    }

    proptest! {
        #[test]
        fn damaged_plans_are_read_or_refused(at in 0_usize..500, byte: u8, length in 0_usize..500) {
            let mut bytes = message().to_bytes();
            let count = bytes.len();
            bytes[at % count] = byte;
            let _ = PlanMessage::parse(&bytes[..length.min(count)]);
        }
    }
}
