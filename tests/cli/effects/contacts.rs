//! How many pairs of triangles are kept, and which do not count.

use super::*;

/// Two small cars that overlap in the first two scenarios, with more keys of the moving and the fixed
/// one and of the effects.
fn scene(place: &Place, parts: &str, effects: &str) -> String {
    place.write(
        "p.csv",
        &format!("{HEADER}0,0,0,1,4.3,0.2,0\n0.8,0,0,0.6,1,0.2,0.1\n1,0,0,0,9,0,0\n"),
    );
    let mesh = "mesh = 'builtin:car?triangles=1000'\n";
    let text = format!(
        "version = 1\n[scenarios]\nposes = 'p.csv'\n[fixed]\n{mesh}[moving]\n{mesh}{parts}\
         [effects]\n{effects}\n"
    );
    place.write("scene.toml", &text)
}

/// The scenario and the pair of each row.
fn pairs(run: &Run) -> Vec<[u32; 3]> {
    let numbers = |row: &BTreeMap<String, f64>| {
        ["scenario", "fixed_triangle", "moving_triangle"].map(|name| row[name] as u32)
    };
    run.table("contacts").iter().map(numbers).collect()
}

#[test]
fn the_first_contacts_are_kept_and_all_are_counted() {
    let place = Place::new();
    let all = Run::of(&place, &scene(&place, "", ""), &["--contacts"]);
    let few = Run::of(&place, &scene(&place, "", "max_contacts = 7"), &["--contacts"]);
    assert_eq!(few.csv, all.csv, "the hash is that of all pairs");
    let of = |run, scenario| pairs(run).into_iter().filter(move |row| row[0] == scenario);
    for scenario in 0..3 {
        assert!(of(&few, scenario).eq(of(&all, scenario).take(7)), "scenario {scenario}");
    }
    assert_eq!([0, 1, 2].map(|scenario| of(&few, scenario).count()), [7, 7, 0]);
}

const PARTS: &str = "[[fixed.parts]]\nname = 'front'\ntriangles = [[0, 99], [700, 799]]\n\
                     [[fixed.parts]]\nname = 'rest'\ntriangles = [[100, 699], [800, 995]]\n\
                     [[moving.parts]]\nname = 'half'\ntriangles = [[0, 499]]\n\
                     [[moving.parts]]\nname = 'other half'\ntriangles = [[500, 995]]\n";

#[test]
fn ignored_parts_take_out_their_pairs_and_no_others() {
    let place = Place::new();
    let all = Run::of(&place, &scene(&place, PARTS, ""), &["--contacts"]);
    let ignore = "segments = true\nignore = [['front', 'half'], ['rest', 'other half']]";
    let some = Run::of(&place, &scene(&place, PARTS, ignore), &["--contacts"]);
    let front = |n: u32| n < 100 || (700..800).contains(&n);
    let kept = |row: &[u32; 3]| front(row[1]) != (row[2] < 500);
    let expected: Vec<[u32; 3]> = pairs(&all).into_iter().filter(kept).collect();
    assert!(!expected.is_empty() && expected.len() < pairs(&all).len());
    assert_eq!(pairs(&some), expected);
    for (scenario, count) in some.numbers("pairs").into_iter().enumerate() {
        let pairs: Vec<[u32; 2]> = expected
            .iter()
            .filter(|row| row[0] as usize == scenario)
            .map(|row| [row[1], row[2]])
            .collect();
        assert_eq!(count, Some(pairs.len() as f64));
        let hash = format!("{:016x}", bumper::effects::contacts::pairs_fnv1a64(&pairs));
        assert_eq!(some.cells("pairs_fnv1a64")[scenario], hash);
    }
    // What does not count has no segments.
    let segments = some.table("segments");
    let in_segments = |row: &[u32; 3]| {
        segments.iter().any(|s| {
            ["scenario", "fixed_triangle", "moving_triangle"].map(|name| s[name] as u32) == *row
        })
    };
    assert!(pairs(&all).iter().all(|row| in_segments(row) == kept(row)));
}

#[test]
fn overlap_does_not_see_what_is_ignored() {
    let place = Place::new();
    let overlap = |ignore: &str| {
        let effects = format!("overlap = true\nignore = [{ignore}]");
        let run = Run::of(&place, &scene(&place, PARTS, &effects), &[]);
        assert_eq!(run.header, ["scenario", "colliding"]);
        run.cells("colliding").concat()
    };
    let all =
        "['front', 'half'], ['front', 'other half'], ['rest', 'half'], ['rest', 'other half']";
    let lists = ["", "['front', 'half']", all];
    assert_eq!(lists.map(overlap), ["110", "110", "000"]);
    // All but the pairs of one part.
    let rest = all.split_once(", ['rest', 'other half']").unwrap().0;
    let all = Run::of(&place, &scene(&place, PARTS, ""), &["--contacts"]);
    let of_rest = |row: &[u32; 3]| row[2] >= 500 && row[1] >= 100 && !(700..800).contains(&row[1]);
    let touch = |n| pairs(&all).iter().any(|row| row[0] == n && of_rest(row));
    let expected: String = (0..3).map(|n| if touch(n) { "1" } else { "0" }).collect();
    assert_eq!(overlap(rest), expected);
}
