//! Rules of the source that the compiler does not check.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use bumper::experiment::cluster::config::Config;
use bumper::experiment::evaluation;
use bumper::scene::{DEFAULT_SCENE, Scene};

/// A module imports only modules of layers further down (or itself).
const LAYERS: &[&[&str]] = &[
    &["geometry"],
    &["mesh"],
    &["tree"],
    &["effects"],
    &["scene", "hardcases"],
    &["transport"],
    &["wire"],
    &["workers"],
    &["scheduler"],
    &["report"],
    &["experiment"],
    &["cli"],
];

/// Knows bytes, and nothing of ours.
const STANDS_ALONE: &str = "transport";

/// Crates that one file each names, or one folder; so that they can be exchanged.
const BACKENDS: &[(&str, &str)] = &[
    ("iceoryx2", "src/transport/shared_memory"),
    ("mpi", "src/transport/mpi.rs"),
    ("parquet", "src/report/parquet.rs"),
    ("memmap2", "src/kernel/tree/subtree/pages.rs"),
    ("lz4_flex", "src/kernel/tree/subtree/compressed.rs"),
    ("indicatif", "src/cli"),
    ("clap", "src/cli"),
    ("anyhow", "src/cli"),
    ("signal_hook", "src/cli/interrupt.rs"),
    ("rand_chacha", "src/scene/random/draw.rs"),
    ("strsim", "src/scene/file.rs"),
    ("flate2", "src/kernel/mesh/gzip.rs"),
    ("base64", "src/kernel/mesh/base64.rs"),
    ("getrandom", "src/transport/peer.rs"),
];

/// The package of what is computed.
const KERNEL: &str = "src/kernel";

const LONGEST_FILE: usize = 450;

const MEANINGLESS_NAMES: &[&str] = &["utils", "util", "common", "helpers", "types", "misc"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Path relative to the root, and text, of every file with one of the extensions.
fn files(folders: &[&str], extensions: &[&str]) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> = folders.iter().map(|folder| root().join(folder)).collect();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| extensions.iter().any(|wanted| e == *wanted))
            {
                let name = path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned();
                found.push((name, fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

fn library() -> Vec<(String, String)> {
    files(&["src", "workers"], &["rs"])
}

/// The top-level module that a file belongs to.
fn module(name: &str) -> Option<&str> {
    let name = name.strip_prefix("src/").unwrap_or(name);
    let name = name.strip_prefix("kernel/").unwrap_or(name);
    let first = name.split('/').next()?;
    let module = first.strip_suffix(".rs").unwrap_or(first);
    (module != "lib" && module != "main").then_some(module)
}

fn layer(module: &str) -> usize {
    LAYERS
        .iter()
        .position(|modules| modules.contains(&module))
        .unwrap_or_else(|| panic!("module {module} has no layer"))
}

/// Without comments and doc comments, line by line: links in documentation may point anywhere.
fn code(text: &str) -> String {
    let without_comment = |line: &str| line.split("//").next().unwrap_or_default().to_owned();
    text.lines().map(without_comment).collect::<Vec<_>>().join("\n")
}

/// Top-level modules that follow `crate::` in code, alone or in braces.
fn imports(code: &str) -> BTreeSet<String> {
    let identifier = |text: &str| -> String {
        text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
    };
    let mut modules = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            None => modules.extend([identifier(rest)]),
            Some(list) => modules.extend(first_of_each(list).iter().map(|item| identifier(item))),
        }
    }
    modules
}

/// The items of a brace list whose opening brace is gone, without what nests in them.
fn first_of_each(list: &str) -> Vec<String> {
    let (mut depth, mut items) = (0, vec![String::new()]);
    for character in list.chars() {
        match character {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => items.push(String::new()),
            _ if depth == 0 && !character.is_whitespace() => {
                items.last_mut().expect("never empty").push(character);
            }
            _ => {}
        }
    }
    items.retain(|item| !item.is_empty());
    items
}

#[test]
fn imports_are_found_in_every_form() {
    let code = "use crate::a::B;\nuse crate::{c::{D, E}, f};\nlet x = crate::g::h();";
    let expected: BTreeSet<String> = ["a", "c", "f", "g"].map(str::to_owned).into();
    assert_eq!(imports(code), expected);
}

#[test]
fn imports_go_downwards_only() {
    for (name, text) in library() {
        let Some(own) = module(&name) else { continue };
        for imported in imports(&code(&text)).iter().filter(|imported| *imported != own) {
            assert!(own != STANDS_ALONE, "{name} imports {imported}");
            assert!(layer(imported) < layer(own), "{name} imports {imported} from above");
        }
    }
}

/// Whether code names a crate, not a module or an item of ours of the same name.
fn names(krate: &str, code: &str) -> bool {
    let starts_a_path = |at: usize| {
        let before = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        !code[..at].ends_with(before)
    };
    code.match_indices(&format!("{krate}::")).any(|(at, _)| starts_a_path(at))
}

#[test]
fn each_backend_crate_is_named_in_one_place() {
    for (krate, place) in BACKENDS {
        for (name, text) in library() {
            let allowed = name.starts_with(place) || !names(krate, &code(&text));
            assert!(allowed, "{name} names {krate}; only {place} may");
        }
    }
}

#[test]
fn every_dependency_is_used() {
    for (package, is_kernel) in [("", false), (KERNEL, true)] {
        let manifest = root().join(package).join("Cargo.toml");
        let manifest: toml::Table = toml::from_str(&fs::read_to_string(manifest).unwrap()).unwrap();
        let own = |(name, _): &&(String, String)| name.starts_with(KERNEL) == is_kernel;
        let code: String = library().iter().filter(own).map(|(_, text)| code(text)).collect();
        for krate in manifest["dependencies"].as_table().unwrap().keys() {
            let krate = krate.replace('-', "_");
            assert!(names(&krate, &code), "{krate} is a dependency that nothing uses");
        }
    }
}

#[test]
fn files_are_short_and_their_names_mean_something() {
    for (name, text) in files(&["src", "workers", "tests", "benches"], &["rs"]) {
        let lines = text.lines().count();
        assert!(lines <= LONGEST_FILE, "{name} has {lines} lines");
        for part in name.trim_end_matches(".rs").split('/') {
            assert!(!MEANINGLESS_NAMES.contains(&part), "{name} says nothing");
        }
    }
}

#[test]
fn no_file_knows_the_machine_it_was_written_on() {
    let everything = files(
        &["src", "workers", "tests", "benches", "config", ".ci", ".github"],
        &["rs", "toml", "md", "yml", "sh"],
    );
    let top = ["README.md", "ARCHITECTURE.md", "Cargo.toml", ".ci/run"];
    let top = top
        .iter()
        .filter_map(|name| Some(((*name).to_owned(), fs::read_to_string(root().join(name)).ok()?)));
    for (name, text) in everything.into_iter().chain(top) {
        for forbidden in ["/work/", "/home/", "/root/", "../shared"] {
            let own_list = name == "tests/tidy.rs";
            assert!(own_list || !text.contains(forbidden), "{name} names {forbidden}");
        }
    }
}

#[test]
fn every_unsafe_block_says_why_it_is_sound() {
    for (name, text) in files(&["src", "workers", "tests", "benches"], &["rs"]) {
        let lines: Vec<&str> = text.lines().collect();
        for (number, line) in lines.iter().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            let opens = ["unsafe {", "unsafe impl"].iter().any(|form| code.contains(form));
            if !opens || name == "tests/tidy.rs" {
                continue;
            }
            let above = &lines[number.saturating_sub(8)..number];
            // A file of one-line intrinsics says it once, above all of them.
            let explained = above.iter().any(|line| line.trim_start().starts_with("// SAFETY:"))
                || lines[..number].iter().any(|line| line.starts_with("// SAFETY of every block"));
            assert!(explained, "{name}:{}: unsafe without SAFETY", number + 1);
        }
    }
}

#[test]
fn every_scene_and_cluster_in_config_is_valid() {
    let scenes = files(&["config"], &["toml"]);
    assert!(scenes.iter().any(|(name, _)| name == "config/default.toml"));
    for (name, _) in scenes {
        let path = root().join(&name);
        let folder = name.split('/').nth(1).filter(|_| !name.ends_with("_scene.toml"));
        match folder {
            // Held by a test of its own.
            Some("experiments") => continue,
            Some("clusters") => Config::read(&path).map(drop),
            _ => Scene::read(&path).map(drop),
        }
        .unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn every_experiment_in_config_is_part_of_the_program() {
    let mut names = evaluation::NAMES.map(|name| format!("config/experiments/{name}.toml"));
    names.sort();
    let there: Vec<String> =
        files(&["config/experiments"], &["toml"]).into_iter().map(|(name, _)| name).collect();
    assert_eq!(there, names);
}

/// The keys are those that the reader itself lists when it refuses one.
#[test]
fn the_default_scene_documents_every_key() {
    let tables =
        ["", "fixed", "moving", "tree", "scenarios", "scenarios.random", "engine", "effects"];
    let optional = ["motion", "effects.clearance", "effects.penetration", "effects.response"];
    let optional = optional.into_iter().chain(["effects.crush", "fixed.stiffness"]);
    for table in tables.into_iter().chain(optional) {
        let text = with_unknown_key(table);
        let error = Scene::parse(&text, "scene", Path::new("")).unwrap_err().to_string();
        let known = error.split_once("expected").unwrap_or_else(|| panic!("{error}")).1;
        let known = known.split("; did you mean").next().unwrap();
        let keys: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
        assert!(!keys.is_empty(), "{error}");
        for key in keys {
            let documented = [format!("{key} = "), format!("[{key}]")];
            assert!(
                documented.iter().any(|form| DEFAULT_SCENE.contains(form)),
                "config/default.toml lacks {table}.{key}"
            );
        }
    }
}

/// The default scene with a key in one of its tables that does not exist.
fn with_unknown_key(table: &str) -> String {
    match table {
        "" => format!("unknown_key = 1\n{DEFAULT_SCENE}"),
        "motion" => format!("{DEFAULT_SCENE}\n[motion]\nunknown_key = 1\n"),
        table if table.starts_with("effects.") || table == "fixed.stiffness" => {
            let (head, name) = table.split_once('.').expect("a table in a table");
            let head = format!("\n[{head}]\n");
            let given = format!("{head}{name} = {{ unknown_key = 1 }}\n");
            DEFAULT_SCENE.replacen(&head, &given, 1)
        }
        "scenarios.random" => DEFAULT_SCENE.replacen("{ count", "{ unknown_key = 1, count", 1),
        _ => {
            let head = format!("\n[{table}]\n");
            assert!(DEFAULT_SCENE.contains(&head), "[{table}] is not in the default scene");
            DEFAULT_SCENE.replacen(&head, &format!("{head}unknown_key = 1\n"), 1)
        }
    }
}

/// What runs each command of the README; a command that nothing runs may be wrong.
#[test]
fn every_command_of_the_readme_is_run_by_something() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let checks = fs::read_to_string(root().join(".ci/run")).unwrap();
    let tests: String = files(&["tests/cli"], &["rs"]).into_iter().map(|(_, text)| text).collect();
    let commands: Vec<&str> = readme
        .split("```sh\n")
        .skip(1)
        .flat_map(|block| block.split("```").next().unwrap_or_default().lines())
        .collect();
    assert!(commands.len() >= 4);
    for command in commands {
        let by_ci = checks.lines().any(|line| line == command);
        assert!(by_ci || tests.contains(&format!("\"{command}\"")), "nothing runs: {command}");
    }
}
