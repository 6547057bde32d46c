// Time, where the bodies move: a slider, the time of impact, and the times in contact.

const SHORTEST_PLAY_S = 3;

export class Timeline {
  constructor(model, elements, onTime) {
    this.duration = model.header.motion?.duration_s ?? 0;
    this.elements = elements;
    this.onTime = onTime;
    this.seconds = 0;
    elements.row.hidden = this.duration === 0;
    elements.slider.max = this.duration;
    elements.slider.step = this.duration / 1000;
    elements.slider.addEventListener('input', () => this.set(Number(elements.slider.value)));
    elements.play.addEventListener('click', () => this.play());
    elements.impact.addEventListener('click', () => this.goToImpact());
  }

  /** Of another scenario: the time of impact, if there is one, and the intervals in contact. */
  show(impact, intervals) {
    this.stop();
    this.impact = impact;
    const { marks, impact: button } = this.elements;
    const mark = (from, to, className, title) => {
      const made = document.createElement('i');
      made.className = className;
      made.title = title;
      made.style.left = `${(100 * from) / this.duration}%`;
      made.style.width = className === 'interval' ? `${(100 * (to - from)) / this.duration}%` : '';
      return made;
    };
    const bands = intervals.map(([from, to]) =>
      mark(from, to, 'interval', `in contact ${from.toFixed(4)} s to ${to.toFixed(4)} s`));
    const line = impact === null ? [] : [mark(impact, impact, 'moment', `first impact at ${impact.toFixed(6)} s`)];
    marks.replaceChildren(...bands, ...line);
    button.disabled = impact === null;
    this.set(0);
  }

  set(seconds) {
    this.seconds = Math.min(this.duration, Math.max(0, seconds));
    const { slider, reading } = this.elements;
    slider.value = this.seconds;
    reading.textContent = `${this.seconds.toFixed(4)} s`;
    this.onTime(this.seconds);
  }

  step(by) {
    this.stop();
    this.set(this.seconds + (by * this.duration) / 100);
  }

  goToImpact() {
    this.stop();
    if (this.impact !== null) this.set(this.impact);
  }

  /** In as long as it takes, but in no less than three seconds; or not any more. */
  play() {
    if (this.duration === 0) return;
    if (this.playing) {
      this.stop();
      return;
    }
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) {
      this.set(this.seconds >= this.duration ? 0 : this.seconds + this.duration / 10);
      return;
    }
    const rate = this.duration / Math.max(SHORTEST_PLAY_S, this.duration);
    const from = this.seconds >= this.duration ? 0 : this.seconds;
    const begin = performance.now();
    const tick = (now) => {
      const seconds = from + (rate * Math.max(0, now - begin)) / 1000;
      this.playing = requestAnimationFrame(tick);
      this.set(seconds);
      if (seconds >= this.duration) this.stop();
    };
    this.playing = requestAnimationFrame(tick);
    this.elements.play.textContent = '❚❚';
  }

  stop() {
    cancelAnimationFrame(this.playing);
    this.playing = null;
    this.elements.play.textContent = '▶';
  }
}
