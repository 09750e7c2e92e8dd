// Time: playing at a speed, a stretch that is played again and again on request, and the run behind the slider.

const SPEEDS = [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1];

class Player {
  constructor(page) {
    Object.assign(this, {page, playing: false, looping: false, chosen: false});
    get("speed").append(...SPEEDS.map(speed => make("option", {value: speed}, `1:${Math.round(1 / speed)}`)));
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
    const {page} = this, [first, last] = this.span();
    if (page.t >= last || page.t < first) page.go(first, false);
    this.set(true);
    let before = performance.now();
    const frame = now => {
      if (!this.playing) return;
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
      this.next = requestAnimationFrame(frame);
    };
    this.next = requestAnimationFrame(frame);
  }

  // What is played: the window if it is looped, else the time that the axes show at first, and behind it the rest.
  span() {
    const {window, stretch, start, end, t} = this.page;
    return this.looping ? window : t < stretch[1] ? stretch : [start, end];
  }

  pause() {
    if (!this.playing) return;
    cancelAnimationFrame(this.next);
    this.set(false);
    this.page.go(this.page.t);
  }

  toggle() { this.playing ? this.pause() : this.play(); }

  loop(on) {
    this.looping = on;
    get("loop").setAttribute("aria-pressed", on);
  }

  set(playing) {
    this.playing = playing;
    get("play-shape").setAttribute("d", playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2l10 6-10 6z");
    get("play").setAttribute("aria-label", playing ? "pause" : "play");
  }
}

const KNEE = 0.7;               // share of the slider for the time that the axes show at first, where runs go on behind it

// The scale of the slider: even, with a knee where runs are left behind that a longer one would squeeze.
class Track {
  constructor(page) { this.page = page; }

  // Times, and where they are on the slider.
  get scale() {
    const {page: {start, end, stretch: [, knee]}} = this;
    return knee < end ? [[start, knee, end], [0, KNEE, 1]] : [[start, end], [0, 1]];
  }

  share(t) {
    const [times, shares] = this.scale;
    return interpolate(times, shares, Math.min(Math.max(t, times[0]), times.at(-1)));
  }

  time(share) {
    const [times, shares] = this.scale;
    return interpolate(shares, times, share);
  }
}

// The whole run behind the slider: the first run's displacement, the window, the events, and a line at the knee.
function drawOverview(page) {
  const {g, w, h} = prepare(get("overview"));
  const x = t => 7 + (w - 14) * page.track.share(t), [, knee] = page.stretch;
  g.fillStyle = page.colour.of("back");
  g.fillRect(0, 4, w, h - 8);
  g.fillStyle = page.colour.of("faint");
  g.fillRect(x(page.window[0]), 4, Math.max(x(page.window[1]) - x(page.window[0]), 2), h - 8);
  const run = page.runs[0], name = run.has("Y") ? "Y" : run.columns[0]?.name;
  if (name) {
    const found = thinned(run.finest(name), w / 4);
    const low = Math.min(...found.low.filter(Number.isFinite)), high = Math.max(...found.high.filter(Number.isFinite));
    g.strokeStyle = page.colour.of("muted");
    g.beginPath();
    found.from.forEach((t, k) => {
      for (const v of [found.low[k], found.high[k]])
        if (Number.isFinite(v)) g.lineTo(x(t), h - 8 - (h - 16) * (v - low) / (high - low || 1));
    });
    g.stroke();
  }
  if (knee < page.end) {
    g.fillStyle = page.colour.of("muted");
    g.fillRect(x(knee) - 0.5, 0, 1, h);
  }
  for (const event of page.events.listed) {
    g.fillStyle = page.colour.of(isLargest(event) ? "accent" : "ink");
    g.fillRect(x(event.t) - 0.75, isLargest(event) ? 0 : h - 9, 1.5, 9);
  }
  if (page.mark === null) return;
  g.fillStyle = page.colour.of("second");
  g.fillRect(x(page.mark) - 1, 0, 2, h);
}
