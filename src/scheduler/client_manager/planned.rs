//! A plan of effects on its way to the workers, with the trees that only it needs.

use std::sync::Arc;

use super::MeshId;
use super::supply::Way;
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

    /// The numbers of what a worker is told of: trees first.
    pub(super) fn numbers(&self) -> impl Iterator<Item = u32> {
        self.parts.iter().map(|(tree, ..)| *tree).chain([self.number])
    }

    /// What is said of the thing with that number to a worker that comes to it in this way.
    pub(super) fn messages(&self, number: u32, way: Way) -> Vec<Message> {
        if let Some(part) = self.parts.iter().find(|(tree, ..)| *tree == number) {
            return self.tree(part, way);
        }
        let plan = match (way, self.published) {
            (Way::InPlace, Some(place)) => plan_in_place(place).to_vec(),
            (Way::ByNode(_), _) => plan_in_place(self.number).to_vec(),
            _ => self.text.clone(),
        };
        vec![message(&JobHeader::plan(self.number), plan)]
    }

    fn tree(&self, part: &(u32, MeshId, Arc<TreeImage>), way: Way) -> Vec<Message> {
        let ((tree, mesh, image), cut) = (part, Cut::Depth(0));
        let (tree, add) = (*tree, JobHeader::add_tree(*tree));
        let subtrees = match way {
            Way::InPlace => {
                let place = InPlaceTree { mesh: mesh.0, cut }.to_bytes().to_vec();
                return vec![message(&add, place)];
            }
            Way::ByNode(_) => return vec![message(&add, Vec::new())],
            Way::Sent => Subtrees::new(image.view(), cut),
        };
        let whole = subtrees.message(0).expect("a tree has a root");
        let whole = message(&JobHeader::add_subtree(tree), whole);
        vec![message(&add, subtrees.outline()), whole]
    }
}

fn message(header: &JobHeader, body: Vec<u8>) -> Message {
    vec![bytemuck::bytes_of(header).to_vec(), body]
}
