use crate::writers::{Body, data_uri, glb, glb_of, gltf_buffer, gltf_document, gltf_inline};
use crate::{assert_refused, load, load_path, triangles};

const CORNERS: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// One triangle over three f32 corners, placed by these nodes; the first node is the root.
fn placed(nodes: &str) -> String {
    document(nodes, r#"{"attributes":{"POSITION":0}}"#, "", &floats(&CORNERS))
}

fn document(nodes: &str, primitives: &str, more_accessors: &str, buffer: &[u8]) -> String {
    let (length, uri) = (buffer.len(), data_uri(buffer));
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}],
        "meshes":[{{"primitives":[{primitives}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}{more_accessors}],
        "bufferViews":[{{"buffer":0,"byteLength":{length}}}],
        "buffers":[{{"byteLength":{length},"uri":"{uri}"}}]}}"#
    )
}

#[track_caller]
fn assert_corners(document: &str, expected: [[f64; 3]; 3]) {
    let mesh = load("m.gltf", document).unwrap_or_else(|error| panic!("{error}"));
    for (corner, expected) in mesh.triangle(0).as_flattened().iter().zip(expected.as_flattened()) {
        assert!((corner - expected).abs() < 1e-15, "{:?}", mesh.triangle(0));
    }
}

#[test]
fn node_transforms_are_scale_then_rotation_then_translation_then_the_parents() {
    // Scaled to (2,0,0) and (0,3,0); turned by 90 degrees about z to (0,2,0) and (-3,0,0); moved
    // by (1,2,3); then the parent exchanges x and y and adds 10 to z.
    let nodes = r#"{"children":[1],"matrix":[0,1,0,0, 1,0,0,0, 0,0,1,0, 0,0,10,1]},
        {"mesh":0,"translation":[1,2,3],"rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,3,1]}"#;
    // The parent's matrix mirrors, so the last two corners change places.
    assert_corners(&placed(nodes), [[2.0, 1.0, 13.0], [2.0, -2.0, 13.0], [4.0, 1.0, 13.0]]);
}

#[test]
fn node_transforms_keep_their_f64_digits() {
    let mesh = load("m.gltf", placed(r#"{"mesh":0,"translation":[0.1,1e-17,123456.789012345]}"#));
    assert_eq!(mesh.expect("legal").vertices()[0], [0.1, 1e-17, 123456.789012345]);
}

#[test]
fn a_mesh_is_placed_once_for_each_node_that_names_it() {
    let nodes = r#"{"children":[1,2]},{"mesh":0},{"mesh":0,"translation":[0,0,1]}"#;
    let mesh = load("m.gltf", placed(nodes)).expect("legal");
    assert_eq!(mesh.faces(), [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.vertices()[3], [0.0, 0.0, 1.0]);
}

#[test]
fn strips_and_fans_are_triangles() {
    let mut buffer = floats(&CORNERS);
    buffer.extend([0, 1, 2, 0, 1]);
    let accessor = |kind: u32| {
        let indices =
            r#",{"bufferView":0,"byteOffset":36,"componentType":5121,"count":5,"type":"SCALAR"}"#;
        let primitive = format!(r#"{{"attributes":{{"POSITION":0}},"indices":1,"mode":{kind}}}"#);
        load("m.gltf", document(r#"{"mesh":0}"#, &primitive, indices, &buffer))
    };
    assert_eq!(accessor(5).expect("strip").faces(), [[0, 1, 2], [1, 0, 2], [2, 0, 1]]);
    assert_eq!(accessor(6).expect("fan").faces(), [[0, 1, 2], [0, 2, 0], [0, 0, 1]]);
    let whole = accessor(4).expect_err("five corners").to_string();
    assert!(whole.contains("meshes[0]: 5 corners do not make whole triangles"), "{whole}");
    let unknown = accessor(7).expect_err("no such mode").to_string();
    assert!(unknown.contains("primitive mode 7 does not exist"), "{unknown}");
}

#[test]
fn quantized_and_interleaved_positions_are_read() {
    let buffer: Vec<u8> = [[0_i16; 4], [32767, 0, 0, 9], [0, -32768, 0, 9]]
        .as_flattened()
        .iter()
        .flat_map(|c| c.to_le_bytes())
        .collect();
    let text = document(r#"{"mesh":0}"#, r#"{"attributes":{"POSITION":0}}"#, "", &buffer)
        .replace("5126", "5122")
        .replace(r#""count""#, r#""normalized":true,"count""#)
        .replace(r#"{"buffer":0,"#, r#"{"buffer":0,"byteStride":8,"#)
        .replace(r#""asset""#, r#""extensionsRequired":["KHR_mesh_quantization"],"asset""#);
    assert_corners(&text, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
}

#[test]
fn primitives_over_the_same_positions_share_vertices() {
    let twice = r#"{"attributes":{"POSITION":0}},{"attributes":{"POSITION":0},"mode":6}"#;
    let mesh = load("m.gltf", document(r#"{"mesh":0}"#, twice, "", &floats(&CORNERS)));
    assert_eq!(mesh.expect("legal").faces(), [[0, 1, 2], [0, 1, 2]]);
}

#[test]
fn buffers_may_be_files_below_the_directory_only() {
    let directory = tempfile::tempdir().unwrap();
    let inner = directory.path().join("inner");
    std::fs::create_dir_all(inner.join("below")).unwrap();
    let body = Body::house();
    for place in ["inner/a b.bin", "inner/below/c.bin", "outside.bin"] {
        std::fs::write(directory.path().join(place), gltf_buffer(&body)).unwrap();
    }
    std::os::unix::fs::symlink(directory.path().join("outside.bin"), inner.join("link.bin"))
        .unwrap();
    let load_with = |uri: &str| {
        let path = inner.join("m.gltf");
        std::fs::write(&path, gltf_document(&body, &format!(r#","uri":"{uri}""#))).unwrap();
        load_path(&path)
    };
    for uri in ["a b.bin", "a%20b.bin", "./below/c.bin"] {
        assert_eq!(load_with(uri).unwrap_or_else(|e| panic!("{e}")), body.mesh(), "{uri}");
    }
    let absolute = directory.path().join("outside.bin").display().to_string();
    for uri in [
        "../outside.bin",
        "%2e%2e/outside.bin",
        "below/../../outside.bin",
        &absolute,
        "link.bin",
        "file:outside.bin",
        "http://example.org/a.bin",
        "..\\\\outside.bin",
        "",
    ] {
        let error = load_with(uri).expect_err(uri).to_string();
        assert!(error.contains("buffers must be files in or below"), "{uri}: {error}");
    }
    let missing = load_with("missing.bin").expect_err("no such file").to_string();
    assert!(missing.contains("buffers[0]: ") && missing.contains("missing.bin"), "{missing}");
    assert!(load_with("below").expect_err("a directory").to_string().contains("regular file"));
}

#[test]
fn what_would_be_read_as_less_than_the_file_means_is_refused() {
    let plain = placed(r#"{"mesh":0}"#);
    let refused = |from: &str, to: &str, message: &str| {
        assert!(plain.contains(from), "{from}");
        assert_refused("m.gltf", plain.replacen(from, to, 1), message);
    };
    refused(
        r#""count":3"#,
        r#""count":4294967295"#,
        "accessors[0]: the header promises 4294967295 elements, the file has bytes for 3",
    );
    refused(r#"[{"bufferView":0,"#, "[{", "accessors[0]: has no bufferView");
    refused(
        r#""count":3"#,
        r#""count":3,"sparse":{"count":1}"#,
        "a sparse accessor is not supported",
    );
    refused(
        r#""count":3"#,
        r#""count":3,"byteOffset":4"#,
        "promises 3 elements, the file has bytes for 2",
    );
    refused(r#""bufferView":0"#, r#""bufferView":7"#, "there is no bufferView 7");
    refused(r#""POSITION":0"#, r#""POSITION":5"#, "there is no accessor 5");
    refused(r#""POSITION":0"#, r#""NORMAL":0"#, "meshes[0]: a primitive has no POSITION");
    refused("VEC3", "VEC2", "accessors[0]: has type VEC2, must be VEC3");
    refused("5126", "5125", "accessors[0]: the component type does not fit");
    refused("5126", "5130", "accessors[0]: the component type does not fit");
    refused(
        r#""byteLength":36"#,
        r#""byteLength":37"#,
        "bufferViews[0]: the header promises 37 bytes",
    );
    refused(
        r#""byteLength":36,"uri""#,
        r#""byteLength":99,"uri""#,
        "buffers[0]: the header promises 99 bytes",
    );
    refused(
        r#""version":"2.0""#,
        r#""version":"1.0""#,
        "asset.version: glTF version 1.0 is not supported",
    );
    refused(
        r#""asset""#,
        r#""extensionsRequired":["KHR_draco_mesh_compression"],"asset""#,
        "the required extension KHR_draco_mesh_compression is not supported",
    );
    refused(r#"{"mesh":0}"#, r#"{"mesh":0,"skin":0}"#, "nodes[0]: a mesh placed by a skin");
    refused(
        r#"{"mesh":0}"#,
        r#"{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{}}}"#,
        "nodes[0]: a mesh placed by",
    );
    refused(r#"{"mesh":0}"#, r#"{"mesh":1}"#, "there is no mesh 1");
    refused(r#"{"mesh":0}"#, r#"{"children":[0]}"#, "nodes[0]: is reached twice");
    refused(r#"{"mesh":0}"#, r#"{"children":[1,1]},{}"#, "nodes[1]: is reached twice");
    refused(r#"{"mesh":0}"#, r#"{"children":[4]}"#, "there is no node 4");
    refused(
        r#"{"mesh":0}"#,
        r#"{"mesh":0,"matrix":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}"#,
        "last row",
    );
    refused(r#"{"mesh":0}"#, r#"{"mesh":0,"scale":[1e999,1,1]}"#, "number out of range");
    refused(
        r#"{"mesh":0}"#,
        r#"{"children":[1],"scale":[1e200,1,1]},{"mesh":0,"scale":[1e200,1,1]}"#,
        "nodes[1]: its transforms take a vertex beyond all finite numbers",
    );
    refused(r#"{"mesh":0}"#, "{}", "the mesh has no faces");
    refused("octet-stream;base64,", "octet-stream,", "a data: URI that is not base64");
    refused("octet-stream;base64,", "octet-stream;base64,***", "data: URI: ");
    refused("{", "[", "glTF JSON: ");
}

#[test]
fn a_position_that_is_not_finite_is_refused() {
    for (value, name) in [(f32::NAN, "NaN"), (f32::NEG_INFINITY, "-inf")] {
        let mut corners = CORNERS;
        corners[4] = value;
        let primitive = r#"{"attributes":{"POSITION":0}}"#;
        let file = document(r#"{"mesh":0}"#, primitive, "", &floats(&corners));
        assert_refused(
            "m.gltf",
            file,
            &format!("nodes[0]: coordinate {name} is not a finite number"),
        );
    }
}

#[test]
fn an_index_out_of_range_is_refused() {
    let body = Body::house();
    let mut buffer = gltf_buffer(&body);
    let last = buffer.len() - 2;
    buffer[last..].copy_from_slice(&10_u16.to_le_bytes());
    let file = glb_of(&gltf_document(&body, ""), &buffer);
    assert_refused(
        "m.glb",
        file,
        "meshes[0]: vertex index 10 is out of range (there are 10 vertices)",
    );
}

#[test]
fn lying_containers_are_refused() {
    let good = glb(&Body::house());
    let edited = |at: usize, value: u32| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    assert_refused(
        "m.glb",
        edited(0, 0),
        "byte 0: found '\\x00\\x00\\x00\\x00', expected the letters glTF",
    );
    assert_refused("m.glb", edited(4, 1), "byte 4: glTF version 1 is not supported");
    assert_refused("m.glb", edited(8, u32::MAX), "byte 8: the header promises 4294967295 bytes");
    assert_refused("m.glb", edited(12, u32::MAX), "byte 12: the header promises 4294967295 bytes");
    assert_refused("m.glb", edited(16, 0), "byte 16: found");
    let document = gltf_document(&Body::house(), "");
    assert_refused("m.gltf", document, "buffers[0]: has neither a uri nor a BIN chunk");
}

#[test]
fn few_bytes_cannot_expand_without_limit() {
    // Every part repeats the same 100,000 corners.
    let corners = 99_999;
    let mut buffer = floats(&CORNERS);
    buffer.resize(36 + corners, 0);
    let accessor = format!(
        r#",{{"bufferView":0,"byteOffset":36,"componentType":5121,"count":{corners},"type":"SCALAR"}}"#
    );
    let primitive = [r#"{"attributes":{"POSITION":0},"indices":1}"#; 2_000].join(",");
    let file = document(r#"{"mesh":0}"#, &primitive, &accessor, &buffer);
    assert_refused("m.gltf", file, "the scene expands to");
}

#[test]
fn only_the_default_scene_is_placed() {
    let two = placed(r#"{"mesh":0},{"mesh":0,"translation":[5,0,0]}"#).replace(
        r#""scenes":[{"nodes":[0]}]"#,
        r#""scene":1,"scenes":[{"nodes":[0]},{"nodes":[1]}]"#,
    );
    assert_eq!(load("m.gltf", two).expect("legal").vertices()[0], [5.0, 0.0, 0.0]);
    let none = placed(r#"{"children":[1]},{"mesh":0}"#).replace(r#""scenes":[{"nodes":[0]}],"#, "");
    assert_eq!(load("m.gltf", none).expect("legal").faces().len(), 1);
}

#[test]
fn containers_are_told_apart_by_content() {
    assert_refused("m.gltf", glb(&Body::house()), "the content is GLB, not glTF");
    assert_refused("m.glb", gltf_inline(&Body::house()), "the content is glTF, not GLB");
    let marked = [b"\xef\xbb\xbf".as_slice(), &gltf_inline(&Body::house())].concat();
    assert_eq!(
        triangles(&load("m.gltf", marked).expect("legal")),
        triangles(&Body::house().mesh())
    );
}

#[test]
fn deeply_nested_json_is_no_danger() {
    let deep = ["[".repeat(300_000), "]".repeat(300_000)].concat();
    let extras = placed(&format!(r#"{{"mesh":0,"extras":{deep}}}"#));
    if let Ok(mesh) = load("m.gltf", extras) {
        assert_eq!(mesh.faces().len(), 1);
    }
    let chain: Vec<String> = (1..100_000).map(|i| format!(r#"{{"children":[{i}]}}"#)).collect();
    let chain = placed(&format!(r#"{},{{"mesh":0}}"#, chain.join(",")));
    assert_eq!(load("m.gltf", chain).expect("legal").faces().len(), 1);
}
