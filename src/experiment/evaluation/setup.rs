//! What samples are of: only those of one setup belong together.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use super::plan::{Evaluation, Models, Vary};
use crate::geometry::simd::SimdLevel;
use crate::report::{Machine, Versions};
use crate::scene::{MatchRule, Unwritable};

/// Everything that samples depend on, but for what is in files.
#[derive(Serialize)]
struct Setup<'a> {
    schema_version: u32,
    name: &'a str,
    versions: Versions,
    cpu: Option<String>,
    cores: usize,
    simd: SimdLevel,
    vary: &'a Vary,
    samples: u32,
    /// Without those that a serial experiment does not have.
    #[serde(skip_serializing_if = "Option::is_none")]
    matchmakers: Option<&'a [MatchRule]>,
    models: Vec<ModelsSetup<'a>>,
}

#[derive(Serialize)]
struct ModelsSetup<'a> {
    name: &'a str,
    /// As in a scene file, without what is varied or compared.
    scene: Value,
    /// As many as the machine has cores, if the scene does not say.
    #[serde(skip_serializing_if = "Option::is_none")]
    workers: Option<u32>,
}

const SCHEMA_VERSION: u32 = 1;

/// As the first line of `points.jsonl`, and in `experiment.json`.
pub fn setup(evaluation: &Evaluation) -> Result<Value, Unwritable> {
    let machine = Machine::this();
    let models = evaluation.models.iter().map(|models| models_setup(evaluation, models));
    let setup = Setup {
        schema_version: SCHEMA_VERSION,
        name: &evaluation.name,
        versions: Versions::this(),
        cpu: machine.cpu,
        cores: machine.cores,
        simd: SimdLevel::chosen(),
        vary: &evaluation.vary,
        samples: evaluation.samples.get(),
        matchmakers: (!evaluation.vary.is_serial()).then_some(&evaluation.matchmakers),
        models: models.collect::<Result<_, _>>()?,
    };
    Ok(serde_json::to_value(setup).expect("string keys and plain values"))
}

fn models_setup<'a>(
    evaluation: &Evaluation,
    models: &'a Models,
) -> Result<ModelsSetup<'a>, Unwritable> {
    let values = models.scene.values()?;
    let mut scene = serde_json::to_value(values).expect("string keys and plain values");
    let mut leave_out = |table: &str, key: &str| {
        scene.pointer_mut(table).and_then(Value::as_object_mut).map(|table| table.remove(key));
    };
    let has_fixed_workers = match evaluation.vary {
        Vary::SerialPercent(_) => {
            leave_out("", "engine");
            false
        }
        Vary::Units { .. } => false,
        Vary::ScenariosPercent(_) | Vary::Depth(_) | Vary::Buffer(_) => true,
    };
    match evaluation.vary {
        Vary::Depth(_) => leave_out("/fixed", "depth"),
        Vary::Buffer(_) => leave_out("/engine/buffer", "scenarios"),
        Vary::SerialPercent(_) | Vary::ScenariosPercent(_) | Vary::Units { .. } => {}
    }
    leave_out("/engine", "matchmaker");
    leave_out("/engine", "workers");
    let workers = has_fixed_workers.then(|| models.scene.engine.worker_count().get());
    Ok(ModelsSetup { name: &models.name, scene, workers })
}

/// Each value that is not the same, by its dotted key.
pub(super) fn differences(there: &Value, here: &Value) -> Vec<String> {
    let (there, here) = (leaves(there), leaves(here));
    let keys: std::collections::BTreeSet<&String> = there.keys().chain(here.keys()).collect();
    let shown = |value: Option<&&Value>| value.map_or("nothing".to_owned(), |v| v.to_string());
    let differs = |key: &&String| there.get(*key) != here.get(*key);
    keys.into_iter()
        .filter(differs)
        .map(|key| {
            let (there, here) = (shown(there.get(key)), shown(here.get(key)));
            format!("`{key}` was {there} and is {here}")
        })
        .collect()
}

/// Everything that is no object; a list of plain values is one.
fn leaves(value: &Value) -> BTreeMap<String, &Value> {
    fn add<'a>(key: &str, value: &'a Value, leaves: &mut BTreeMap<String, &'a Value>) {
        let below = |name: &str| match key {
            "" => name.to_owned(),
            key => format!("{key}.{name}"),
        };
        match value {
            Value::Object(fields) => {
                fields.iter().for_each(|(name, value)| add(&below(name), value, leaves));
            }
            Value::Array(items) if items.iter().any(Value::is_object) => {
                let items = items.iter().enumerate();
                items.for_each(|(index, value)| add(&below(&index.to_string()), value, leaves));
            }
            value => {
                leaves.insert(key.to_owned(), value);
            }
        }
    }
    let mut found = BTreeMap::new();
    add("", value, &mut found);
    found
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::scene::Transport;

    #[test]
    fn differences_are_told_by_their_keys_and_both_values() {
        let there = json!({ "a": 1, "b": { "c": [1, 2] }, "d": [{ "e": 1 }], "same": null });
        let here =
            json!({ "a": 2, "b": { "c": [1, 3] }, "d": [{ "e": 1 }, { "e": 5 }], "same": null });
        assert_eq!(
            differences(&there, &here),
            ["`a` was 1 and is 2", "`b.c` was [1,2] and is [1,3]", "`d.1.e` was nothing and is 5"]
        );
        assert!(differences(&there, &there).is_empty());
    }

    #[test]
    fn a_setup_tells_experiments_models_and_engines_apart() {
        let depth = Evaluation::embedded("depth").unwrap();
        let buffer = Evaluation::embedded("buffer").unwrap();
        let differ = |a: &Evaluation, b: &Evaluation| {
            differences(&setup(a).unwrap(), &setup(b).unwrap()).join(" ")
        };
        assert_eq!(differ(&depth, &depth), "");
        let words = differ(&depth, &buffer);
        assert!(words.contains("`name` was \"depth\" and is \"buffer\""), "{words}");
        let mut other = depth.clone();
        other.models.pop();
        assert!(differ(&depth, &other).contains("`models.1.name`"));
        let mut other = depth.clone();
        other.models[0].scene.engine.transport = Transport::Socket;
        assert!(differ(&depth, &other).contains("was \"pipe\" and is \"socket\""));
    }
}
