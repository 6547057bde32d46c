//! Meshes that come with the program: a passenger car and a tracked armoured personnel carrier, and
//! two bodies that are hard on floating point.
//!
//! The vehicles are made as visual and CAD models are: many separate hollow parts that meet, overlap
//! a little or leave gaps. Metres, ISO 8855 axes (x forward, y to the left, z up), the origin on the
//! ground below the middle of the vehicle's length. The same bits on every machine.

mod assembly;
mod blocks;
mod budget;
mod car;
mod curve;
mod loft;
mod placement;
mod revolution;
mod sheet;
mod slivers;
mod tracked;
mod turn;

use std::{fmt, str::FromStr};

use super::{MeshError, TriangleMesh};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// A four-door saloon, 4.5 m long.
    Car,
    /// A personnel carrier on tracks, 5 m long.
    Tracked,
    /// A cube of blocks of 0.25 m, all faces, edges and corners in contact.
    Blocks,
    /// A box of strips down to less than a nanometre wide.
    Slivers,
}

impl Model {
    const ALL: [Self; 4] = [Self::Car, Self::Tracked, Self::Blocks, Self::Slivers];

    fn name(self) -> &'static str {
        match self {
            Self::Car => "car",
            Self::Tracked => "tracked",
            Self::Blocks => "blocks",
            Self::Slivers => "slivers",
        }
    }

    fn default_triangles(self) -> u32 {
        match self {
            Self::Car => 90_000,
            Self::Tracked => 300_000,
            Self::Blocks => 12_000,
            Self::Slivers => 4_000,
        }
    }

    fn fewest_triangles(self) -> u32 {
        match self {
            Self::Car | Self::Tracked => Builtin::MIN_TRIANGLES,
            Self::Blocks => blocks::TRIANGLES_OF_A_BLOCK,
            Self::Slivers => slivers::FEWEST_TRIANGLES,
        }
    }
}

/// `car`, `tracked`, `blocks` or `slivers`, and a triangle budget: `car?triangles=20000`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Builtin {
    model: Model,
    triangles: u32,
}

impl Builtin {
    /// The smallest budget at which a vehicle still looks like one.
    pub const MIN_TRIANGLES: u32 = 1_000;
    /// Beyond any use, and still far from the memory of a workstation.
    pub const MAX_TRIANGLES: u32 = 20_000_000;

    /// The mesh will have at most `triangles` triangles, and a vehicle few less.
    pub fn new(model: Model, triangles: u32) -> Result<Self, MeshError> {
        let (min, max) = (model.fewest_triangles(), Self::MAX_TRIANGLES);
        if !(min..=max).contains(&triangles) {
            return Err(MeshError::BuiltinBudget { triangles, min, max });
        }
        Ok(Self { model, triangles })
    }

    pub fn model(&self) -> Model {
        self.model
    }

    pub fn triangles(&self) -> u32 {
        self.triangles
    }

    pub fn mesh(&self) -> TriangleMesh {
        let budget = u64::from(self.triangles);
        match self.model {
            Model::Car => budget::within_budget(budget, car::car),
            Model::Tracked => budget::within_budget(budget, tracked::tracked),
            Model::Blocks => blocks::blocks(self.triangles),
            Model::Slivers => slivers::slivers(self.triangles),
        }
    }
}

impl From<Model> for Builtin {
    fn from(model: Model) -> Self {
        Self { model, triangles: model.default_triangles() }
    }
}

impl FromStr for Builtin {
    type Err = MeshError;

    /// The text after `builtin:`.
    fn from_str(text: &str) -> Result<Self, MeshError> {
        let (name, option) = match text.split_once('?') {
            Some((name, option)) => (name, Some(option)),
            None => (text, None),
        };
        let model = Model::ALL
            .into_iter()
            .find(|model| model.name() == name)
            .ok_or_else(|| MeshError::UnknownBuiltin(name.to_owned()))?;
        let Some(option) = option else { return Ok(model.into()) };
        let count = option
            .strip_prefix("triangles=")
            .ok_or_else(|| MeshError::UnknownBuiltinOption(option.to_owned()))?;
        let triangles = count.parse().map_err(|_| MeshError::BuiltinNotACount(count.to_owned()))?;
        Self::new(model, triangles)
    }
}

impl fmt::Display for Builtin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.model.name())?;
        if self.triangles != self.model.default_triangles() {
            write!(f, "?triangles={}", self.triangles)?;
        }
        Ok(())
    }
}
