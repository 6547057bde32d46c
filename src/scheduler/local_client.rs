//! The master's proxy of one worker (section 6.4.3 of the paper).

use std::collections::VecDeque;

use super::indicator::{ClientIndicator, TreeIndicator};
use super::matchmaker::Candidate;

/// Tasks a client may have before it is claimed. The paper's is one; with two, a worker finds the
/// next task waiting when it has answered one, instead of sleeping until the master has woken up
/// and filled a buffer. [`crate::transport::QUEUED_JOBS`] has room for them.
pub const OUTSTANDING_TASKS: usize = 2;

/// The indicators of one scenario: of the fixed and of the moving tree.
pub type Indicators = [TreeIndicator; 2];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Starting,
    Ready,
    Dead,
}

/// A batch that was sent and is not answered in full.
#[derive(Debug)]
struct Task {
    number: u64,
    /// Ascending.
    unanswered: Vec<u32>,
}

/// What a worker said and could not have said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unexpected {
    #[error("it answers task {found}, but is at task {expected:?}")]
    Task { found: u64, expected: Option<u64> },
    #[error("it answers scenario {0}, which it was not given or has answered before")]
    Scenario(u32),
    #[error("it ends task {task} without an answer to scenario {scenario}")]
    Unanswered { task: u64, scenario: u32 },
    #[error("it says for the second time that it is ready")]
    Ready,
}

#[derive(Debug)]
pub struct LocalClient {
    state: State,
    /// Scenarios for the next task.
    buffer: Vec<u32>,
    /// Oldest first, which is the order of the answers.
    tasks: VecDeque<Task>,
    /// Distributed roots the worker was given: of the fixed and of the moving tree.
    given: [ClientIndicator; 2],
}

impl Default for LocalClient {
    fn default() -> Self {
        let state = State::Starting;
        Self { state, buffer: Vec::new(), tasks: VecDeque::new(), given: Default::default() }
    }
}

impl LocalClient {
    pub fn ready(&mut self) -> Result<(), Unexpected> {
        match std::mem::replace(&mut self.state, State::Ready) {
            State::Starting => Ok(()),
            _ => Err(Unexpected::Ready),
        }
    }

    pub fn is_starting(&self) -> bool {
        self.state == State::Starting
    }

    pub fn is_alive(&self) -> bool {
        self.state != State::Dead
    }

    /// A claimed client takes no scenarios.
    pub fn is_claimed(&self) -> bool {
        self.state != State::Ready || self.tasks.len() >= OUTSTANDING_TASKS
    }

    pub fn tasks(&self) -> usize {
        self.tasks.len()
    }

    pub fn buffered(&self) -> usize {
        self.buffer.len()
    }

    pub fn candidate(&self, client: usize, scenario: &Indicators) -> Candidate {
        let score = self.given.iter().zip(scenario).map(|(given, tree)| given.score(tree)).sum();
        Candidate { client, score, load: self.buffer.len() }
    }

    pub fn push(&mut self, scenario: u32, indicators: &Indicators) {
        self.buffer.push(scenario);
        for (given, tree) in self.given.iter_mut().zip(indicators) {
            given.give(tree);
        }
    }

    /// The buffer becomes a task. Returns its scenarios, ascending.
    pub fn begin_task(&mut self, number: u64) -> &[u32] {
        let mut unanswered = std::mem::take(&mut self.buffer);
        unanswered.sort_unstable();
        self.tasks.push_back(Task { number, unanswered });
        &self.tasks[self.tasks.len() - 1].unanswered
    }

    pub fn answered(&mut self, task: u64, scenario: u32) -> Result<(), Unexpected> {
        let current = self.current(task)?;
        let position = current.unanswered.binary_search(&scenario);
        current.unanswered.remove(position.map_err(|_| Unexpected::Scenario(scenario))?);
        Ok(())
    }

    /// Whether the scenario belongs to the task at hand and has no answer yet.
    pub fn expects(&mut self, task: u64, scenario: u32) -> Result<(), Unexpected> {
        match self.current(task)?.unanswered.binary_search(&scenario) {
            Ok(_) => Ok(()),
            Err(_) => Err(Unexpected::Scenario(scenario)),
        }
    }

    pub fn end_task(&mut self, task: u64) -> Result<(), Unexpected> {
        if let Some(&scenario) = self.current(task)?.unanswered.first() {
            return Err(Unexpected::Unanswered { task, scenario });
        }
        self.tasks.pop_front();
        Ok(())
    }

    /// Returns what others have to answer now: everything unanswered, sent or not.
    pub fn die(&mut self) -> Vec<u32> {
        self.state = State::Dead;
        let sent = self.tasks.drain(..).flat_map(|task| task.unanswered);
        sent.chain(self.buffer.drain(..)).collect()
    }

    fn current(&mut self, task: u64) -> Result<&mut Task, Unexpected> {
        let expected = self.tasks.front().map(|current| current.number);
        match self.tasks.front_mut() {
            Some(current) if current.number == task => Ok(current),
            _ => Err(Unexpected::Task { found: task, expected }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::indicator::tests::row;
    use super::*;

    fn ready() -> LocalClient {
        let mut client = LocalClient::default();
        client.ready().unwrap();
        client
    }

    fn with_task(number: u64, scenarios: &[u32]) -> LocalClient {
        let mut client = ready();
        for &scenario in scenarios {
            client.push(scenario, &Indicators::default());
        }
        client.begin_task(number);
        client
    }

    #[test]
    fn a_client_is_claimed_until_it_is_ready_and_while_its_tasks_are_out() {
        let mut client = LocalClient::default();
        assert!(client.is_claimed());
        client.ready().unwrap();
        for number in 0..OUTSTANDING_TASKS as u64 {
            assert!(!client.is_claimed());
            client.push(number as u32, &Indicators::default());
            client.begin_task(number);
        }
        assert!(client.is_claimed());
        client.answered(0, 0).unwrap();
        assert!(client.is_claimed());
        client.end_task(0).unwrap();
        assert!(!client.is_claimed());
        assert_eq!(client.ready(), Err(Unexpected::Ready));
    }

    #[test]
    fn a_task_is_sent_in_ascending_order() {
        let mut client = ready();
        for scenario in [7, 2, 5] {
            client.push(scenario, &Indicators::default());
        }
        assert_eq!(client.begin_task(0), [2, 5, 7]);
        assert_eq!(client.buffered(), 0);
    }

    #[test]
    fn only_the_expected_answers_are_taken() {
        let mut client = with_task(4, &[1, 2]);
        assert_eq!(client.answered(4, 3), Err(Unexpected::Scenario(3)));
        let other_task = Unexpected::Task { found: 5, expected: Some(4) };
        assert_eq!(client.answered(5, 1), Err(other_task));
        client.expects(4, 1).unwrap();
        client.answered(4, 1).unwrap();
        assert_eq!(client.answered(4, 1), Err(Unexpected::Scenario(1)));
        assert_eq!(client.expects(4, 1), Err(Unexpected::Scenario(1)));
        assert_eq!(client.end_task(4), Err(Unexpected::Unanswered { task: 4, scenario: 2 }));
    }

    #[test]
    fn a_dead_client_gives_back_what_it_has_not_answered() {
        let mut client = with_task(4, &[1, 2, 3]);
        client.push(9, &Indicators::default());
        client.answered(4, 2).unwrap();
        assert_eq!(client.die(), [1, 3, 9]);
        assert!(client.is_claimed() && !client.is_alive());
    }

    #[test]
    fn scores_add_up_over_both_trees() {
        let mut client = ready();
        let third = [row(0, &[1, 11, 0, 1, 0, 4]), row(1, &[0, 0, 14, 6])];
        client.push(3, &third);
        let second = [row(0, &[0, 11, 0, 1, 1, 0]), row(1, &[2, 1, 14, 6])];
        assert_eq!(client.candidate(0, &second).score, 11 + 1 + 14 + 6);
        assert_eq!(client.candidate(0, &second).load, 1);
    }
}
