//! The trees that a worker has: in place, or received subtree by subtree.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Deref;
use std::rc::{Rc, Weak};
use std::sync::Arc;

use super::WorkerError;
use super::peers::{Fetcher, Server, Shelf};
use crate::transport::peer::PeerName;
use crate::transport::{GeometryInPlace, GrowingGeometry, Message, TransportError, WorkerEnd};
use crate::tree::roots::CutTree;
use crate::tree::subtree::{PartialTree, SeenTree};
use crate::tree::{KeptTree, TreeView};
use crate::wire::{Fetch, InPlaceTree, place_of};

pub trait TreeStore<W> {
    /// The body is that of the message that adds the tree. Returns the hash of its image.
    fn add(&mut self, transport: &mut W, tree: u32, body: &[u8]) -> Result<u64, WorkerError>;

    /// The body is that of the message that adds the subtree; its number.
    fn add_subtree(&mut self, tree: u32, body: &[u8]) -> Result<u32, WorkerError>;

    /// Takes the subtree from another worker, if that one has it and is quick enough.
    fn fetch_subtree(&mut self, tree: u32, _fetch: &Fetch) -> Result<bool, WorkerError> {
        Err(WorkerError::Tree(tree))
    }

    /// Lets other workers have the subtrees that come from now on; by which name, if that can be.
    fn serve(&mut self) -> Option<PeerName> {
        None
    }

    fn remove(&mut self, tree: u32) -> Result<(), WorkerError>;

    /// A batch about these trees has come: what it needs is here.
    fn look(&mut self, _trees: [u32; 2]) {}

    /// The bytes of a plan, from the body of the message that brings it.
    fn plan(&mut self, transport: &mut W, body: &[u8]) -> Result<Vec<u8>, WorkerError>;

    /// The job that was published, from the body of the message that says where.
    fn elsewhere(&mut self, _transport: &mut W, _body: &[u8]) -> Result<Message, WorkerError> {
        Err(WorkerError::Elsewhere)
    }

    /// An error while parts of it are not here.
    fn whole(&self, tree: u32) -> Result<TreeView<'_>, WorkerError>;

    fn cut(&self, tree: u32) -> Result<CutTree<'_>, WorkerError>;
}

/// Trees that lie where the master published them. A mesh that is cut in two ways is two trees,
/// which lie in one place.
pub struct Shared<G> {
    trees: BTreeMap<u32, KeptTree<Image<G>>>,
    meshes: BTreeMap<u32, Weak<G>>,
}

/// Bytes that all trees of a mesh are in.
#[derive(Debug)]
struct Image<G>(Rc<G>);

impl<G: Deref<Target = [u8]>> Deref for Image<G> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.0
    }
}

impl<G> Default for Shared<G> {
    fn default() -> Self {
        Self { trees: BTreeMap::new(), meshes: BTreeMap::new() }
    }
}

impl<G> Shared<G> {
    fn image<W>(&mut self, transport: &mut W, mesh: u32) -> Result<Image<G>, TransportError>
    where
        W: GeometryInPlace<Geometry = G>,
    {
        if let Some(image) = self.meshes.get(&mesh).and_then(Weak::upgrade) {
            return Ok(Image(image));
        }
        let image = Rc::new(transport.geometry(mesh)?);
        self.meshes.insert(mesh, Rc::downgrade(&image));
        Ok(Image(image))
    }
}

impl<W: GeometryInPlace> TreeStore<W> for Shared<W::Geometry> {
    fn add(&mut self, transport: &mut W, tree: u32, body: &[u8]) -> Result<u64, WorkerError> {
        let place = InPlaceTree::parse(body)?;
        let image = self.image(transport, place.mesh)?;
        match self.trees.entry(tree) {
            Entry::Occupied(_) => Err(WorkerError::Tree(tree)),
            Entry::Vacant(free) => {
                let kept = KeptTree::new(image, place.cut);
                let kept = kept.map_err(|source| WorkerError::Image { tree, source })?;
                Ok(free.insert(kept).view().hash())
            }
        }
    }

    fn add_subtree(&mut self, tree: u32, _body: &[u8]) -> Result<u32, WorkerError> {
        Err(WorkerError::Tree(tree))
    }

    fn remove(&mut self, tree: u32) -> Result<(), WorkerError> {
        self.trees.remove(&tree).map(drop).ok_or(WorkerError::Tree(tree))
    }

    fn plan(&mut self, transport: &mut W, body: &[u8]) -> Result<Vec<u8>, WorkerError> {
        Ok(transport.geometry(place_of(body)?)?.to_vec())
    }

    fn whole(&self, tree: u32) -> Result<TreeView<'_>, WorkerError> {
        self.trees.get(&tree).map(KeptTree::view).ok_or(WorkerError::Tree(tree))
    }

    fn cut(&self, tree: u32) -> Result<CutTree<'_>, WorkerError> {
        self.trees.get(&tree).map(KeptTree::cut).ok_or(WorkerError::Tree(tree))
    }
}

/// Trees of which what was needed so far has come.
#[derive(Default)]
pub struct Received {
    trees: BTreeMap<u32, PartialTree>,
    fetcher: Fetcher,
    /// Where others find what has come.
    serving: Option<(Arc<Shelf>, Server)>,
}

impl Received {
    fn keep(&self, tree: u32, root: u32, message: &[u8]) {
        if let Some((shelf, _)) = &self.serving {
            shelf.put(tree, root, message.into());
        }
    }
}

impl<W: WorkerEnd> TreeStore<W> for Received {
    fn add(&mut self, _transport: &mut W, tree: u32, body: &[u8]) -> Result<u64, WorkerError> {
        let subtree = |source| WorkerError::Subtree { tree, source };
        match self.trees.entry(tree) {
            Entry::Occupied(_) => Err(WorkerError::Tree(tree)),
            Entry::Vacant(free) => Ok(free.insert(PartialTree::new(body).map_err(subtree)?).hash()),
        }
    }

    fn add_subtree(&mut self, tree: u32, body: &[u8]) -> Result<u32, WorkerError> {
        let partial = self.trees.get_mut(&tree).ok_or(WorkerError::Tree(tree))?;
        let root = partial.add(body).map_err(|source| WorkerError::Subtree { tree, source })?;
        self.keep(tree, root, body);
        Ok(root)
    }

    fn fetch_subtree(&mut self, tree: u32, fetch: &Fetch) -> Result<bool, WorkerError> {
        let Fetch { root, peer, .. } = *fetch;
        let partial = self.trees.get_mut(&tree).ok_or(WorkerError::Tree(tree))?;
        let limit = partial.longest_message(root);
        let limit = limit.map_err(|e| WorkerError::Subtree { tree, source: e.into() })?;
        let fetched = self.fetcher.fetch(tree, fetch, limit);
        // What another worker does is no fault of this one.
        let failed = match fetched {
            Err(error) => error.to_string(),
            Ok(message) => match partial.add_root(root, &message) {
                Ok(()) => {
                    self.keep(tree, root, &message);
                    return Ok(true);
                }
                Err(error) => error.to_string(),
            },
        };
        eprintln!("worker: subtree {root} of tree {tree} has not come from {peer:?}: {failed}");
        self.fetcher.give_up(peer);
        Ok(false)
    }

    fn serve(&mut self) -> Option<PeerName> {
        if self.serving.is_none() {
            let shelf = Arc::default();
            match Server::start(Arc::clone(&shelf)) {
                Ok(server) => self.serving = Some((shelf, server)),
                Err(error) => eprintln!("worker: cannot serve subtrees to others: {error}"),
            }
        }
        self.serving.as_ref().map(|(_, server)| server.name())
    }

    fn remove(&mut self, tree: u32) -> Result<(), WorkerError> {
        if let Some((shelf, _)) = &self.serving {
            shelf.remove(tree);
        }
        self.trees.remove(&tree).map(drop).ok_or(WorkerError::Tree(tree))
    }

    fn plan(&mut self, _transport: &mut W, body: &[u8]) -> Result<Vec<u8>, WorkerError> {
        Ok(body.to_vec())
    }

    fn whole(&self, tree: u32) -> Result<TreeView<'_>, WorkerError> {
        self.trees.get(&tree).and_then(PartialTree::whole).ok_or(WorkerError::Tree(tree))
    }

    fn cut(&self, tree: u32) -> Result<CutTree<'_>, WorkerError> {
        self.trees.get(&tree).map(PartialTree::cut_tree).ok_or(WorkerError::Tree(tree))
    }
}

/// Trees that grow where the leader of this worker's node puts what the master sends.
pub struct InNode<G>(BTreeMap<u32, SeenTree<G>>);

impl<G> Default for InNode<G> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<W: GrowingGeometry> TreeStore<W> for InNode<W::Growing> {
    /// The number says it all.
    fn add(&mut self, transport: &mut W, tree: u32, _body: &[u8]) -> Result<u64, WorkerError> {
        match self.0.entry(tree) {
            Entry::Occupied(_) => Err(WorkerError::Tree(tree)),
            Entry::Vacant(free) => {
                let seen = SeenTree::new(transport.growing(tree)?);
                let seen = seen.map_err(|source| WorkerError::Subtree { tree, source })?;
                Ok(free.insert(seen).hash())
            }
        }
    }

    fn add_subtree(&mut self, tree: u32, _body: &[u8]) -> Result<u32, WorkerError> {
        Err(WorkerError::Tree(tree))
    }

    fn remove(&mut self, tree: u32) -> Result<(), WorkerError> {
        self.0.remove(&tree).map(drop).ok_or(WorkerError::Tree(tree))
    }

    fn look(&mut self, trees: [u32; 2]) {
        for tree in trees {
            if let Some(seen) = self.0.get_mut(&tree) {
                seen.look();
            }
        }
    }

    fn plan(&mut self, transport: &mut W, body: &[u8]) -> Result<Vec<u8>, WorkerError> {
        Ok(transport.geometry(place_of(body)?)?.to_vec())
    }

    fn elsewhere(&mut self, transport: &mut W, body: &[u8]) -> Result<Message, WorkerError> {
        Ok(Message::from(&*transport.geometry(place_of(body)?)?))
    }

    fn whole(&self, tree: u32) -> Result<TreeView<'_>, WorkerError> {
        self.0.get(&tree).and_then(SeenTree::whole).ok_or(WorkerError::Tree(tree))
    }

    fn cut(&self, tree: u32) -> Result<CutTree<'_>, WorkerError> {
        self.0.get(&tree).map(SeenTree::cut_tree).ok_or(WorkerError::Tree(tree))
    }
}
