//! A plan of effects on its way to the workers, with the trees that only it needs.

use std::sync::Arc;

use super::MeshId;
use super::supply::SentTree;
use crate::effects::Plan;
use crate::effects::layout::Layout;
use crate::scene::Compression;
use crate::tree::TreeImage;
use crate::tree::roots::Cut;
use crate::wire::{InPlaceTree, JobHeader, PlanMessage, plan_in_place};

pub(super) struct Planned {
    /// Plans are numbered as trees are.
    pub number: u32,
    pub layout: Layout,
    /// Where workers can read it, if there is such a place.
    pub published: Option<u32>,
    text: Vec<u8>,
    /// The number of each tree, and what a worker is told of it.
    parts: Vec<(u32, Vec<Message>)>,
}

/// How workers come by the trees of a plan.
#[derive(Clone, Copy)]
pub(super) enum Parts {
    InPlace,
    Sent(Compression),
}

/// A message, in parts.
type Message = Vec<Vec<u8>>;

impl Planned {
    /// `parts`: the trees by their numbers.
    pub(super) fn new(
        number: u32,
        plan: &Plan,
        parts: &[(u32, MeshId, Arc<TreeImage>)],
        how: Parts,
    ) -> Self {
        let numbers = parts.iter().map(|(tree, ..)| *tree).collect();
        let text = PlanMessage { plan: plan.clone(), parts: numbers }.to_bytes();
        let told = |(tree, mesh, image): &(u32, MeshId, Arc<TreeImage>)| {
            (*tree, messages(*tree, *mesh, image, how))
        };
        let parts = parts.iter().map(told).collect();
        Self { number, layout: plan.layout(), published: None, text, parts }
    }

    pub(super) fn text(&self) -> &[u8] {
        &self.text
    }

    /// For each thing that a worker is told of, its number and what it is told: trees first.
    pub(super) fn messages(&self) -> impl Iterator<Item = (u32, Vec<Message>)> {
        let plan = match self.published {
            Some(place) => plan_in_place(place).to_vec(),
            None => self.text.clone(),
        };
        let plan = (self.number, vec![message(&JobHeader::plan(self.number), plan)]);
        self.parts.iter().cloned().chain([plan])
    }
}

/// What a worker is told of a tree that it is to have as a whole.
fn messages(tree: u32, mesh: MeshId, image: &TreeImage, how: Parts) -> Vec<Message> {
    let (add, cut) = (JobHeader::add_tree(tree), Cut::Depth(0));
    match how {
        Parts::InPlace => {
            vec![message(&add, InPlaceTree { mesh: mesh.0, cut }.to_bytes().to_vec())]
        }
        Parts::Sent(compress) => {
            let sent = SentTree::new(image.view(), cut, compress);
            let whole = message(&JobHeader::add_subtree(tree), sent.message(0).into_owned());
            vec![message(&add, sent.outline()), whole]
        }
    }
}

fn message(header: &JobHeader, body: Vec<u8>) -> Message {
    vec![bytemuck::bytes_of(header).to_vec(), body]
}
