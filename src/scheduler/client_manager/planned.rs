//! A plan of effects on its way to the workers, with the trees that only it needs.

use std::sync::Arc;

use super::MeshId;
use super::supply::{Published, SentTree, Way};
use crate::effects::Plan;
use crate::effects::layout::Layout;
use crate::scene::Compression;
use crate::tree::TreeImage;
use crate::tree::roots::Cut;
use crate::wire::{InPlaceTree, JobHeader, PlanMessage, published_at};

pub(super) struct Planned {
    /// Plans are numbered as trees are.
    pub number: u32,
    pub layout: Layout,
    /// Where workers can read it, if there is such a place.
    pub published: Option<u32>,
    text: Vec<u8>,
    parts: Vec<Part>,
}

/// What is said of a tree that workers are to have as a whole.
struct Part {
    /// Its number.
    tree: u32,
    in_place: Message,
    /// Empty if nobody is sent anything.
    sent: Vec<Message>,
}

/// A message, in parts.
type Message = Vec<Vec<u8>>;

impl Planned {
    /// `parts`: the trees by their numbers.
    pub(super) fn new(
        number: u32,
        plan: &Plan,
        parts: &[(u32, MeshId, Arc<TreeImage>)],
        published: Published,
        compress: Compression,
    ) -> Self {
        let numbers = parts.iter().map(|(tree, ..)| *tree).collect();
        let text = PlanMessage { plan: plan.clone(), parts: numbers }.to_bytes();
        let parts = parts.iter().map(|(tree, mesh, image)| {
            let place = InPlaceTree { mesh: mesh.0, cut: WHOLE }.to_bytes().to_vec();
            let sent = match published {
                Published::Everywhere => Vec::new(),
                _ => sent(*tree, image, compress),
            };
            Part { tree: *tree, in_place: message(&JobHeader::add_tree(*tree), place), sent }
        });
        let parts = parts.collect();
        Self { number, layout: plan.layout(), published: None, text, parts }
    }

    pub(super) fn text(&self) -> &[u8] {
        &self.text
    }

    /// The numbers of what a worker is told of: trees first.
    pub(super) fn numbers(&self) -> impl Iterator<Item = u32> {
        self.parts.iter().map(|part| part.tree).chain([self.number])
    }

    /// What is said of the thing with that number to a worker that comes to it in this way.
    pub(super) fn messages(&self, number: u32, way: Way) -> Vec<Message> {
        if let Some(part) = self.parts.iter().find(|part| part.tree == number) {
            return match way {
                Way::InPlace => vec![part.in_place.clone()],
                Way::Sent => part.sent.clone(),
                Way::ByNode(_) => vec![message(&JobHeader::add_tree(number), Vec::new())],
            };
        }
        let plan = match (way, self.published) {
            (Way::InPlace, Some(place)) => published_at(place).to_vec(),
            (Way::ByNode(_), _) => published_at(self.number).to_vec(),
            _ => self.text.clone(),
        };
        vec![message(&JobHeader::plan(self.number), plan)]
    }
}

const WHOLE: Cut = Cut::Depth(0);

fn sent(tree: u32, image: &TreeImage, compress: Compression) -> Vec<Message> {
    let sent = SentTree::new(image.view(), WHOLE, compress);
    let whole = message(&JobHeader::add_subtree(tree), sent.message(0).into_owned());
    vec![message(&JobHeader::add_tree(tree), sent.outline()), whole]
}

fn message(header: &JobHeader, body: Vec<u8>) -> Message {
    vec![bytemuck::bytes_of(header).to_vec(), body]
}
