// Puts together what is drawn and what is said of the chosen scenario.

import { Box3, Matrix4, Sphere, Vector3 } from 'three';
import { Body, LOOKS, ray } from './body.js';
import * as colours from './colours.js';
import { arrowsOf, impactTime, impactTriangles } from './facts.js';
import { bindKeys } from './keys.js';
import { drawLegend, legendRows, scaleBar, shortName } from './legend.js';
import { ScenarioList } from './list.js';
import { placed, startOf } from './motion.js';
import { Arrow, Lines, curveSegments } from './overlay.js';
import { Panel } from './panel.js';
import { Stage, VIEWS } from './stage.js';
import { Timeline } from './timeline.js';

const BACKGROUNDS = { light: '#eef1f4', dark: '#15191e' };

export class Viewer {
  constructor(model, page) {
    this.model = model;
    this.page = page;
    this.deepest = Math.max(...model.bodies.map(({ boxes }) => boxes.length)) - 1;
    this.depth = Math.min(4, this.deepest);
    this.onlyWorker = null;
    this.shown = {
      contacts: true, onTop: false, curves: true, arrows: true, boxes: false, byWorker: false, legend: true,
    };
    this.stage = new Stage(page.canvas);
    this.bodies = model.bodies.map((body, side) => new Body(body, side));
    this.curves = new Lines(colours.CURVE, 3);
    this.picked = new Lines(colours.PICKED, 3);
    this.arrows = {
      facts: {},
      clearance: new Arrow(colours.CLEARANCE, true),
      least: new Arrow(colours.PENETRATION, false),
      along: new Arrow(colours.ALONG, false),
      impact: new Arrow(colours.IMPACT, false),
    };
    const { facts, ...drawn } = this.arrows;
    this.drawnArrows = Object.entries(drawn);
    this.stage.scene.add(
      ...this.bodies.map((body) => body.object),
      this.curves.object,
      this.picked.object,
      ...this.drawnArrows.map(([, arrow]) => arrow.object),
    );
    this.stage.onDraw((stage) => this.fitToScreen(stage));
    this.panel = new Panel(model, page.panel, (ranks) => this.lookAtPair(ranks));
    this.timeline = new Timeline(model, page.time, (seconds) => this.place(seconds));
    this.list = new ScenarioList(model, page.list, (at) => this.choose(at));
    this.list.onArrange = () => this.showSlider();
    this.bindControls();
    bindKeys(this, page.help);
    this.setTheme(matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light');
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', ({ matches }) =>
      this.setTheme(matches ? 'dark' : 'light'));
    this.choose(this.list.order[0] ?? 0);
    this.lookAtAll('slanted');
  }

  bindControls() {
    const { page } = this;
    for (const [name, input] of Object.entries(page.toggles)) {
      input.addEventListener('change', () => this.toggle(name, input.checked));
    }
    page.depth.addEventListener('input', () => this.setDepth(Number(page.depth.value)));
    page.depth.max = this.deepest;
    page.looks.forEach((select, side) =>
      select.addEventListener('change', () => this.setLook(side, select.value)));
    page.worker.add(new Option('all workers', ''));
    for (let n = 0; n < this.model.header.workers; n++) page.worker.add(new Option(`worker ${n}`, n));
    page.worker.addEventListener('change', () => {
      this.onlyWorker = page.worker.value === '' ? null : Number(page.worker.value);
      this.toggle('byWorker', true);
    });
    page.slider.addEventListener('input', () => this.choose(this.list.order[Number(page.slider.value)]));
    page.helpButton.addEventListener('click', () => page.help.showModal());
    page.themeButton.addEventListener('click', () => this.switchTheme());
    let pressed = null;
    page.canvas.addEventListener('pointerdown', ({ clientX, clientY }) => { pressed = [clientX, clientY]; });
    page.canvas.addEventListener('pointerup', ({ clientX, clientY }) => {
      const moved = pressed && Math.hypot(clientX - pressed[0], clientY - pressed[1]);
      if (moved !== null && moved < 4) this.pick(clientX, clientY);
    });
  }

  /** Another scenario, by its place among those that are listed. */
  choose(at) {
    if (at === undefined || at >= this.model.scenarios.count) return;
    const { model } = this;
    const { scenarios, header } = model;
    this.at = at;
    this.start = startOf(model, at);
    this.isDeformed = header.deform_after !== undefined && scenarios.numbers[at] > header.deform_after;
    this.bodies.forEach((body) => body.setDeformed(this.isDeformed));
    const contacts = scenarios.contacts(at);
    this.contactRanks = [0, 1].map((side) =>
      [...new Set(contacts.filter((_, place) => place % 2 === side))]);
    const impact = impactTime(model, at);
    this.impactRanks = impact === null ? null : impactTriangles(model, at, (side, id) => this.rankOf(side, id));
    this.bodies.forEach((body, side) => {
      const meets = this.impactRanks && this.contactRanks[side].length === 0 ? [this.impactRanks[side]] : [];
      body.showContacts([...this.contactRanks[side], ...meets]);
    });
    const curves = scenarios.curves(at);
    this.hasCurves = curves.length > 0;
    this.curves.set(curveSegments(curves));
    this.say('');
    this.panel.show(at);
    this.timeline.show(impact, scenarios.intervals(at));
    this.arrows.facts = arrowsOf(model, at, this.middleOfContacts());
    this.drawnArrows.forEach(([name, arrow]) => arrow.set(this.arrows.facts[name]));
    this.list.show(at);
    this.showSlider();
    this.applyShown();
  }

  rankOf(side, id) {
    this.ranks ??= this.model.bodies.map(({ ids }) => {
      const ranks = new Uint32Array(ids.length);
      ids.forEach((number, rank) => { ranks[number] = rank; });
      return ranks;
    });
    return this.ranks[side][id];
  }

  /** Both bodies at a time. */
  place(seconds) {
    if (!this.start) return;
    const starts = [new Matrix4(), this.start];
    this.bodies.forEach((body, side) =>
      body.place(placed(this.model.bodies[side], starts[side], seconds), seconds));
    // Curves and distances are those of the start.
    this.isAtStart = seconds === 0;
    this.picked.set([]);
    this.applyShown();
  }

  showSlider() {
    const { slider, sliderReading } = this.page;
    const { order } = this.list;
    slider.max = Math.max(0, order.length - 1);
    slider.disabled = order.length < 2;
    const place = order.indexOf(this.at);
    if (place >= 0) slider.value = place;
    sliderReading.textContent = `scenario ${this.model.scenarios.numbers[this.at] ?? '–'}`;
  }

  toggle(name, to = !this.shown[name]) {
    const before = this.shown.byWorker;
    this.shown[name] = to;
    if (name === 'byWorker' && (to || before)) this.paint();
    this.applyShown();
  }

  paint() {
    const { workers } = this.model.header;
    this.bodies.forEach((body) => {
      if (!this.shown.byWorker) {
        body.paintWhole();
        return;
      }
      body.paintRoots((root) => {
        if (this.onlyWorker !== null) {
          return body.model.isHeld(root, this.onlyWorker) ? colours.worker(this.onlyWorker) : colours.NO_WORKER;
        }
        const holders = [...Array(workers).keys()].filter((number) => body.model.isHeld(root, number));
        if (holders.length === 0) return colours.NO_WORKER;
        return holders.length === 1 ? colours.worker(holders[0]) : colours.SEVERAL_WORKERS;
      });
    });
  }

  /** What is drawn is what was asked for. */
  applyShown() {
    const { shown, page } = this;
    for (const [name, input] of Object.entries(page.toggles)) input.checked = shown[name];
    page.depth.value = this.depth;
    page.depthReading.textContent = `depth ${this.depth}`;
    this.bodies.forEach((body, side) => {
      body.setContactsVisible(shown.contacts, shown.onTop);
      const boxes = shown.boxes ? this.depth : null;
      if (body.shownBoxes !== boxes) {
        body.showBoxes(boxes);
        body.shownBoxes = boxes;
      }
      page.looks[side].value = body.look;
    });
    this.curves.object.visible = shown.curves && this.isAtStart;
    this.drawnArrows.forEach(([name, arrow]) =>
      arrow.show(shown.arrows && (this.isAtStart || name === 'impact')));
    page.legend.hidden = !shown.legend;
    drawLegend(page.entries, legendRows(this));
    this.stage.draw();
  }

  setDepth(depth) {
    this.depth = Math.min(this.deepest, Math.max(0, depth));
    this.toggle('boxes', true);
  }

  setLook(side, look) {
    this.bodies[side].setLook(look);
    this.applyShown();
  }

  nextLook(side) {
    const now = LOOKS.indexOf(this.bodies[side].look);
    this.setLook(side, LOOKS[(now + 1) % LOOKS.length]);
  }

  setTheme(theme) {
    document.documentElement.dataset.theme = theme;
    this.stage.setBackground(BACKGROUNDS[theme]);
  }

  switchTheme() {
    this.setTheme(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark');
  }

  lookAtAll(from) {
    this.stage.look(this.cornersOfAll(), VIEWS[from]);
  }

  lookAtContacts() {
    const corners = this.cornersOfContacts();
    const { clearance } = this.arrows.facts;
    if (corners.length > 0) this.stage.look(around(corners, 1.5, 0.03));
    else if (clearance) this.stage.look(around(clearance, 4, 0.2));
    else this.lookAtAll();
  }

  lookAtPair(ranks) {
    const triangles = ranks.map((rank, side) => this.bodies[side].placedCorners(rank));
    this.picked.set(triangles.flatMap(outline));
    this.stage.look(around(triangles.flat(), 2, 0.02));
  }

  cornersOfContacts() {
    return this.contactRanks.flatMap((ranks, side) =>
      ranks.flatMap((rank) => this.bodies[side].placedCorners(rank)));
  }

  middleOfContacts() {
    const corners = this.cornersOfContacts();
    return new Box3().setFromPoints(corners.length > 0 ? corners : this.cornersOfAll()).getCenter(new Vector3());
  }

  /** Of the bounds of both bodies. */
  cornersOfAll() {
    return this.bodies.flatMap(({ model, object }) => {
      const half = new Vector3(...model.size).multiplyScalar(0.5);
      return cornersOf(half.clone().negate(), half).map((corner) => corner.applyMatrix4(object.matrix));
    });
  }

  /** Says which triangle is below a place on the screen. */
  pick(clientX, clientY) {
    const { left, top, width, height } = this.page.canvas.getBoundingClientRect();
    const [x, y] = [(2 * (clientX - left)) / width - 1, 1 - (2 * (clientY - top)) / height];
    const from = ray(this.stage.camera, x, y);
    const hits = this.bodies
      .map((body, side) => ({ side, hit: body.pick(from) }))
      .filter(({ hit }) => hit)
      .sort((a, b) => a.hit.distance - b.hit.distance);
    if (hits.length === 0) {
      this.picked.set([]);
      this.say('');
    } else {
      const { side, hit } = hits[0];
      const body = this.bodies[side];
      this.picked.set(outline(body.placedCorners(hit.rank)));
      const role = ['fixed', 'moving'][side];
      this.say(`${role} triangle ${body.model.ids[hit.rank]} (${shortName(body.model.name)})`);
    }
    this.stage.draw();
  }

  say(text) {
    this.page.status.textContent = text;
    this.page.status.hidden = text === '';
  }

  fitToScreen(stage) {
    this.stage.world = new Box3().setFromPoints(this.cornersOfAll()).getBoundingSphere(new Sphere());
    this.drawnArrows.forEach(([, arrow]) => arrow.fit(stage));
    const { pixels, text } = scaleBar(stage);
    this.page.scale.style.width = `${pixels}px`;
    this.page.scale.textContent = text;
  }
}

const outline = ([a, b, c]) =>
  [a, b, b, c, c, a].flatMap((corner) => corner.toArray());

const cornersOf = (low, high) => [0, 1, 2, 3, 4, 5, 6, 7].map((bits) =>
  new Vector3(...[0, 1, 2].map((k) => (bits & (1 << k) ? high : low).getComponent(k))));

/** The corners of a cube around points, so many times as large, and no smaller than shows where on the
 *  vehicle it is. */
function around(points, times, least) {
  const { center, radius } = new Box3().setFromPoints(points).getBoundingSphere(new Sphere());
  const half = new Vector3().setScalar(Math.max(times * radius, least) / Math.sqrt(3));
  return cornersOf(center.clone().sub(half), center.clone().add(half));
}
