// The list of scenarios: filtered, sorted, and drawn only where it is seen.

import { spoken } from './facts.js';

const ROW = 26;

export class ScenarioList {
  constructor(model, elements, choose) {
    this.model = model;
    this.elements = elements;
    this.choose = choose;
    this.order = [];
    this.fillSortings();
    const { filter, least, sort, descending, list } = elements;
    for (const input of [filter, least, sort, descending]) {
      input.addEventListener('input', () => this.arrange());
    }
    list.addEventListener('scroll', () => this.draw());
    list.addEventListener('click', ({ target }) => {
      const row = target.closest('[data-at]');
      if (row) this.choose(Number(row.dataset.at));
    });
    new ResizeObserver(() => this.draw()).observe(list);
    this.arrange();
  }

  fillSortings() {
    const { sort } = this.elements;
    const plain = [['number', 'number'], ['pairs', 'pairs of triangles']];
    const others = this.model.scenarios.columns.map(({ name }) => [`column ${name}`, name]);
    for (const [value, text] of [...plain, ...others]) sort.add(new Option(text, value));
  }

  /** What scenarios are sorted by. */
  key() {
    const { scenarios } = this.model;
    const by = this.elements.sort.value;
    if (by === 'number') return (at) => at;
    if (by === 'pairs') return (at) => scenarios.pairs[at];
    const column = scenarios.columns.find(({ name }) => `column ${name}` === by);
    return (at) => column.values[at];
  }

  arrange() {
    const { scenarios } = this.model;
    const { filter, least, descending } = this.elements;
    const wanted = {
      all: () => true,
      touching: (at) => scenarios.pairs[at] > 0,
      apart: (at) => scenarios.pairs[at] === 0,
    }[filter.value];
    const most = Number(least.value) || 0;
    const key = this.key();
    const sign = descending.checked ? -1 : 1;
    const order = Array.from({ length: scenarios.count }, (_, at) => at)
      .filter((at) => wanted(at) && scenarios.pairs[at] >= most);
    // What has no value comes last.
    const compare = (a, b) => {
      const [x, y] = [key(a), key(b)];
      if (Number.isNaN(x) || Number.isNaN(y)) return Number.isNaN(x) - Number.isNaN(y) || a - b;
      return sign * (x - y) || a - b;
    };
    this.order = order.sort(compare);
    this.show(this.chosen);
    this.onArrange?.(this.order);
  }

  /** Marks a scenario, and brings it into view. */
  show(at) {
    this.chosen = at;
    const { list, count } = this.elements;
    const place = this.order.indexOf(at);
    if (place >= 0) {
      const top = place * ROW;
      if (top < list.scrollTop) list.scrollTop = top;
      if (top + ROW > list.scrollTop + list.clientHeight) list.scrollTop = top + ROW - list.clientHeight;
    }
    count.textContent = `${this.order.length.toLocaleString('en')} of ${this.model.scenarios.count.toLocaleString('en')} listed`;
    this.draw();
  }

  /** The scenario so many places further, within the list. */
  neighbour(by) {
    const place = this.order.indexOf(this.chosen);
    const to = place < 0 ? 0 : Math.min(this.order.length - 1, Math.max(0, place + by));
    return this.order[to] ?? this.chosen;
  }

  draw() {
    const { list } = this.elements;
    const first = Math.floor(list.scrollTop / ROW);
    const rows = this.order.slice(first, first + Math.ceil(list.clientHeight / ROW) + 1);
    const inner = document.createElement('div');
    inner.style.height = `${this.order.length * ROW}px`;
    rows.forEach((at, place) => inner.append(this.row(at, (first + place) * ROW)));
    list.replaceChildren(inner);
  }

  row(at, top) {
    const { scenarios } = this.model;
    const row = document.createElement('div');
    row.className = 'row';
    row.dataset.at = at;
    row.setAttribute('role', 'option');
    row.setAttribute('aria-selected', String(at === this.chosen));
    row.style.top = `${top}px`;
    const touches = scenarios.pairs[at] > 0;
    const sorted = scenarios.columns.find(({ name }) => `column ${name}` === this.elements.sort.value);
    const cells = [
      ['number', String(scenarios.numbers[at])],
      [touches ? 'touch' : 'apart', touches ? '●' : '○'],
      ['pairs', scenarios.pairs[at].toLocaleString('en')],
      ['value', sorted ? spoken(sorted, sorted.values[at]) : scenarios.hasDetail(at) ? '' : 'counts only'],
    ];
    for (const [name, text] of cells) {
      const cell = document.createElement('span');
      cell.className = name;
      cell.textContent = text;
      row.append(cell);
    }
    return row;
  }
}
