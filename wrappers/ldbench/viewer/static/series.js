// A run for the other parts: exact values at rows, values between them, and what is known where no row is kept.

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

// A contact with a larger normal force is closed [N], whether its rail pushes or pulls; as in contact_intervals.py.
const CLOSED = 1, isClosed = N => Math.abs(N) > CLOSED;
const CONTACTS = ["LT", "LF", "RT", "RF"];
const OF_OPEN = /^(?:angle|y|z|radius)_([LR][TF])$/;      // columns without a value where a contact is open

class Run {
  constructor(facts, number, data) {
    Object.assign(this, facts, data);
    this.number = number;
    this.names = new Set(facts.columns.map(column => column.name));
    this.known = new Map(facts.columns.map(column => [column.name, column]));
    this.cached = new Map();
    this.inFile = {t: this.t, rowTimes: this.rowTimes};
    this.shift = 0;
    if (this.t.length < this.rows) this.rowNumbers = numbersOf(this.t, this.rowTimes);
    addDerived(this);
  }

  get start() { return this.t[0]; }
  get end() { return this.t[this.t.length - 1]; }

  has(name) { return this.names.has(name); }

  // The facts of a column: of the file, derived, or an expression of two columns; undefined if the run has none.
  column(name) { return this.known.get(name) ?? addExpression(this, name); }

  // Show the run later by `shift` seconds.
  place(shift) {
    if (shift === this.shift) return;
    this.shift = shift;
    for (const [name, times] of Object.entries(this.inFile))
      if (times) this[name] = shift ? times.map(t => t + shift) : times;
    this.cached.clear();
  }

  // The kept row that is nearest to a time.
  row(at) { return nearestIndex(this.t, at); }

  // The kept row at a time; null if the row of the file that is nearest to this time is not kept.
  keptRow(at) {
    const i = this.row(at);
    return !this.rowNumbers || this.rowNumbers[i] === nearestIndex(this.rowTimes, at) || Math.abs(this.t[i] - at) < 1e-9
      ? i : null;
  }

  // Whether the kept row i follows the one before it in the file too.
  joined(i) { return !this.rowNumbers || this.rowNumbers[i] === this.rowNumbers[i - 1] + 1; }

  value(name, row) { return this.has(name) ? this.exact[name][row] : NaN; }

  // The times and values of the finest series of a column.
  series(name) {
    const track = this.tracks[name];
    return track ? [this.rowTimes, track] : [this.t, this.exact[name]];
  }

  at(name, at) {
    return this.has(name) ? interpolate(...this.series(name), at) : NaN;
  }

  // What is known of a column at a time: {x}, of the kept row or between the rows; {x, about} of the levels that a long
  // run keeps for every row; {low, high} of the rows nearby if that is all.
  reading(name, at) {
    if (!this.has(name)) return {x: NaN};
    if (!this.rowNumbers) return {x: this.at(name, at)};
    const i = this.keptRow(at), band = this.bands[name];
    if (i !== null) return {x: this.exact[name][i]};
    if (this.tracks[name]) return {x: this.at(name, at), about: true};
    const row = nearestIndex(this.rowTimes, at), [, c] = OF_OPEN.exec(name) ?? [];
    if (!band || at < this.start || at > this.end || this.tracks["N_" + c]?.[row] === 0) return {x: NaN};
    const k = Math.floor(row / this.bin);
    return {low: band.low[k], high: band.high[k]};
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
    if (!isClosed(N)) return null;
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
    if (i < 0 || i >= this.t.length || !isClosed(this.value("N_" + c, i))) return null;
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

  // The closed contact with the largest force, of one side or of both; else that of the nearest earlier or later row that
  // has one; null if there is none nearby.
  contactNear(side, at) {
    const names = CONTACTS.filter(c => (!side || c[0] === side) && this.has("N_" + c));
    const hardest = find => names.map(find).filter(found => found && Number.isFinite(found.u + found.v))
      .sort((a, b) => Math.abs(b.N) - Math.abs(a.N))[0];
    const now = hardest(c => this.contact(c, at));
    if (now) return now;
    const i = indexBefore(this.t, at);
    for (const step of [-1, 1])
      for (let k = i; k >= 0 && k < this.t.length && Math.abs(k - i) < 5000; k += step) {
        const found = names.some(c => isClosed(this.exact["N_" + c][k]))
          && hardest(c => ({...this.contactAtRow(c, k), N: this.exact["N_" + c][k]}));
        if (found) return found;
      }
    return null;
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

// The numbers of the kept rows among all rows.
function numbersOf(t, rowTimes) {
  const found = new Int32Array(t.length);
  for (let i = 0, k = 0; i < t.length; i++, k++) {
    while (k + 1 < rowTimes.length && Math.abs(rowTimes[k + 1] - t[i]) < Math.abs(rowTimes[k] - t[i])) k++;
    found[i] = k;
  }
  return found;
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
// no wider than a pixel; with the band, points of the exact rows where they are dense enough to help. Points are joined
// if `joined` says so, or all of them.
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
  if (chosen.low === chosen.high)
    return {points: chosen.from === run.t ? exactPoints(run, name, start, end) : lineThrough(chosen.from, chosen.low, a, b),
            exact: null, band: null};
  return {points: null, exact: b - a < pixels / 2 ? exactPoints(run, name, start, end) : null, band: cut(chosen, a, b)};
}

function lineThrough(t, x, a, b) {
  return {t: t.subarray(a, b + 1), x: x.subarray(a, b + 1)};
}

function exactPoints(run, name, start, end) {
  const a = indexBefore(run.t, start), b = Math.min(indexBefore(run.t, end) + 1, run.t.length - 1);
  return {...lineThrough(run.t, run.exact[name], a, b), joined: run.rowNumbers ? i => run.joined(a + i) : undefined};
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
