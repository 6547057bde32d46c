//! What it costs a query that trees are cut into subtrees, on one core.
//!
//! ```text
//! cargo bench --bench cutting -- [--count N]
//! ```
//!
//! On the vehicles of `BUMPER_BENCH_DATA=DIR`, a directory with `meshes/*.ply` and `poses/*.csv`,
//! or else on the built-in ones. The descent from pairs of roots is timed beside that from the top,
//! on the same poses in turn, and its pairs are checked against that one's. Bytes are those of all
//! subtrees sent apart, with what lies above them, relative to both images.

#[path = "kernel/poses.rs"]
#[expect(dead_code, reason = "near misses are for the kernel's own benchmark")]
mod poses;
#[path = "kernel/timing.rs"]
mod timing;

use std::num::NonZeroU32;
use std::path::Path;

use anyhow::{Result, ensure};
use bumper::geometry::Pose;
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::scene::read_poses;
use bumper::tree::descent::{Descent, Pair};
use bumper::tree::roots::{Cut, PreAnalysis, RootPair, distributed_roots};
use bumper::tree::subtree::Subtrees;
use bumper::tree::{BuildOptions, TreeImage, TreeKind, TreeView, build};
use clap::Parser;
use timing::Timings;

#[derive(Parser)]
struct Args {
    #[arg(long, default_value = "300")]
    count: NonZeroU32,
    /// What cargo passes to every benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

const DEPTHS: [[u32; 2]; 5] = [[6, 6], [8, 8], [10, 10], [12, 12], [12, 6]];

/// Roots that cutting by triangles is to give.
const ROOTS: [usize; 3] = [64, 256, 1024];

fn main() -> Result<()> {
    let args = Args::parse();
    let Some(directory) = std::env::var_os("BUMPER_BENCH_DATA") else {
        return study(["builtin:tracked", "builtin:car"], None, args.count);
    };
    let directory = Path::new(&directory);
    for [fixed, moving] in [["m113", "audi"], ["audi", "audi"]] {
        let mesh = |name| directory.join(format!("meshes/{name}.ply")).display().to_string();
        let poses = directory.join(format!("poses/{fixed}-{moving}.csv"));
        study([&mesh(fixed), &mesh(moving)], Some(&poses), args.count)?;
    }
    Ok(())
}

fn study(sources: [&str; 2], poses: Option<&Path>, count: NonZeroU32) -> Result<()> {
    let load = |source: &str| -> Result<TriangleMesh> { Ok(source.parse::<MeshSource>()?.load()?) };
    let [fixed, moving] = sources;
    println!("\n{fixed} against {moving}, us a pose");
    let (fixed, moving) = (load(fixed)?, load(moving)?);
    let wide = BuildOptions { kind: TreeKind::Wide };
    let poses = match poses {
        Some(path) => read_poses(path, Some(count))?,
        None => {
            let trees = (build(&fixed, wide), build(&moving, wide));
            poses::random((&fixed, &trees.0), (&moving, &trees.1), count)?
        }
    };
    println!(
        "{:5} {:>13} {:>10} {:>7} {:>13} {:>9} {:>9} {:>7} {:>7} {:>7}",
        "kind",
        "cut",
        "roots",
        "pairs",
        "pre-analysis",
        "from top",
        "from cut",
        "mean",
        "median",
        "bytes"
    );
    for kind in TreeKind::ALL.into_iter().rev() {
        let images = [&fixed, &moving].map(|mesh| build(mesh, BuildOptions { kind }));
        for cuts in cuts(&images) {
            Trial::new(&images, cuts).run(&poses)?;
        }
    }
    Ok(())
}

fn cuts(images: &[TreeImage; 2]) -> Vec<[Cut; 2]> {
    let by_depth = DEPTHS.map(|depths| depths.map(Cut::Depth));
    let by_triangles = ROOTS.map(|roots| {
        [0, 1].map(|tree: usize| Cut::Triangles(triangles_for(&images[tree].view(), roots)))
    });
    by_depth.into_iter().chain(by_triangles).collect()
}

/// The least number of triangles that gives no more roots than these.
fn triangles_for(tree: &TreeView<'_>, roots: usize) -> u32 {
    let (mut few, mut enough) = (0, tree.triangle_count());
    while enough - few > 1 {
        let middle = few + (enough - few) / 2;
        let found = distributed_roots(tree, Cut::Triangles(middle)).len();
        *(if found <= roots { &mut enough } else { &mut few }) = middle;
    }
    enough
}

struct Trial<'a> {
    cuts: [Cut; 2],
    views: [TreeView<'a>; 2],
    analysis: PreAnalysis<'a>,
    descent: Descent,
    pre_analysis: Timings,
    from_top: Timings,
    from_cut: Timings,
    root_pairs: usize,
}

impl<'a> Trial<'a> {
    fn new([fixed, moving]: &'a [TreeImage; 2], cuts: [Cut; 2]) -> Self {
        Self {
            cuts,
            views: [fixed.view(), moving.view()],
            analysis: PreAnalysis::new(fixed.view(), cuts[0], moving.view(), cuts[1]),
            descent: Descent::default(),
            pre_analysis: Timings::default(),
            from_top: Timings::default(),
            from_cut: Timings::default(),
            root_pairs: 0,
        }
    }

    fn run(mut self, poses: &[Pose]) -> Result<()> {
        let (mut roots, mut top, mut cut) = (Vec::new(), Vec::new(), Vec::new());
        for (number, pose) in poses.iter().enumerate() {
            self.analysis.overlapping_roots(pose, &mut roots);
            self.pre_analysis.time(|| self.analysis.overlapping_roots(pose, &mut roots));
            self.root_pairs += roots.len();
            // The first two are to warm up, and each is as often the first of both.
            for turn in 0..4 {
                if (turn + number) % 2 == 0 {
                    self.descend_from_top(pose, &mut top, turn > 1)?;
                } else {
                    self.descend_from_cut(pose, &roots, &mut cut, turn > 1)?;
                }
            }
            top.sort_unstable();
            cut.sort_unstable();
            ensure!(top == cut, "pose {number}: the pairs below the roots are not all pairs");
        }
        self.print(poses.len());
        Ok(())
    }

    fn descend_from_top(&mut self, pose: &Pose, pairs: &mut Vec<Pair>, timed: bool) -> Result<()> {
        pairs.clear();
        let Self { descent, views: [fixed, moving], from_top, .. } = self;
        let mut call = || descent.all_pairs(fixed, moving, pose, pairs);
        Ok(if timed { from_top.time(call) } else { call() }?)
    }

    fn descend_from_cut(
        &mut self,
        pose: &Pose,
        roots: &[RootPair],
        pairs: &mut Vec<Pair>,
        timed: bool,
    ) -> Result<()> {
        pairs.clear();
        let Self { descent, analysis, from_cut, .. } = self;
        let (fixed, moving) = (analysis.fixed(), analysis.moving());
        let mut call = || descent.all_pairs_below(fixed, moving, pose, roots, pairs);
        Ok(if timed { from_cut.time(call) } else { call() }?)
    }

    /// All subtrees of both trees as messages, relative to both images.
    fn bytes_sent(&self) -> f64 {
        let (mut sent, mut whole) = (0, 0);
        for (tree, cut) in self.views.into_iter().zip(self.cuts) {
            let subtrees = Subtrees::new(tree, cut);
            let length = |root| subtrees.message_length(root).expect("the root is one of them");
            sent += subtrees.outline().len() + (0..subtrees.count()).map(length).sum::<usize>();
            whole += tree.header().byte_length as usize;
        }
        sent as f64 / whole as f64
    }

    fn print(&mut self, poses: usize) {
        let cut = match self.cuts {
            [Cut::Depth(a), Cut::Depth(b)] => format!("d = {a}/{b}"),
            [Cut::Depth(n) | Cut::Triangles(n), Cut::Depth(m) | Cut::Triangles(m)] => {
                format!("N = {n}/{m}")
            }
        };
        let roots =
            format!("{}/{}", self.analysis.fixed_roots().len(), self.analysis.moving_roots().len());
        let [pre, top, below] =
            [&self.pre_analysis, &self.from_top, &self.from_cut].map(|timings| timings.mean_us());
        let median = self.from_cut.quantile_us(0.5) / self.from_top.quantile_us(0.5);
        println!(
            "{:5} {cut:>13} {roots:>10} {:7.1} {pre:13.2} {top:9.1} {below:9.1} {:7.3} {median:7.3} {:7.3}",
            self.views[0].kind().to_string(),
            self.root_pairs as f64 / poses as f64,
            below / top,
            self.bytes_sent(),
        );
    }
}
