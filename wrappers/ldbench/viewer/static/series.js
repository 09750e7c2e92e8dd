// A run for the other parts: values at rows, what is known between them and where no row is kept, and what is drawn.

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
const SAME = 1e-9;              // rows at a smaller distance are at one time [s]

class Run {
  constructor(facts, number, data) {
    Object.assign(this, facts, data, {number, shift: 0, made: new Map()});      // made: expressions by their names
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

  // The time of the file's row that is nearest to a time.
  rowTime(at) {
    const times = this.rowTimes ?? this.t;
    return times[nearestIndex(times, at)];
  }

  // Whether the kept row i follows the one before it in the file too.
  joined(i) { return !this.rowNumbers || this.rowNumbers[i] <= this.rowNumbers[i - 1] + 1; }

  value(name, row) { return this.has(name) ? this.exact[name][row] : NaN; }

  // The times and values of the finest series of a column.
  series(name) {
    const track = this.tracks[name];
    return track ? [this.rowTimes, track] : [this.t, this.exact[name]];
  }

  at(name, at) {
    return this.has(name) ? interpolate(...this.series(name), at) : NaN;
  }

  // What is known of a column at a time: the value of a row that is kept, a value between two rows that are kept and follow each
  // other in the file, or the limits of the rows there.
  reading(name, at) {
    if (!this.column(name)) return NOTHING;
    const i = indexBefore(this.t, at + SAME), x = this.exact[name];
    if (Math.abs(this.t[i] - at) <= SAME) return new Reading(x[i]);
    if (at < this.start || at > this.end) return NOTHING;
    if (this.joined(i + 1)) return between(this.t, x, i, at, k => this.joined(k));
    const row = indexBefore(this.rowTimes, at + SAME), here = this.limits(name, row), next = this.limits(name, row + 1);
    if (at - this.rowTimes[row] <= SAME) return here;
    if (!this.tracks[name]) return here.or(next);
    const {low, high} = between(this.rowTimes, this.tracks[name], row, at);
    const off = Math.max(here.high - here.low, next.high - next.low);
    return new Reading(low - off, high + off);
  }

  // What is known of a column in a row of the file that is not kept.
  limits(name, row) {
    const {low, high, bin} = this.band(name), k = Math.floor(row / bin), [, c] = OF_OPEN.exec(name) ?? [];
    return this.bands["N_" + c]?.high[row] === 0 ? NOTHING : new Reading(low[k], high[k]);
  }

  // The limits of a column in each bin of rows of a long run; undefined for a run that is kept whole.
  band(name) {
    const made = this.made.get(name);
    if (!this.bands[name] && this.rowNumbers && made) {
      const parts = made.parts.map(part => this.band(part)), bin = Math.max(...parts.map(part => part.bin));
      const [a, b] = parts.map(part => part.bin < bin ? pooled(part, bin) : part), low = a.low.slice(), high = a.low.slice();
      for (let k = 0; k < low.length; k++) ({low: low[k], high: high[k]} = combined(made.sign,
        {low: a.low[k], high: a.high[k]}, {low: b.low[k], high: b.high[k]}));
      this.bands[name] = {low, high, bin};
    }
    return this.bands[name];
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
    const band = this.band(name);
    if (!band) return asBins(this.t, this.exact[name]);
    const times = next => band.low.map((_, k) => this.rowTimes[Math.min(k * band.bin + next, this.rows - 1)]);
    return {...band, ...band.bin === 1 ? {from: this.rowTimes, to: this.rowTimes} : {from: times(0), to: times(band.bin - 1)}};
  }
}

// The rows between two times, and one more at either side: the first index and the one behind the last.
function span(t, start, end) { return [indexBefore(t, start), Math.min(indexBefore(t, end) + 2, t.length)]; }

function asBins(t, x) { return {from: t, to: t, low: x, high: x}; }

// The least and largest value of `factor` bins together.
function pooled(fine, factor) {
  const n = Math.ceil(fine.low.length / factor), next = {low: new Float64Array(n), high: new Float64Array(n), bin: factor};
  for (let k = 0; k < n; k++) {
    let low = NaN, high = NaN;
    for (let i = k * factor; i < Math.min((k + 1) * factor, fine.low.length); i++) {
      if (!(low <= fine.low[i])) low = Number.isNaN(fine.low[i]) ? low : fine.low[i];
      if (!(high >= fine.high[i])) high = Number.isNaN(fine.high[i]) ? high : fine.high[i];
    }
    [next.low[k], next.high[k]] = [low, high];
  }
  return next;
}

function coarser(fine, factor) {
  const next = pooled(fine, factor), last = fine.to.length - 1;
  return {...next, from: next.low.map((_, k) => fine.from[k * factor]),
          to: next.low.map((_, k) => fine.to[Math.min((k + 1) * factor - 1, last)])};
}

// Bins for so many pixels: those given, or two for each pixel.
function thinned(bins, pixels) {
  const n = bins.low.length;
  return n <= 4 * pixels ? bins : coarser(bins, Math.ceil(n / (2 * pixels)));
}

// What to draw of a column between two times in so many pixels: points, or a band of bins, and with it the rows that are
// kept where they are dense enough to help. Points are joined if `joined` says so, or all of them.
function drawing(run, name, start, end, pixels) {
  return drawable(part(run.finest(name), start, end), !run.rowNumbers, pixels, () => exactPoints(run, name, start, end));
}

// The difference of a later run from the first one, in this form.
function drawnDifference(first, other, name, start, end, pixels) {
  const found = difference(first, other, name, start, end), whole = Boolean(found.x);
  return drawable(whole ? asBins(found.t, found.x) : found, whole, pixels,
                  () => whole ? found : exactDifference(first, other, name, start, end));
}

function drawable(all, whole, pixels, points) {
  const band = thinned(all, pixels);
  if (whole && band === all) return {points: points()};
  return {band, exact: band.low.length < pixels / 2 ? points() : null};
}

// The bins between two times.
function part({from, to, low, high}, start, end) {
  const [a, b] = span(from, start, end);
  return Object.fromEntries(Object.entries({from, to, low, high}).map(([key, x]) => [key, x.subarray(a, b)]));
}

function middles({low, high}) { return low.map((x, k) => (x + high[k]) / 2); }

function exactPoints(run, name, start, end) {
  const [a, b] = span(run.t, start, end);
  return {t: run.t.subarray(a, b), x: run.exact[name].subarray(a, b),
          joined: run.rowNumbers ? i => run.joined(a + i) : undefined};
}

// The difference of a later run from the first one, at the rows of the first one between two times, as {t, x}; where a run has
// rows that are not kept, the limits of the difference, {from, to, low, high}.
function difference(first, other, name, start, end) {
  if (!first.rowNumbers && !other.rowNumbers) {
    const [a, b] = span(first.t, start, end), t = first.t.subarray(a, b), x = first.exact[name];
    return {t, x: t.map((at, i) => interpolate(other.t, other.exact[name], at) - x[a + i])};
  }
  const mine = part(first.finest(name), start, end), {from, to, low, high} = other.finest(name), last = from.length - 1;
  const found = {...mine, low: mine.low.map(() => NaN), high: mine.low.map(() => NaN)};
  for (let k = 0, i = 0; k < mine.low.length; k++) {
    const begin = mine.from[k] + SAME, end = mine.to[k] - SAME;
    if (mine.to[k] < from[0] - SAME || mine.from[k] > to[last] + SAME) continue;
    while (i < last && from[i + 1] <= begin) i++;
    // The bins of the other run from the one in or behind which this bin begins to the one in or before which it ends.
    let theirs = new Reading(low[i], high[i]);
    for (let j = i; j < last && to[j] < end; j++) theirs = theirs.or(new Reading(low[j + 1], high[j + 1]));
    ({low: found.low[k], high: found.high[k]} = combined("-", theirs, {low: mine.low[k], high: mine.high[k]}));
  }
  return found;
}

// The differences of two runs at the rows that both keep at one time.
function exactDifference(first, other, name, start, end) {
  const [a, b] = span(first.t, start, end), rows = [];
  for (let i = a, j = 0; i < b; i++) {
    while (j < other.t.length && other.t[j] < first.t[i] - SAME) j++;
    if (Math.abs(other.t[j] - first.t[i]) <= SAME) rows.push([i, j]);
  }
  const follows = k => rows[k].every((row, which) => row === rows[k - 1][which] + 1 && [first, other][which].joined(row));
  return {t: Float64Array.from(rows, ([i]) => first.t[i]), joined: k => k > 0 && follows(k),
          x: Float64Array.from(rows, ([i, j]) => other.exact[name][j] - first.exact[name][i])};
}
