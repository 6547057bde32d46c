// Where bodies are at a time: the closed form of src/geometry/motion/trajectory.rs, in coordinates that
// are relative to the middle of each body.

import { Matrix4, Quaternion, Vector3 } from 'three';

/** The pose of the moving body in a scenario, as a matrix. */
export function startOf({ scenarios }, at) {
  const [a, b, c, d, e, f, g, h, i, x, y, z] = scenarios.poses.subarray(12 * at, 12 * at + 12);
  return new Matrix4().set(a, b, c, x, d, e, f, y, g, h, i, z, 0, 0, 0, 1);
}

/** A body that starts there, after a time: its centre of gravity goes by v t + a t^2 / 2, and it is
 *  turned about that by the vector w t + alpha t^2 / 2. */
export function placed(body, start, seconds) {
  if (!body.motion || seconds === 0) return start.clone();
  const { motion, axes } = body.motion;
  const rotation = new Matrix4().extractRotation(start);
  const path = along(motion.velocity_m_s, motion.acceleration_m_s2, seconds);
  const turn = along(motion.spin_rad_s, motion.spin_acceleration_rad_s2, seconds);
  if (axes === 'body') [path, turn].forEach((vector) => vector.applyMatrix4(rotation));
  const cg = relative(motion.cg_m, body.center);
  const from = cg.applyMatrix4(start);
  return new Matrix4()
    .makeTranslation(from.clone().add(path))
    .multiply(turned(turn))
    .multiply(new Matrix4().makeTranslation(from.negate()))
    .multiply(start);
}

/** A part in its body: it turns about an axis, then slides. */
export function partPlaced(part, center, seconds) {
  const { turn, velocity_m_s, acceleration_m_s2 } = part.motion;
  const placed = new Matrix4();
  if (seconds === 0) return placed;
  placed.makeTranslation(along(velocity_m_s, acceleration_m_s2, seconds));
  if (!turn) return placed;
  const angle = turn.rate_rad_s * seconds + turn.acceleration_rad_s2 * 0.5 * seconds * seconds;
  const pivot = relative(turn.point_m, center);
  return placed
    .multiply(new Matrix4().makeTranslation(pivot))
    .multiply(turned(new Vector3(...turn.axis).multiplyScalar(angle)))
    .multiply(new Matrix4().makeTranslation(pivot.clone().negate()));
}

const along = (rate, acceleration, t) =>
  new Vector3(...rate).multiplyScalar(t).addScaledVector(new Vector3(...acceleration), 0.5 * t * t);

const relative = (point, center) => new Vector3(...point.map((x, k) => x - center[k]));

function turned(vector) {
  const angle = vector.length();
  if (angle === 0) return new Matrix4();
  const turn = new Quaternion().setFromAxisAngle(vector.clone().divideScalar(angle), angle);
  return new Matrix4().makeRotationFromQuaternion(turn);
}
