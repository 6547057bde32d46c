//! A body in the scene file, and what is said of it beside its mesh: mass, motion, stiffness, parts.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::SceneError;
use super::file::{Source, Spanned};
use crate::effects::crush::{Stiffness, StiffnessError, StiffnessValues};
use crate::effects::motion::{Axes, BodyMotion};
use crate::effects::response::{Inertia, InertiaError};
use crate::effects::{BodyAsked, Ranges};
use crate::geometry::Point;
use crate::geometry::motion::{Motion, MotionError, MotionValues, PartMotion, PartMotionValues};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BodyFile {
    pub mesh: Spanned<String>,
    pub offset_m: Option<Spanned<Point>>,
    pub depth: Option<Spanned<i64>>,
    pub subtree_triangles: Option<Spanned<i64>>,
    mass_kg: Option<Spanned<f64>>,
    inertia_kg_m2: Option<Spanned<InertiaFile>>,
    cg_m: Option<Spanned<Point>>,
    velocity_m_s: Option<Spanned<Point>>,
    acceleration_m_s2: Option<Spanned<Point>>,
    spin_rad_s: Option<Spanned<Point>>,
    spin_acceleration_rad_s2: Option<Spanned<Point>>,
    axes: Option<Axes>,
    stiffness: Option<Spanned<StiffnessValues>>,
    #[serde(default)]
    parts: Vec<PartFile>,
}

/// Moments about the centre of gravity along the axes, or the whole tensor.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "three moments of inertia, or a tensor of three rows")]
enum InertiaFile {
    Moments(Point),
    Tensor([Point; 3]),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PartFile {
    name: Spanned<String>,
    triangles: Spanned<Vec<[u32; 2]>>,
    motion: Option<Spanned<PartMotionValues>>,
}

/// By name.
pub(super) type Parts = BTreeMap<String, Ranges>;

impl Source<'_> {
    /// With all its parts by name.
    pub(super) fn body_asked(
        &self,
        body: &str,
        file: &BodyFile,
    ) -> Result<(BodyAsked, Parts), SceneError> {
        let (parts, moving) = self.parts(body, file)?;
        let asked = BodyAsked {
            inertia: self.inertia(body, file)?,
            motion: self.motion_of(body, file)?,
            stiffness: self.stiffness(body, file)?,
            parts: moving,
        };
        Ok((asked, parts))
    }

    fn inertia(&self, body: &str, file: &BodyFile) -> Result<Option<Inertia>, SceneError> {
        let [mass_key, inertia_key] =
            ["mass_kg", "inertia_kg_m2"].map(|key| format!("{body}.{key}"));
        let (mass, inertia) = match (&file.mass_kg, &file.inertia_kg_m2) {
            (None, None) => return Ok(None),
            (Some(mass), Some(inertia)) => (mass, inertia),
            (Some(mass), None) => {
                let reason = format!("comes with `{inertia_key}`, which is missing");
                return Err(self.wrong(mass, &mass_key, reason));
            }
            (None, Some(inertia)) => {
                let reason = format!("comes with `{mass_key}`, which is missing");
                return Err(self.wrong(inertia, &inertia_key, reason));
            }
        };
        let tensor = match *inertia.get_ref() {
            InertiaFile::Moments([x, y, z]) => [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]],
            InertiaFile::Tensor(tensor) => tensor,
        };
        Inertia::new(*mass.get_ref(), tensor).map(Some).map_err(|error| match error {
            InertiaError::Mass(_) => self.wrong(mass, &mass_key, error),
            _ => self.wrong(inertia, &inertia_key, error),
        })
    }

    fn motion_of(&self, body: &str, file: &BodyFile) -> Result<BodyMotion, SceneError> {
        let given = [
            ("cg_m", &file.cg_m),
            ("velocity_m_s", &file.velocity_m_s),
            ("acceleration_m_s2", &file.acceleration_m_s2),
            ("spin_rad_s", &file.spin_rad_s),
            ("spin_acceleration_rad_s2", &file.spin_acceleration_rad_s2),
        ];
        let value = |at: usize| given[at].1.as_ref().map(|v| *v.get_ref()).unwrap_or_default();
        let values = MotionValues {
            cg_m: value(0),
            velocity_m_s: value(1),
            acceleration_m_s2: value(2),
            spin_rad_s: value(3),
            spin_acceleration_rad_s2: value(4),
        };
        let motion = Motion::new(values).map_err(|error| {
            let wrong = |(key, value): &(&str, &Option<Spanned<Point>>)| {
                let value = value.as_ref()?;
                let is_it = matches!(&error, MotionError::NotFinite { field, .. } if field == key);
                is_it.then(|| self.wrong(value, &format!("{body}.{key}"), error))
            };
            given.iter().find_map(wrong).unwrap_or_else(|| self.invalid(0, body, error))
        })?;
        Ok(BodyMotion { motion, axes: file.axes.unwrap_or_default() })
    }

    fn stiffness(&self, body: &str, file: &BodyFile) -> Result<Option<Stiffness>, SceneError> {
        let Some(given) = &file.stiffness else { return Ok(None) };
        let StiffnessValues { a_n_m, b_n_m2 } = *given.get_ref();
        Stiffness::new(a_n_m, b_n_m2).map(Some).map_err(|error| {
            let key = match error {
                StiffnessError::B(_) => "b_n_m2",
                _ => "a_n_m",
            };
            self.wrong(given, &format!("{body}.stiffness.{key}"), error)
        })
    }

    fn parts(
        &self,
        body: &str,
        file: &BodyFile,
    ) -> Result<(Parts, Vec<(Ranges, PartMotion)>), SceneError> {
        let (mut parts, mut moving) = (Parts::new(), Vec::<(Ranges, PartMotion)>::new());
        for part in &file.parts {
            let triangles = Ranges::new(part.triangles.get_ref().clone()).map_err(|error| {
                self.wrong(&part.triangles, &format!("{body}.parts.triangles"), error)
            })?;
            if let Some(motion) = &part.motion {
                if moving.iter().any(|(other, _)| other.meets(&triangles)) {
                    let reason = "has triangles of another part that moves";
                    let key = format!("{body}.parts.triangles");
                    return Err(self.wrong(&part.triangles, &key, reason));
                }
                let checked = PartMotion::new(*motion.get_ref());
                let checked = checked
                    .map_err(|error| self.wrong(motion, &format!("{body}.parts.motion"), error))?;
                moving.push((triangles.clone(), checked));
            }
            if parts.insert(part.name.get_ref().clone(), triangles).is_some() {
                let reason = format!("'{}' names two parts", part.name.get_ref());
                return Err(self.wrong(&part.name, &format!("{body}.parts.name"), reason));
            }
        }
        Ok((parts, moving))
    }
}
