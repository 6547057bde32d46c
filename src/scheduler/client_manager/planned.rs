//! A plan of effects on its way to the workers, with the trees that only it needs.

use std::sync::Arc;

use super::MeshId;
use crate::effects::Plan;
use crate::effects::layout::Layout;
use crate::tree::TreeImage;
use crate::tree::roots::Cut;
use crate::tree::subtree::Subtrees;
use crate::wire::{InPlaceTree, JobHeader, PlanMessage, plan_in_place};

pub(super) struct Planned {
    /// Plans are numbered as trees are.
    pub number: u32,
    pub layout: Layout,
    /// Where workers can read it, if there is such a place.
    pub published: Option<u32>,
    text: Vec<u8>,
    parts: Vec<(u32, MeshId, Arc<TreeImage>)>,
}

/// A message, in parts.
type Message = Vec<Vec<u8>>;

impl Planned {
    /// `parts`: the trees by their numbers.
    pub(super) fn new(number: u32, plan: &Plan, parts: Vec<(u32, MeshId, Arc<TreeImage>)>) -> Self {
        let numbers = parts.iter().map(|(tree, ..)| *tree).collect();
        let text = PlanMessage { plan: plan.clone(), parts: numbers }.to_bytes();
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
        self.parts.iter().map(|part| self.tree(part)).chain([plan])
    }

    fn tree(&self, (tree, mesh, image): &(u32, MeshId, Arc<TreeImage>)) -> (u32, Vec<Message>) {
        let (tree, cut) = (*tree, Cut::Depth(0));
        let add = JobHeader::add_tree(tree);
        if self.published.is_some() {
            let place = InPlaceTree { mesh: mesh.0, cut }.to_bytes().to_vec();
            return (tree, vec![message(&add, place)]);
        }
        let subtrees = Subtrees::new(image.view(), cut);
        let whole = subtrees.message(0).expect("a tree has a root");
        let whole = message(&JobHeader::add_subtree(tree), whole);
        (tree, vec![message(&add, subtrees.outline()), whole])
    }
}

fn message(header: &JobHeader, body: Vec<u8>) -> Message {
    vec![bytemuck::bytes_of(header).to_vec(), body]
}
