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

// Read exact numbers. `method` says how each is predicted: as a multiple of another column, or from the last numbers.
function readExact(reader, n, method, t, other) {
  const exponents = new Int8Array(reader.take(n).slice().buffer);
  const differences = reader.planes(n, 4);
  const x = new Float64Array(n);
  for (let i = 0; i < n; i++) {
    const e = exponents[i];
    if (e >= ZERO) {
      x[i] = e === EMPTY ? NaN : 0;
      continue;
    }
    const guess = other ? method.ratio * other[i] : predict(method.order, x, t, i);
    const power = POWERS[Math.abs(e)];
    let units = Math.floor((e < 0 ? guess * power : guess / power) + 0.5);
    if (!(Math.abs(units) <= 1e9)) units = 0;
    const m = units + signed(differences[i]);
    x[i] = Math.abs(e) > 22 ? Number(m + "e" + e) : e < 0 ? m / power : m * power;
  }
  return x;
}

function predict(order, x, t, i) {
  if (order === 0 || i < order) return 0;
  const x1 = x[i - 1];
  if (order === 1) return x1;
  const t0 = t ? t[i] : i, t1 = t ? t[i - 1] : i - 1, t2 = t ? t[i - 2] : i - 2;
  const x2 = x[i - 2], d1 = (x1 - x2) / (t1 - t2), line = x1 + d1 * (t0 - t1);
  if (order === 2) return line;
  const t3 = t ? t[i - 3] : i - 3, d2 = (x2 - x[i - 3]) / (t2 - t3);
  return line + (d1 - d2) / (t1 - t3) * (t0 - t1) * (t0 - t2);
}

// Turn levels into values; level 0 stands for no value.
function fromLevels(a, low, step) {
  return Float64Array.from(a, q => q > 0 ? low + step * (q - 1) : NaN);
}

// Decode everything that is kept of a run: {t, exact: {name: values}, rowTime(i), tracks, bands, bin}.
async function readRun(index, base64) {
  const reader = new Reader(await inflate(base64));
  const n = index.kept, exact = {};
  let t = null;
  for (const method of index.exact) {
    const x = readExact(reader, n, method, t, method.of === undefined ? null : exact[method.of]);
    if (t) exact[method.name] = x;
    else t = x;
  }
  const run = {t, exact, tracks: {}, bands: {}, rows: index.rows, bin: index.bin ?? 1};
  if (index.bands.length) {
    const rowTimes = new Float64Array(index.rows);
    if (index.even) {
      for (let i = 0; i < index.rows; i++)
        rowTimes[i] = index.start + (index.end - index.start) * i / (index.rows - 1);
    } else rowTimes.set(readExact(reader, index.rows, {order: 1}, null, null));
    run.rowTimes = rowTimes;
    const bins = Math.ceil(index.rows / index.bin);
    for (const {name, low, step, order} of index.bands) {
      if (order) {
        const a = reader.sums(index.rows, 3);
        if (order === 2) for (let i = 1; i < a.length; i++) a[i] += a[i - 1];
        run.tracks[name] = fromLevels(a, low, step);
      } else {
        const a = reader.sums(bins, 2), b = reader.planes(bins, 2).map((d, i) => a[i] + d);
        run.bands[name] = {low: fromLevels(a, low, step), high: fromLevels(b, low, step)};
      }
    }
  }
  return run;
}
