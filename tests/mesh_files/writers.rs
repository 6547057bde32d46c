//! Writes one body in every format and variant that must read as the same mesh.

use std::fmt::Write;
use std::io::Write as _;

use bumper::mesh::TriangleMesh;

/// Coordinates are multiples of 1/64, so that every format can hold them.
pub struct Body {
    pub vertices: Vec<[f64; 3]>,
    pub polygons: Vec<Vec<u32>>,
}

impl Body {
    /// A prism over a pentagon: quads and n-gons, closed, 3 m x 2 m walls 1 m high, roof 2 m.
    pub fn house() -> Self {
        let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 2.0], [0.0, 1.0]];
        let front = outline.map(|[y, z]| [0.0, y, z]);
        let back = outline.map(|[y, z]| [3.0, y, z]);
        let mut polygons = vec![vec![4, 3, 2, 1, 0], vec![5, 6, 7, 8, 9]];
        polygons.extend((0..5).map(|i| vec![i, (i + 1) % 5, (i + 1) % 5 + 5, i + 5]));
        Self { vertices: [front, back].concat(), polygons }
    }

    /// An open, crooked sheet of triangles, one of them without area.
    pub fn crooked() -> Self {
        let vertices = (0..7).map(|i| {
            let i = f64::from(i);
            [i * 0.375 - 1.0, (i * 37.0 % 11.0) / 64.0, -(i * 23.0 % 17.0) / 32.0]
        });
        let polygons = (0..5).map(|i| vec![i, i + 2, i + 1]).chain([vec![0, 6, 6]]);
        Self { vertices: vertices.collect(), polygons: polygons.collect() }
    }

    pub fn faces(&self) -> Vec<[u32; 3]> {
        let fan =
            |p: &Vec<u32>| (1..p.len() - 1).map(|i| [p[0], p[i], p[i + 1]]).collect::<Vec<_>>();
        self.polygons.iter().flat_map(fan).collect()
    }

    pub fn mesh(&self) -> TriangleMesh {
        TriangleMesh::new(self.vertices.clone(), self.faces()).expect("a valid body")
    }
}

#[derive(Clone, Debug)]
pub struct Variant {
    pub name: &'static str,
    pub bytes: Vec<u8>,
    /// False where the format keeps corners instead of shared vertices.
    pub indexed: bool,
}

pub fn every_variant(body: &Body) -> Vec<Variant> {
    let variant = |name, bytes| Variant { name, bytes, indexed: true };
    let soup = |name, bytes| Variant { name, bytes, indexed: false };
    let obj = obj(body, false, "\n");
    vec![
        variant("text.ply", ply_text(body, "\n")),
        variant("crlf.ply", ply_text(body, "\r\n")),
        variant("little.ply", ply_binary(body, false)),
        variant("big.ply", ply_binary(body, true)),
        variant("plain.obj", obj.clone()),
        variant("negative.obj", self::obj(body, true, "\n")),
        variant("crlf.obj", self::obj(body, false, "\r\n")),
        variant("no extension", obj),
        soup("text.stl", stl_text(body, "\n")),
        soup("crlf.stl", stl_text(body, "\r\n")),
        soup("binary.STL", stl_binary(body, b"made by a test")),
        soup("solid.stl", stl_binary(body, b"solid but binary")),
        variant("binary.glb", glb(body)),
        variant("inline.gltf", gltf_inline(body)),
        variant("plain.wrl", vrml(body, "\n")),
        variant("crlf.wrl", vrml(body, "\r\n")),
        variant("packed.wrl", gzip(&vrml(body, "\n"))),
        variant("packed.wrz", gzip(&vrml(body, "\n"))),
        variant("packed.wrl.gz", gzip(&vrml(body, "\n"))),
    ]
}

fn with_line_end(text: &str, line_end: &str) -> Vec<u8> {
    text.replace('\n', line_end).into_bytes()
}

fn joined<T: ToString>(numbers: &[T]) -> String {
    numbers.iter().map(T::to_string).collect::<Vec<_>>().join(" ")
}

/// Properties out of order, an element and properties that nobody asked for.
pub fn ply_text(body: &Body, line_end: &str) -> Vec<u8> {
    let mut text = format!(
        "ply\nformat ascii 1.0\ncomment caf\u{e9}\nelement camera 1\nproperty float zoom\n\
         element vertex {}\nproperty double z\nproperty uchar red\nproperty double x\n\
         property list uchar int tags\nproperty double y\n\
         element face {}\nproperty int material\nproperty list uchar int vertex_index\nend_header\n1.5\n",
        body.vertices.len(),
        body.polygons.len()
    );
    for [x, y, z] in &body.vertices {
        writeln!(text, "{z} 255 {x} 2 7 8 {y}").unwrap();
    }
    for polygon in &body.polygons {
        writeln!(text, "-3 {} {}", polygon.len(), joined(polygon)).unwrap();
    }
    with_line_end(&text, line_end)
}

/// A different type for each coordinate that can hold it; faces before vertices.
pub fn ply_binary(body: &Body, big: bool) -> Vec<u8> {
    let order = |little: &[u8]| {
        let mut bytes = little.to_vec();
        if big {
            bytes.reverse();
        }
        bytes
    };
    let encoding = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{encoding}_endian 1.0\nelement face {}\n\
         property list ushort uint32 vertex_indices\nproperty list char double weights\n\
         element vertex {}\nproperty float32 x\nproperty short flags\nproperty double y\n\
         property float z\nend_header\n",
        body.polygons.len(),
        body.vertices.len()
    )
    .into_bytes();
    for polygon in &body.polygons {
        bytes.extend(order(&(polygon.len() as u16).to_le_bytes()));
        polygon.iter().for_each(|i| bytes.extend(order(&i.to_le_bytes())));
        bytes.push(1);
        bytes.extend(order(&0.5_f64.to_le_bytes()));
    }
    for [x, y, z] in &body.vertices {
        bytes.extend(order(&(*x as f32).to_le_bytes()));
        bytes.extend(order(&(-2_i16).to_le_bytes()));
        bytes.extend(order(&y.to_le_bytes()));
        bytes.extend(order(&(*z as f32).to_le_bytes()));
    }
    bytes
}

/// With names, groups, an absent material file, a continued line and comments.
pub fn obj(body: &Body, negative: bool, line_end: &str) -> Vec<u8> {
    let mut text =
        String::from("# C:\\models\\\nmtllib absent.mtl\no body\nvt 0.5 0.5\nvn 0 0 1\n");
    for vertex in &body.vertices {
        writeln!(text, "v {}", joined(vertex)).unwrap();
    }
    for (number, polygon) in body.polygons.iter().enumerate() {
        writeln!(text, "g part{number}\nusemtl paint # of the part").unwrap();
        let count = body.vertices.len() as i64;
        let index = |i: &u32| i64::from(*i) + if negative { -count } else { 1 };
        let corner = |i: &u32| match number % 4 {
            0 => index(i).to_string(),
            1 => format!("{}/1", index(i)),
            2 => format!("{}//1", index(i)),
            _ => format!("{}/1/1", index(i)),
        };
        let corners: Vec<String> = polygon.iter().map(corner).collect();
        let (first, rest) = corners.split_at(2);
        writeln!(text, "f {} \\\n{} # side", first.join(" "), rest.join("\t")).unwrap();
    }
    with_line_end(&text, line_end)
}

pub fn stl_text(body: &Body, line_end: &str) -> Vec<u8> {
    let mut text = String::from("solid two words\n");
    for face in body.faces() {
        text.push_str(" facet normal nan nan nan\n  OUTER loop\n");
        for corner in face {
            writeln!(text, "   vertex {}", joined(&body.vertices[corner as usize])).unwrap();
        }
        text.push_str("  endloop\n endfacet\n");
    }
    text.push_str("endsolid two words\n");
    with_line_end(&text, line_end)
}

pub fn stl_binary(body: &Body, title: &[u8]) -> Vec<u8> {
    let mut bytes = title.to_vec();
    bytes.resize(80, 0);
    let faces = body.faces();
    bytes.extend((faces.len() as u32).to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        let corners = face.iter().flat_map(|i| body.vertices[*i as usize]);
        corners.for_each(|c| bytes.extend((c as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Positions as f32, then indices as u16.
pub fn gltf_buffer(body: &Body) -> Vec<u8> {
    let coordinates = body.vertices.as_flattened().iter();
    let mut bytes: Vec<u8> = coordinates.flat_map(|c| (*c as f32).to_le_bytes()).collect();
    bytes.extend(body.faces().as_flattened().iter().flat_map(|i| (*i as u16).to_le_bytes()));
    bytes
}

/// `uri` is the member of the buffer that says where it is, with a comma before it.
pub fn gltf_document(body: &Body, uri: &str) -> String {
    let (vertices, corners) = (body.vertices.len(), 3 * body.faces().len());
    let (split, total) = (12 * vertices, 12 * vertices + 2 * corners);
    let rest = total - split;
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"name":"n"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":9}},"indices":1,"material":3}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{vertices},"type":"VEC3","min":[0,0,0]}},
        {{"bufferView":1,"componentType":5123,"count":{corners},"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{split}}},{{"buffer":0,"byteOffset":{split},"byteLength":{rest}}}],
        "buffers":[{{"byteLength":{total}{uri}}}]}}"#
    )
}

pub fn gltf_inline(body: &Body) -> Vec<u8> {
    let data = data_uri(&gltf_buffer(body));
    gltf_document(body, &format!(r#","uri":"{data}""#)).into_bytes()
}

pub fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", base64(bytes))
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = group.iter().chain([&0, &0]).take(3).fold(0, |n, b| n << 8 | usize::from(*b));
        for place in 0..4 {
            let digit = char::from(DIGITS[bits >> (18 - 6 * place) & 63]);
            text.push(if place <= group.len() { digit } else { '=' });
        }
    }
    text
}

pub fn glb(body: &Body) -> Vec<u8> {
    glb_of(&gltf_document(body, ""), &gltf_buffer(body))
}

pub fn glb_of(document: &str, buffer: &[u8]) -> Vec<u8> {
    let mut json = document.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut binary = buffer.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((12 + 8 + json.len() as u32 + 8 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

pub fn vrml_shape(body: &Body) -> String {
    let points: Vec<String> = body.vertices.iter().map(|v| joined(v)).collect();
    let polygons: Vec<String> =
        body.polygons.iter().map(|p| format!("{} -1", joined(p).replace(' ', ", "))).collect();
    format!(
        "Shape {{ appearance Appearance {{ material DEF M Material {{ diffuseColor 1 0 0 }} }}\n\
         geometry IndexedFaceSet {{ solid FALSE coordIndex [ {} ]\n\
         coord Coordinate {{ point [ {} ] }} texCoordIndex [ 0 0 0 -1 ] }} }}\n",
        polygons.join("\n"),
        points.join(",\n"),
    )
}

pub fn vrml(body: &Body, line_end: &str) -> Vec<u8> {
    let text = format!(
        "#VRML V2.0 utf8\n# a }} in a comment\nGroup {{ children [\n\
         WorldInfo {{ info [ \"a }} in a \\\" string\" ] }}\n{} ] }}",
        vrml_shape(body)
    );
    with_line_end(&text, line_end)
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}
