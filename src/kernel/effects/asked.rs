//! What a scene asks for, and the plan that this makes.

use std::num::NonZeroU32;

use super::clearance::ClearanceOptions;
use super::crush::{CrushOptions, Stiffness};
use super::motion::{BodyMotion, MotionOptions, PartTree};
use super::penetration::PenetrationOptions;
use super::response::{Inertia, ResponseBody, ResponseOptions};
use super::{Plan, Ranges, Step};
use crate::geometry::Pose;
use crate::geometry::motion::{Horizon, Motion, PartMotion, Trajectory};
use crate::mesh::TriangleMesh;
use crate::mesh::closed::{Part, Shells};
use crate::tree::advance::{Resolution, Tolerance};

/// What a scene asks for, each value checked by itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Asked {
    pub pairs: PairsAsked,
    /// So many pairs of a scenario are kept, from the first; absent: all.
    pub most_contacts: Option<NonZeroU32>,
    /// Parts of the fixed and of the moving mesh whose contacts do not count.
    pub ignore: Vec<[Ranges; 2]>,
    pub segments: bool,
    pub containment: bool,
    pub clearance: Option<ClearanceOptions>,
    pub penetration: Option<PenetrationOptions>,
    pub volume: bool,
    pub motion: Option<MotionAsked>,
    pub response: Option<ResponseAsked>,
    /// What the bodies are calls for no response.
    pub response_is_off: bool,
    pub crush: Option<CrushAsked>,
    /// The fixed and the moving one.
    pub bodies: [BodyAsked; 2],
}

/// What is found of the triangles that touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PairsAsked {
    /// Whether there is a pair.
    Overlap,
    #[default]
    Contacts,
}

impl PairsAsked {
    pub fn name(self) -> &'static str {
        match self {
            Self::Overlap => "overlap",
            Self::Contacts => "contacts",
        }
    }
}

/// How long bodies move, and how closely it is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionAsked {
    pub horizon: Horizon,
    pub tolerance: Tolerance,
    pub resolution: Option<Resolution>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseAsked {
    pub restitution: f64,
    pub friction: f64,
}

impl Default for ResponseAsked {
    /// Of severe collisions of cars (Steffan & Moser, SAE 960886).
    fn default() -> Self {
        Self { restitution: 0.1, friction: 0.6 }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrushAsked {
    pub width_m: f64,
    pub height_m: Option<f64>,
    pub taper_m: f64,
    /// By the crush of this scenario both vehicles are deformed in those after it.
    pub deform_after: Option<u32>,
}

/// What a scene says of a body beside its mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyAsked {
    pub inertia: Option<Inertia>,
    pub motion: BodyMotion,
    pub stiffness: Option<Stiffness>,
    /// Parts that move in the body.
    pub parts: Vec<(Ranges, PartMotion)>,
}

impl BodyAsked {
    fn moves(&self) -> bool {
        self.has_velocity() || !self.parts.is_empty()
    }

    fn has_velocity(&self) -> bool {
        let still = Motion::default();
        let (own, none) = (self.motion.motion.values(), still.values());
        (own.velocity_m_s, own.spin_rad_s) != (none.velocity_m_s, none.spin_rad_s)
            || (own.acceleration_m_s2, own.spin_acceleration_rad_s2)
                != (none.acceleration_m_s2, none.spin_acceleration_rad_s2)
    }
}

/// What a scene lacks for what it asks.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}`: {reason}")]
pub struct Unplannable {
    /// Of the scene file.
    pub key: String,
    pub reason: String,
}

impl Unplannable {
    fn new(key: impl Into<String>, reason: impl Into<String>) -> Self {
        Self { key: key.into(), reason: reason.into() }
    }
}

const SIDES: [&str; 2] = ["fixed", "moving"];

impl Asked {
    /// The scenario by whose crush both vehicles are deformed, if there is one.
    pub fn deform_after(&self) -> Option<u32> {
        self.crush.and_then(|crush| crush.deform_after)
    }

    /// The steps, in their order, of scenarios of a fixed and a moving mesh.
    pub fn plan(&self, meshes: [&TriangleMesh; 2]) -> Result<Plan, Unplannable> {
        self.check_parts(meshes)?;
        self.check_ignored()?;
        let containment = self.needs_containment(meshes)?;
        let mut steps = Vec::new();
        steps.extend(self.segments.then_some(Step::Segments));
        steps.extend(containment.then_some(Step::Containment));
        steps.extend(self.clearance.map(Step::Clearance));
        steps.extend(self.penetration.map(Step::Penetration));
        steps.extend(self.volume.then_some(Step::Volume));
        steps.extend(self.motion(meshes)?.map(|options| Step::Motion(Box::new(options))));
        if let Some(response) = self.response()? {
            steps.push(Step::Response(Box::new(response)));
            if let Some(crush) = self.crush(&response)? {
                steps.push(Step::Crush(Box::new(crush)));
            }
        }
        Ok(Plan { ignore: self.ignore.clone(), steps })
    }

    /// Whether it is enough to know of one pair.
    pub fn overlap_is_enough(&self) -> bool {
        self.pairs == PairsAsked::Overlap
            && self.ignore.is_empty()
            && !self.segments
            && !self.calls_for_response()
    }

    /// Whether all pairs are wanted and nothing else.
    pub fn is_contacts_only(&self) -> bool {
        let Self { pairs, ignore, segments, containment, clearance, penetration, volume, .. } =
            self;
        *pairs == PairsAsked::Contacts
            && ignore.is_empty()
            && !(*segments || *containment || *volume)
            && (clearance, penetration, self.motion) == (&None, &None, None)
            && !self.calls_for_response()
    }

    /// Pairs of a scenario that are kept.
    pub fn most_pairs(&self) -> u32 {
        self.most_contacts.map_or(u32::MAX, NonZeroU32::get)
    }

    /// It was asked for, or the bodies are described as an impact needs them.
    fn calls_for_response(&self) -> bool {
        let described = self.bodies.iter().all(|body| body.inertia.is_some());
        let moves = self.bodies.iter().any(BodyAsked::has_velocity);
        self.response.is_some()
            || self.crush.is_some()
            || described && moves && !self.response_is_off
    }

    fn motion(&self, meshes: [&TriangleMesh; 2]) -> Result<Option<MotionOptions>, Unplannable> {
        let Some(MotionAsked { horizon, tolerance, resolution }) = self.motion else {
            // An impact needs velocities without a motion as well.
            let needs_motion = |body: &BodyAsked| {
                !body.parts.is_empty() || body.has_velocity() && !self.calls_for_response()
            };
            if self.bodies.iter().any(needs_motion) {
                let reason = "is missing: something moves, and nothing says how long";
                return Err(Unplannable::new("motion.duration_s", reason));
            }
            return Ok(None);
        };
        if !self.bodies.iter().any(BodyAsked::moves) {
            let reason = "nothing moves: give `moving.velocity_m_s`, or another velocity";
            return Err(Unplannable::new("motion", reason));
        }
        for (side, body) in self.bodies.iter().enumerate() {
            let reach =
                meshes[side].vertices().iter().map(|v| v.map(|c| c * c).iter().sum::<f64>());
            let reach = reach.fold(0.0, f64::max).sqrt();
            let moves = |part| Trajectory::new(Pose::IDENTITY, &body.motion.motion, part);
            let parts = body.parts.iter().map(|(_, motion)| Some(motion)).chain([None]);
            for part in parts {
                moves(part).rounding(reach, horizon).map_err(|error| {
                    Unplannable::new(format!("{}.velocity_m_s", SIDES[side]), error.to_string())
                })?;
            }
        }
        let bodies = self.bodies.each_ref().map(|body| body.motion);
        let parts = [0, 1].map(|side: usize| part_trees(&self.bodies[side], meshes[side]));
        let locate = self.calls_for_response();
        Ok(Some(MotionOptions { horizon, tolerance, resolution, bodies, locate, parts }))
    }

    fn response(&self) -> Result<Option<ResponseOptions>, Unplannable> {
        if !self.calls_for_response() {
            return Ok(None);
        }
        if self.response_is_off {
            let reason = "is false, and `effects.crush` needs it: leave one out";
            return Err(Unplannable::new("effects.response", reason));
        }
        let by = if self.crush.is_some() { "effects.crush" } else { "effects.response" };
        let [fixed, moving] = [0, 1].map(|side: usize| {
            let BodyAsked { inertia, motion, .. } = &self.bodies[side];
            let missing = || {
                let key = format!("{}.mass_kg", SIDES[side]);
                Unplannable::new(
                    key,
                    format!("is missing, with `inertia_kg_m2`: `{by}` needs both"),
                )
            };
            Ok(ResponseBody { inertia: inertia.ok_or_else(missing)?, motion: *motion })
        });
        let bodies = [fixed?, moving?];
        if !self.bodies.iter().any(BodyAsked::has_velocity) {
            let reason = format!("is missing: `{by}` needs bodies that move");
            return Err(Unplannable::new("moving.velocity_m_s", reason));
        }
        let ResponseAsked { restitution, friction } = self.response.unwrap_or_default();
        Ok(Some(ResponseOptions { restitution, friction, bodies }))
    }

    fn crush(&self, response: &ResponseOptions) -> Result<Option<CrushOptions>, Unplannable> {
        let Some(crush) = self.crush else { return Ok(None) };
        let CrushAsked { width_m, height_m, taper_m, .. } = crush;
        let [fixed, moving] = [0, 1].map(|side: usize| {
            let missing = || {
                let key = format!("{}.stiffness", SIDES[side]);
                Unplannable::new(key, "is missing: `effects.crush` needs CRASH3's A and B")
            };
            self.bodies[side].stiffness.ok_or_else(missing)
        });
        let (stiffness, bodies) = ([fixed?, moving?], response.bodies);
        Ok(Some(CrushOptions { stiffness, width_m, height_m, taper_m, bodies }))
    }

    fn check_parts(&self, meshes: [&TriangleMesh; 2]) -> Result<(), Unplannable> {
        for (side, name) in SIDES.into_iter().enumerate() {
            let triangles = meshes[side].faces().len();
            let ignored = self.ignore.iter().map(|pair| &pair[side]);
            let moving = self.bodies[side].parts.iter().map(|(part, _)| part);
            if let Some(last) = ignored.chain(moving).map(Ranges::last).max()
                && last as usize >= triangles
            {
                let reason =
                    format!("one has triangle {last}, and the mesh {triangles}, counted from 0");
                return Err(Unplannable::new(format!("{name}.parts"), reason));
            }
        }
        Ok(())
    }

    /// Effects that look at whole meshes would look at what is ignored as well.
    fn check_ignored(&self) -> Result<(), Unplannable> {
        let whole = [
            ("effects.containment", self.containment),
            ("effects.clearance", self.clearance.is_some()),
            ("effects.penetration", self.penetration.is_some()),
            ("effects.volume", self.volume),
            ("motion", self.motion.is_some()),
        ];
        match whole.iter().find(|(_, asked)| *asked && !self.ignore.is_empty()) {
            Some((key, _)) => {
                let reason = format!(
                    "is about contacts, and `{key}` looks at the whole meshes: leave one out"
                );
                Err(Unplannable::new("effects.ignore", reason))
            }
            None => Ok(()),
        }
    }

    /// Where it was asked for, and where others have to know it: what is inside overlaps, though
    /// nothing touches. Without a closed part nothing can be inside.
    fn needs_containment(&self, meshes: [&TriangleMesh; 2]) -> Result<bool, Unplannable> {
        if !(self.containment || self.volume || self.penetration.is_some()) {
            return Ok(false);
        }
        let shells = meshes.map(|mesh| Shells::of(mesh.vertices(), mesh.faces().iter().copied()));
        let edges = shells.each_ref().map(Shells::open_edges);
        let is_any_closed = shells.iter().flat_map(Shells::parts).any(Part::is_closed);
        if self.containment && !is_any_closed {
            let reason = format!(
                "neither mesh has a closed part that something could be inside: the fixed one has \
                 {} open edges, the moving one {}",
                edges[0], edges[1]
            );
            return Err(Unplannable::new("effects.containment", reason));
        }
        let open = shells.iter().position(|shells| !shells.parts().iter().any(Part::is_solid));
        match open.filter(|_| self.volume) {
            Some(side) => {
                let reason = format!(
                    "the {} mesh has no closed part whose triangles all face one side, so no \
                     volume: it has {} open edges",
                    SIDES[side], edges[side]
                );
                Err(Unplannable::new("effects.volume", reason))
            }
            None => Ok(is_any_closed),
        }
    }
}

/// The body without its moving parts, and those; none if no part moves.
fn part_trees(body: &BodyAsked, mesh: &TriangleMesh) -> Vec<PartTree> {
    if body.parts.is_empty() {
        return Vec::new();
    }
    let moves = |triangle: &u32| body.parts.iter().any(|(part, _)| part.contains(*triangle));
    let rest = (0..mesh.faces().len() as u32).filter(|triangle| !moves(triangle));
    let rest =
        Ranges::of(rest).map(|triangles| PartTree { triangles, motion: PartMotion::default() });
    let moving = body
        .parts
        .iter()
        .map(|(triangles, motion)| PartTree { triangles: triangles.clone(), motion: *motion });
    rest.into_iter().chain(moving).collect()
}
