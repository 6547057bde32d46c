use crate::mesh::Problem;
use crate::mesh::affine::Affine;

pub const FIELDS: [&str; 5] = ["center", "rotation", "scale", "scaleOrientation", "translation"];

/// `T C R SR S -SR -C`, applied from right to left (ISO/IEC 14772-1, 6.52). A field without
/// numbers has its default.
pub fn from_fields<'a>(field: impl Fn(&'static str) -> &'a [f64]) -> Result<Affine, Problem> {
    let center = array(&field, "center", [0.0; 3])?;
    let orientation = array(&field, "scaleOrientation", [0.0, 0.0, 1.0, 0.0])?;
    let parts = [
        Affine::translation(array(&field, "translation", [0.0; 3])?),
        Affine::translation(center),
        rotation(array(&field, "rotation", [0.0, 0.0, 1.0, 0.0])?),
        rotation(orientation),
        Affine::scale(array(&field, "scale", [1.0; 3])?),
        rotation([orientation[0], orientation[1], orientation[2], -orientation[3]]),
        Affine::translation(center.map(|c| -c)),
    ];
    Ok(parts.iter().fold(Affine::IDENTITY, |outer, inner| outer.after(inner)))
}

fn array<'a, const N: usize>(
    field: &impl Fn(&'static str) -> &'a [f64],
    name: &'static str,
    default: [f64; N],
) -> Result<[f64; N], Problem> {
    match field(name) {
        [] => Ok(default),
        numbers => numbers.try_into().map_err(|_| {
            let what = format!("{name} has {} numbers, must have {N}", numbers.len());
            Problem::Malformed(what)
        }),
    }
}

/// About an axis by an angle in radians (Rodrigues). The axis need not have length one; without
/// a direction there is no rotation.
fn rotation([x, y, z, angle]: [f64; 4]) -> Affine {
    let length = x.hypot(y).hypot(z);
    if length == 0.0 || angle == 0.0 {
        return Affine::IDENTITY;
    }
    let (x, y, z) = (x / length, y / length, z / length);
    let (s, c) = angle.sin_cos();
    let v = 1.0 - c;
    Affine::linear([
        x * x * v + c,
        x * y * v - z * s,
        x * z * v + y * s,
        y * x * v + z * s,
        y * y * v + c,
        y * z * v - x * s,
        z * x * v - y * s,
        z * y * v + x * s,
        z * z * v + c,
    ])
}
