//! The master's proxy of one worker (section 6.4.3 of the paper).

use std::collections::VecDeque;

use super::indicator::TreeIndicator;
use crate::tree::roots::RootPair;

/// Tasks a client may have before it is claimed. The paper's is one; with two, a worker finds the
/// next task waiting when it has answered one, instead of sleeping until the master has woken up
/// and filled a buffer. [`crate::transport::QUEUED_JOBS`] has room for them.
pub const OUTSTANDING_TASKS: usize = 2;

/// The indicators of one scenario: of the fixed and of the moving tree.
pub type Indicators = [TreeIndicator; 2];

/// What the pre-analysis found out about a scenario. Nothing, where nobody has to know.
#[derive(Clone, Debug, Default)]
pub struct Analysis {
    pub indicators: Indicators,
    /// What its worker has to descend.
    pub root_pairs: Vec<RootPair>,
}

/// Bytes of each subtree that has to be sent: of the fixed and of the moving tree. Empty where
/// geometry is in place.
pub type SubtreeBytes = [Vec<u64>; 2];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Starting,
    Ready,
    Dead,
}

/// A scenario on its way to a worker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Buffered {
    pub scenario: u32,
    pub root_pairs: Vec<RootPair>,
}

/// What a full buffer becomes.
#[derive(Debug, PartialEq, Eq)]
pub struct NewTask {
    pub number: u64,
    /// Ascending by scenario.
    pub batch: Vec<Buffered>,
    /// Distributed roots that the worker has not been given before: of the fixed and of the moving
    /// tree.
    pub subtrees: [Vec<u32>; 2],
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
    #[error("it says that it could not fetch subtree {root} of tree {tree}, and was not told to")]
    NotFetched { tree: usize, root: u32 },
}

#[derive(Debug)]
pub struct LocalClient {
    state: State,
    /// Scenarios for the next task.
    buffer: Vec<Buffered>,
    /// Oldest first, which is the order of the answers.
    tasks: VecDeque<Task>,
    /// Trees that the worker was told of and has not taken yet: so long it is given no task.
    trees_awaited: u32,
    /// Tasks that it may have before it is claimed.
    most_tasks: usize,
}

impl Default for LocalClient {
    fn default() -> Self {
        Self {
            state: State::Starting,
            buffer: Vec::new(),
            tasks: VecDeque::new(),
            trees_awaited: 0,
            most_tasks: OUTSTANDING_TASKS,
        }
    }
}

impl LocalClient {
    /// One that is claimed with so many tasks, at least one.
    pub fn with_most_tasks(most_tasks: usize) -> Self {
        Self { most_tasks, ..Self::default() }
    }

    pub fn most_tasks(&self) -> usize {
        self.most_tasks
    }

    pub fn ready(&mut self) -> Result<(), Unexpected> {
        match self.state {
            State::Starting => {
                self.state = State::Ready;
                Ok(())
            }
            _ => Err(Unexpected::Ready),
        }
    }

    pub fn is_starting(&self) -> bool {
        self.state == State::Starting
    }

    pub fn is_ready(&self) -> bool {
        self.state == State::Ready
    }

    pub fn is_alive(&self) -> bool {
        self.state != State::Dead
    }

    /// A claimed client takes no scenarios.
    pub fn is_claimed(&self) -> bool {
        !self.has_room_for_task()
    }

    pub fn tasks(&self) -> usize {
        self.tasks.len()
    }

    pub fn buffered(&self) -> usize {
        self.buffer.len()
    }

    /// Scenarios that were sent or buffered and have no answer.
    pub fn unanswered(&self) -> usize {
        self.buffer.len() + self.tasks.iter().map(|task| task.unanswered.len()).sum::<usize>()
    }

    pub fn push(&mut self, scenario: u32, root_pairs: Vec<RootPair>) {
        self.buffer.push(Buffered { scenario, root_pairs });
    }

    /// Whether it could be sent another task.
    pub fn has_room_for_task(&self) -> bool {
        self.state == State::Ready && self.trees_awaited == 0 && self.tasks.len() < self.most_tasks
    }

    /// The buffer becomes a task, ascending by scenario.
    pub fn begin_task(&mut self, number: u64) -> Vec<Buffered> {
        let mut batch = std::mem::take(&mut self.buffer);
        batch.sort_unstable_by_key(|buffered| buffered.scenario);
        let unanswered = batch.iter().map(|buffered| buffered.scenario).collect();
        self.tasks.push_back(Task { number, unanswered });
        batch
    }

    pub fn answered(&mut self, task: u64, scenario: u32) -> Result<(), Unexpected> {
        let current = self.current(task)?;
        let position = current.unanswered.binary_search(&scenario);
        current.unanswered.remove(position.map_err(|_| Unexpected::Scenario(scenario))?);
        Ok(())
    }

    /// Whether the scenario belongs to the task at hand and has no answer yet.
    pub fn expects(&self, task: u64, scenario: u32) -> Result<(), Unexpected> {
        let current = self.tasks.front().filter(|current| current.number == task);
        match current.ok_or_else(|| self.not_at(task))?.unanswered.binary_search(&scenario) {
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

    /// The worker is told of a tree.
    pub fn told_of_tree(&mut self) {
        self.trees_awaited += 1;
    }

    /// It says that it has taken one.
    pub fn took_tree(&mut self) {
        self.trees_awaited = self.trees_awaited.saturating_sub(1);
    }

    pub fn awaits_trees(&self) -> bool {
        self.trees_awaited > 0
    }

    /// Returns what it leaves to others: scenarios that were sent or buffered and have no answer.
    pub fn die(&mut self) -> Vec<u32> {
        let Self { tasks, buffer, .. } =
            std::mem::replace(self, Self { state: State::Dead, ..self.anew() });
        let sent = tasks.into_iter().flat_map(|task| task.unanswered);
        sent.chain(buffer.into_iter().map(|buffered| buffered.scenario)).collect()
    }

    /// Another worker is started in the place of a dead one.
    pub fn restart(&mut self) {
        *self = self.anew();
    }

    fn anew(&self) -> Self {
        Self::with_most_tasks(self.most_tasks)
    }

    fn current(&mut self, task: u64) -> Result<&mut Task, Unexpected> {
        let wrong = self.not_at(task);
        self.tasks.front_mut().filter(|current| current.number == task).ok_or(wrong)
    }

    fn not_at(&self, task: u64) -> Unexpected {
        Unexpected::Task { found: task, expected: self.tasks.front().map(|task| task.number) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ready() -> LocalClient {
        let mut client = LocalClient::default();
        client.ready().unwrap();
        client
    }

    fn push(client: &mut LocalClient, scenario: u32) {
        client.push(scenario, Vec::new());
    }

    fn with_task(number: u64, scenarios: &[u32]) -> LocalClient {
        let mut client = ready();
        scenarios.iter().for_each(|&scenario| push(&mut client, scenario));
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
            push(&mut client, number as u32);
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
        [7, 2, 5].iter().for_each(|&scenario| push(&mut client, scenario));
        let task = client.begin_task(0);
        assert_eq!(task.iter().map(|b| b.scenario).collect::<Vec<_>>(), [2, 5, 7]);
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
        push(&mut client, 7);
        client.begin_task(5);
        push(&mut client, 9);
        client.answered(4, 2).unwrap();
        assert_eq!(client.die(), [1, 3, 7, 9]);
        assert!(client.is_claimed() && !client.is_alive());
    }

    #[test]
    fn a_client_is_claimed_until_it_has_taken_every_tree_that_it_was_told_of() {
        let mut client = ready();
        client.told_of_tree();
        client.told_of_tree();
        client.took_tree();
        assert!(client.is_claimed() && client.awaits_trees());
        client.took_tree();
        assert!(!client.is_claimed() && !client.awaits_trees());
    }
}
