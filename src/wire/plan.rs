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
        let refused = |error: &dyn std::fmt::Display| WireError::Plan(error.to_string());
        let message: Self = serde_json::from_slice(bytes).map_err(|error| refused(&error))?;
        let (needed, found) = (message.plan.part_count(), message.parts.len());
        if needed != found {
            return Err(refused(&format_args!("it needs {needed} more trees and names {found}")));
        }
        Ok(message)
    }
}

#[cfg(test)]
mod tests;
