// What effects say of a scenario, made ready to be drawn. Points are relative to the middle of the fixed
// body.

import { Vector3 } from 'three';

const axes = (name) => ['x', 'y', 'z'].map((axis) => `${name}_${axis}_m`);

/** The ends of arrows, or null; those of a way out begin where one asks. */
export function arrowsOf(model, at, from) {
  const point = (names) => {
    const found = model.scenarios.point(at, names);
    return found && new Vector3(...found).sub(new Vector3(...model.bodies[0].center));
  };
  const nearest = [point(axes('nearest_fixed')), point(axes('nearest_moving'))];
  const out = model.scenarios.point(at, axes('least_translation'));
  const depth = model.scenarios.value(at, 'penetration_depth_m');
  const along = model.header.penetration_direction;
  const impact = point(axes('impact'));
  const normal = model.scenarios.point(at, ['impact_normal_x', 'impact_normal_y', 'impact_normal_z']);
  return {
    clearance: nearest[0] && nearest[1] ? nearest : null,
    least: out ? [from, from.clone().add(new Vector3(...out))] : null,
    along: along && Number.isFinite(depth)
      ? [from, from.clone().addScaledVector(new Vector3(...along).normalize(), depth)]
      : null,
    impact: impact && normal ? [impact, impact.clone().addScaledVector(new Vector3(...normal), 0.5)] : null,
  };
}

/** When they first touch, or null. */
export function impactTime({ header, scenarios }, at) {
  const time = scenarios.value(at, 'impact_time_s');
  if (!header.motion || !Number.isFinite(time)) return null;
  const motion = scenarios.columns.find((column) => column.name === 'motion');
  const outcome = motion?.choices[motion.values[at]];
  return outcome === 'impact' || outcome === 'in_contact' ? time : null;
}

/** Ranks of the triangles that meet first, or null. */
export function impactTriangles(model, at, rankOf) {
  const numbers = ['impact_fixed_triangle', 'impact_moving_triangle']
    .map((name) => model.scenarios.value(at, name));
  return numbers.every(Number.isFinite) ? numbers.map((number, side) => rankOf(side, number)) : null;
}

/** A value as a person reads it. */
export function spoken({ kind, choices }, value) {
  if (!Number.isFinite(value)) return '–';
  if (kind === 'choice') return choices[value];
  if (kind === 'flag') return value === 1 ? 'yes' : 'no';
  if (kind === 'count') return value.toLocaleString('en');
  return short(value);
}

/** Five digits. */
export function short(value) {
  if (value === 0) return '0';
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-4 ? value.toExponential(3) : String(Number(value.toPrecision(5)));
}

/** A length with a unit that fits. */
export function length(metres) {
  const size = Math.abs(metres);
  if (size === 0) return '0 m';
  if (size < 1e-3) return `${Number((metres * 1e6).toPrecision(4))} µm`;
  if (size < 1) return `${Number((metres * 1e3).toPrecision(4))} mm`;
  if (size < 1e4) return `${Number(metres.toPrecision(4))} m`;
  return `${Number((metres * 1e-3).toPrecision(4))} km`;
}
