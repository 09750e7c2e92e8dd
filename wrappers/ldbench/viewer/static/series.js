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
    Object.assign(this, facts, data, {number, shift: 0});
    this.known = new Map(facts.columns.map(column => [column.name, column]));
    this.inFile = {t: this.t, rowTimes: this.rowTimes};
    if (this.t.length < this.rows) this.rowNumbers = this.t.map(t => nearestIndex(this.rowTimes, t));
    addDerived(this);
  }

  get start() { return this.t[0]; }
  get end() { return this.t[this.t.length - 1]; }

  has(name) { return this.known.has(name); }

  // The facts of a column: of the file, derived, or an expression of two columns; undefined if the run has none.
  column(name) { return this.known.get(name) ?? addExpression(this, name); }

  // Show the run later by `shift` seconds.
  place(shift) {
    if (shift === this.shift) return;
    this.shift = shift;
    for (const [name, times] of Object.entries(this.inFile))
      if (times) this[name] = shift ? times.map(t => t + shift) : times;
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
    const t = Math.min(Math.max(at, this.start), this.end), [y, z, roll] = ["Y", "Z", "roll"].map(name => this.at(name, t) || 0);
    return {y, z, roll};
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

  // The least and largest values of a column, and the first and last times of the rows that have them: those of each row, or of
  // bins of rows where a long run keeps no more.
  finest(name) {
    const band = this.bands[name];
    if (!band) return asBins(...this.series(name));
    const times = next => band.low.map((_, k) => this.rowTimes[Math.min(k * this.bin + next, this.rows - 1)]);
    return {...band, from: times(0), to: times(this.bin - 1)};
  }
}

// The rows between two times, and one more at either side: the first index and the one behind the last.
function span(t, start, end) { return [indexBefore(t, start), Math.min(indexBefore(t, end) + 2, t.length)]; }

function asBins(t, x) { return {from: t, to: t, low: x, high: x}; }

// The least and largest value of `factor` bins together.
function coarser(fine, factor) {
  const n = Math.ceil(fine.low.length / factor), array = () => new Float64Array(n);
  const next = {low: array(), high: array(), from: array(), to: array()};
  for (let k = 0; k < n; k++) {
    const a = k * factor, b = Math.min(a + factor, fine.low.length);
    let low = NaN, high = NaN;
    for (let i = a; i < b; i++) {
      if (!(low <= fine.low[i])) low = Number.isNaN(fine.low[i]) ? low : fine.low[i];
      if (!(high >= fine.high[i])) high = Number.isNaN(fine.high[i]) ? high : fine.high[i];
    }
    [next.low[k], next.high[k], next.from[k], next.to[k]] = [low, high, fine.from[a], fine.to[b - 1]];
  }
  return next;
}

// Bins for so many pixels: those given, or two for each pixel.
function thinned(bins, pixels) {
  const n = bins.low.length;
  return n <= 4 * pixels ? bins : coarser(bins, Math.ceil(n / (2 * pixels)));
}

// What to draw of a column between two times in so many pixels: points, or a band of bins, and with it the rows that are
// kept where they are dense enough to help. Points are joined if `joined` says so, or all of them.
function drawing(run, name, start, end, pixels) {
  const {from, to, low, high} = run.finest(name), [a, b] = span(from, start, end), part = x => x.subarray(a, b);
  const rows = low === high, least = part(low), all = {from: part(from), to: part(to), low: least, high: rows ? least : part(high)};
  const band = thinned(all, pixels);
  if (rows && band === all) return {points: run.tracks[name] ? {t: all.from, x: least} : exactPoints(run, name, start, end)};
  return {band, exact: band.low.length < pixels / 2 ? exactPoints(run, name, start, end) : null};
}

function exactPoints(run, name, start, end) {
  const [a, b] = span(run.t, start, end);
  return {t: run.t.subarray(a, b), x: run.exact[name].subarray(a, b),
          joined: run.rowNumbers ? i => run.joined(a + i) : undefined};
}

// The difference of a later run from the first one, at the rows of the first one between two times.
function difference(first, other, name, start, end) {
  const [t, x] = first.series(name), [u, y] = other.series(name), [a, b] = span(t, start, end);
  const times = t.subarray(a, b);
  return {t: times, x: times.map((at, i) => interpolate(u, y, at) - x[a + i])};
}
