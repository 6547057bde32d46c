// How long frames of a page take while its camera goes round, on this machine's graphics (or, where it
// has none, drawn by its processor), in Debian's Chromium:
//
//   node viewer/frames.mjs PAGE [FRAMES]
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [page, frames = '120'] = process.argv.slice(2);
const profile = mkdtempSync(join(tmpdir(), 'frames-'));
const flags = ['--headless', '--remote-debugging-pipe', '--no-sandbox', '--enable-unsafe-swiftshader',
  '--window-size=1280,800', `--user-data-dir=${profile}`];
const browser = spawn('chromium', flags, { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });

// Messages of JSON that end with a zero byte, each with a number that its answer has.
const waiting = new Map();
let kept = '';
browser.stdio[4].setEncoding('utf8').on('data', (text) => {
  const messages = (kept + text).split('\0');
  kept = messages.pop();
  for (const message of messages.map((message) => JSON.parse(message))) {
    waiting.get(message.id)?.(message);
    waiting.delete(message.id);
  }
});
let last = 0;
function call(method, params, sessionId) {
  const id = ++last;
  browser.stdio[3].write(JSON.stringify({ id, method, params, sessionId }) + '\0');
  return new Promise((done, failed) => {
    waiting.set(id, ({ result, error }) => (error ? failed(new Error(`${method}: ${error.message}`)) : done(result)));
  });
}

/** Runs in the page. A frame is over when its pixels are there. */
async function measure(count) {
  const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
  while (document.documentElement?.dataset.ready !== 'true') await sleep(50);
  const { stage } = window.bumper;
  while (stage.isAsked || stage.flight) await sleep(50);
  const gl = stage.renderer.getContext();
  const names = gl.getExtension('WEBGL_debug_renderer_info');
  const pixel = new Uint8Array(4);
  const axis = stage.camera.up;
  const times = [];
  for (let frame = 0; frame < count; frame++) {
    const begin = performance.now();
    stage.camera.position.sub(stage.controls.target).applyAxisAngle(axis, (2 * Math.PI) / count);
    stage.camera.position.add(stage.controls.target);
    stage.camera.lookAt(stage.controls.target);
    stage.listeners.forEach((listener) => listener(stage));
    stage.fitDepth();
    stage.renderer.render(stage.scene, stage.camera);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    times.push(performance.now() - begin);
  }
  times.sort((a, b) => a - b);
  const { calls, triangles } = stage.renderer.info.render;
  return {
    by: gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER),
    size: [gl.drawingBufferWidth, gl.drawingBufferHeight],
    calls,
    triangles,
    ms: { least: times[0], median: times[count >> 1], most: times[count - 1] },
  };
}

try {
  const { targetId } = await call('Target.createTarget', { url: pathToFileURL(resolve(page)).href });
  const { sessionId } = await call('Target.attachToTarget', { targetId, flatten: true });
  const expression = `(${measure})(${Number(frames)})`;
  const evaluated = { expression, awaitPromise: true, returnByValue: true };
  const { result, exceptionDetails } = await call('Runtime.evaluate', evaluated, sessionId);
  if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
  console.log(JSON.stringify(result.value, null, 2));
} finally {
  browser.kill();
  await new Promise((done) => browser.once('exit', done));
  rmSync(profile, { recursive: true, force: true });
}
