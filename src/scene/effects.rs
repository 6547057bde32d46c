//! What a scene asks for: `[effects]`, `[motion]`, and what the bodies are.

use std::num::NonZeroU32;

use serde::Deserialize;

use super::SceneError;
use super::body::{BodyFile, Parts};
use super::file::{Source, Spanned};
use super::switch::Switch;
use super::values::{in_range, positive};
use crate::effects::clearance::ClearanceOptions;
use crate::effects::penetration::{Direction, Effort, PenetrationOptions};
use crate::effects::response::{Contact, ContactError};
use crate::effects::{Asked, CrushAsked, MotionAsked, PairsAsked, Ranges, ResponseAsked};
use crate::geometry::Point;
use crate::geometry::motion::Horizon;
use crate::tree::advance::{Resolution, Tolerance as ImpactTolerance};
use crate::tree::nearest::Tolerance;

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EffectsFile {
    overlap: Option<Spanned<bool>>,
    contacts: Option<Spanned<bool>>,
    max_contacts: Option<Spanned<i64>>,
    segments: Option<Spanned<bool>>,
    #[serde(default)]
    ignore: Vec<Spanned<[String; 2]>>,
    containment: Option<bool>,
    clearance: Option<Switch<ClearanceFile>>,
    penetration: Option<Switch<PenetrationFile>>,
    volume: Option<bool>,
    response: Option<Switch<ResponseFile>>,
    crush: Option<CrushFile>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ClearanceFile {
    tolerance_m: Option<Spanned<f64>>,
    tolerance_relative: Option<Spanned<f64>>,
    margin_m: Option<Spanned<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct PenetrationFile {
    direction: Option<Spanned<Point>>,
    least: Option<bool>,
    directions: Option<Spanned<i64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ResponseFile {
    restitution: Option<Spanned<f64>>,
    friction: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CrushFile {
    width_m: Spanned<f64>,
    height_m: Option<Spanned<f64>>,
    taper_m: Option<Spanned<f64>>,
    deform_after: Option<Spanned<i64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MotionFile {
    duration_s: Option<Spanned<f64>>,
    tolerance_m: Option<Spanned<f64>>,
    resolution_s: Option<Spanned<f64>>,
}

/// A tenth of a millimetre counts as contact.
const IMPACT_TOLERANCE_M: f64 = 1e-4;

fn is_on(value: Option<&Spanned<bool>>) -> bool {
    value.is_some_and(|value| *value.get_ref())
}

fn given<T: Copy>(value: Option<&Spanned<T>>, default: T) -> T {
    value.map_or(default, |value| *value.get_ref())
}

impl Source<'_> {
    pub(super) fn asked(
        &self,
        effects: &EffectsFile,
        motion: Option<&Spanned<MotionFile>>,
        bodies: [&BodyFile; 2],
    ) -> Result<Asked, SceneError> {
        let (fixed, fixed_parts) = self.body_asked("fixed", bodies[0])?;
        let (moving, moving_parts) = self.body_asked("moving", bodies[1])?;
        let asked = Asked {
            pairs: self.pairs(effects)?,
            most_contacts: self.most_contacts(effects)?,
            ignore: self.ignored(effects, &[fixed_parts, moving_parts])?,
            segments: is_on(effects.segments.as_ref()),
            containment: effects.containment.unwrap_or_default(),
            clearance: on(effects.clearance.as_ref(), |file| self.clearance(file))?,
            penetration: on(effects.penetration.as_ref(), |file| self.penetration(file))?,
            volume: effects.volume.unwrap_or_default(),
            motion: motion.map(|motion| self.motion(motion)).transpose()?,
            response: on(effects.response.as_ref(), |file| self.response(file))?,
            response_is_off: matches!(effects.response, Some(Switch::Off)),
            crush: effects.crush.as_ref().map(|file| self.crush(file)).transpose()?,
            bodies: [fixed, moving],
        };
        Ok(asked)
    }

    fn pairs(&self, effects: &EffectsFile) -> Result<PairsAsked, SceneError> {
        if !is_on(effects.overlap.as_ref()) {
            let off = effects.contacts.as_ref().filter(|value| !value.get_ref());
            let reason =
                "is found in any case: write `effects.overlap = true` to stop at the first";
            let refused = off.map(|value| self.wrong(value, "effects.contacts", reason));
            return refused.map_or(Ok(PairsAsked::Contacts), Err);
        }
        if let Some(value) = &effects.max_contacts {
            let reason = "is about all pairs, and `effects.overlap` stops at the first: keep the one \
                          that is meant";
            return Err(self.wrong(value, "effects.max_contacts", reason));
        }
        let more = [("contacts", &effects.contacts), ("segments", &effects.segments)];
        for (key, value) in more {
            if let Some(value) = value.as_ref().filter(|value| *value.get_ref()) {
                let reason = "finds all pairs, and `effects.overlap` stops at the first: keep the \
                              one that is meant";
                return Err(self.wrong(value, &format!("effects.{key}"), reason));
            }
        }
        Ok(PairsAsked::Overlap)
    }

    fn most_contacts(&self, effects: &EffectsFile) -> Result<Option<NonZeroU32>, SceneError> {
        let limit = |n| positive(n, "a number of contacts", i64::from(u32::MAX) - 1).map(Some);
        self.checked(effects.max_contacts.as_ref(), "effects.max_contacts", None, limit)
    }

    fn ignored(
        &self,
        effects: &EffectsFile,
        parts: &[Parts; 2],
    ) -> Result<Vec<[Ranges; 2]>, SceneError> {
        let found = |names: &Spanned<[String; 2]>, side: usize| {
            let name = &names.get_ref()[side];
            let body = ["fixed", "moving"][side];
            parts[side].get(name).cloned().ok_or_else(|| {
                let reason = format!("there is no part '{name}' in `{body}.parts`");
                self.wrong(names, "effects.ignore", reason)
            })
        };
        effects.ignore.iter().map(|names| Ok([found(names, 0)?, found(names, 1)?])).collect()
    }

    fn clearance(&self, file: &ClearanceFile) -> Result<ClearanceOptions, SceneError> {
        let absolute = file.tolerance_m.as_ref();
        let relative = file.tolerance_relative.as_ref();
        self.checked(absolute, "effects.clearance.tolerance_m", Tolerance::NONE, |m| {
            Tolerance::new(m, 0.0)
        })?;
        let key = "effects.clearance.tolerance_relative";
        let tolerance = Tolerance::new(given(absolute, 0.0), given(relative, 0.0));
        let tolerance = tolerance.or_else(|error| {
            self.checked(relative, key, Tolerance::NONE, |_| Err::<Tolerance, _>(&error))
        })?;
        let margin = |m: f64| {
            let is_one = m.is_finite() && m >= 0.0;
            is_one.then_some(Some(m)).ok_or(format!("is {m}: give metres, not negative"))
        };
        let margin_m =
            self.checked(file.margin_m.as_ref(), "effects.clearance.margin_m", None, margin)?;
        Ok(ClearanceOptions { tolerance, margin_m })
    }

    fn penetration(&self, file: &PenetrationFile) -> Result<PenetrationOptions, SceneError> {
        let direction = self.checked(
            file.direction.as_ref(),
            "effects.penetration.direction",
            None,
            |direction| Direction::new(direction).map(Some),
        )?;
        let effort = self.checked(
            file.directions.as_ref(),
            "effects.penetration.directions",
            Effort::default(),
            |n| positive(n, "a number of directions", 4096).map(|n| Effort { directions: n.get() }),
        )?;
        let least = file.least.unwrap_or(direction.is_none());
        Ok(PenetrationOptions {
            direction,
            least: (least || direction.is_none()).then_some(effort),
        })
    }

    fn motion(&self, motion: &Spanned<MotionFile>) -> Result<MotionAsked, SceneError> {
        let file = motion.get_ref();
        let Some(duration) = &file.duration_s else {
            let reason = "is missing: a motion needs to end, write seconds";
            return Err(self.wrong(motion, "motion.duration_s", reason));
        };
        let horizon = Horizon::new(*duration.get_ref());
        let default = ImpactTolerance::new(IMPACT_TOLERANCE_M).expect("it is above 0");
        Ok(MotionAsked {
            horizon: horizon.map_err(|e| self.wrong(duration, "motion.duration_s", e))?,
            tolerance: self.checked(
                file.tolerance_m.as_ref(),
                "motion.tolerance_m",
                default,
                ImpactTolerance::new,
            )?,
            resolution: self.checked(
                file.resolution_s.as_ref(),
                "motion.resolution_s",
                None,
                |seconds| match Resolution::new(seconds) {
                    Ok(_) if seconds < 1e-4 * duration.get_ref() => Err(format!(
                        "{seconds} is below a ten-thousandth of `motion.duration_s`: give more"
                    )),
                    resolution => resolution.map(Some).map_err(|e| e.to_string()),
                },
            )?,
        })
    }

    fn response(&self, file: &ResponseFile) -> Result<ResponseAsked, SceneError> {
        let default = ResponseAsked::default();
        let asked = ResponseAsked {
            restitution: given(file.restitution.as_ref(), default.restitution),
            friction: given(file.friction.as_ref(), default.friction),
        };
        let up = [0.0, 0.0, 1.0];
        let checked = Contact::new([0.0; 3], up, asked.restitution, asked.friction).map(drop);
        let (key, value) = match &checked {
            Err(ContactError::Restitution(_)) => ("restitution", &file.restitution),
            _ => ("friction", &file.friction),
        };
        self.checked(value.as_ref(), &format!("effects.response.{key}"), (), |_| checked)?;
        Ok(asked)
    }

    fn crush(&self, file: &CrushFile) -> Result<CrushAsked, SceneError> {
        let length = |m: f64| {
            let is_one = m.is_finite() && m > 0.0;
            is_one.then_some(m).ok_or(format!("is {m}: give metres, more than 0"))
        };
        let key = |name: &str| format!("effects.crush.{name}");
        let width = self.checked(Some(&file.width_m), &key("width_m"), 0.0, length)?;
        let height = |m| length(m).map(Some);
        let scenario = |n| in_range(n, "the number of a scenario", (0, i64::from(u32::MAX) - 1));
        Ok(CrushAsked {
            width_m: width,
            height_m: self.checked(file.height_m.as_ref(), &key("height_m"), None, height)?,
            taper_m: self.checked(file.taper_m.as_ref(), &key("taper_m"), 0.1, length)?,
            deform_after: self.checked(
                file.deform_after.as_ref(),
                &key("deform_after"),
                None,
                |n| scenario(n).map(Some),
            )?,
        })
    }
}

/// The checked options of what is switched on.
fn on<T, V>(
    switch: Option<&Switch<T>>,
    check: impl FnOnce(&T) -> Result<V, SceneError>,
) -> Result<Option<V>, SceneError> {
    switch.and_then(Switch::on).map(check).transpose()
}
