// One chart over time: columns of the runs that are shown, or the differences of the further runs from the first.

const MARGIN = {left: 62, right: 12, top: 8, bottom: 22};

class Chart {
  constructor(page, names, mode = "values") {
    Object.assign(this, {page, names, mode});
  }

  // The runs and columns that are drawn: {run, column, colour, dash}.
  lines() {
    const {runs, colour} = this.page, several = runs.length > 1;
    return runs.slice(this.mode === "difference" ? 1 : 0).flatMap(run => this.names.map((name, k) => {
      const column = run.columns.find(one => one.name === name);
      const contact = name.split("_").at(-1);
      if (!column) return null;
      if (several) return {run, column, colour: colour.run(run), dash: colour.dashes[k % colour.dashes.length]};
      const ofContact = colour.contacts.has(contact) && this.names.filter(one => one.endsWith(contact)).length < 2;
      return ofContact
        ? {run, column, colour: colour.of(contact), dash: contact[1] === "F" ? [6, 2] : []}
        : {run, column, colour: colour.series(k), dash: colour.dashes[k % colour.dashes.length]};
    })).filter(Boolean);
  }

  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2), {clientWidth: w, clientHeight: h} = this.canvas;
    this.canvas.width = Math.round(w * ratio);
    this.canvas.height = Math.round(h * ratio);
    Object.assign(this, {w, h, ratio});
  }

  get inner() { return Math.max(this.w - MARGIN.left - MARGIN.right, 10); }

  x(t) {
    const [start, end] = this.page.window;
    return MARGIN.left + this.inner * (t - start) / (end - start);
  }

  time(x) {
    const [start, end] = this.page.window;
    return start + (end - start) * (x - MARGIN.left) / this.inner;
  }

  draw() {
    const {page, ratio} = this, g = this.canvas.getContext("2d");
    const [start, end] = page.window;
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, this.w, this.h);
    g.font = "11px system-ui, sans-serif";
    const drawn = this.lines().map(line => ({line, ...this.pieces(line, start, end)}));
    const [low, high] = extent(drawn, start, end);
    const bottom = this.h - MARGIN.bottom;
    const y = v => bottom - (bottom - MARGIN.top) * (v - low) / (high - low);
    this.axes(g, low, high, y, bottom, drawn[0]?.line.column.unit ?? "");
    g.save();
    g.beginPath();
    g.rect(MARGIN.left, MARGIN.top - 1, this.inner, bottom - MARGIN.top + 2);
    g.clip();
    this.marks(g, bottom);
    g.lineJoin = "round";
    for (const {line, points, band, exact} of drawn) {
      const v = x => y(line.column.scale * x);
      g.strokeStyle = g.fillStyle = line.colour;
      g.lineWidth = 1.4;
      if (band) this.drawBand(g, band, v, Boolean(exact));
      g.setLineDash(line.dash);
      const dots = points && points.t.length < this.inner / 8;
      if (points) this.drawLine(g, points, v, dots);
      if (exact) this.drawLine(g, exact, v, true, 1.5 * line.run.spacing);
      g.setLineDash([]);
    }
    g.restore();
    if (!Number.isFinite(drawn.reduce((sum, one) => sum + one.most, 0)) || !drawn.length) {
      g.fillStyle = page.colour.of("muted");
      g.textAlign = "center";
      g.fillText(this.empty(drawn), MARGIN.left + this.inner / 2, (bottom + MARGIN.top) / 2);
    }
  }

  empty(drawn) {
    if (drawn.some(one => Number.isFinite(one.most))) return "";
    if (!drawn.length) return this.mode === "difference" ? "a difference needs a second run" : "no such column";
    return "no values here";
  }

  pieces(line, start, end) {
    const {run, column} = line;
    const found = this.mode === "difference"
      ? thinned(difference(this.page.runs[0], run, column.name, start, end), this.inner)
      : drawing(run, column.name, start, end, this.inner);
    let least = Infinity, most = -Infinity;
    const see = (x, from, to) => {
      if (to < start || from > end) return;
      if (x < least) least = x;
      if (x > most) most = x;
    };
    const {points, band} = found;
    if (points) points.x.forEach((x, i) => see(x, points.t[i], points.t[i]));
    if (band) {
      band.low.forEach((x, i) => see(x, band.from[i], band.to[i]));
      band.high.forEach((x, i) => see(x, band.from[i], band.to[i]));
    }
    return {...found, least: least * column.scale, most: most * column.scale};
  }

  // Points that lie further apart than `reach` are not joined.
  drawLine(g, {t, x}, v, dots, reach = Infinity) {
    g.beginPath();
    let pen = false;
    for (let i = 0; i < t.length; i++) {
      if (Number.isNaN(x[i])) {
        pen = false;
        continue;
      }
      if (pen && t[i] - t[i - 1] <= reach) g.lineTo(this.x(t[i]), v(x[i]));
      else g.moveTo(this.x(t[i]), v(x[i]));
      pen = true;
    }
    g.stroke();
    if (!dots) return;
    for (let i = 0; i < t.length; i++)
      if (!Number.isNaN(x[i])) g.fillRect(this.x(t[i]) - 1.5, v(x[i]) - 1.5, 3, 3);
  }

  drawBand(g, {from, to, low, high}, v, pale) {
    g.globalAlpha = pale ? 0.3 : 0.85;
    for (let k = 0; k < from.length; k++) {
      if (Number.isNaN(low[k])) continue;
      const x = this.x(from[k]), width = Math.max(this.x(to[k]) - x, 1), top = v(high[k]);
      g.fillRect(x, top - 0.5, width, Math.max(v(low[k]) - top, 0) + 1);
    }
    g.globalAlpha = 1;
  }

  axes(g, low, high, y, bottom, unit) {
    const {colour} = this.page, [start, end] = this.page.window;
    g.lineWidth = 1;
    g.textBaseline = "middle";
    g.textAlign = "right";
    const [values, digits] = ticks(low, high, Math.max((bottom - MARGIN.top) / 34, 2));
    for (const v of values) {
      g.strokeStyle = colour.of("faint");
      line(g, MARGIN.left, y(v), this.w - MARGIN.right, y(v));
      g.fillStyle = colour.of("muted");
      g.fillText(tickWords(v, digits), MARGIN.left - 6, y(v));
    }
    g.textAlign = "center";
    const [times, timeDigits] = ticks(start, end, Math.max(this.inner / 95, 2));
    for (const t of times) {
      g.strokeStyle = colour.of("faint");
      line(g, this.x(t), MARGIN.top, this.x(t), bottom);
      g.fillStyle = colour.of("muted");
      g.fillText(tickWords(t, timeDigits), this.x(t), bottom + 10);
    }
    g.textAlign = "right";
    g.fillText("s", this.w - 1, bottom + 10);
    g.textAlign = "center";
    g.save();
    g.translate(8, (MARGIN.top + bottom) / 2);
    g.rotate(-Math.PI / 2);
    g.fillText(unit, 0, 0);
    g.restore();
    g.strokeStyle = colour.of("muted");
    line(g, MARGIN.left, bottom, this.w - MARGIN.right, bottom);
  }

  marks(g, bottom) {
    const [start, end] = this.page.window;
    g.strokeStyle = this.page.colour.of("edge");
    g.globalAlpha = 0.6;
    for (const {t} of this.page.events) if (t >= start && t <= end) line(g, this.x(t), MARGIN.top, this.x(t), bottom);
    g.globalAlpha = 1;
  }
}

function line(g, x1, y1, x2, y2) {
  g.beginPath();
  g.moveTo(Math.round(x1) + 0.5, Math.round(y1) + 0.5);
  g.lineTo(Math.round(x2) + 0.5, Math.round(y2) + 0.5);
  g.stroke();
}

// The limits of the vertical axis; a constant gets room, so that rounding is not magnified.
function extent(drawn) {
  const low = Math.min(...drawn.map(one => one.least)), high = Math.max(...drawn.map(one => one.most));
  if (!(high >= low) || !Number.isFinite(high - low)) return [0, 1];
  const middle = (low + high) / 2;
  if (high - low < 1e-9 * Math.abs(middle) || high === low) {
    const half = Math.max(0.05 * Math.abs(middle), Math.abs(middle) > 0 ? 0 : 1);
    return [middle - half, middle + half];
  }
  return [low - 0.05 * (high - low), high + 0.05 * (high - low)];
}

// Round numbers between two limits, about `count` of them, and the decimals that they need.
function ticks(low, high, count) {
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find(k => k * power >= raw * (1 - 1e-9)) * power;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return [found, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))];
}

function tickWords(v, digits) {
  const tiny = digits > 5, text = tiny || Math.abs(v) >= 1e6 ? `${+v.toPrecision(3)}` : v.toFixed(digits);
  return tiny && Math.abs(v) < 10 ** -(digits + 2) ? "0" : text.replace("e+", "e").replaceAll("-", "−");
}
