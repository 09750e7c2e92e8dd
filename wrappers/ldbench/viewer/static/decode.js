// From the bytes of a run to its columns. pack.py writes them; predictions are made here in the same order of
// operations, so that every number comes out to the last bit.

const EMPTY = 127, ZERO = 126;                  // stand for an exponent
const POWERS = Array.from({length: 129}, (_, k) => Number("1e" + k));

async function inflate(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  take(n) {
    this.at += n;
    return this.bytes.subarray(this.at - n, this.at);
  }

  // Read non-negative whole numbers whose bytes of equal weight lie together.
  planes(n, count) {
    const found = new Float64Array(n);
    for (let k = 0; k < count; k++) {
      const plane = this.take(n), weight = 2 ** (8 * k);
      for (let i = 0; i < n; i++) found[i] += weight * plane[i];
    }
    return found;
  }

  // Add differences up.
  sums(n, count) {
    const a = this.planes(n, count);
    for (let i = 0, sum = 0; i < n; i++) a[i] = sum += signed(a[i]);
    return a;
  }
}

function signed(code) {
  return code % 2 ? -(code + 1) / 2 : code / 2;
}

// Read exact numbers. Each is predicted by the parabola through the last three, over t or, without it, over their numbers.
function readExact(reader, n, t) {
  const exponents = new Int8Array(reader.take(n).slice().buffer);
  const differences = reader.planes(n, 4);
  const x = new Float64Array(n);
  for (let i = 0; i < n; i++) {
    const e = exponents[i];
    if (e >= ZERO) {
      x[i] = e === EMPTY ? NaN : 0;
      continue;
    }
    const guess = i < 3 ? 0 : predict(x, t, i), power = POWERS[Math.abs(e)];
    let units = Math.floor((e < 0 ? guess * power : guess / power) + 0.5);
    if (!(Math.abs(units) <= 1e9)) units = 0;
    const m = units + signed(differences[i]);
    x[i] = Math.abs(e) > 22 ? Number(m + "e" + e) : e < 0 ? m / power : m * power;
  }
  return x;
}

function predict(x, t, i) {
  const [t0, t1, t2, t3] = t ? [t[i], t[i - 1], t[i - 2], t[i - 3]] : [i, i - 1, i - 2, i - 3];
  const d1 = (x[i - 1] - x[i - 2]) / (t1 - t2), d2 = (x[i - 2] - x[i - 3]) / (t2 - t3);
  return x[i - 1] + d1 * (t0 - t1) + (d1 - d2) / (t1 - t3) * (t0 - t1) * (t0 - t2);
}

const HALF = 0.501;                             // of a level, and a little more for rounding

// Turn levels into values; 0 stands for no value. The lowest level is the least value itself, and no other value has it.
function fromLevels(a, low, step, level = l => l) {
  return Float64Array.from(a, q => q > 0 ? low + step * level(q - 1) : NaN);
}

// Decode everything that is kept of a run: {t, exact: {name: values}, rowTimes, tracks: {name: values of every row}, bands: {name:
// {low, high, bin}}, bin}, where `bin` is how many rows a bin has.
async function readRun(index, base64) {
  const reader = new Reader(await inflate(base64));
  const t = readExact(reader, index.kept), exact = {};
  for (const name of index.exact) exact[name] = readExact(reader, index.kept, t);
  const run = {t, exact, tracks: {}, bands: {}, rows: index.rows, bin: index.bin ?? 1};
  if (index.bands.length) {
    run.rowTimes = readExact(reader, index.rows);
    const bins = Math.ceil(index.rows / index.bin);
    for (const {name, low, step, order} of index.bands) {
      if (order) {
        const a = reader.sums(index.rows, 3);
        if (order === 2) for (let i = 1; i < a.length; i++) a[i] += a[i - 1];
        run.tracks[name] = fromLevels(a, low, step);
        run.bands[name] = {low: fromLevels(a, low, step, l => l > 1 ? l - HALF : 0),
                           high: fromLevels(a, low, step, l => l > 0 ? l + HALF : 0), bin: 1};
      } else {
        const a = reader.sums(bins, 2), b = reader.planes(bins, 2).map((d, i) => a[i] + d);
        run.bands[name] = {low: fromLevels(a, low, step), high: fromLevels(b, low, step), bin: run.bin};
      }
    }
  }
  return run;
}
