//! The file as it is written: keys and types. `config/clusters/paper.toml` describes every key.

use std::path::PathBuf;

use serde::Deserialize;

use super::super::machine::{Copies, MasterPlace};
use super::AnalysisCost;
use crate::scene::{Compression, MatchRule, Spanned, SubtreesFrom};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConfigFile {
    #[serde(rename = "version")]
    _version: i64,
    pub name: Spanned<String>,
    pub scene: Option<PathBuf>,
    pub nodes: Spanned<Vec<GroupFile>>,
    #[serde(default)]
    pub master: MasterFile,
    pub link: LinkFile,
    #[serde(default)]
    pub messages: MessagesFile,
    #[serde(default)]
    pub memory: MemoryFile,
    #[serde(default)]
    pub scale: ScaleFile,
    pub run: RunFile,
    #[serde(default)]
    pub sweep: SweepFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupFile {
    pub count: Spanned<i64>,
    pub cores: Spanned<i64>,
    pub speed: Option<Spanned<f64>>,
    pub memory_gigabytes: Option<Spanned<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MasterFile {
    pub place: Option<MasterPlace>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkFile {
    pub gigabits_per_s: Spanned<f64>,
    pub latency_us: Option<Spanned<f64>>,
    pub message_bytes: Option<Spanned<f64>>,
    pub window_kilobytes: Option<Spanned<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MessagesFile {
    pub send_us: Option<Spanned<f64>>,
    pub receive_us: Option<Spanned<f64>>,
    pub copy_megabytes_per_s: Option<Spanned<f64>>,
    pub wake_up_us: Option<Spanned<f64>>,
    pub delivery_us: Option<Spanned<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MemoryFile {
    pub process_megabytes: Option<Spanned<f64>>,
    pub geometry_factor: Option<Spanned<f64>>,
    pub begin_on_master: Option<bool>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScaleFile {
    #[serde(default)]
    pub serial_s: Vec<Spanned<f64>>,
    pub slowdown: Option<Spanned<f64>>,
    pub tree_megabytes: Option<Spanned<[f64; 2]>>,
    pub analysis: Option<AnalysisCost>,
    pub make_megabytes_per_s: Option<Spanned<f64>>,
    pub place_megabytes_per_s: Option<Spanned<f64>>,
    pub score_root_ns: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunFile {
    pub scenarios: Spanned<i64>,
    pub depths: Spanned<[i64; 2]>,
    pub buffer: BufferFile,
    pub tasks: Option<Spanned<i64>>,
    pub hold_back: Option<bool>,
    pub matchmakers: Spanned<Vec<MatchRule>>,
    pub copies: Option<Spanned<Vec<Copies>>>,
    pub compression: Option<Spanned<Vec<Compression>>>,
    pub subtrees_from: Option<Spanned<Vec<SubtreesFrom>>>,
    pub samples: Option<Spanned<i64>>,
    pub match_seed: Option<Spanned<i64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BufferFile {
    pub scenarios: Spanned<i64>,
    pub kilobytes: Option<Spanned<i64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepFile {
    #[serde(default)]
    pub scenarios: Vec<Spanned<i64>>,
    #[serde(default)]
    pub depths: Vec<Spanned<i64>>,
    #[serde(default)]
    pub buffer: Vec<Spanned<i64>>,
    #[serde(default)]
    pub nodes: Vec<Spanned<Vec<i64>>>,
}
