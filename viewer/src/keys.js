// Every key that does something, and the overlay that lists them.

import { element } from './panel.js';

const ORBIT = Math.PI / 24;

export function bindKeys(viewer, help) {
  const { stage, list, timeline } = viewer;
  const go = (by) => viewer.choose(list.neighbour(by));
  const all = [
    ['Scenarios', [
      [['ArrowRight', 'n'], '→ or n', 'next in the list', () => go(1)],
      [['ArrowLeft', 'p'], '← or p', 'the one before', () => go(-1)],
      [['PageDown'], 'Page down', 'ten further', () => go(10)],
      [['PageUp'], 'Page up', 'ten back', () => go(-10)],
      [['Home'], 'Home', 'first in the list', () => go(-Infinity)],
      [['End'], 'End', 'last in the list', () => go(Infinity)],
    ]],
    ['Time (scenes with motion)', [
      [[' '], 'Space', 'play, or stop', () => timeline.play()],
      [['ArrowUp', '.'], '↑ or .', 'a hundredth later', () => timeline.step(1)],
      [['ArrowDown', ','], '↓ or ,', 'a hundredth earlier', () => timeline.step(-1)],
      [['i'], 'i', 'time of the first impact', () => timeline.goToImpact()],
    ]],
    ['Look', [
      [['f'], 'f', 'at what touches, or at what is nearest', () => viewer.lookAtContacts()],
      [['a'], 'a', 'at both vehicles', () => viewer.lookAtAll()],
      [['1'], '1', 'from the front', () => viewer.lookAtAll('front')],
      [['2'], '2', 'from the left', () => viewer.lookAtAll('left')],
      [['3'], '3', 'from above', () => viewer.lookAtAll('above')],
      [['Shift+ArrowLeft'], 'Shift + arrows', 'turn around', () => stage.orbit(-ORBIT, 0)],
      [['Shift+ArrowRight'], null, null, () => stage.orbit(ORBIT, 0)],
      [['Shift+ArrowUp'], null, null, () => stage.orbit(0, -ORBIT)],
      [['Shift+ArrowDown'], null, null, () => stage.orbit(0, ORBIT)],
      [['+', '='], '+', 'nearer', () => stage.zoom(1 / 1.2)],
      [['-'], '-', 'farther', () => stage.zoom(1.2)],
    ]],
    ['Show', [
      [['c'], 'c', 'triangles that touch', () => viewer.toggle('contacts')],
      [['o'], 'o', 'these through everything before them', () => viewer.toggle('onTop')],
      [['u'], 'u', 'contact curves', () => viewer.toggle('curves')],
      [['r'], 'r', 'arrows of clearance, penetration, impact', () => viewer.toggle('arrows')],
      [['b'], 'b', 'boxes of the trees', () => viewer.toggle('boxes')],
      [['['], '[', 'boxes one level higher', () => viewer.setDepth(viewer.depth - 1)],
      [[']'], ']', 'boxes one level deeper', () => viewer.setDepth(viewer.depth + 1)],
      [['w'], 'w', 'subtrees by their workers', () => viewer.toggle('byWorker')],
      [['g'], 'g', 'fixed vehicle solid, ghost, hidden', () => viewer.nextLook(0)],
      [['h'], 'h', 'moving vehicle solid, ghost, hidden', () => viewer.nextLook(1)],
      [['l'], 'l', 'legend', () => viewer.toggle('legend')],
      [['t'], 't', 'light or dark', () => viewer.switchTheme()],
      [['?'], '?', 'this help', () => (help.open ? help.close() : help.showModal())],
    ]],
  ];
  const actions = new Map(all.flatMap(([, keys]) =>
    keys.flatMap(([names, , , action]) => names.map((name) => [name, action]))));
  fill(help, all);
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (help.open && event.key !== '?') return;
    if (writes(event)) return;
    const shifted = event.shiftKey && event.key.startsWith('Arrow') ? `Shift+${event.key}` : event.key;
    const action = actions.get(shifted);
    if (!action) return;
    event.preventDefault();
    action();
  });
}

/** Whether a key means something to what has the focus. */
function writes({ target, key }) {
  if (target.matches('select, input[type=number]')) return true;
  if (target.matches('button, input[type=checkbox]')) return key === ' ' || key === 'Enter';
  return false;
}

function fill(help, all) {
  const columns = all.map(([title, keys]) => {
    const section = element('section', '');
    const table = element('dl', '');
    for (const [, name, meaning] of keys) {
      if (name) table.append(element('dt', name), element('dd', meaning));
    }
    section.append(element('h3', title), table);
    return section;
  });
  help.querySelector('.columns').replaceChildren(...columns);
}
