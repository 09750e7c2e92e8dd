// A run for the other parts: exact values at rows, values between them, and what a chart draws of a column.

// The last index with t[i] <= x, at least 0.
function indexBefore(t, x) {
  let low = 0, high = t.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (t[middle] <= x) low = middle;
    else high = middle - 1;
  }
  return low;
}

function nearestIndex(t, x) {
  const i = indexBefore(t, x);
  return i + 1 < t.length && t[i + 1] - x < x - t[i] ? i + 1 : i;
}

// Interpolate linearly between rows; NaN beyond them and beside a row without a value.
function interpolate(t, x, at) {
  if (at < t[0] || at > t[t.length - 1]) return NaN;
  const i = indexBefore(t, at);
  if (i + 1 === t.length || t[i] === at) return x[i];
  return x[i] + (x[i + 1] - x[i]) * (at - t[i]) / (t[i + 1] - t[i]);
}

class Run {
  constructor(facts, number, data) {
    Object.assign(this, facts, data);
    this.number = number;
    this.names = new Set(facts.columns.map(column => column.name));
    this.cached = new Map();
  }

  get start() { return this.t[0]; }
  get end() { return this.t[this.t.length - 1]; }

  // The mean time between all rows of the file, kept or not [s].
  get spacing() { return (this.end - this.start) / (this.rows - 1); }

  has(name) { return this.names.has(name); }

  row(at) { return nearestIndex(this.t, at); }

  value(name, row) { return this.has(name) ? this.exact[name][row] : NaN; }

  // The times and values of the finest series of a column.
  series(name) {
    const track = this.tracks[name];
    return track ? [this.rowTimes, track] : [this.t, this.exact[name]];
  }

  at(name, at) {
    return this.has(name) ? interpolate(...this.series(name), at) : NaN;
  }

  // The value that a chart shows: between the rows or, where many rows are left out, the nearest one.
  shownAt(name, at) {
    return this.rows > this.t.length && !this.tracks[name] ? this.value(name, this.row(at)) : this.at(name, at);
  }

  // The displacements of the axle centre; a column that the file lacks is zero.
  pose(at) {
    const q = name => {
      const x = this.at(name, Math.min(Math.max(at, this.start), this.end));
      return Number.isFinite(x) ? x : 0;
    };
    return {y: q("Y"), z: q("Z"), roll: q("roll")};
  }

  // A closed contact: force [N] and point relative to the axle centre, turned back by the roll. Force from the finest
  // series; direction and point between the rows that are kept, or from the nearest one with a closed contact.
  contact(c, at) {
    const N = this.at("N_" + c, at);
    if (!(N > 0)) return null;
    const i = indexBefore(this.t, at), j = Math.min(i + 1, this.t.length - 1);
    const a = this.contactAtRow(c, i), b = this.contactAtRow(c, j);
    if (a && b) {
      const share = j > i && this.t[j] > this.t[i] ? (at - this.t[i]) / (this.t[j] - this.t[i]) : 0;
      const mix = key => a[key] + (b[key] - a[key]) * share;
      return {N, angle: mix("angle"), u: mix("u"), v: mix("v")};
    }
    for (let k = 0; k < 60; k++) {
      const found = this.contactAtRow(c, i - k) ?? this.contactAtRow(c, j + k);
      if (found) return {...found, N};
    }
    return {N, angle: NaN, u: NaN, v: NaN};
  }

  contactAtRow(c, i) {
    if (i < 0 || i >= this.t.length || !(this.value("N_" + c, i) > 0)) return null;
    let angle = this.value("angle_" + c, i);
    if (!Number.isFinite(angle)) {
      const inward = c[0] === "L" ? -1 : 1;
      angle = Math.atan2(inward * this.value("Fy_" + c, i), this.value("Fz_" + c, i));
    }
    const roll = this.axleRoll + (this.value("roll", i) || 0);
    const dy = this.value("y_" + c, i) - (this.value("Y", i) || 0);
    const dz = this.value("z_" + c, i) - (this.value("Z", i) || 0) - this.axle;
    const cos = Math.cos(roll), sin = Math.sin(roll);
    return {angle, u: cos * dy + sin * dz, v: cos * dz - sin * dy};
  }

  // The least and largest value in bins of 1, 4, 16 ... rows of the finest series: [{from, to, low, high}], with the rows'
  // first and last times. Of a long run without all rows of this column, the finest are the bins of the file.
  levels(name) {
    const known = this.cached.get(name);
    if (known) return known;
    const band = this.bands[name];
    let finest;
    if (band) {
      const last = this.rows - 1, times = this.rowTimes;
      finest = {low: band.low, high: band.high,
                from: Float64Array.from(band.low, (_, k) => times[k * this.bin]),
                to: Float64Array.from(band.low, (_, k) => times[Math.min((k + 1) * this.bin - 1, last)])};
    } else {
      const [t, x] = this.series(name);
      finest = {low: x, high: x, from: t, to: t};
    }
    const found = [finest];
    while (found.at(-1).low.length > 512) found.push(coarser(found.at(-1), 4));
    this.cached.set(name, found);
    return found;
  }
}

function coarser(fine, factor) {
  const n = Math.ceil(fine.low.length / factor);
  const next = {low: new Float64Array(n), high: new Float64Array(n), from: new Float64Array(n),
                to: new Float64Array(n)};
  for (let k = 0; k < n; k++) {
    const a = k * factor, b = Math.min(a + factor, fine.low.length);
    let low = NaN, high = NaN;
    for (let i = a; i < b; i++) {
      if (!(low <= fine.low[i])) low = Number.isNaN(fine.low[i]) ? low : fine.low[i];
      if (!(high >= fine.high[i])) high = Number.isNaN(fine.high[i]) ? high : fine.high[i];
    }
    next.low[k] = low;
    next.high[k] = high;
    next.from[k] = fine.from[a];
    next.to[k] = fine.to[b - 1];
  }
  return next;
}

// What to draw between two times in so many pixels: a line through points, or the band of the coarsest bins that are
// no wider than a pixel; with the band, points of the exact rows where they are dense enough to help.
function drawing(run, name, start, end, pixels) {
  const levels = run.levels(name);
  const span = level => {
    const a = indexBefore(level.from, start), b = Math.min(indexBefore(level.from, end) + 1, level.from.length - 1);
    return [a, b];
  };
  let chosen = levels[0];
  for (const level of levels) {
    const [a, b] = span(level);
    if (b - a < pixels) break;
    chosen = level;
  }
  const [a, b] = span(chosen);
  const points = chosen.low === chosen.high ? lineThrough(chosen.from, chosen.low, a, b) : null;
  const exact = !points && b - a < pixels / 2 ? exactPoints(run, name, start, end) : null;
  return {points, exact, band: points ? null : cut(chosen, a, b)};
}

function lineThrough(t, x, a, b) {
  return {t: t.subarray(a, b + 1), x: x.subarray(a, b + 1)};
}

function exactPoints(run, name, start, end) {
  const a = indexBefore(run.t, start), b = Math.min(indexBefore(run.t, end) + 1, run.t.length - 1);
  return lineThrough(run.t, run.exact[name], a, b);
}

function cut(level, a, b) {
  const part = key => level[key].subarray(a, b + 1);
  return {from: part("from"), to: part("to"), low: part("low"), high: part("high")};
}

// The difference of a later run from the first one, at the rows of the first one between two times.
function difference(first, other, name, start, end) {
  const [t, x] = first.series(name), [u, y] = other.series(name);
  const a = indexBefore(t, start), b = Math.min(indexBefore(t, end) + 1, t.length - 1);
  const d = new Float64Array(b - a + 1);
  for (let i = a; i <= b; i++) d[i - a] = interpolate(u, y, t[i]) - x[i];
  return {t: t.subarray(a, b + 1), x: d};
}

// Every point, or the least and largest value of as many stretches as there are pixels.
function thinned({t, x}, pixels) {
  if (t.length <= 4 * pixels) return {points: {t, x}, band: null};
  const factor = Math.ceil(t.length / (2 * pixels));
  return {points: null, band: coarser({low: x, high: x, from: t, to: t}, factor)};
}
