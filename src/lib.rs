//! bumper finds exactly which triangles of two detailed vehicle models touch, in thousands of
//! poses, on all cores of one machine: the system of Grinberg & Wiseman, "Scalable parallel
//! simulator for vehicular collision detection" (2013), as a zero-copy shared-memory engine.
//!
//! ```
//! use bumper::effects::contacts::contacts;
//! use bumper::geometry::Pose;
//! use bumper::mesh::MeshSource;
//! use bumper::tree::{BuildOptions, TreeKind, build, descent::Descent};
//!
//! let fixed = "builtin:tracked?triangles=5000".parse::<MeshSource>()?.load()?;
//! let moving = "builtin:car?triangles=5000".parse::<MeshSource>()?.load()?;
//! let trees = [fixed, moving].map(|mesh| build(&mesh, BuildOptions { kind: TreeKind::Wide }));
//!
//! let quarter_turn_to_the_left = [0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()];
//! let pose = Pose::checked(quarter_turn_to_the_left, [3.0, 1.0, 0.0])?;
//! let mut pairs = Vec::new();
//! contacts(&mut Descent::default(), &trees[0].view(), &trees[1].view(), &pose, &mut pairs)?;
//! assert!(!pairs.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Map
//! Imports go down only: [`geometry`] <- [`mesh`], [`tree`] <- [`effects`], [`scene`],
//! [`hardcases`] <- [`wire`] <- [`workers`], [`scheduler`] <- [`report`] <- [`cli`]. [`transport`]
//! moves bytes and imports nothing of ours.
//!
//! # Glossary
//! - *scenario*: one pose of the moving mesh against the fixed one, which stays as its file has it
//! - *pair*: a triangle of each mesh that have a point in common, numbered as in their files
//! - *image*: a tree as relocatable bytes, used in place wherever they are
//! - *distributed root*: a tree node at depth d, or a leaf above it; the unit of transfer
//! - *accuracy*: what counts as a pair; exact unless a scene asks for less
//! - *indicator*: which distributed roots a scenario needs, or a client has been given
//! - *matchmaker*: chooses the client for a scenario; *claimed*: a client that is at work

pub use bumper_kernel::{effects, geometry, mesh, tree};

pub mod cli;
pub mod experiment;
pub mod hardcases;
pub mod report;
pub mod scene;
pub mod scheduler;
pub mod transport;
pub mod wire;
#[path = "../workers/mod.rs"]
pub mod workers;
