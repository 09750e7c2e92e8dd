// What is known of a number: its value, or limits between which it lies. Readings are added, subtracted, multiplied and
// divided here alone, so that a number with all digits is never made of one that is not known to all digits.

class Reading {
  constructor(low, high = low) { Object.assign(this, {low, high}); }

  get exact() { return this.low === this.high; }
  get unknown() { return Number.isNaN(this.low + this.high); }
  get middle() { return this.exact ? this.low : (this.low + this.high) / 2; }

  // The limits that hold both readings.
  or(other) { return new Reading(Math.min(this.low, other.low), Math.max(this.high, other.high)); }

  // How far this reading is above another one. The digits that two numbers of a file share leave none behind the ninth.
  above(other) {
    const found = combined("-", this, other);
    if (!found.exact || found.low === 0) return found;
    const digits = placeOf(found.low) - Math.max(placeOf(this.low), placeOf(other.low)) + FILE_DIGITS;
    return new Reading(digits < 1 ? 0 : Number(found.low.toPrecision(Math.min(digits, 15))));
  }
}

const NOTHING = new Reading(NaN);
const FILE_DIGITS = 9;
const OPERATIONS = {
  "+": (a, b) => a + b, "-": (a, b) => a - b, "*": (a, b) => a * b, "/": (a, b) => b === 0 ? NaN : a / b,
};

// What two readings make. Each operation is monotonic in each number, so its extremes are at the limits; nothing is known of a
// ratio whose divisor may be zero.
function combined(sign, a, b) {
  if (sign === "/" && b.low <= 0 && b.high >= 0) return NOTHING;
  const act = OPERATIONS[sign], found = [a.low, a.high].flatMap(x => [act(x, b.low), act(x, b.high)]);
  return new Reading(Math.min(...found), Math.max(...found));
}

// A value between the rows i and i + 1: on the straight line between them, off it by what this line, drawn on, misses the rows
// beside them that `joined` knows to follow in the file, and by the rounding of the file; without such rows, by what both rows
// differ. A curve that is smooth or has one kink or jump between the rows is within. A column that stays constant is known.
function between(t, x, i, at, joined = () => true) {
  const slope = (x[i + 1] - x[i]) / (t[i + 1] - t[i]), line = time => x[i] + slope * (time - t[i]);
  const misses = [[i - 1, i], [i + 2, i + 2]].filter(([k, second]) => k >= 0 && k < t.length && joined(second))
    .map(([k]) => Math.abs(x[k] - line(t[k]))).filter(Number.isFinite);
  if (slope === 0 && misses.includes(0)) return new Reading(x[i]);
  const off = (misses.length ? misses.reduce((a, b) => a + b) : Math.abs(x[i + 1] - x[i]))
    + Math.max(Math.abs(x[i]), Math.abs(x[i + 1])) * 10 ** (1 - FILE_DIGITS);
  return new Reading(line(at) - off, line(at) + off);
}

// A reading in words: with all digits asked for; ≈ and the digits that are known, the last of them to one unit; or both limits,
// rounded outwards.
function readingWords({low, high}, column, si = false, digits = 7) {
  const [a, b] = [low, high].map(x => si ? x : column.scale * x), words = (x, n) => si ? asInFile(x, n - 1) : shortNumber(x, n);
  if (!(a < b)) return words(a, si ? FILE_DIGITS : digits);
  const known = placeOf(Math.max(-a, b)) + 1 - Math.ceil(Math.log10(b - a));
  if (a * b > 0 && known >= 3) return `≈ ${words((a + b) / 2, Math.min(known, digits))}`;
  return `${words(outwards(a, -1), 4)} … ${words(outwards(b, 1), 4)}`;
}

// A reading with three decimals, or as many as are known: a displacement in thousandths of its unit.
function decimalWords({low, high}, scale) {
  const [a, b] = [scale * low, scale * high], known = b > a ? Math.min(Math.floor(-Math.log10(b - a)), 3) : 3;
  return Number.isNaN(a) ? UNKNOWN : known < 1 ? [outwards(a, -1), outwards(b, 1)].map(x => numberText(x, {decimals: 1})).join(" … ")
    : (b > a ? "≈ " : "") + numberText((a + b) / 2, {decimals: known});
}

// The normal force of a contact at a time.
function forceWords(run, c, at) {
  const found = run.reading("N_" + c, at);
  return found.exact ? forceText(found.low) : `${readingWords(found, run.column("N_" + c), false, 4)} kN`;
}

// The power of ten of a number's first digit.
function placeOf(x) { return Math.floor(Math.log10(Math.abs(x))); }

// A number with four digits that is at most (-1) or at least (1) as large.
function outwards(x, way) {
  const short = Number(x.toPrecision(4));
  return way * (short - x) >= 0 ? short : Number((short + way * 10 ** (placeOf(x) - 3)).toPrecision(4));
}
