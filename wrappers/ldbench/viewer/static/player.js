// Playing: a speed, one loop of frames, and a stretch that is played again and again on request.

const SPEEDS = [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1];

class Player {
  constructor(page) {
    Object.assign(this, {page, playing: false, looping: false, turn: 0, chosen: false});
    get("speed").append(...SPEEDS.map(speed => make("option", {value: String(speed)}, `1:${Math.round(1 / speed)}`)));
    get("speed").onchange = () => { this.chosen = true; };
  }

  get speed() { return Number(get("speed").value); }

  // A speed by which so many seconds of a run take about 20 s, unless one was chosen.
  suit(seconds) {
    if (!this.chosen) get("speed").value = SPEEDS.findLast(speed => speed <= seconds / 20 * 1.5) ?? SPEEDS[0];
  }

  choose(speed) {
    if (!SPEEDS.includes(speed)) return;
    get("speed").value = speed;
    this.chosen = true;
  }

  change(step) {
    const k = SPEEDS.indexOf(this.speed);
    this.choose(SPEEDS[Math.min(Math.max(k + step, 0), SPEEDS.length - 1)]);
  }

  play() {
    if (this.playing) return;
    const {page} = this, turn = ++this.turn, [first, last] = this.span();
    if (page.t >= last || page.t < first) page.go(first, false);
    this.playing = true;
    this.draw();
    let before = performance.now();
    const frame = now => {
      // A loop that was stopped stays stopped, even if another one has begun since.
      if (turn !== this.turn || !this.playing) return;
      const [start, end] = this.span();
      let t = page.t + Math.max(now - before, 0) / 1e3 * this.speed;
      before = now;
      if (t >= end && !this.looping) {
        this.pause();
        page.go(end);
        return;
      }
      if (t >= end) t = start + (t - end) % (end - start || 1);
      page.go(t, false);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  // What is played: the window if it is looped, else the whole run.
  span() { return this.looping ? this.page.window : [this.page.start, this.page.end]; }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.draw();
    this.page.go(this.page.t);
  }

  toggle() { this.playing ? this.pause() : this.play(); }

  loop(on) {
    this.looping = on;
    get("loop").setAttribute("aria-pressed", on);
  }

  draw() {
    get("play-shape").setAttribute("d", this.playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2l10 6-10 6z");
    get("play").setAttribute("aria-label", this.playing ? "pause" : "play");
  }
}
