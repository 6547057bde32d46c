//! Files that commands write.

use std::fs;
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use anyhow::Context;

pub(super) fn make_folder(folder: &Path) -> anyhow::Result<()> {
    let unusable = || format!("{}: cannot be written to", folder.display());
    fs::create_dir_all(folder).with_context(unusable)
}

/// All of it or nothing: a file that was there before stays until the new one is whole.
pub(super) fn write(path: &Path, content: impl AsRef<[u8]>) -> anyhow::Result<()> {
    let is_device = fs::metadata(path).is_ok_and(|file| !file.is_file());
    let written = match is_device {
        true => fs::write(path, content),
        false => replace(path, content.as_ref()),
    };
    written.with_context(|| format!("cannot write {}", path.display()))
}

fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    let mut new = tempfile::Builder::new();
    // As any file is made, less what the user's mask takes away.
    let mut file = new
        .permissions(PermissionsExt::from_mode(0o666))
        .tempfile_in(folder.unwrap_or(Path::new(".")))?;
    file.write_all(content)?;
    file.persist(path)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_as_a_whole_and_a_device_is_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("figure.svg");
        write(&path, "long before").unwrap();
        let before = fs::File::open(&path).unwrap();
        write(&path, "new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(io::read_to_string(before).unwrap(), "long before");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        write(Path::new("/dev/null"), "gone").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    #[test]
    fn where_nothing_can_be_written_is_named() {
        let refused = write(Path::new("/nowhere/figure.svg"), "").unwrap_err();
        assert_eq!(refused.to_string(), "cannot write /nowhere/figure.svg");
    }
}
