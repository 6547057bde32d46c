// What is known of the chosen scenario, in words and numbers.

import { spoken } from './facts.js';

const MOST_PAIRS = 200;

export class Panel {
  constructor(model, elements, pick) {
    this.model = model;
    this.elements = elements;
    elements.pairs.addEventListener('click', ({ target }) => {
      const row = target.closest('[data-pair]');
      if (row) pick(row.dataset.pair.split(' ').map(Number));
    });
  }

  show(at) {
    const { scenarios, header } = this.model;
    const { heading, values, pairs } = this.elements;
    const count = scenarios.pairs[at];
    heading.textContent = `Scenario ${scenarios.numbers[at]}`;
    const rows = [
      ['touching', count > 0 ? 'yes' : 'no', count > 0 ? 'touch' : ''],
      ['pairs of triangles', count.toLocaleString('en'), ''],
      ['answered by', `worker ${scenarios.workers[at]}`, ''],
    ];
    if (header.deform_after !== undefined) {
      rows.push(['vehicles', scenarios.numbers[at] > header.deform_after ? 'deformed' : 'as they were', '']);
    }
    for (const column of scenarios.columns) {
      const value = column.values[at];
      if (Number.isFinite(value)) rows.push([column.name, spoken(column, value), '']);
    }
    values.replaceChildren(...rows.flatMap(([name, value, kind]) => [
      element('dt', name.replaceAll('_', '_\u200b')),
      element('dd', value, kind),
    ]));
    this.showPairs(at, pairs);
  }

  showPairs(at, list) {
    const { scenarios, bodies } = this.model;
    const contacts = scenarios.contacts(at);
    const count = contacts.length / 2;
    const rows = [];
    for (let pair = 0; pair < Math.min(count, MOST_PAIRS); pair++) {
      const ranks = [contacts[2 * pair], contacts[2 * pair + 1]];
      const button = element('button', ranks.map((rank, side) => bodies[side].ids[rank]).join(' × '));
      button.dataset.pair = ranks.join(' ');
      button.title = 'Look at this pair: fixed × moving triangle';
      rows.push(button);
    }
    const left = (scenarios.pairs[at] - rows.length).toLocaleString('en');
    if (!scenarios.hasDetail(at)) {
      rows.push(element('p', `${left}, which are not in this page: it would grow too large`));
    } else if (scenarios.pairs[at] > rows.length) {
      rows.push(element('p', `and ${left} more`));
    }
    if (scenarios.pairs[at] === 0) rows.push(element('p', 'none'));
    list.replaceChildren(...rows);
  }
}

export function element(name, text, className = '') {
  const made = document.createElement(name);
  made.textContent = text;
  if (className) made.className = className;
  return made;
}
