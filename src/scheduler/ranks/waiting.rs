//! Messages that wait until subtrees of other nodes have come.

use std::collections::VecDeque;

use crate::transport::Message;
use crate::transport::ranks::Rank;
use crate::wire::SubtreeRequest;

/// In the order in which the master spoke: each message waits for what was asked for before it, and for
/// nothing else.
#[derive(Debug, Default)]
pub struct Waiting(VecDeque<Entry>);

#[derive(Debug)]
enum Entry {
    Subtree { from: Rank, subtree: SubtreeRequest },
    Message(Message),
}

impl Waiting {
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The subtree was asked of this rank.
    pub fn ask(&mut self, from: Rank, subtree: SubtreeRequest) {
        self.0.push_back(Entry::Subtree { from, subtree });
    }

    pub fn hold(&mut self, message: Message) {
        self.0.push_back(Entry::Message(message));
    }

    /// The rank has answered. Returns whether it was asked.
    pub fn has_come(&mut self, from: Rank, subtree: SubtreeRequest) -> bool {
        let is_it = |entry: &Entry| match entry {
            Entry::Subtree { from: asked, subtree: lacked } => (*asked, *lacked) == (from, subtree),
            Entry::Message(_) => false,
        };
        let at = self.0.iter().position(is_it);
        at.and_then(|at| self.0.remove(at)).is_some()
    }

    /// A message that waits for nothing any more.
    pub fn next(&mut self) -> Option<Message> {
        match self.0.pop_front_if(|entry| matches!(entry, Entry::Message(_)))? {
            Entry::Message(message) => Some(message),
            Entry::Subtree { .. } => unreachable!("only messages are taken"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_waits_for_what_was_asked_for_before_it_and_for_nothing_else() {
        let mut waiting = Waiting::default();
        let subtree = |root| SubtreeRequest { tree: 7, root };
        let next = |waiting: &mut Waiting| waiting.next().map(|message| message[0]);
        waiting.ask(1, subtree(0));
        waiting.hold(Message::from(&[10][..]));
        waiting.ask(2, subtree(1));
        waiting.hold(Message::from(&[11][..]));
        waiting.hold(Message::from(&[12][..]));
        assert_eq!(next(&mut waiting), None);
        assert!(!waiting.has_come(1, subtree(1)), "another was asked");
        assert!(waiting.has_come(2, subtree(1)));
        assert!(!waiting.has_come(2, subtree(1)), "it was asked once");
        assert_eq!(next(&mut waiting), None, "the first has yet to come");
        assert!(waiting.has_come(1, subtree(0)));
        let all: Vec<_> = std::iter::from_fn(|| next(&mut waiting)).collect();
        assert_eq!((all, waiting.is_empty()), (vec![10, 11, 12], true));
    }
}
