//! `bumper report`: outputs of commands as one page to read.

use std::path::Path;

use anyhow::Context;

use super::args::ReportArgs;
use super::failure::Failure;
use super::files::{make_folder, write};
use super::terminal;
use crate::report::figure::grouped;
use crate::report::source::{Section, Source, sections};
use crate::report::{Drawing, page, svg_files};

pub(super) fn run(args: &ReportArgs) -> Result<(), Failure> {
    let mut all: Vec<Section> = Vec::new();
    for directory in &args.directories {
        all.extend(sections(directory)?);
    }
    let html = page::html(&all)?;
    let drawings = || all.iter().flat_map(|section| &section.drawings);
    if let Some(folder) = &args.svg {
        write_figures(folder, drawings())?;
    }
    write(&args.out, &html)?;
    let (figures, kilobytes) = (drawings().count(), grouped(html.len() as u64 / 1000));
    let out = args.out.display();
    let text = format!("{out}: {figures} figures, {kilobytes} kB\n");
    Ok(terminal::print(&text).context("cannot print where the report is")?)
}

/// A command's output and its figures beside it. What is drawn is read from what is written.
pub(super) fn write_output(out: &Path, source: Source, json: &str) -> anyhow::Result<Vec<Drawing>> {
    write(&out.join(source.file()), json)?;
    let drawings = source.section(out, json.to_owned())?.drawings;
    write_figures(out, &drawings)?;
    Ok(drawings)
}

/// Each as a file of its name in a directory, which is made where there is none.
fn write_figures<'a>(
    folder: &Path,
    drawings: impl IntoIterator<Item = &'a Drawing>,
) -> anyhow::Result<()> {
    let files = svg_files(drawings)?;
    make_folder(folder)?;
    files.iter().try_for_each(|(name, svg)| write(&folder.join(name), svg))
}
