//! What a scene asks for: `[effects]`, and what else calls for effects.

use std::collections::BTreeMap;
use std::num::NonZeroU32;

use serde::Deserialize;
use toml::Spanned;

use super::SceneError;
use super::file::{BodyFile, Source};
use super::values::positive;
use crate::effects::{Asked, PairsAsked, Ranges};

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EffectsFile {
    overlap: Option<Spanned<bool>>,
    contacts: Option<Spanned<bool>>,
    max_contacts: Option<Spanned<i64>>,
    segments: Option<Spanned<bool>>,
    #[serde(default)]
    ignore: Vec<Spanned<[String; 2]>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartFile {
    name: Spanned<String>,
    triangles: Spanned<Vec<[u32; 2]>>,
}

fn is_on(value: Option<&Spanned<bool>>) -> bool {
    value.is_some_and(|value| *value.get_ref())
}

impl Source<'_> {
    pub(super) fn asked(
        &self,
        effects: &EffectsFile,
        bodies: [&BodyFile; 2],
    ) -> Result<Asked, SceneError> {
        let parts = [self.parts("fixed", bodies[0])?, self.parts("moving", bodies[1])?];
        Ok(Asked {
            pairs: self.pairs(effects)?,
            most_contacts: self.most_contacts(effects)?,
            ignore: self.ignored(effects, &parts)?,
            segments: is_on(effects.segments.as_ref()),
        })
    }

    fn pairs(&self, effects: &EffectsFile) -> Result<PairsAsked, SceneError> {
        let (overlap, contacts) = (effects.overlap.as_ref(), effects.contacts.as_ref());
        if !is_on(overlap) {
            return Ok(PairsAsked::Contacts);
        }
        let more = [("contacts", contacts), ("segments", effects.segments.as_ref())];
        for (key, value) in more {
            if let Some(value) = value.filter(|value| *value.get_ref()) {
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

    fn parts(&self, body: &str, file: &BodyFile) -> Result<Parts, SceneError> {
        let mut parts = Parts::new();
        for part in &file.parts {
            let triangles = Ranges::new(part.triangles.get_ref().clone()).map_err(|error| {
                self.wrong(&part.triangles, &format!("{body}.parts.triangles"), error)
            })?;
            let name = part.name.get_ref().clone();
            if parts.insert(name, triangles).is_some() {
                let reason = format!("'{}' names two parts", part.name.get_ref());
                return Err(self.wrong(&part.name, &format!("{body}.parts.name"), reason));
            }
        }
        Ok(parts)
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
}

/// By name.
type Parts = BTreeMap<String, Ranges>;
