use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::wire::SubtreeRequest;

/// Messages of subtrees, as they came: in a worker that serves others its geometry takes, beside the
/// place that it is used in, once more the bytes that were sent.
#[derive(Debug, Default)]
pub struct Shelf(Mutex<Messages>);

/// By tree and root.
type Messages = BTreeMap<(u32, u32), Arc<[u8]>>;

impl Shelf {
    pub fn put(&self, tree: u32, root: u32, message: Arc<[u8]>) {
        self.locked(|messages| drop(messages.insert((tree, root), message)));
    }

    pub fn get(&self, SubtreeRequest { tree, root }: SubtreeRequest) -> Option<Arc<[u8]>> {
        self.locked(|messages| messages.get(&(tree, root)).cloned())
    }

    /// The tree is not here any more.
    pub fn remove(&self, tree: u32) {
        self.locked(|messages| messages.retain(|&(of, _), _| of != tree));
    }

    /// Each change is whole at once, so that nothing is left half done by whoever panics.
    fn locked<T>(&self, use_it: impl FnOnce(&mut Messages) -> T) -> T {
        use_it(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
