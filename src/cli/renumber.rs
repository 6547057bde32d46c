//! Runs of some of the scenarios, whose numbers are not those of the run.

use std::io;

use crate::scheduler::client_manager::{EngineError, ResultSink, ScenarioResult};

/// Hands results on under the numbers that the whole has for them.
pub(super) struct Renumbered<'a> {
    pub sink: &'a mut dyn ResultSink,
    pub number: &'a dyn Fn(u32) -> u32,
}

impl ResultSink for Renumbered<'_> {
    fn accept(&mut self, result: ScenarioResult<'_>) -> io::Result<()> {
        let scenario = (self.number)(result.scenario);
        self.sink.accept(ScenarioResult { scenario, ..result })
    }

    fn set_aside(&mut self, scenario: u32) -> io::Result<()> {
        self.sink.set_aside((self.number)(scenario))
    }
}

/// An error of such a run, with `earlier` scenarios answered before it.
pub(super) fn renumbered(
    error: EngineError,
    number: &dyn Fn(u32) -> u32,
    earlier: u32,
) -> EngineError {
    match error {
        EngineError::Overflow { scenario, triangle, corner } => {
            EngineError::Overflow { scenario: number(scenario), triangle, corner }
        }
        EngineError::AllWorkersDied { completed, last } => {
            EngineError::AllWorkersDied { completed: earlier + completed, last }
        }
        other => other,
    }
}
