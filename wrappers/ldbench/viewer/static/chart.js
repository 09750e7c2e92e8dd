// One chart: columns of the runs that are shown over time or over another column, or the differences of the further
// runs from the first one over time.

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
      const look = colour.ofColumn(name) ?? colour.neutral(neutral++);
      const same = taken.filter(one => one === look.colour).length;
      taken.push(look.colour);
      return {run, column, colour: look.colour, dash: same ? colour.dashes[(same + 1) % 4] : look.dash, width: 1.4};
    })).filter(Boolean);
  }

  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2), {clientWidth: w, clientHeight: h} = this.canvas;
    this.canvas.width = Math.round(w * ratio);
    this.canvas.height = Math.round(h * ratio);
    Object.assign(this, {w, h, ratio});
    this.box = boxOf(w, h);
  }

  // Time of a pixel and back.
  x(t) {
    const [start, end] = this.page.window, {left, right} = this.box;
    return left + (right - left) * (t - start) / (end - start);
  }

  time(x) {
    const [start, end] = this.page.window, {left, right} = this.box;
    return start + (end - start) * (x - left) / (right - left);
  }

  // A column in the unit that the vertical axis shows.
  asOnAxis(column) {
    if (!this.scale || this.scale.log || this.over) return column;
    const [factor, unit] = shortUnit(column.unit, Math.max(Math.abs(this.scale.low), Math.abs(this.scale.high)));
    return {...column, scale: factor * column.scale, unit};
  }

  draw() {
    const g = this.canvas.getContext("2d");
    g.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    g.clearRect(0, 0, this.w, this.h);
    this.paint(g);
  }

  // Draw on a canvas or into a picture; `this.scale` is the vertical scale then.
  paint(g) {
    const {page, box} = this, [start, end] = page.window;
    g.font = "11px system-ui, sans-serif";
    const drawn = this.over ? this.lines().map(line => this.curve(line, start, end))
      : this.lines().map(line => ({line, ...this.pieces(line, start, end)}));
    this.scale = this.scaleOf(drawn);
    const unit = drawn[0]?.line.column.unit ?? "";
    let x = t => this.x(t);
    if (this.over) {
      x = this.horizontal(drawn);
      drawAxes(g, page.colour, box, this.scale, unit, ...this.across, x, drawn[0]?.across.unit ?? "");
    } else drawAxes(g, page.colour, box, this.scale, unit, start, end, x, "s");
    g.save();
    g.beginPath();
    g.rect(box.left, box.top - 1, box.right - box.left, box.bottom - box.top + 2);
    g.clip();
    if (!this.over) this.drawEvents(g);
    g.lineJoin = "round";
    for (const one of drawn) {
      g.strokeStyle = g.fillStyle = one.line.colour;
      g.lineWidth = one.line.width;
      if (this.over) this.drawCurve(g, one);
      else this.drawPieces(g, one);
    }
    g.restore();
    const words = this.empty(drawn);
    if (!words) return;
    g.fillStyle = page.colour.of("muted");
    g.textAlign = "center";
    g.fillText(words, (box.left + box.right) / 2, (box.bottom + box.top) / 2);
  }

  scaleOf(drawn) {
    const {box} = this, least = Math.min(...drawn.map(one => one.least)), most = Math.max(...drawn.map(one => one.most));
    const smallest = Math.min(...drawn.map(one => one.smallest)), largest = Math.max(-least, most);
    const [low, high] = this.limits ?? (this.log ? logExtent(smallest, largest) : extent(least, most));
    return this.log && low > 0 ? logScale(low, high, box.top, box.bottom) : linearScale(low, high, box.top, box.bottom);
  }

  empty(drawn) {
    if (drawn.some(one => Number.isFinite(one.most))) return "";
    if (!drawn.length) return this.mode === "difference" ? "a difference needs a second run" : "no such column";
    return "no values here";
  }

  pieces(line, start, end) {
    const {run, column} = line, pixels = this.box.right - this.box.left;
    const found = this.mode === "difference"
      ? thinned(difference(this.page.runs[0], run, column.name, start, end), pixels)
      : drawing(run, column.name, start, end, pixels);
    let least = Infinity, most = -Infinity, smallest = Infinity;
    const see = (x, from, to) => {
      if (to < start || from > end) return;
      if (x < least) least = x;
      if (x > most) most = x;
      const size = Math.abs(x);
      if (size < smallest && size > 0) smallest = size;
    };
    const {points, band} = found;
    if (points) points.x.forEach((x, i) => see(x, points.t[i], points.t[i]));
    if (band) {
      band.low.forEach((x, i) => see(x, band.from[i], band.to[i]));
      band.high.forEach((x, i) => see(x, band.from[i], band.to[i]));
    }
    // A stretch without a point shows the line between the points on both sides.
    if (points && least === Infinity) points.x.forEach(x => see(x, start, end));
    const scale = column.scale;
    return {...found, least: least * scale, most: most * scale, smallest: smallest * scale};
  }

  drawPieces(g, {line, points, band, exact}) {
    const v = x => this.scale.y(line.column.scale * x);
    g.setLineDash(line.dash);
    if (band) this.drawBand(g, band, v, Boolean(exact));
    const dots = points && points.t.length < (this.box.right - this.box.left) / 8;
    if (points) this.drawLine(g, points, v, dots || Boolean(points.joined));
    if (exact) this.drawLine(g, exact, v, true);
    g.setLineDash([]);
  }

  // Points between which the run has rows that are not kept are dots.
  drawLine(g, {t, x, joined}, v, dots) {
    g.beginPath();
    let pen = false;
    const shown = i => !Number.isNaN(x[i]) && (!this.scale.log || x[i] !== 0);
    for (let i = 0; i < t.length; i++) {
      if (!shown(i)) {
        pen = false;
        continue;
      }
      if (pen && (!joined || joined(i))) g.lineTo(this.x(t[i]), v(x[i]));
      else g.moveTo(this.x(t[i]), v(x[i]));
      pen = true;
    }
    g.stroke();
    if (!dots) return;
    const size = t.length < (this.box.right - this.box.left) / 3 ? 3 : 1.5;
    for (let i = 0; i < t.length; i++)
      if (shown(i)) g.fillRect(this.x(t[i]) - size / 2, v(x[i]) - size / 2, size, size);
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
    const within = this.page.events.all.filter(({t}) => t >= start && t <= end);
    const shown = within.length > (box.right - box.left) / 6 ? within.filter(event => !event.fromRows) : within;
    g.strokeStyle = this.page.colour.of("edge");
    g.globalAlpha = shown.length > 40 ? 0.3 : 0.6;
    for (const {t} of shown) line(g, this.x(t), box.top, this.x(t), box.bottom);
    g.globalAlpha = 1;
  }
}

function boxOf(w, h) {
  const right = Math.max(w - MARGIN.right, MARGIN.left + 10);
  return {left: MARGIN.left, right, top: MARGIN.top, bottom: h - MARGIN.bottom, spare: MARGIN.right - 1};
}
