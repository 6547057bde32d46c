// Reads what the page carries and shows it.

import { makeModel } from './model.js';
import { element } from './panel.js';
import { readPayload } from './payload.js';
import { Viewer } from './viewer.js';
import { shortName } from './legend.js';

const get = (id) => document.getElementById(id);

function parts() {
  const toggles = ['contacts', 'onTop', 'curves', 'arrows', 'boxes', 'byWorker', 'legend'];
  return {
    canvas: get('canvas'),
    status: get('status'),
    help: get('help'),
    helpButton: get('help-button'),
    themeButton: get('theme-button'),
    legend: get('legend'),
    entries: get('entries'),
    scale: get('scale'),
    depth: get('depth'),
    depthReading: get('depth-reading'),
    worker: get('worker'),
    looks: [get('look-fixed'), get('look-moving')],
    slider: get('slider'),
    sliderReading: get('slider-reading'),
    toggles: Object.fromEntries(toggles.map((name) => [name, get(`show-${name}`)])),
    list: {
      list: get('list'),
      filter: get('filter'),
      least: get('least'),
      sort: get('sort'),
      descending: get('descending'),
      count: get('count'),
    },
    panel: { heading: get('heading'), values: get('values'), pairs: get('pair-list') },
    time: {
      row: get('time'),
      slider: get('time-slider'),
      reading: get('time-reading'),
      play: get('play'),
      impact: get('impact'),
      marks: get('marks'),
    },
  };
}

/** The whole run in a few lines. */
function introduce({ header }) {
  const many = (number) => number.toLocaleString('en');
  const names = header.bodies.map(({ name }) => shortName(name));
  document.title = `${names.join(' – ')} · bumper`;
  get('title').textContent = names.join(' – ');
  get('title').title = header.bodies.map(({ name }) => name).join('\n');
  const facts = [
    ['scenarios', many(header.scenarios)],
    ['colliding', many(header.colliding)],
    ['pairs', many(header.pairs)],
    ['accuracy', header.accuracy],
  ];
  get('facts').replaceChildren(...facts.flatMap(([name, value]) => {
    const shown = element('dd', value);
    shown.id = `run-${name}`;
    return [element('dt', name), shown];
  }));
  const left = [];
  if (header.listed < header.scenarios) {
    left.push(`${many(header.scenarios - header.listed)} scenarios are not listed here.`);
  }
  if (header.detailed < header.listed) {
    left.push(`The triangles of ${many(header.listed - header.detailed)} listed scenarios are left out, so that this page stays small: they show counts only.`);
  }
  get('left-out').textContent = left.join(' ');
  get('left-out').hidden = left.length === 0;
}

async function start() {
  const status = get('status');
  try {
    const source = get('payload');
    const model = makeModel(await readPayload(source.textContent));
    source.remove();
    introduce(model);
    window.bumper = new Viewer(model, parts());
    status.hidden = true;
    document.documentElement.dataset.ready = 'true';
  } catch (error) {
    const drawn = document.createElement('canvas').getContext('webgl2');
    status.textContent = drawn ? `This page cannot be shown: ${error.message}` : 'This page needs WebGL 2, which this browser does not have or has switched off.';
    console.error(error);
  }
}

start();
