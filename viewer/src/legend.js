// What the colours mean, how long a metre is, and what the arrows measure.

import * as colours from './colours.js';
import { length } from './facts.js';
import { element } from './panel.js';

export function drawLegend(box, rows) {
  box.replaceChildren(...rows.map(({ colour, shape, text }) => {
    const row = element('div', '', 'entry');
    const mark = element('i', '', shape);
    mark.style.setProperty('--colour', colour);
    row.append(mark, element('span', text));
    return row;
  }));
}

export function legendRows(viewer) {
  const { model, shown, arrows, depth, onlyWorker } = viewer;
  const { header, bodies } = model;
  const rows = [];
  const add = (is, colour, shape, text) => { if (is) rows.push({ colour, shape, text }); };
  const before = viewer.isDeformed ? ', before the crash' : '';
  const names = bodies.map(({ name, triangles }) => `${shortName(name)}, ${triangles.toLocaleString('en')} triangles`);
  if (shown.byWorker) {
    const kind = header.shares_memory ? 'needed by' : 'sent to';
    const workers = onlyWorker === null ? [...Array(Math.min(7, header.workers)).keys()] : [onlyWorker];
    for (const number of workers) add(true, colours.worker(number), 'area', `subtrees ${kind} worker ${number}`);
    add(onlyWorker === null && header.workers > 1, colours.SEVERAL_WORKERS, 'area', `subtrees ${kind} several workers`);
    add(true, colours.NO_WORKER, 'area', onlyWorker === null ? `subtrees ${kind} none` : `other subtrees`);
  } else {
    add(true, colours.BODIES[0], 'area', `fixed: ${names[0]}`);
    add(true, colours.BODIES[1], 'area', `moving: ${names[1]}`);
  }
  add(shown.contacts, colours.CONTACTS[0], 'area', 'fixed triangles that touch');
  add(shown.contacts, colours.CONTACTS[1], 'area', 'moving triangles that touch');
  add(shown.curves && viewer.hasCurves, colours.CURVE, 'line', 'contact curves');
  add(shown.boxes, colours.BOXES[0], 'line', `boxes of the fixed tree (${header.tree}), depth ${depth}${before}`);
  add(shown.boxes, colours.BOXES[1], 'line', `boxes of the moving tree (${header.tree}), depth ${depth}${before}`);
  const arrow = (name, colour, text) => {
    const ends = arrows.facts[name];
    add(shown.arrows && ends, colour, 'line', ends ? `${text}: ${length(ends[0].distanceTo(ends[1]))}` : '');
  };
  arrow('clearance', colours.CLEARANCE, 'clearance');
  arrow('least', colours.PENETRATION, 'shortest way out found');
  arrow('along', colours.ALONG, 'depth along the direction');
  add(shown.arrows && arrows.facts.impact, colours.IMPACT, 'line', 'normal at the first impact (no scale)');
  return rows;
}

/** A round number of metres, and how many pixels that is at the distance that is looked at. */
export function scaleBar(stage) {
  const most = 160 * stage.pixel();
  const power = 10 ** Math.floor(Math.log10(most));
  const metres = [5, 2, 1].map((n) => n * power).find((n) => n <= most) ?? power;
  return { pixels: metres / stage.pixel(), text: length(metres) };
}

export const shortName = (name) => name.split('/').pop();
