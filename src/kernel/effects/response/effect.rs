use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::{Body, Change, Contact, Impact, Inertia, NoImpact, Regime, impact};
use crate::effects::layout::{Column, Note, StepLayout};
use crate::effects::motion::BodyMotion;
use crate::effects::{Collision, Effect, Known, Scenario};
use crate::geometry::Pose;
use crate::geometry::contact::{Kind, certified};
use crate::geometry::motion::Trajectory;
use crate::tree::descent::DescentError;

/// A vehicle in a collision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResponseBody {
    pub inertia: Inertia,
    /// Its velocities at the start, and its centre of gravity.
    pub motion: BodyMotion,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResponseOptions {
    /// Of Newton, 0 to 1.
    pub restitution: f64,
    /// Of Coulomb.
    pub friction: f64,
    /// The fixed and the moving one.
    pub bodies: [ResponseBody; 2],
}

const REGIMES: &[&str] = &["full", "sliding", "parting", "wedged"];
const LAYOUT: StepLayout = StepLayout {
    name: "response",
    work_unit: "impacts",
    columns: &[
        Column::choice("impact", REGIMES),
        Column::number("contact_x_m"),
        Column::number("contact_y_m"),
        Column::number("contact_z_m"),
        Column::number("contact_normal_x"),
        Column::number("contact_normal_y"),
        Column::number("contact_normal_z"),
        Column::number("closing_speed_m_s"),
        Column::number("impulse_x_n_s"),
        Column::number("impulse_y_n_s"),
        Column::number("impulse_z_n_s"),
        Column::number("fixed_delta_v_m_s"),
        Column::number("fixed_delta_v_x_m_s"),
        Column::number("fixed_delta_v_y_m_s"),
        Column::number("fixed_delta_v_z_m_s"),
        Column::number("fixed_delta_spin_x_rad_s"),
        Column::number("fixed_delta_spin_y_rad_s"),
        Column::number("fixed_delta_spin_z_rad_s"),
        Column::number("fixed_pdof_deg"),
        Column::number("moving_delta_v_m_s"),
        Column::number("moving_delta_v_x_m_s"),
        Column::number("moving_delta_v_y_m_s"),
        Column::number("moving_delta_v_z_m_s"),
        Column::number("moving_delta_spin_x_rad_s"),
        Column::number("moving_delta_spin_y_rad_s"),
        Column::number("moving_delta_spin_z_rad_s"),
        Column::number("moving_pdof_deg"),
        Column::number("energy_loss_j"),
        Column::flag("energy_rises"),
    ],
    tables: &[],
};

/// Names of the columns of one body.
struct Names {
    delta_v: &'static str,
    delta_v_axes: [&'static str; 3],
    delta_spin_axes: [&'static str; 3],
    pdof: &'static str,
}

const NAMES: [Names; 2] = [
    Names {
        delta_v: "fixed_delta_v_m_s",
        delta_v_axes: ["fixed_delta_v_x_m_s", "fixed_delta_v_y_m_s", "fixed_delta_v_z_m_s"],
        delta_spin_axes: [
            "fixed_delta_spin_x_rad_s",
            "fixed_delta_spin_y_rad_s",
            "fixed_delta_spin_z_rad_s",
        ],
        pdof: "fixed_pdof_deg",
    },
    Names {
        delta_v: "moving_delta_v_m_s",
        delta_v_axes: ["moving_delta_v_x_m_s", "moving_delta_v_y_m_s", "moving_delta_v_z_m_s"],
        delta_spin_axes: [
            "moving_delta_spin_x_rad_s",
            "moving_delta_spin_y_rad_s",
            "moving_delta_spin_z_rad_s",
        ],
        pdof: "moving_pdof_deg",
    },
];

/// What an impact does to both vehicles: where a motion brings them together, or, where they overlap
/// from the start, in the plane that fits best to where they touch.
pub struct ResponseEffect {
    options: ResponseOptions,
}

impl ResponseEffect {
    pub fn new(options: ResponseOptions) -> Self {
        Self { options }
    }
}

impl Effect for ResponseEffect {
    fn layout(&self) -> StepLayout {
        LAYOUT
    }

    fn is_called_for(&self, known: &Known) -> bool {
        known.touching || known.collision.is_some()
    }

    fn run(
        &mut self,
        scenario: &mut Scenario<'_>,
        known: &mut Known,
        note: &mut Note<'_>,
    ) -> Result<u64, DescentError> {
        let collision = known.collision.or_else(|| plane_of_contacts(scenario));
        let Some(mut collision) = collision else { return Ok(0) };
        let starts = [Pose::IDENTITY, scenario.pose];
        let bodies =
            [0, 1].map(|side| self.options.bodies[side].at(&starts[side], collision.time_s));
        let [Some(fixed), Some(moving)] = bodies else { return Ok(0) };
        let bodies = [&fixed, &moving];
        if known.collision.is_none() && is_turned(bodies, &collision) {
            collision.normal = collision.normal.map(|c| -c);
        }
        known.collision = Some(collision);
        let Collision { point, normal, .. } = collision;
        note.numbers(["contact_x_m", "contact_y_m", "contact_z_m"], point);
        note.numbers(["contact_normal_x", "contact_normal_y", "contact_normal_z"], normal);
        note.number("closing_speed_m_s", closing_speed(bodies, &collision));
        let ResponseOptions { restitution, friction, .. } = self.options;
        // The contact's normal is from the second body to the first.
        let contact = Contact::new(point, normal.map(|c| -c), restitution, friction);
        let Ok(contact) = contact else { return Ok(0) };
        match impact(bodies, &contact) {
            Err(NoImpact::Apart) => note.choice("impact", "parting"),
            Err(NoImpact::Wedged) => note.choice("impact", "wedged"),
            Ok(impact) => {
                write(&impact, note);
                known.impact = Some(impact);
            }
        }
        Ok(1)
    }
}

impl ResponseBody {
    /// Some time after it was in this pose; `None` if it has left the range of numbers.
    pub fn at(&self, start: &Pose, time_s: f64) -> Option<Body> {
        let motion = self.motion.in_world(start);
        let trajectory = Trajectory::new(*start, &motion, None);
        let (pose, cg) = (trajectory.pose(time_s), motion.values().cg_m);
        let (velocity, spin) = trajectory.velocities(time_s);
        let rotation = Matrix3::from_row_slice(&pose.rotation);
        // It is one to the decimals that poses are given with: the search for the one that is nearest
        // would take most of the effect's time.
        let rotation = Rotation3::from_matrix_unchecked(rotation);
        let turn = UnitQuaternion::from_rotation_matrix(&rotation).into_inner().normalize();
        let orientation = [turn.w, turn.i, turn.j, turn.k];
        Body::new(self.inertia, pose.apply(cg), orientation, velocity, spin).ok()
    }
}

/// A plane alone does not know its sides. The moving body is where its centre of gravity is, seen from
/// the fixed one's; where that does not tell, where it comes from.
fn is_turned(bodies: [&Body; 2], collision: &Collision) -> bool {
    let [fixed, moving] = bodies;
    let between = moving.cg() - fixed.cg();
    let along = between.dot(&Vector3::from(collision.normal));
    if along.abs() > 1e-3 * between.norm() {
        return along < 0.0;
    }
    closing_speed(bodies, collision) < 0.0
}

/// At which the points of both bodies there approach each other along the normal, m/s.
fn closing_speed([fixed, moving]: [&Body; 2], collision: &Collision) -> f64 {
    let point = Vector3::from(collision.point);
    let of = |body: &Body| body.velocity() + body.spin().cross(&(point - body.cg()));
    (of(fixed) - of(moving)).dot(&Vector3::from(collision.normal))
}

/// The middle of where the triangles touch, by the lengths of the segments, and the direction in
/// which it is thinnest. `None`: fewer than two segments, which have no plane.
fn plane_of_contacts(scenario: &mut Scenario<'_>) -> Option<Collision> {
    let (pose, pairs) = (scenario.pose, scenario.pairs);
    let [fixed, moving] = scenario.by_number();
    let segments = pairs.iter().filter_map(|&[i, j]| {
        let moving = moving.triangle(j).map(|p| pose.apply(p));
        let contact = certified(&fixed.triangle(i), &moving)?;
        let ends = [contact.corners()[0], *contact.corners().get(1)?].map(Vector3::from);
        (contact.kind() == Kind::Segment).then_some(ends)
    });
    let weighted: Vec<_> = segments.map(|[p, q]| (0.5 * (p + q), q - p, (q - p).norm())).collect();
    let total: f64 = weighted.iter().map(|(.., length)| length).sum();
    let middle = weighted.iter().map(|(at, _, length)| at * *length).sum::<Vector3<f64>>() / total;
    let scatter = |(at, along, length): &(Vector3<f64>, Vector3<f64>, f64)| {
        let off = at - middle;
        (off * off.transpose() + along * along.transpose() / 12.0) * *length
    };
    let scatter: Matrix3<f64> = weighted.iter().map(scatter).sum();
    if weighted.len() < 2 || !scatter.iter().all(|c| c.is_finite()) {
        return None;
    }
    let axes = SymmetricEigen::new(scatter);
    let thinnest = axes.eigenvectors.column(axes.eigenvalues.imin()).into_owned();
    let normal = thinnest.try_normalize(0.0)?;
    Some(Collision { time_s: 0.0, point: middle.into(), normal: normal.into() })
}

fn write(impact: &Impact, note: &mut Note<'_>) {
    let Impact { impulse, changes, energy_loss, energy_rises, regime } = impact;
    note.choice(
        "impact",
        match regime {
            Regime::Full => "full",
            Regime::Sliding => "sliding",
        },
    );
    note.numbers(["impulse_x_n_s", "impulse_y_n_s", "impulse_z_n_s"], (*impulse).into());
    for (Change { delta_v, delta_spin, pdof_deg }, names) in changes.iter().zip(&NAMES) {
        note.number(names.delta_v, delta_v.norm());
        note.numbers(names.delta_v_axes, (*delta_v).into());
        note.numbers(names.delta_spin_axes, (*delta_spin).into());
        note.number(names.pdof, *pdof_deg);
    }
    note.number("energy_loss_j", *energy_loss);
    note.flag("energy_rises", *energy_rises);
}
