//! The path of a track: a belt stretched around circles, in the plane of x (forward) and z (up).

/// Doublings of the number of corners of an arc.
const ARC_DOUBLINGS: u32 = 5;

#[derive(Clone, Copy)]
pub(super) struct Circle {
    pub centre: [f64; 2],
    pub radius: f64,
}

/// A point of the belt, the way it runs there and the side away from the circles (unit vectors).
pub(super) struct Station {
    pub point: [f64; 2],
    pub along: [f64; 2],
    pub outward: [f64; 2],
}

/// `count` stations at equal distances around a belt; the circles come counter-clockwise, seen
/// with x to the right and z up, and each arc is less than half a turn. A station lies in the
/// middle between two pins.
pub(super) fn stations(circles: &[Circle], count: usize) -> Vec<Station> {
    let corners = corners(circles);
    let pins = walk(&corners, count);
    (0..count)
        .map(|i| {
            let (from, to) = (pins[i], pins[(i + 1) % count]);
            let along = unit([to[0] - from[0], to[1] - from[1]]);
            let point = [0, 1].map(|k| (from[k] + to[k]) / 2.0);
            Station { point, along, outward: [along[1], -along[0]] }
        })
        .collect()
}

/// The belt as a closed polygon.
fn corners(circles: &[Circle]) -> Vec<[f64; 2]> {
    let count = circles.len();
    let normal = |i: usize| tangent_normal(circles[i % count], circles[(i + 1) % count]);
    let arc = |i: usize| {
        let circle = circles[i];
        let mut normals = vec![normal(i + count - 1), normal(i)];
        for _ in 0..ARC_DOUBLINGS {
            let halves = normals
                .windows(2)
                .flat_map(|n| [n[0], unit([n[0][0] + n[1][0], n[0][1] + n[1][1]])]);
            normals = halves.chain([normals[normals.len() - 1]]).collect();
        }
        normals.into_iter().map(move |n| [0, 1].map(|k| circle.centre[k] + circle.radius * n[k]))
    };
    (0..count).flat_map(arc).collect()
}

/// Outward normal of the straight run from one circle to the next.
fn tangent_normal(from: Circle, to: Circle) -> [f64; 2] {
    let way = [0, 1].map(|k| to.centre[k] - from.centre[k]);
    let distance = (way[0] * way[0] + way[1] * way[1]).sqrt();
    let e = way.map(|c| c / distance);
    let along = (from.radius - to.radius) / distance;
    let across = (1.0 - along * along).sqrt();
    [along * e[0] + across * e[1], along * e[1] - across * e[0]]
}

/// `count` points at equal distances around a closed polygon.
fn walk(corners: &[[f64; 2]], count: usize) -> Vec<[f64; 2]> {
    let edge = |i: usize| (corners[i], corners[(i + 1) % corners.len()]);
    let length = |i: usize| {
        let (a, b) = edge(i);
        let [x, z] = [b[0] - a[0], b[1] - a[1]];
        (x * x + z * z).sqrt()
    };
    let step = (0..corners.len()).map(length).sum::<f64>() / count as f64;
    let (mut points, mut passed) = (Vec::with_capacity(count), 0.0);
    for i in 0..corners.len() {
        let (a, b) = edge(i);
        while points.len() < count && points.len() as f64 * step <= passed + length(i) {
            let t = (points.len() as f64 * step - passed) / length(i);
            points.push([0, 1].map(|k| a[k] + (b[k] - a[k]) * t));
        }
        passed += length(i);
    }
    points
}

fn unit([x, z]: [f64; 2]) -> [f64; 2] {
    let norm = (x * x + z * z).sqrt();
    [x / norm, z / norm]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stations_divide_a_belt_evenly_and_touch_its_circles_from_outside() {
        let circles = [
            Circle { centre: [-1.0, 0.0], radius: 0.3 },
            Circle { centre: [1.0, 0.0], radius: 0.3 },
            Circle { centre: [1.5, 0.6], radius: 0.2 },
            Circle { centre: [-1.5, 0.5], radius: 0.25 },
        ];
        let stations = stations(&circles, 63);
        assert_eq!(stations.len(), 63);
        for station in &stations {
            for circle in &circles {
                let away = [0, 1].map(|k| station.point[k] - circle.centre[k]);
                let height = away[0] * station.outward[0] + away[1] * station.outward[1];
                assert!(height > 0.9 * circle.radius, "{:?}", station.point);
            }
        }
    }
}
