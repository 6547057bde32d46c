//! What containment, volume of overlap and penetration cost, on one core.
//!
//! ```text
//! cargo bench --bench solids
//! ```
//!
//! Every answer is checked: by a closed form, by its parts, or by asking again at the place it names.

use std::f64::consts::{PI, TAU};
use std::time::Instant;

use anyhow::{Result, ensure};
use bumper::effects::Kept;
use bumper::effects::inside::{Containment, Location, Locator, Nesting};
use bumper::effects::penetration::{Bodies, Direction, Effort, Penetration, Trees};
use bumper::effects::volume::{Overlap, volume};
use bumper::geometry::{Point, Pose};
use bumper::mesh::closed::Shells;
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::tree::descent::Descent;
use bumper::tree::{BuildOptions, TreeKind, build};

fn main() -> Result<()> {
    let meshes = ["builtin:tracked", "builtin:car", "builtin:blocks"].map(load);
    let [tracked, car, blocks] = meshes;
    let (tracked, car, blocks) = (tracked?, car?, blocks?);
    println!("mesh       triangles   parts  closed   solid  open edges  parts of it in ms");
    let shells = [("tracked", &tracked), ("car", &car), ("blocks", &blocks)].map(describe);
    let [in_tracked, in_car, in_blocks] = &shells;
    println!();
    containment(in_tracked, in_car)?;
    halves(in_blocks, "blocks")?;
    halves(in_car, "car")?;
    lens()?;
    penetration(&tracked, &car)
}

fn load(name: &str) -> Result<TriangleMesh> {
    Ok(name.parse::<MeshSource>()?.load()?)
}

/// What `work` gives, and its milliseconds, the least of three times.
fn timed<T>(mut work: impl FnMut() -> T) -> (T, f64) {
    let mut once = || {
        let start = Instant::now();
        let found = work();
        (found, start.elapsed().as_secs_f64() * 1e3)
    };
    let (_, first) = once();
    let (_, second) = once();
    let (found, third) = once();
    (found, first.min(second).min(third))
}

fn describe((name, mesh): (&str, &TriangleMesh)) -> Shells {
    let (shells, ms) = timed(|| Shells::of(mesh.vertices(), mesh.faces().iter().copied()));
    let [closed, solid] = [
        shells.parts().iter().filter(|part| part.is_closed()).count(),
        shells.parts().iter().filter(|part| part.is_solid()).count(),
    ];
    println!(
        "{name:9} {:10} {:7} {closed:7} {solid:7} {:11} {ms:18.1}",
        mesh.faces().len(),
        shells.parts().len(),
        shells.open_edges(),
    );
    shells
}

fn block(low: Point, high: Point) -> Shells {
    let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] });
    let points: Vec<Point> = (0..8).map(corner).collect();
    let faces = (0..3).flat_map(|axis| {
        let (along, up) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let [[a, b, c, d], [e, f, g, h]] =
            [0, 1 << axis].map(|base: u32| [base, base + along, base + along + up, base + up]);
        [[a, d, c], [a, c, b], [e, f, g], [e, g, h]]
    });
    Shells::of(&points, faces)
}

fn containment(tracked: &Shells, car: &Shells) -> Result<()> {
    let mut nesting = Nesting::default();
    let room = block([-20.0; 3], [20.0; 3]);
    let (found, ms) = timed(|| nesting.contained(&room, car, &Pose::IDENTITY));
    ensure!(
        found?.containment() == Containment::MovingInFixed,
        "the car is not in a room round it"
    );
    println!("car in a room                        {ms:9.2} ms");
    let (found, ms) = timed(|| nesting.contained(car, tracked, &Pose::IDENTITY));
    let parts = car.parts().len() + tracked.parts().len();
    let inside = found?;
    println!(
        "car and tracked, {parts} parts           {ms:9.2} ms, {:.2} us a part; inside: {}, {}",
        ms * 1e3 / parts as f64,
        inside.fixed_in_moving,
        inside.moving_in_fixed
    );
    let mut locator = Locator::default();
    let (found, ms) = timed(|| locator.locate(&[[0.0, 0.0, 50.0]], tracked, tracked.points())[0]);
    ensure!(found == Location::Outside, "a point above the roof is not outside");
    println!("one point and tracked                {ms:9.2} ms");
    Ok(())
}

/// A mesh is cut in two by boxes.
fn halves(shells: &Shells, name: &str) -> Result<()> {
    let (own, ms) = timed(|| volume(shells));
    println!("volume of {name:6}                     {ms:9.2} ms: {:.6} m3", own.cubic_metres);
    let mut overlap = Overlap::default();
    let (left, right) =
        (block([-30.0; 3], [0.1, 30.0, 30.0]), block([0.1, -30.0, -30.0], [30.0; 3]));
    let (parts, ms) =
        timed(|| [&left, &right].map(|half| overlap.volume(half, shells, &Pose::IDENTITY)));
    let [left, right] = parts;
    let (left, right) = (left?, right?);
    let off = (left.cubic_metres + right.cubic_metres - own.cubic_metres).abs();
    ensure!(off <= left.error + right.error + own.error, "the halves of {name} are off by {off}");
    println!(
        "volumes of both halves of it         {ms:9.2} ms, off by {off:.1e} of a bound {:.1e}",
        { left.error + right.error + own.error }
    );
    let (shared, ms) = timed(|| overlap.volume(shells, shells, &Pose::IDENTITY));
    println!("volume of overlap with itself        {ms:9.2} ms: {:.6} m3", shared?.cubic_metres);
    Ok(())
}

/// Of rings round the z axis.
fn sphere(rings: u32) -> Shells {
    let around = 2 * rings;
    let point = |ring: u32, at: u32| {
        let (polar, angle) =
            (PI * f64::from(ring) / f64::from(rings), TAU * f64::from(at) / f64::from(around));
        let radius = if ring.is_multiple_of(rings) { 0.0 } else { polar.sin() };
        [radius * angle.cos(), radius * angle.sin(), polar.cos()]
    };
    let points: Vec<Point> =
        (0..=rings).flat_map(|ring| (0..around).map(move |at| point(ring, at))).collect();
    let faces = (0..rings).flat_map(|ring| {
        (0..around).flat_map(move |at| {
            let next = (at + 1) % around;
            let [a, b, c, d] = [(ring, at), (ring, next), (ring + 1, next), (ring + 1, at)]
                .map(|(ring, at)| ring * around + at);
            [[a, d, c], [a, c, b]]
        })
    });
    Shells::of(&points, faces)
}

fn lens() -> Result<()> {
    let spheres = [295, 150].map(sphere);
    let distance = 0.9;
    let pose =
        Pose::from_quaternion([0.8, 0.0, 0.6, 0.0], [0.36, 0.48, 0.8].map(|c: f64| c * distance));
    let mut overlap = Overlap::default();
    let (found, ms) = timed(|| overlap.volume(&spheres[0], &spheres[1], &pose));
    let found = found?;
    let lens = PI / 12.0 * (4.0 + distance) * (2.0 - distance).powi(2);
    let missing: f64 = spheres.iter().map(|s| 4.0 / 3.0 * PI - volume(s).cubic_metres).sum();
    let off = lens - found.cubic_metres;
    ensure!(off >= 0.0 && off <= missing, "the lens is off by {off}, the spheres by {missing}");
    println!(
        "two spheres, 348,000 and 90,000      {ms:9.2} ms, error {:.1e}, off the lens by {off:.1e}",
        found.error
    );
    Ok(())
}

fn penetration(fixed: &TriangleMesh, moving: &TriangleMesh) -> Result<()> {
    let images = [fixed, moving].map(|mesh| build(mesh, BuildOptions { kind: TreeKind::Wide }));
    let views = [images[0].view(), images[1].view()];
    let (mut kept, mut nesting) = ([Kept::default(), Kept::default()], Nesting::default());
    let mut descent = Descent::default();
    let mut bodies = Trees::new(views, &mut kept, &mut descent, &mut nesting);
    let mut penetration = Penetration::default();
    let pose = Pose::from_quaternion([0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()], [3.0, 1.0, 0.0]);
    let mut pairs = Vec::new();
    bodies.pairs(&pose, &mut pairs)?;
    println!("car against tracked: {} pairs", pairs.len());
    for (name, direction) in [("forward", [1.0, 0.0, 0.0]), ("up", [0.0, 0.0, 1.0])] {
        let direction = Direction::new(direction)?;
        let (depth, ms) = timed(|| penetration.depth_along(&mut bodies, &pose, &direction));
        let depth = depth?;
        let by = Point::from(direction).map(|c| c * depth.free_at);
        ensure!(is_free(&mut bodies, &pose, by)?, "touching at {} {name}", depth.free_at);
        println!(
            "depth {name:8}                       {ms:9.2} ms, {} queries: {:.6} m",
            depth.queries, depth.metres
        );
    }
    for directions in [0, 128] {
        let effort = Effort { directions };
        let (least, ms) = timed(|| penetration.least_translation(&mut bodies, &pose, effort));
        let least = least?;
        ensure!(is_free(&mut bodies, &pose, least.translation)?, "touching at {least:?}");
        println!(
            "least of seeds and {directions:3} directions    {ms:9.2} ms, {} queries: {:.6} m",
            least.queries, least.length
        );
    }
    Ok(())
}

fn is_free(bodies: &mut Trees<'_>, pose: &Pose, by: Point) -> Result<bool> {
    let translation = [0, 1, 2].map(|k| pose.translation[k] + by[k]);
    let mut pairs = Vec::new();
    bodies.pairs(&Pose { translation, ..*pose }, &mut pairs)?;
    Ok(pairs.is_empty())
}
