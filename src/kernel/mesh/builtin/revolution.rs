use super::{
    sheet::{Ends, Sheet},
    turn::turn,
};

/// Spans of a full circle: a circle is never coarser than this.
const SPANS: usize = 8;

/// Turns a profile of (height along z, radius) points about the z axis. Seen with z to the right
/// and the radius up, the profile runs so that the material is on its right.
fn revolve(profile: &[[f64; 2]], ends: Ends) -> Sheet {
    let profile = profile.to_vec();
    let spans = profile.len() - usize::from(!ends.wrap[0]);
    Sheet::new([spans, SPANS], ends, move |u, v| {
        let from = (u as usize).min(spans - 1);
        let (p, q) = (profile[from], profile[(from + 1) % profile.len()]);
        let t = u - from as f64;
        let [height, radius] = [0, 1].map(|k| p[k] + (q[k] - p[k]) * t);
        let [cos, sin] = turn(v / SPANS as f64);
        [radius * cos, radius * sin, height]
    })
}

/// A solid of revolution: the profile begins and ends on the axis (radius 0).
pub(super) fn turned_solid(profile: &[[f64; 2]]) -> Sheet {
    revolve(profile, Ends::SOLID)
}

/// A body of revolution around a hole: the profile is a closed loop, its first point not repeated.
pub(super) fn turned_ring(profile: &[[f64; 2]]) -> Sheet {
    revolve(profile, Ends::RING)
}

/// A skin of revolution, open at both ends.
pub(super) fn turned_skin(profile: &[[f64; 2]]) -> Sheet {
    revolve(profile, Ends::TUBE)
}

pub(super) fn cylinder(radius: f64, from: f64, to: f64) -> Sheet {
    turned_solid(&[[from, 0.0], [from, radius], [to, radius], [to, 0.0]])
}

/// A tube or a disc with a hole.
pub(super) fn annulus(inner: f64, outer: f64, from: f64, to: f64) -> Sheet {
    turned_ring(&[[from, inner], [from, outer], [to, outer], [to, inner]])
}

/// A torus in the plane z = 0.
pub(super) fn torus(radius: f64, thickness: f64) -> Sheet {
    let ring: Vec<[f64; 2]> = (0..6)
        .map(|k| {
            let [cos, sin] = turn(0.5 - f64::from(k) / 6.0);
            [thickness * cos, radius + thickness * sin]
        })
        .collect();
    turned_ring(&ring)
}
