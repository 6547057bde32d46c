//! From what is written to what can be simulated.

use std::fmt::Display;
use std::num::NonZeroU32;
use std::path::Path;

use super::super::events::nanoseconds;
use super::super::machine::{Copies, Link, MasterPlace, MemoryRules, MessageCosts, Node};
use super::file::{
    ConfigFile, GroupFile, LinkFile, MemoryFile, MessagesFile, RunFile, ScaleFile, SweepFile,
};
use super::{Config, Group, Point, Run, Scale, Sweep};
use crate::scene::{
    Compression, Distribution, SceneError, Source, Spanned, SubtreesFrom, buffer_kilobytes,
    buffer_scenarios,
};
use crate::scheduler::local_client::OUTSTANDING_TASKS;

/// Of all nodes together: ten times what there is a configuration for.
const MOST_WORKERS: i64 = 100_000;
const MOST_SCENARIOS: i64 = 100_000_000;

type Checked<T> = Result<T, SceneError>;

pub fn config(text: &str, name: &str, folder: &Path) -> Checked<Config> {
    let checker = Checker(Source { text, name, folder });
    let file: ConfigFile = checker.0.read()?;
    let groups = checker.groups(&file.nodes)?;
    let nodes = groups.iter().map(|group| group.count).collect();
    let config = Config {
        name: checker.name(&file.name)?,
        scene: file.scene.map(|scene| folder.join(scene)),
        master: file.master.place.unwrap_or(MasterPlace::FirstNode),
        link: checker.link(&file.link)?,
        messages: checker.messages(&file.messages)?,
        memory: checker.memory(&file.memory)?,
        scale: checker.scale(&file.scale, &file.memory)?,
        run: checker.run(&file.run, nodes)?,
        sweep: checker.sweep(&file.sweep, &groups)?,
        groups,
    };
    checker.together(&config, &file.run)?;
    Ok(config)
}

struct Checker<'a>(Source<'a>);

impl Checker<'_> {
    fn value<T: Copy, V, E: Display>(
        &self,
        value: &Spanned<T>,
        key: &str,
        check: impl FnOnce(T) -> Result<V, E>,
    ) -> Checked<V> {
        check(*value.get_ref()).map_err(|error| self.0.wrong(value, key, error))
    }

    fn whole(&self, value: &Spanned<i64>, key: &str, range: (i64, i64)) -> Checked<u32> {
        self.value(value, key, |n| {
            let is_in = n >= range.0 && n <= range.1;
            let number = u32::try_from(n).ok().filter(|_| is_in);
            number.ok_or(format!("{n} is not a whole number from {} to {}", range.0, range.1))
        })
    }

    fn positive(&self, value: &Spanned<f64>, key: &str) -> Checked<f64> {
        self.value(value, key, |x| {
            let is_good = x.is_finite() && x > 0.0;
            is_good.then_some(x).ok_or(format!("{x} is not a number above 0"))
        })
    }

    fn positive_or<V>(
        &self,
        value: Option<&Spanned<f64>>,
        key: &str,
        default: V,
        map: impl Fn(f64) -> V,
    ) -> Checked<V> {
        value.map_or(Ok(default), |value| self.positive(value, key).map(map))
    }

    /// 0 if absent.
    fn not_negative(&self, value: Option<&Spanned<f64>>, key: &str) -> Checked<f64> {
        let Some(value) = value else { return Ok(0.0) };
        self.value(value, key, |x| {
            let is_good = x.is_finite() && x >= 0.0;
            is_good.then_some(x).ok_or(format!("{x} is not a number from 0 on"))
        })
    }

    fn name(&self, name: &Spanned<String>) -> Checked<String> {
        let text = name.get_ref();
        let is_stem = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if text.is_empty() || !text.chars().all(is_stem) {
            let reason =
                format!("'{text}' cannot be the stem of a file: write letters, digits, - and _");
            return Err(self.0.wrong(name, "name", reason));
        }
        Ok(text.clone())
    }

    fn groups(&self, groups: &Spanned<Vec<GroupFile>>) -> Checked<Vec<Group>> {
        let group = |file: &GroupFile| {
            let memory = file.memory_gigabytes.as_ref();
            Ok(Group {
                count: self.whole(&file.count, "nodes.count", (1, MOST_WORKERS))?,
                node: Node {
                    cores: self.whole(&file.cores, "nodes.cores", (1, MOST_WORKERS))?,
                    speed: self.positive_or(file.speed.as_ref(), "nodes.speed", 1.0, |x| x)?,
                    memory_bytes: self.positive_or(
                        memory,
                        "nodes.memory_gigabytes",
                        f64::INFINITY,
                        |gb| gb * 1e9,
                    )?,
                },
            })
        };
        let checked: Vec<_> = groups.get_ref().iter().map(group).collect::<Checked<_>>()?;
        let workers = checked.iter().map(|g: &Group| i64::from(g.count) * i64::from(g.node.cores));
        match workers.sum() {
            1..=MOST_WORKERS => Ok(checked),
            n => {
                Err(self.0.wrong(groups, "nodes", format!("{n} cores are not 1 to {MOST_WORKERS}")))
            }
        }
    }

    fn link(&self, file: &LinkFile) -> Checked<Link> {
        let rate = self.positive(&file.gigabits_per_s, "link.gigabits_per_s")?;
        let latency = self.not_negative(file.latency_us.as_ref(), "link.latency_us")?;
        Ok(Link {
            bytes_per_s: rate * 1e9 / 8.0,
            latency: nanoseconds(latency * 1e-6),
            message_bytes: self.not_negative(file.message_bytes.as_ref(), "link.message_bytes")?,
            window_bytes: self.positive_or(
                file.window_kilobytes.as_ref(),
                "link.window_kilobytes",
                None,
                |kilobytes| Some(kilobytes * 1e3),
            )?,
        })
    }

    fn messages(&self, file: &MessagesFile) -> Checked<MessageCosts> {
        let time = |value: &Option<Spanned<f64>>, key| {
            self.not_negative(value.as_ref(), key).map(|us| nanoseconds(us * 1e-6))
        };
        let send = time(&file.send_us, "messages.send_us")?;
        Ok(MessageCosts {
            send,
            receive: time(&file.receive_us, "messages.receive_us")?,
            gathered: send,
            copy_bytes_per_s: self.positive_or(
                file.copy_megabytes_per_s.as_ref(),
                "messages.copy_megabytes_per_s",
                f64::INFINITY,
                |megabytes| megabytes * 1e6,
            )?,
            wake_up: time(&file.wake_up_us, "messages.wake_up_us")?,
            score_root: 0.0,
            delivery: time(&file.delivery_us, "messages.delivery_us")?,
        })
    }

    fn memory(&self, file: &MemoryFile) -> Checked<MemoryRules> {
        let process = file.process_megabytes.as_ref();
        Ok(MemoryRules {
            process_bytes: 1e6 * self.not_negative(process, "memory.process_megabytes")?,
            begin_on_master: file.begin_on_master.unwrap_or_default(),
        })
    }

    fn scale(&self, file: &ScaleFile, memory: &MemoryFile) -> Checked<Scale> {
        let mut serial_s: Vec<f64> = Vec::new();
        for value in &file.serial_s {
            let key = "scale.serial_s";
            let seconds = self.positive(value, key)?;
            if serial_s.last().is_some_and(|&before| before >= seconds) {
                let reason = format!(
                    "{seconds} is not above the one before: each is from the first scenario on"
                );
                return Err(self.0.wrong(value, key, reason));
            }
            serial_s.push(seconds);
        }
        let rate = |value: &Option<Spanned<f64>>, key| {
            self.positive_or(value.as_ref(), key, None, |megabytes| Some(megabytes * 1e6))
        };
        let trees = |megabytes: [f64; 2]| {
            let is_good = megabytes.iter().all(|x| x.is_finite() && *x > 0.0);
            is_good.then_some(Some(megabytes.map(|x| x * 1e6))).ok_or("is not two numbers above 0")
        };
        let score = file.score_root_ns.as_ref();
        Ok(Scale {
            serial_s,
            slowdown: self.positive_or(file.slowdown.as_ref(), "scale.slowdown", None, Some)?,
            tree_bytes: match &file.tree_megabytes {
                None => None,
                Some(value) => self.value(value, "scale.tree_megabytes", trees)?,
            },
            memory_factor: self.positive_or(
                memory.geometry_factor.as_ref(),
                "memory.geometry_factor",
                1.0,
                |x| x,
            )?,
            analysis: file.analysis.unwrap_or_default(),
            make_bytes_per_s: rate(&file.make_megabytes_per_s, "scale.make_megabytes_per_s")?,
            place_bytes_per_s: rate(&file.place_megabytes_per_s, "scale.place_megabytes_per_s")?,
            score_root_ns: score
                .map(|value| self.not_negative(Some(value), "scale.score_root_ns"))
                .transpose()?,
        })
    }

    fn run(&self, file: &RunFile, nodes: Vec<u32>) -> Checked<Run> {
        let depths = self.value(&file.depths, "run.depths", |[fixed, moving]| {
            Ok::<_, String>([depth(fixed)?, depth(moving)?])
        })?;
        let bytes = match &file.buffer.kilobytes {
            None => u64::MAX,
            Some(value) => {
                1000 * self.value(value, "run.buffer.kilobytes", buffer_kilobytes)?.get()
            }
        };
        let samples = match &file.samples {
            None => 1,
            Some(value) => self.whole(value, "run.samples", (1, 1000))?,
        };
        let seed = match &file.match_seed {
            None => 1,
            Some(value) => self.whole(value, "run.match_seed", (0, i64::from(u32::MAX)))?,
        };
        Ok(Run {
            point: Point {
                scenarios: self.scenarios(&file.scenarios, "run.scenarios")?,
                depths,
                buffer: self.value(
                    &file.buffer.scenarios,
                    "run.buffer.scenarios",
                    buffer_scenarios,
                )?,
                nodes,
            },
            buffer_bytes: bytes,
            most_tasks: match &file.tasks {
                None => OUTSTANDING_TASKS,
                Some(value) => self.whole(value, "run.tasks", (1, 1000))? as usize,
            },
            holds_back: file.hold_back.unwrap_or_default(),
            matchmakers: self.each_once(&file.matchmakers, "run.matchmakers")?,
            copies: match &file.copies {
                None => vec![Copies::Process],
                Some(copies) => self.each_once(copies, "run.copies")?,
            },
            compression: match &file.compression {
                None => vec![Compression::None],
                Some(compression) => self.each_once(compression, "run.compression")?,
            },
            subtrees_from: match &file.subtrees_from {
                None => vec![SubtreesFrom::Master],
                Some(from) => self.each_once(from, "run.subtrees_from")?,
            },
            samples: NonZeroU32::new(samples).expect("it is at least 1"),
            match_seed: seed.into(),
        })
    }

    fn each_once<T: Copy + PartialEq>(&self, list: &Spanned<Vec<T>>, key: &str) -> Checked<Vec<T>> {
        let values = list.get_ref();
        let is_repeated = (1..values.len()).any(|at| values[..at].contains(&values[at]));
        match values.is_empty() || is_repeated {
            true => Err(self.0.wrong(list, key, "says nothing, or something twice")),
            false => Ok(values.clone()),
        }
    }

    fn scenarios(&self, value: &Spanned<i64>, key: &str) -> Checked<NonZeroU32> {
        let number = self.whole(value, key, (1, MOST_SCENARIOS))?;
        Ok(NonZeroU32::new(number).expect("it is at least 1"))
    }

    fn sweep(&self, file: &SweepFile, groups: &[Group]) -> Checked<Sweep> {
        let all = |values: &Vec<Spanned<i64>>, key: &str| -> Checked<Vec<NonZeroU32>> {
            values.iter().map(|value| self.scenarios(value, key)).collect()
        };
        let depths = file.depths.iter().map(|value| self.value(value, "sweep.depths", depth));
        let buffer = file.buffer.iter();
        let buffer = buffer.map(|value| self.value(value, "sweep.buffer", buffer_scenarios));
        Ok(Sweep {
            scenarios: all(&file.scenarios, "sweep.scenarios")?,
            depths: depths.collect::<Checked<_>>()?,
            buffer: buffer.collect::<Checked<_>>()?,
            nodes: file
                .nodes
                .iter()
                .map(|value| self.nodes(value, groups))
                .collect::<Checked<_>>()?,
        })
    }

    fn nodes(&self, value: &Spanned<Vec<i64>>, groups: &[Group]) -> Checked<Vec<u32>> {
        let counts = value.get_ref();
        let fits = |(&count, group): (&i64, &Group)| {
            u32::try_from(count).ok().filter(|&count| count <= group.count)
        };
        let checked: Option<Vec<_>> = counts.iter().zip(groups).map(fits).collect();
        let checked = checked.filter(|checked| {
            counts.len() == groups.len() && checked.iter().any(|&count| count > 0)
        });
        checked.ok_or_else(|| {
            let reason =
                "is not a number of nodes for each group, up to its count, at least one in all";
            self.0.wrong(value, "sweep.nodes", reason)
        })
    }

    /// What excludes what.
    fn together(&self, config: &Config, run: &RunFile) -> Checked<()> {
        if let Some(copies) = &run.copies
            && config.run.copies.contains(&Copies::Node)
            && config.memory.begin_on_master
        {
            let reason = "has \"node\" beside `memory.begin_on_master`: who has moved away shares \
                          no memory with who has not";
            return Err(self.0.wrong(copies, "run.copies", reason));
        }
        Ok(())
    }
}

fn depth(value: i64) -> Result<u32, String> {
    Distribution::at_depth(value).map(|_| value as u32).map_err(|error| error.to_string())
}
