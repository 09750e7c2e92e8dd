// One chart: columns of the runs that are shown over time or over another column, or the differences of the further
// runs from the first one over time.

const MOST_WITH_EVENTS = 2;     // runs: the events of more of them are one grey area

class Chart {
  constructor(page, {names, mode = "values", over = "", log = false, limits = null, acrossLimits = null}) {
    Object.assign(this, {page, names, mode: over ? "values" : mode, over, log, limits, acrossLimits});
  }

  // The runs and columns that are drawn: {run, column, colour, dash, width}. Of several runs, each has its look, and the
  // further columns are thinner; of one run, the contacts have theirs.
  lines() {
    const {runs, colour} = this.page, several = runs.length > 1, taken = [];
    let neutral = 0;
    return runs.slice(this.mode === "difference" ? 1 : 0).flatMap(run => this.names.map((name, k) => {
      const column = run.column(name);
      if (!column) return null;
      if (several) return {run, column, colour: colour.run(run), dash: colour.dash(run), width: [1.4, 2.2, 0.8][k % 3]};
      const look = colour.ofColumn(column) ?? colour.neutral(neutral++);
      const free = [look.dash, ...DASHES].find(dash => !taken.includes(look.colour + dash)) ?? look.dash;
      taken.push(look.colour + free);
      return {run, column, colour: look.colour, dash: free, width: 1.4};
    })).filter(Boolean);
  }

  resize() {
    Object.assign(this, prepare(this.canvas));
    const right = Math.max(this.w - MARGIN.right, MARGIN.left + 10);
    this.box = {left: MARGIN.left, right, top: MARGIN.top, bottom: this.h - MARGIN.bottom - (this.over ? MARGIN.words : 0),
                spare: MARGIN.right - 1};
  }

  // The limits of the horizontal axis: the window of time, or values of another column as they are shown.
  get ends() { return this.over ? this.across : this.page.window; }

  // The pixel of a place on the horizontal axis and back.
  x(place) {
    const [start, end] = this.ends, {left, right} = this.box;
    return left + (right - left) * (place - start) / (end - start);
  }

  place(x) {
    const [start, end] = this.ends, {left, right} = this.box;
    return start + (end - start) * (x - left) / (right - left);
  }

  // A column in the unit that the vertical axis shows.
  asOnAxis(column) {
    if (!this.scale || this.scale.log || this.over) return column;
    const [factor, unit] = shortUnit(column.unit, this.scale);
    return {...column, scale: factor * column.scale, unit};
  }

  // What a line shows.
  nameOf({run, column}) {
    const {name, contact = "", side = "", unit, scale} = this.asOnAxis(column);
    return {what: this.mode === "difference" ? "difference" : "column", run: run.name, column: name, contact, side, unit,
            factor: scale, over: this.over};
  }

  draw() {
    this.g.clearRect(0, 0, this.w, this.h);
    this.paint(this.g);
  }

  // Draw on a canvas or into a picture; `this.scale` is the vertical scale then.
  paint(g) {
    const {page, box} = this, [start, end] = page.window;
    g.font = "11px system-ui, sans-serif";
    const drawn = this.lines().map(line => this.over ? this.curve(line, start, end) : this.pieces(line, start, end));
    const all = key => drawn.map(one => one[key]);
    this.curves = this.over ? drawn : [];
    if (this.over) this.across = this.acrossLimits ?? extent(Math.min(...all("leftmost")), Math.max(...all("rightmost")));
    const least = Math.min(...all("least")), most = Math.max(...all("most")), smallest = Math.min(...all("smallest"));
    const [low, high] = this.limits ?? (this.log ? logExtent(smallest, Math.max(-least, most)) : extent(least, most));
    this.scale = verticalScale(low, high, this.log && low > 0, box);
    naming(g, {what: "axes"});
    drawAxes(g, page.colour, box, this.scale, drawn[0]?.line.column.unit ?? "", this.ends, x => this.x(x),
             this.over ? drawn[0]?.across.unit ?? "" : "s", commonWords(drawn.map(({line}) => line.column.words)),
             this.over ? drawn[0]?.across.words ?? "" : "");
    g.save();
    g.beginPath();
    g.rect(box.left, box.top - 1, box.right - box.left, box.bottom - box.top + 2);
    g.clip();
    naming(g, {what: "events"});
    if (!this.over) this.drawEvents(g);
    g.lineJoin = "round";
    drawn.forEach(one => this.drawPieces(g, one));
    naming(g, {what: "nothing to show"});
    g.restore();
    const words = drawn.some(one => Number.isFinite(one.most)) ? "" : drawn.length ? "no values here"
      : this.mode === "difference" ? "a difference needs a second run" : "no such column";
    g.fillStyle = page.colour.of("muted");
    g.textAlign = "center";
    if (words) g.fillText(words, (box.left + box.right) / 2, (box.bottom + box.top) / 2);
    naming(g);
  }

  // What is drawn of a line over time.
  pieces(line, start, end) {
    const {run, column} = line, pixels = this.box.right - this.box.left;
    const found = this.mode === "difference" ? drawnDifference(this.page.runs[0], run, column.name, start, end, pixels)
      : drawing(run, column.name, start, end, pixels);
    const {points, band} = found;
    return {line, ...found, ...extremes(column.scale, ...(band ? [band.low, band.high] : [points.x]))};
  }

  // What is drawn of a line over another column, in the window of time. A long run has both columns for every row, or at kept rows.
  curve(line, start, end) {
    const {run, column} = line, across = run.column(this.over) ?? {unit: "", scale: NaN, words: this.over};
    const every = [column.name, this.over].every(name => run.band(name)?.bin === 1);
    const times = every ? run.rowTimes : run.t, [a, b] = span(times, start, end);
    const values = name => every ? middles(part(run.finest(name), start, end))
      : run.exact[name]?.subarray(a, b) ?? new Float64Array(0);
    const t = values(this.over).map(x => across.scale * x), x = t.length ? values(column.name) : t;
    const {least: leftmost, most: rightmost} = extremes(1, t);
    return {line, across, times: times.subarray(a, b), leftmost, rightmost, ...extremes(column.scale, x),
            points: {t, x, joined: every || !run.rowNumbers ? undefined : i => run.joined(a + i)}};
  }

  // Where a curve is at a time [px]; null if it is not known to some pixels.
  pointAt({line: {run, column}, across}, t) {
    const ends = (name, pixel) => [run.reading(name, t).low, run.reading(name, t).high].map(pixel);
    const places = [ends(this.over, x => this.x(across.scale * x)), ends(column.name, x => this.scale.y(column.scale * x))];
    return places.every(([a, b]) => Math.abs(b - a) < 6) ? places.map(([a, b]) => (a + b) / 2) : null;
  }

  // The point of all curves that is nearest to a pixel: {curve, i, x, y}; null beyond 40 px.
  nearest(px, py) {
    let best = null, least = 40 ** 2;
    for (const curve of this.curves) {
      const {points, line: {column}} = curve;
      points.t.forEach((place, i) => {
        const x = this.x(place), y = this.scale.y(column.scale * points.x[i]), d = (x - px) ** 2 + (y - py) ** 2;
        if (d < least) [least, best] = [d, {curve, i, x, y}];
      });
    }
    return best;
  }

  drawPieces(g, {line, points, band, exact}) {
    const v = x => this.scale.y(line.column.scale * x);
    naming(g, this.nameOf(line));
    g.strokeStyle = g.fillStyle = line.colour;
    g.lineWidth = line.width;
    g.setLineDash(line.dash);
    if (band) this.drawBand(g, band, v, Boolean(exact));
    if (points) this.drawLine(g, points, v, points.t.length < (this.box.right - this.box.left) / 8 || Boolean(points.joined));
    if (exact) this.drawLine(g, exact, v, true);
    g.setLineDash([]);
  }

  // Points between which the run has rows that are not kept are dots.
  drawLine(g, {t, x, joined}, v, dots) {
    const size = t.length < (this.box.right - this.box.left) / 3 ? 3 : 1.5;
    let pen = false;
    g.beginPath();
    for (let i = 0; i < t.length; i++) {
      const shown = !Number.isNaN(x[i] + t[i]) && (!this.scale.log || x[i] !== 0), px = this.x(t[i]), py = v(x[i]);
      if (shown && pen && (!joined || joined(i))) g.lineTo(px, py);
      else if (shown) g.moveTo(px, py);
      if (shown && dots) g.fillRect(px - size / 2, py - size / 2, size, size);
      pen = shown;
    }
    g.stroke();
  }

  // A bin spans its least and largest value. The line goes on from one bin to the next through all values between them, and
  // has its dashes where bins are flat.
  drawBand(g, {from, to, low, high}, v, pale) {
    g.globalAlpha = pale ? 0.3 : 0.85;
    const {log} = this.scale, floor = this.box.bottom, between = (x, least, most) => Math.min(Math.max(x, least), most);
    const ends = k => {
      if (!log) return [v(high[k]), v(low[k])];
      const a = v(low[k]), b = v(high[k]);
      return low[k] > 0 || high[k] < 0 ? [Math.min(a, b), Math.max(a, b)] : [Math.min(a, b, floor), floor];
    };
    let before = null;
    g.beginPath();
    for (let k = 0; k < from.length; k++) {
      if (Number.isNaN(low[k]) || (log && low[k] === 0 && high[k] === 0)) {
        before = null;
        continue;
      }
      const x = this.x(from[k]), right = this.x(to[k]), [top, bottom] = ends(k);
      const middle = (top + bottom) / 2, flat = bottom - top < 2;
      if (before) {
        // The shortest way between both bins.
        const start = between(middle, before.top, before.bottom);
        if (!before.flat) g.moveTo(before.right, start);
        g.lineTo(x, between(start, top, bottom));
      } else {
        g.moveTo(x, middle);
        g.lineTo(x + 1, middle);
      }
      if (flat) g.lineTo(right, middle);
      else g.fillRect(x, top - 0.5, Math.max(right - x, g.lineWidth), bottom - top + 1);
      before = {top, bottom, flat, right};
    }
    g.stroke();
    g.globalAlpha = 1;
  }

  drawEvents(g) {
    const [start, end] = this.page.window, {box} = this;
    if (this.page.runs.length > MOST_WITH_EVENTS) return;
    const within = this.page.events.all.filter(({t}) => t >= start && t <= end);
    const shown = within.length > (box.right - box.left) / 6 ? within.filter(event => !event.fromRows) : within;
    g.strokeStyle = this.page.colour.of("edge");
    g.globalAlpha = shown.length > 40 ? 0.3 : 0.6;
    for (const {t} of shown) line(g, this.x(t), box.top, this.x(t), box.bottom);
    g.globalAlpha = 1;
  }
}

// The least and the largest of some values, and the smallest magnitude that is not zero.
function extremes(scale, ...series) {
  let [least, most, smallest] = [Infinity, -Infinity, Infinity];
  for (const values of series)
    for (const x of values) {
      if (x < least) least = x;
      if (x > most) most = x;
      if (x !== 0 && Math.abs(x) < smallest) smallest = Math.abs(x);
    }
  return {least: scale * least, most: scale * most, smallest: scale * smallest};
}
