//! Reads the packed hard cases; `tests/data/hardcases/README.md` describes their form.
#![allow(dead_code, reason = "each test program that mounts this uses a part of it")]

use std::io::Read;

use bumper::geometry::{Point, Pose, Triangle};
use flate2::read::GzDecoder;

#[derive(Debug)]
pub struct PairCase {
    pub family: String,
    pub intersect: bool,
    /// Of the common set: 0 none, 1 a point, 2 a segment, 3 an area.
    pub kind: u8,
    pub a: Triangle,
    pub b: Triangle,
}

pub struct MeshCase {
    pub name: String,
    pub fixed: Vec<Triangle>,
    pub moving: Vec<Triangle>,
    pub quaternion: [f64; 4],
    pub pose: Pose,
    pub pairs: Vec<[u32; 2]>,
}

pub struct TransformCase {
    pub quaternion: [f64; 4],
    pub translation: Point,
    pub point: Point,
    pub rotation: [f64; 9],
    pub placed: Point,
}

pub fn pair_cases() -> Vec<PairCase> {
    const FILES: [&[u8]; 2] = [
        include_bytes!("../data/hardcases/pairs-0.bin.gz"),
        include_bytes!("../data/hardcases/pairs-1.bin.gz"),
    ];
    FILES.into_iter().flat_map(pair_cases_of).collect()
}

fn pair_cases_of(packed: &[u8]) -> Vec<PairCase> {
    let mut file = Unpacked::new(packed);
    let cases = file.count();
    let families: Vec<String> = (0..file.count()).map(|_| file.name()).collect();
    let family_numbers = file.take(cases).to_vec();
    let kinds = file.take(cases).to_vec();
    let rows = file.planes::<18>(cases);
    let case = |((family, kind), row): ((u8, u8), [f64; 18])| PairCase {
        family: families[usize::from(family)].clone(),
        intersect: kind > 0,
        kind,
        a: [part(&row, 0), part(&row, 3), part(&row, 6)],
        b: [part(&row, 9), part(&row, 12), part(&row, 15)],
    };
    family_numbers.into_iter().zip(kinds).zip(rows).map(case).collect()
}

pub fn mesh_cases() -> Vec<MeshCase> {
    let mut file = Unpacked::new(include_bytes!("../data/hardcases/meshes.bin.gz"));
    let cases = file.count();
    (0..cases).map(|_| mesh_case(&mut file)).collect()
}

fn mesh_case(file: &mut Unpacked) -> MeshCase {
    let name = file.name();
    let [vertices_a, faces_a, vertices_b, faces_b, pairs] = [(); 5].map(|()| file.count());
    let quaternion = file.numbers();
    let pose = Pose { rotation: file.numbers(), translation: file.numbers() };
    let fixed = file.triangles(vertices_a, faces_a);
    let moving = file.triangles(vertices_b, faces_b);
    let pairs = (0..pairs).map(|_| file.indices()).collect();
    MeshCase { name, fixed, moving, quaternion, pose, pairs }
}

pub fn transform_cases() -> Vec<TransformCase> {
    let mut file = Unpacked::new(include_bytes!("../data/hardcases/transforms.bin.gz"));
    let cases = file.count();
    let case = |row: [f64; 22]| TransformCase {
        quaternion: part(&row, 0),
        translation: part(&row, 4),
        point: part(&row, 7),
        rotation: part(&row, 10),
        placed: part(&row, 19),
    };
    file.planes(cases).into_iter().map(case).collect()
}

fn part<const N: usize>(row: &[f64], from: usize) -> [f64; N] {
    row[from..from + N].try_into().unwrap()
}

struct Unpacked {
    bytes: Vec<u8>,
    position: usize,
}

impl Unpacked {
    fn new(packed: &[u8]) -> Self {
        let mut bytes = Vec::new();
        GzDecoder::new(packed).read_to_end(&mut bytes).unwrap();
        Self { bytes, position: 0 }
    }

    fn take(&mut self, length: usize) -> &[u8] {
        self.position += length;
        &self.bytes[self.position - length..self.position]
    }

    fn index(&mut self) -> u32 {
        u32::from_le_bytes(self.take(4).try_into().unwrap())
    }

    fn count(&mut self) -> usize {
        self.index() as usize
    }

    fn indices<const N: usize>(&mut self) -> [u32; N] {
        [(); N].map(|()| self.index())
    }

    fn numbers<const N: usize>(&mut self) -> [f64; N] {
        [(); N].map(|()| f64::from_le_bytes(self.take(8).try_into().unwrap()))
    }

    fn name(&mut self) -> String {
        let length = usize::from(self.take(1)[0]);
        String::from_utf8(self.take(length).to_vec()).unwrap()
    }

    fn triangles(&mut self, vertices: usize, faces: usize) -> Vec<Triangle> {
        let vertices: Vec<Point> = (0..vertices).map(|_| self.numbers()).collect();
        let face = |indices: [u32; 3]| indices.map(|i| vertices[i as usize]);
        (0..faces).map(|_| face(self.indices())).collect()
    }

    /// `count` rows of `N` numbers, stored as byte planes.
    fn planes<const N: usize>(&mut self, count: usize) -> Vec<[f64; N]> {
        let bytes = self.take(8 * N * count);
        let byte = |row, column, k| bytes[(8 * column + k) * count + row];
        let number =
            |row, column| f64::from_le_bytes(std::array::from_fn(|k| byte(row, column, k)));
        (0..count).map(|row| std::array::from_fn(|column| number(row, column))).collect()
    }
}
