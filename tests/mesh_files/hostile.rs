use proptest::prelude::*;

use crate::writers::{Body, every_variant};
use crate::{assert_refused, load_path, parse, refusal};

const EXTENSIONS: [&str; 7] = ["ply", "obj", "stl", "glb", "gltf", "wrl", "wrz"];

const OPENINGS: [&[u8]; 6] =
    [b"", b"ply\n", b"solid\n", b"glTF\x02\0\0\0", b"#VRML V2.0 utf8\n", b"\x1f\x8b\x08"];

#[test]
fn an_empty_file_is_refused() {
    for extension in EXTENSIONS {
        assert_refused(
            &format!("m.{extension}"),
            b"",
            &format!("m.{extension}: the file is empty"),
        );
    }
    assert_refused("mesh", b"", "mesh: the file is empty");
}

#[test]
fn a_truncated_file_never_reads_as_a_smaller_mesh() {
    for body in [Body::house(), Body::crooked()] {
        for variant in every_variant(&body) {
            let knows_its_end = !variant.name.ends_with(".obj") && variant.name != "no extension";
            let whole = parse(variant.name, &variant.bytes).expect(variant.name);
            for length in 0..variant.bytes.len() {
                let Ok(mesh) = parse(variant.name, &variant.bytes[..length]) else { continue };
                let counts = (mesh.vertices().len(), mesh.faces().len());
                let expected = (whole.vertices().len(), whole.faces().len());
                let same =
                    counts == expected || variant.name.ends_with(".stl") && counts.1 == expected.1;
                assert!(same || !knows_its_end, "{} cut to {length} bytes", variant.name);
            }
        }
    }
}

#[test]
fn content_of_another_format_is_refused() {
    for variant in every_variant(&Body::house()) {
        for extension in EXTENSIONS {
            let family = |name: &str| match name {
                "wrz" | "gz" => "wrl".to_owned(),
                other => other.to_lowercase(),
            };
            let own = variant.name.rsplit_once('.').map_or("obj", |(_, extension)| extension);
            if family(own) == family(extension) {
                continue;
            }
            let message = refusal(&format!("m.{extension}"), &variant.bytes);
            assert!(message.contains("as the extension says"), "{}: {message}", variant.name);
        }
    }
}

#[test]
fn foreign_content_is_refused() {
    for content in
        [b"\x89PNG\r\n\x1a\n".as_slice(), b"<html></html>", b"\0\0\0\0", b"\xff\xfe", b"\n"]
    {
        assert_refused("mesh.dat", content, "neither the extension nor the content");
        for extension in EXTENSIONS {
            refusal(&format!("m.{extension}"), content);
        }
    }
}

#[test]
fn what_is_not_a_readable_file_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let folder = directory.path().join("folder.ply");
    std::fs::create_dir(&folder).unwrap();
    let error = load_path(&folder).expect_err("a directory").to_string();
    assert!(error.ends_with("folder.ply: is not a regular file, give a mesh file"), "{error}");
    let error = load_path(&directory.path().join("absent.obj")).expect_err("absent").to_string();
    assert!(error.contains("absent.obj: cannot be read: No such file"), "{error}");
    // It would never end.
    load_path("/dev/zero".as_ref()).expect_err("a device");
}

#[derive(Clone, Debug)]
enum Edit {
    Replace(prop::sample::Index, u8),
    Insert(prop::sample::Index, u8),
    Remove(prop::sample::Index),
    Repeat(prop::sample::Index, prop::sample::Index),
}

impl Edit {
    fn apply(&self, bytes: &mut Vec<u8>) {
        match self {
            _ if bytes.is_empty() => {}
            Self::Replace(at, byte) => {
                let at = at.index(bytes.len());
                bytes[at] = *byte;
            }
            Self::Insert(at, byte) => bytes.insert(at.index(bytes.len()), *byte),
            Self::Remove(at) => drop(bytes.remove(at.index(bytes.len()))),
            Self::Repeat(from, to) => {
                let (from, to) = (from.index(bytes.len()), to.index(bytes.len()));
                bytes.extend_from_within(from.min(to)..from.max(to));
            }
        }
    }
}

fn edit() -> impl Strategy<Value = Edit> {
    let byte =
        || prop_oneof![any::<u8>(), prop::sample::select(b"0123456789-.e{}[]\"\\/# \n".to_vec())];
    let place = any::<prop::sample::Index>;
    prop_oneof![
        (place(), byte()).prop_map(|(at, byte)| Edit::Replace(at, byte)),
        (place(), byte()).prop_map(|(at, byte)| Edit::Insert(at, byte)),
        place().prop_map(Edit::Remove),
        (place(), place()).prop_map(|(from, to)| Edit::Repeat(from, to)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// What is still read is valid: the type holds for it.
    #[test]
    fn damaged_files_never_panic(
        variant in prop::sample::select(every_variant(&Body::house())),
        edits in prop::collection::vec(edit(), 1..6),
    ) {
        let mut bytes = variant.bytes;
        edits.iter().for_each(|edit| edit.apply(&mut bytes));
        if let Ok(mesh) = parse(variant.name, &bytes) {
            prop_assert!(mesh.vertices().as_flattened().iter().all(|c| c.is_finite()));
            let last = mesh.faces().as_flattened().iter().max();
            prop_assert!(last.is_some_and(|i| (*i as usize) < mesh.vertices().len()));
        }
    }

    #[test]
    fn noise_never_panics(
        opening in prop::sample::select(OPENINGS.to_vec()),
        extension in prop::sample::select(EXTENSIONS.to_vec()),
        noise in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let _ = parse(&format!("m.{extension}"), &[opening, &noise].concat());
    }
}
