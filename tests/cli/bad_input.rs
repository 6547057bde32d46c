//! Input that is refused: the words, the exit code, and what it must not cost.

use std::fs;
use std::path::Path;
use std::process::Output;

use super::*;

#[test]
fn arguments_that_make_no_sense_are_usage_errors() {
    let place = Place::new();
    let poses = place.write("p.csv", &format!("{HEADER}1,0,0,0,0,0,0\n"));
    let scene = place.write(
        "poses.toml",
        "version = 1\nfixed.mesh = 'a.stl'\nmoving.mesh = 'b.stl'\nscenarios.poses = 'p.csv'\n",
    );
    let cases: [(&[&str], &[&str]); 13] = [
        (&["run", "--workers", "0"], &["--workers", "0 is not a number of workers"]),
        (&["run", "--workers", "many"], &["--workers", "'many' is not a number"]),
        (&["run", "--count", "0"], &["--count"]),
        (&["run", "--count=-3"], &["--count", "-3"]),
        (&["run", "--poses", &poses, "--seed", "3"], &["--seed", "--poses"]),
        (&["run", &scene, "--seed", "3"], &["--seed", "p.csv", "nothing is random"]),
        (&["run", "--contacts"], &["--out"]),
        (&["run", "--fixed", "builtin:tank"], &["--fixed", "tank"]),
        (&["drive"], &["drive"]),
        (&["run", "--compress", "zip"], &["--compress", "lz4"]),
        (&["run", "--subtrees-from", "workers", "--transport", "threads"], &["subtrees_from"]),
        (&["run", "--compress", "lz4"], &["compress = lz4", "iceoryx2", "pipe or socket"]),
        (&["bench", "engine", "--over", "pipe,threads", "--compress", "lz4"], &["over threads"]),
    ];
    for (arguments, words) in cases {
        refused(&place.run(arguments), 2, words);
    }
}

#[test]
fn an_instruction_set_that_cannot_be_had_is_a_usage_error() {
    let place = Place::new();
    let output = place.bumper(&["run"]).env("BUMPER_SIMD", "sse9").output().unwrap();
    refused(&output, 2, &["BUMPER_SIMD", "sse9", "portable"]);
}

/// Each of them would do all of the work, and write the same files.
#[test]
#[cfg(not(feature = "mpi"))]
fn ranks_of_a_job_that_know_nothing_of_each_other_are_a_usage_error() {
    let place = Place::new();
    let rank = |number: &str| {
        let mut command = place.bumper(&["run"]);
        command.env("OMPI_COMM_WORLD_SIZE", "2").env("OMPI_COMM_WORLD_RANK", number);
        command.output().unwrap()
    };
    for number in ["0", "1"] {
        refused(&rank(number), 2, &["several ranks", "--features mpi"]);
    }
}

#[test]
fn bad_scenes_are_refused_with_their_line() {
    let place = Place::new();
    let base = "version = 1\nfixed.mesh = 'a.stl'\nmoving.mesh = 'b.stl'\n";
    let cases = [
        ("scenarios.random = { count = -1 }", "bad.toml:4: `scenarios.random.count`: -1"),
        ("scenarios.random = { count = 1, sed = 2 }", "did you mean `seed`?"),
        ("scenarios.random = { count = 1 }\nengine.workers = 0", "bad.toml:5: `engine.workers`: 0"),
        ("scenarios.random = { count = 1 ", "bad.toml:4"),
    ];
    for (lines, words) in cases {
        let scene = place.write("bad.toml", &format!("{base}{lines}\n"));
        refused(&place.run(&["run", &scene]), 2, &["bad.toml", words]);
    }
    refused(&place.run(&["run", &place.text("no.toml")]), 1, &["no.toml", "cannot read the scene"]);
}

#[test]
fn bad_poses_are_refused_with_their_line_and_field() {
    let place = Place::new();
    let cases = [
        (String::new(), "p.csv:1: nothing where the header"),
        (HEADER.to_owned(), "p.csv: there is no pose"),
        (format!("{HEADER}1,0,0,0,0,0,0\n1,0,0,nan,0,0,0\n"), "p.csv:3: qz is not a finite"),
        (format!("{HEADER}1,0,0\n"), "p.csv:2: 3 fields where 7 are wanted"),
        (format!("{HEADER}1,1,0,0,0,0,0\n"), "p.csv:2: the quaternion has length 1.4"),
    ];
    for (text, words) in cases {
        let poses = place.write("p.csv", &text);
        let run = ["run", "--fixed", CAR, "--moving", CAR, "--poses", &poses, "--out"];
        let output = place.run(&[&run[..], &[&place.text("out")]].concat());
        refused(&output, 1, &[words]);
        assert!(!place.path("out/scenarios.csv").exists());
    }
}

#[test]
fn bad_meshes_are_refused_by_name() {
    let place = Place::new();
    let empty = place.write("empty.stl", "");
    let hostile = place.write(
        "hostile.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
         property float z\nelement face 4000000000\nproperty list uchar int vertex_indices\n\
         end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    );
    for mesh in [&empty, &hostile, &place.text("missing.obj")] {
        let name = Path::new(mesh).file_name().unwrap().to_str().unwrap();
        refused(&place.run(&["run", "--fixed", mesh, "--moving", CAR]), 1, &[name, "fixed mesh"]);
        refused(&place.run(&["run", "--moving", mesh, "--fixed", CAR]), 1, &[name, "moving mesh"]);
        refused_info(&place.run(&["mesh", "info", mesh]), name);
    }
}

/// Workers tell the corner of a triangle; the file's vertex is looked up by the master.
#[test]
fn a_pose_that_overflows_is_refused_and_names_the_vertex() {
    let place = Place::new();
    let fixed = place.write("fixed.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    // The unused one would overflow as well.
    let vertices = "v 0 0 0\nv 0 1.7e308 0\nv 1 0 0\nv 0 1e308 0\nv 0 1.1e308 0\n";
    let moving = place.write("moving.obj", &format!("{vertices}f 1 3 3\nf 1 3 4\nf 5 4 1\n"));
    let poses = format!("{HEADER}1,0,0,0,0,0,0\n1,0,0,0,0,1e308,0\n");
    let poses = place.write("p.csv", &poses);
    for transport in ["iceoryx2", "threads", "pipe"] {
        let scene = ["run", "--fixed", &fixed, "--moving", &moving, "--poses", &poses];
        let output =
            place.run(&[&scene[..], &["--workers", "1", "--transport", transport]].concat());
        let words = ["vertex 3 of the moving mesh", "scenario 1: corner 2 of triangle 1 of"];
        refused(&output, 1, &words);
    }
}

fn refused_info(output: &Output, name: &str) {
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(output).contains(name), "{}", stderr(output));
}

#[test]
fn an_output_directory_is_refused_before_any_work() {
    let place = Place::new();
    let file = place.write("file", "not a folder");
    let foreign = place.path("foreign");
    fs::create_dir(&foreign).unwrap();
    fs::write(foreign.join("summary.json"), "mine").unwrap();
    // The mesh is missing too: the directory is looked at first.
    let missing = place.text("missing.stl");
    let cases = [
        (file.clone(), "cannot write results here"),
        (format!("{file}/below"), "cannot write results here"),
        ("/proc/bumper".to_owned(), "cannot write results here"),
        (foreign.to_str().unwrap().to_owned(), "not of an earlier run"),
    ];
    for (out, words) in cases {
        refused(&place.run(&["run", "--fixed", &missing, "--out", &out]), 1, &[&out, words]);
    }
    assert_eq!(fs::read_to_string(foreign.join("summary.json")).unwrap(), "mine");
}

#[test]
fn a_failed_run_leaves_earlier_results_alone() {
    let place = Place::new();
    let out = place.text("out");
    succeeded(&place.run_small(&["--out", &out]));
    let before = fs::read(place.path("out/summary.json")).unwrap();
    let missing = place.text("missing.stl");
    refused(&place.run(&["run", "--fixed", &missing, "--out", &out]), 1, &["missing.stl"]);
    assert_eq!(fs::read(place.path("out/summary.json")).unwrap(), before);
}

#[test]
fn a_run_that_cannot_begin_leaves_earlier_results_alone() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::new();
    let out = place.text("out");
    succeeded(&place.run_small(&["--out", &out, "--contacts"]));
    let files = ["summary.json", "scenarios.csv", "contacts.parquet"];
    let read = || files.map(|name| fs::read(place.path("out").join(name)).unwrap());
    let before = read();
    // Refused by the transport, which starts when everything else is ready.
    for home in fs::read_dir(place.path("runtime")).unwrap() {
        let open_to_others = fs::Permissions::from_mode(0o755);
        fs::set_permissions(home.unwrap().path(), open_to_others).unwrap();
    }
    refused(&place.run_small(&["--out", &out]), 1, &["0700"]);
    assert_eq!(read(), before);
}

/// A limit on the size of files stands for a disk that is full.
#[test]
fn a_full_disk_keeps_every_whole_row() {
    use std::os::unix::process::CommandExt;
    const LIMIT: u64 = 2 << 20;
    let place = Place::new();
    let triangle = place.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let poses = place.write("p.csv", &format!("{HEADER}{}", "1,0,0,0,0,0,0\n".repeat(100_000)));
    let out = place.text("out");
    let scene = ["run", "--fixed", &triangle, "--moving", &triangle, "--poses", &poses];
    let mut command =
        place.bumper(&[&scene[..], &["--out", &out, "--contacts", "--no-cache"]].concat());
    let limit = libc::rlimit { rlim_cur: LIMIT, rlim_max: LIMIT };
    // SAFETY: both calls may be made between fork and exec, and take what lives until then.
    unsafe {
        command.pre_exec(move || {
            libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
            match libc::setrlimit(libc::RLIMIT_FSIZE, &limit) {
                0 => Ok(()),
                _ => Err(std::io::Error::last_os_error()),
            }
        });
    }
    let words = ["scenarios.csv: cannot be completed", "File too large", "answered before"];
    refused(&command.output().unwrap(), 1, &words);
    let text = fs::read_to_string(place.path("out/scenarios.csv")).unwrap();
    assert!(text.ends_with('\n') && text.len() as u64 > LIMIT - 100, "{} bytes", text.len());
    let rows = scenarios(&place.path("out/scenarios.csv"));
    assert!(rows.iter().enumerate().all(|(number, row)| row.0 as usize == number), "no gap");
    assert_eq!(contacts(&place.path("out/contacts.parquet")).len(), rows.len());
}
