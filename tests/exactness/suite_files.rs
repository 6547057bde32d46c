//! Files of hard cases from outside: read as they are, or refused by name and line.

use bumper::geometry::Pose;
use bumper::hardcases::{Cases, Report, Row, Suite, check};
use bumper::tree::Accuracy;
use proptest::prelude::*;

const ONE: &str = "3ff0000000000000";
const ZERO: &str = "0000000000000000";

/// Two equal triangles, or one of them two higher.
fn pair(truth: &str, kind: &str, touching: bool) -> String {
    let height = if touching { ZERO } else { "4000000000000000" };
    let triangle = |z: &str| format!("{ZERO} {ZERO} {z} {ONE} {ZERO} {z} {ZERO} {ONE} {z}");
    format!("my_family {truth} {kind} {} {}", triangle(ZERO), triangle(height))
}

const MESHES: &str = "# two cases
case twins_00 3 1 3 1 1
q 3ff0000000000000 0000000000000000 0000000000000000 0000000000000000
R 3ff0000000000000 0000000000000000 0000000000000000 0000000000000000 3ff0000000000000 \
0000000000000000 0000000000000000 0000000000000000 3ff0000000000000
t 0000000000000000 0000000000000000 0000000000000000
v 0000000000000000 0000000000000000 0000000000000000
v 3ff0000000000000 0000000000000000 0000000000000000
v 0000000000000000 3ff0000000000000 0000000000000000
f 0 1 2
v 0000000000000000 0000000000000000 0000000000000000
v 3ff0000000000000 0000000000000000 0000000000000000
v 0000000000000000 3ff0000000000000 0000000000000000
f 2 1 0
p 0 0
";

fn refusal(text: &str) -> String {
    Suite::parse(text.as_bytes(), "my.txt").expect_err("refused").to_string()
}

#[test]
fn comments_blank_lines_and_any_line_ends_are_read_over() {
    let (hit, miss) = (pair("1", "area", true), pair("0", "none", false));
    for text in [
        format!("{hit}\n{miss}\n"),
        format!("\u{feff}# mine\r\n\r\n{hit}\r\n  {miss}"),
        format!("\n\n{}\n# more\n{miss}\n", hit.replace(' ', " \t ")),
    ] {
        let Cases::Pairs(cases) = Suite::parse(text.as_bytes(), "my.txt").unwrap().cases else {
            panic!("these are pairs");
        };
        assert_eq!(cases.len(), 2);
        assert!(cases[0].intersect() && !cases[1].intersect() && cases[0].family == "my_family");
        assert_eq!(text.lines().nth(cases[1].line - 1).unwrap().trim(), miss);
    }
}

#[test]
fn meshes_are_read_with_their_pose_and_pairs() {
    let suite = Suite::parse(MESHES.as_bytes(), "my.txt").unwrap();
    let Cases::Meshes(cases) = &suite.cases else { panic!("these are meshes") };
    assert_eq!((cases.len(), cases[0].line, cases[0].family()), (1, 2, "twins"));
    assert_eq!((cases[0].pose, &cases[0].pairs[..]), (Pose::IDENTITY, &[[0, 0]][..]));
    assert!(check(&[suite], &|_| ()).wrong.is_empty());
}

#[test]
fn what_is_not_a_suite_is_refused_with_its_line() {
    let good = pair("1", "area", true);
    let cases = [
        (String::new(), "my.txt: there is no case in it"),
        ("# nothing\n\n".to_owned(), "my.txt: there is no case in it"),
        ("solid cube".to_owned(), "my.txt:1: 2 fields where 21 are wanted"),
        (format!("{good}\n{good} {ONE}"), "my.txt:2: 22 fields where 21 are wanted"),
        (pair("2", "area", true), "my.txt:1: '2' where the truth, 0 or 1, is wanted"),
        (pair("1", "volume", true), "'volume' where none, point, segment or area is wanted"),
        (pair("0", "area", true), "my.txt:1: truth 0 does not go with the kind area"),
        (good.replacen(ONE, "7ff0000000000000", 1), "my.txt:1: inf is not a finite number"),
        (good.replacen(ONE, "7ff8000000000000", 1), "my.txt:1: NaN is not a finite number"),
        (good.replacen(ONE, "3ff000000000000", 1), "'3ff000000000000' where an f64 as 16"),
        (good.replacen(ONE, "+ff0000000000000", 1), "'+ff0000000000000' where an f64 as 16"),
        (MESHES.replace(" 3 1 1\n", " 3 1\n"), "my.txt:2: 5 fields where 6 are wanted"),
        (MESHES.replace(" 3 1 1\n", " 3 1 -1\n"), "'-1' where a number below 2^32 is wanted"),
        (MESHES.replace(" 3 1 1\n", " 3 1 4294967295\n"), "my.txt:14: the file ends here, a pair"),
        (MESHES.replace("twins_00 3", "twins_00 4"), "my.txt:9: 'f' where v is wanted"),
        (MESHES.replace("f 0 1 2", "f 0 1 3"), "my.txt:9: the fixed mesh: triangle 0: vertex"),
        (MESHES.replace("p 0 0", "p 0 1"), "my.txt:14: the pair 0 1 is not of the meshes'"),
        (
            MESHES.replace(" 3 1 1\n", " 3 1 2\n") + "p 0 0\n",
            "my.txt:15: the pair 0 0 does not come after the one before it",
        ),
        (MESHES.replace("t 0", "T 0"), "my.txt:5: 'T' where t is wanted"),
        (format!("{MESHES}\n{good}"), "my.txt:16: 'my_family' where case is wanted"),
        ([ONE; 22].join(" ") + "\n" + ONE, "my.txt:2: 1 fields where 22 are wanted"),
    ];
    for (text, words) in cases {
        let refusal = refusal(&text);
        assert!(refusal.contains(words), "{refusal}: {words}");
    }
    let not_text = Suite::parse(b"\xff\xfe\x00", "my.txt").unwrap_err().to_string();
    assert!(
        not_text.starts_with("my.txt:1: '") && not_text.ends_with("where text in UTF-8 is wanted")
    );
    let cut = &[0x1f, 0x8b, 8, 0, 0];
    assert!(Suite::parse(cut, "my.txt").unwrap_err().to_string().starts_with("my.txt: gzip: "));
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let refusal = |path: &std::path::Path| Suite::read(path).unwrap_err().to_string();
    assert!(refusal(&folder.path().join("no.txt")).contains("no.txt: cannot be read: No such"));
    assert!(refusal(folder.path()).ends_with("is not a regular file, give a file of hard cases"));
}

fn exact(report: &Report) -> Vec<&Row> {
    report.rows.iter().filter(|row| row.level == Accuracy::EXACT).collect()
}

#[test]
fn wrong_truths_are_found_in_every_way_and_named() {
    let text = format!("{}\n{}\n", pair("1", "area", true), pair("1", "point", false));
    let report = check(&[Suite::parse(text.as_bytes(), "my.txt").unwrap()], &|_| ());
    assert_eq!(report.cases, 2);
    assert!(exact(&report).iter().all(|row| (row.cases, row.wrong) == (2, 1)), "{report:?}");
    assert_eq!(report.wrong.len(), exact(&report).len());
    assert!(report.wrong.iter().all(|w| (w.line, &*w.family) == (2, "my_family")));

    let text = MESHES.replace(" 3 1 1\n", " 3 1 0\n").replace("p 0 0\n", "");
    let report = check(&[Suite::parse(text.as_bytes(), "my.txt").unwrap()], &|_| ());
    let wrong = exact(&report).iter().filter(|row| row.wrong == 1).count();
    assert!(wrong == exact(&report).len() - 1, "all but the pose: {report:?}");

    let numbers = |pose: [&str; 10], rest: [&str; 12]| [&pose[..], &rest[..]].concat().join(" ");
    let at_rest = [ONE, ZERO, ZERO, ZERO, ZERO, ZERO, ZERO, ONE, ONE, ONE];
    let [o, z] = [ONE, ZERO];
    let truth = numbers(at_rest, [o, z, z, z, o, z, z, z, o, o, o, o]);
    let minus_zero = numbers(at_rest, [o, "8000000000000000", z, z, o, z, z, z, o, o, o, o]);
    let text = format!("{truth}\n{minus_zero}\n");
    let report = check(&[Suite::parse(text.as_bytes(), "my.txt").unwrap()], &|_| ());
    assert_eq!((report.rows[0].wrong, report.wrong[0].line), (1, 2), "{report:?}");
}

proptest! {
    #![proptest_config(super::config(1_000))]

    #[test]
    fn damaged_files_are_read_or_refused_and_never_panic(
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        meshes: bool,
    ) {
        let text = if meshes { MESHES.to_owned() } else { pair("1", "area", true).repeat(2) };
        let mut bytes = text.into_bytes();
        for (at, value) in damage {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        for end in [bytes.len(), cut.index(bytes.len())] {
            if let Ok(suite) = Suite::parse(&bytes[..end], "my.txt") {
                prop_assert!(!suite.is_empty());
            }
        }
    }
}
