// What there is to be seen, as arrays. Coordinates are metres, relative to the middle of the fixed body
// (in the world) or of a body (in that body). Triangles are numbered in the order of their tree's
// leaves; `ids` has their numbers in the mesh file.

import { starts, sums, unzigzag } from './payload.js';

export function makeModel({ header, section }) {
  return {
    header,
    bodies: header.bodies.map((body, side) => makeBody(body, side, header, section)),
    scenarios: makeScenarios(header, section),
  };
}

function makeBody(header, side, { workers }, section) {
  const triangles = starts(section(`roots${side}`));
  const words = Math.max(1, Math.ceil(workers / 32));
  const holders = section(`holders${side}`);
  return {
    ...header,
    positions: positions(section(`positions${side}`), header.step_m),
    deformed: header.is_deformed ? positions(section(`deformed${side}`), header.step_m) : null,
    index: corners(section(`corners${side}`)),
    ids: sums(section(`ids${side}`)),
    rootStarts: triangles,
    isHeld: (root, worker) => (holders[root * words + (worker >> 5)] >>> (worker & 31)) & 1,
    boxStarts: starts(header.boxes),
    boxNumbers: section(`boxes${side}`),
    parts: header.parts.map((motion, number) => ({
      motion,
      ranks: sums(section(`part${side}.${number}`)),
    })),
  };
}

function positions(codes, step) {
  const numbers = new Float32Array(codes.length);
  const at = [0, 0, 0];
  for (let i = 0; i < codes.length; i++) numbers[i] = step * (at[i % 3] += unzigzag(codes[i]));
  return numbers;
}

function corners(codes) {
  let next = 0;
  return codes.map((below) => {
    const vertex = next - below;
    next = Math.max(next, vertex + 1);
    return vertex;
  });
}

function makeScenarios(header, section) {
  const kept = section('kept');
  const curves = withoutKept(section('curves'), kept);
  const intervals = withoutKept(section('intervals'), kept);
  const lengths = section('curve_lengths');
  const pairStarts = starts(kept.map((count) => Math.max(0, count - 1)));
  const curveStarts = starts(curves);
  const pointStarts = starts(lengths.map((length) => length >> 1));
  const points = section('curve_points');
  const intervalStarts = starts(intervals);
  const times = section('interval_times');
  const contacts = section('contacts');
  const columns = header.columns.map((column) => ({
    ...column,
    values: section(`column.${column.name}`),
  }));
  const byName = new Map(columns.map((column) => [column.name, column]));
  return {
    count: header.listed,
    numbers: section('numbers'),
    pairs: section('pairs'),
    workers: section('workers'),
    poses: section('poses'),
    columns,
    hasDetail: (at) => kept[at] > 0,
    /** Pairs of ranks, one after the other. */
    contacts: (at) => contactsOf(contacts.subarray(2 * pairStarts[at], 2 * pairStarts[at + 1])),
    curves: (at) => range(curveStarts[at], curveStarts[at + 1]).map((curve) => ({
      isClosed: (lengths[curve] & 1) === 1,
      points: points.subarray(3 * pointStarts[curve], 3 * pointStarts[curve + 1]),
    })),
    intervals: (at) => range(intervalStarts[at], intervalStarts[at + 1])
      .map((interval) => [times[2 * interval], times[2 * interval + 1]]),
    /** What an effect says, NaN if it says nothing. */
    value: (at, name) => byName.get(name)?.values[at] ?? NaN,
    /** Of three columns, or null. */
    point(at, names) {
      const point = names.map((name) => this.value(at, name));
      return point.every(Number.isFinite) ? point : null;
    },
  };
}

/** One number a scenario, from one a scenario that is shown in full. */
function withoutKept(numbers, kept) {
  let at = 0;
  return Uint32Array.from(kept, (count) => (count > 0 ? numbers[at++] : 0));
}

function contactsOf(codes) {
  const pairs = new Uint32Array(codes.length);
  for (let i = 0; i < codes.length; i += 2) {
    pairs[i] = (pairs[i - 2] ?? 0) + codes[i];
    pairs[i + 1] = (pairs[i - 1] ?? 0) + unzigzag(codes[i + 1]);
  }
  return pairs;
}

const range = (from, to) => Array.from({ length: to - from }, (_, i) => from + i);
