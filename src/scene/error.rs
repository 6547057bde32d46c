use std::io;
use std::path::PathBuf;

/// Why there is no scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("{path}: cannot read the scene: {source}", path = path.display())]
    Read { path: PathBuf, source: io::Error },
    /// `key` is dotted, as in `scenarios.random.count`; empty where no key is to blame.
    #[error("{file}:{line}: {}{reason}", prefix(key))]
    Invalid { file: String, line: usize, key: String, reason: String },
}

fn prefix(key: &str) -> String {
    if key.is_empty() { String::new() } else { format!("`{key}`: ") }
}

/// Why there are no poses.
#[derive(Debug, thiserror::Error)]
pub enum PosesError {
    #[error("{path}: cannot read the poses: {source}", path = path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{path}:{line}: {found} where the header `qw,qx,qy,qz,tx,ty,tz` should be", path = path.display())]
    Header { path: PathBuf, line: u64, found: String },
    #[error("{path}:{line}: {reason}", path = path.display())]
    Row { path: PathBuf, line: u64, reason: String },
    #[error("{path}: there is no pose below the header line", path = path.display())]
    Empty { path: PathBuf },
    #[error("{path}: {wanted} poses are asked for, but the file has only {found}", path = path.display())]
    TooFew { path: PathBuf, wanted: u32, found: usize },
    #[error("{path}: more than {max} poses: split the file", path = path.display(), max = u32::MAX)]
    TooMany { path: PathBuf },
}
