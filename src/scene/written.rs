//! A scene as a file again: as it is after the command line has had its say, so that its results can
//! be looked at, and a run gone on with, from the file alone.

use std::path::{Path, absolute};

use serde::Serialize;
use toml::{Table, Value};

use super::file::VERSION;
use super::{Body, EngineOptions, Scenarios, Scene};
use crate::effects::Asked;
use crate::mesh::MeshSource;
use crate::tree::roots::Cut;
use crate::tree::{Accuracy, TreeKind};

/// What no scene file can hold.
#[derive(Debug, thiserror::Error)]
pub enum Unwritable {
    #[error("{0:?} cannot be written into a scene: its name is not text")]
    Path(std::path::PathBuf),
    #[error("{key} = {value} cannot be written into a scene: at most {max}", max = i64::MAX)]
    Number { key: &'static str, value: u64 },
}

impl Scene {
    /// Of which nothing but all contacts, exactly, is asked.
    pub fn of_contacts(
        [fixed, moving]: [Body; 2],
        tree: TreeKind,
        scenarios: Scenarios,
        engine: EngineOptions,
    ) -> Self {
        let (accuracy, effects) = (Accuracy::EXACT, Asked::default());
        let file = table([("version", VERSION.into())]);
        Self { fixed, moving, tree, accuracy, scenarios, engine, effects, file }
    }

    /// Reads as the same scene from any directory: paths are absolute.
    pub fn to_toml(&self) -> Result<String, Unwritable> {
        Ok(toml::to_string(&self.table()?).expect("a table of TOML values"))
    }

    /// The same as values, to be written otherwise.
    pub fn values(&self) -> Result<impl Serialize + use<>, Unwritable> {
        self.table()
    }

    fn table(&self) -> Result<Table, Unwritable> {
        let mut table = self.file.clone();
        table.insert("accuracy".into(), self.accuracy.to_string().into());
        for (key, body) in [("fixed", &self.fixed), ("moving", &self.moving)] {
            write_body(inner(&mut table, key), body)?;
        }
        inner(&mut table, "tree").insert("kind".into(), self.tree.to_string().into());
        table.insert("scenarios".into(), scenarios(&self.scenarios)?.into());
        table.insert("engine".into(), engine(&self.engine)?.into());
        Ok(table)
    }
}

impl Scene {
    /// The first key in which what the two ask differs; not how it is computed, which changes no
    /// answer.
    pub fn difference(&self, other: &Self) -> Result<Option<String>, Unwritable> {
        let asked = |scene: &Self| -> Result<Value, Unwritable> {
            let mut table: Table = toml::from_str(&scene.to_toml()?).expect("it was just written");
            table.remove("engine");
            for body in ["fixed", "moving"] {
                inner(&mut table, body)
                    .retain(|key, _| key != "depth" && key != "subtree_triangles");
            }
            Ok(table.into())
        };
        Ok(first_difference(&asked(self)?, &asked(other)?))
    }
}

/// Its dotted key; empty for the values themselves.
fn first_difference(one: &Value, other: &Value) -> Option<String> {
    let (Value::Table(one), Value::Table(other)) = (one, other) else {
        return (one != other).then(String::new);
    };
    let keys = one.keys().chain(other.keys().filter(|key| !one.contains_key(*key)));
    keys.into_iter().find_map(|key| match (one.get(key), other.get(key)) {
        (Some(one), Some(other)) => {
            let below = first_difference(one, other)?;
            Some(if below.is_empty() { key.clone() } else { format!("{key}.{below}") })
        }
        _ => Some(key.clone()),
    })
}

/// The table in it, which is made where there is none.
fn inner<'a>(table: &'a mut Table, key: &str) -> &'a mut Table {
    let value = table.entry(key).or_insert_with(|| Table::new().into());
    value.as_table_mut().expect("the scene was read with a table here")
}

fn write_body(table: &mut Table, body: &Body) -> Result<(), Unwritable> {
    let mesh = match &body.mesh {
        MeshSource::File(path) => text(path)?,
        builtin @ MeshSource::Builtin(_) => builtin.to_string(),
    };
    table.insert("mesh".into(), mesh.into());
    let (cut, other, value) = match body.distribution.cut() {
        Cut::Depth(depth) => ("depth", "subtree_triangles", depth),
        Cut::Triangles(most) => ("subtree_triangles", "depth", most),
    };
    table.insert(cut.into(), value.into());
    table.remove(other);
    table.insert("offset_m".into(), body.offset.to_vec().into());
    Ok(())
}

fn scenarios(scenarios: &Scenarios) -> Result<Table, Unwritable> {
    Ok(match scenarios {
        Scenarios::Random(random) => {
            let penetration = vec![random.penetration.min(), random.penetration.max()];
            let random = table([
                ("count", random.count.get().into()),
                ("seed", number("seed", random.seed)?),
                ("penetration", penetration.into()),
            ]);
            table([("random", random.into())])
        }
        Scenarios::Poses { file, first } => {
            let mut poses = table([("poses", text(file)?.into())]);
            poses.extend(first.map(|first| ("first".to_owned(), first.get().into())));
            poses
        }
    })
}

fn engine(options: &EngineOptions) -> Result<Table, Unwritable> {
    let mut buffer = table([("scenarios", options.buffer_scenarios.get().into())]);
    if let Some(kilobytes) = options.buffer_kilobytes {
        buffer.insert("kilobytes".into(), number("kilobytes", kilobytes.get())?);
    }
    let slowdowns: Vec<Value> = options.slowdowns.iter().map(|one| one.factor().into()).collect();
    let mut engine = table([
        ("transport", options.transport.name().into()),
        ("matchmaker", options.matchmaker.name().into()),
        ("match_seed", number("match_seed", options.match_seed)?),
        ("buffer", buffer.into()),
        ("compress", options.compress.name().into()),
        ("subtrees_from", options.subtrees_from.name().into()),
        ("restarts", options.restarts.into()),
        ("patience_s", options.patience.as_secs_f64().into()),
        ("slowdowns", slowdowns.into()),
    ]);
    engine.extend(options.workers.map(|count| ("workers".to_owned(), count.get().get().into())));
    let start_from = options.start_from.map(|from| ("start_from".to_owned(), from.name().into()));
    engine.extend(start_from);
    engine.insert("compress".into(), options.compress.name().into());
    engine.insert("subtrees_from".into(), options.subtrees_from.name().into());
    Ok(engine)
}

fn table<const N: usize>(values: [(&str, Value); N]) -> Table {
    values.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

fn text(path: &Path) -> Result<String, Unwritable> {
    // Fails only for an empty path or where there is no current directory.
    let path = absolute(path).unwrap_or_else(|_| path.to_owned());
    path.into_os_string().into_string().map_err(|path| Unwritable::Path(path.into()))
}

fn number(key: &'static str, value: u64) -> Result<Value, Unwritable> {
    i64::try_from(value).map(Value::from).map_err(|_| Unwritable::Number { key, value })
}
