// Vertical scales, round numbers and the axes of a chart.

const MARGIN = {left: 62, right: 12, top: 8, bottom: 22, words: 14};

// A vertical scale: value to pixel and back. A logarithmic one shows magnitudes.
function verticalScale(low, high, log, {top, bottom}) {
  const there = log ? v => Math.log10(Math.abs(v)) : v => v, back = log ? v => 10 ** v : v => v;
  const start = there(low), px = (bottom - top) / (there(high) - start);
  return {low, high, log, y: v => bottom - px * (there(v) - start), value: y => back(start + (bottom - y) / px)};
}

// The limits of a linear axis; a constant gets room, so that rounding is not magnified.
function extent(low, high) {
  if (!(high >= low) || !Number.isFinite(high - low)) return [0, 1];
  const middle = (low + high) / 2;
  if (high - low < 1e-9 * Math.abs(middle) || high === low) {
    const half = Math.max(0.05 * Math.abs(middle), Math.abs(middle) > 0 ? 0 : 1);
    return [middle - half, middle + half];
  }
  return [low - 0.05 * (high - low), high + 0.05 * (high - low)];
}

// The limits of a logarithmic axis: at most ten decades below the largest magnitude.
function logExtent(least, most) {
  if (!(most > 0) || !Number.isFinite(most)) return [0.1, 1];
  const low = Math.max(least > 0 ? least : 0, most * 1e-10);
  return low > 0.5 * most ? [0.5 * low, 2 * most] : [low / 1.3, most * 1.3];
}

// Round numbers between two limits, about `count` of them and at least two, and the decimals that they need.
function ticks(low, high, count) {
  const raw = (high - low) / count;
  let power = 10 ** Math.floor(Math.log10(raw)), k = [1, 2, 5, 10].findIndex(one => one * power >= raw * (1 - 1e-9));
  for (let tries = 0; ; tries++) {
    const step = [1, 2, 5, 10][k] * power, found = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step && found.length < 1000; i++)
      found.push(i * step);
    if (found.length >= 2 || tries > 3) return [found, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), step];
    if (--k < 0) [k, power] = [2, power / 10];
  }
}

// Decades, with steps between them if there are fewer than two decades.
function logTicks(low, high) {
  const found = [], first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high));
  const every = Math.ceil((last - first) / 6), factors = last - first < 3 ? [1, 2, 5] : [1];
  for (let e = first; e <= last; e += every) for (const k of factors) found.push(k * 10 ** e);
  return found.filter(v => v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9));
}

// A number at a tick, with the digits that its neighbours differ by.
function tickWords(v, digits, step) {
  const most = Math.abs(v), figures = Math.min(Math.max(Math.ceil(Math.log10(most / step) - 1e-9) + 1, 1), 12);
  if (most < 0.01 * step) return "0";
  return digits <= 5 && most < 1e6 ? numberText(v, {decimals: digits}) : shortNumber(v, figures);
}

function line(g, ...ends) { strokes(g, ends.map(v => Math.round(v) + 0.5)); }

// The factor and the unit in which the numbers of a scale are short: a drift of 1e-8 J is 10 nJ.
function shortUnit(unit, {low, high}) {
  const largest = Math.max(Math.abs(low), Math.abs(high));
  return unit !== "J" || largest >= 1e-3 ? [1, unit] : largest >= 1e-6 ? [1e6, "µJ"] : [1e9, "nJ"];
}

// What all of some lists begin with.
function commonStart(lists) {
  const [first = []] = lists;
  let count = 0;
  while (count < first.length && lists.every(list => list[count] === first[count])) count++;
  return first.slice(0, count);
}

// The words that all of some begin with, up to a comma: of "normal force, left tread" and "normal force, right tread" the force. Where
// they begin otherwise, the last words in front of the commas: of "kinetic energy, roll" and "elastic energy, left wheel" the energy.
function commonWords(all) {
  const parts = all.map(words => words.split(", ")), start = commonStart(parts).join(", ");
  return start || commonStart(parts.map(([what]) => what.split(" ").reverse())).reverse().join(" ");
}

// Words and unit at an axis; the unit alone where there is no room for both.
function axisWords(g, words, unit, room) {
  const both = [words, unit && `[${unit}]`].filter(Boolean).join(" ");
  return g.measureText(both).width < room ? both : unit;
}

// Draw both axes of a chart. `box` is where it draws; the last number of the horizontal axis carries the unit. words: of what the
// vertical axis has, and across of the horizontal one, if it is not time.
function drawAxes(g, colour, box, scale, unit, [low, high], x, horizontalUnit, words, across) {
  const {left, right, top, bottom} = box;
  g.lineWidth = 1;
  g.textBaseline = "middle";
  g.textAlign = "right";
  g.strokeStyle = colour.of("faint");
  g.fillStyle = colour.of("muted");
  const [factor, shown] = scale.log ? [1, unit] : shortUnit(unit, scale);
  const [values, digits, step] = scale.log ? [logTicks(scale.low, scale.high)]
    : ticks(factor * scale.low, factor * scale.high, Math.max((bottom - top) / 34, 3));
  for (const v of values) {
    const y = scale.y(v / factor), text = scale.log ? shortNumber(v, 2) : tickWords(v, digits, step);
    line(g, left, y, right, y);
    g.fillText(text, left - 6, Math.min(Math.max(y, top + 2), bottom - 2));
  }
  const [times, timeDigits, timeStep] = ticks(low, high, Math.max((right - left) / 95, 3)), end = right + box.spare;
  g.textAlign = "center";
  let taken = end;
  for (const t of times.reverse()) {
    line(g, x(t), top, x(t), bottom);
    // Times keep their decimals down to nanoseconds.
    const number = timeDigits > 5 && timeDigits <= 10 ? numberText(t, {decimals: timeDigits}) : tickWords(t, timeDigits, timeStep);
    const text = taken === end && horizontalUnit ? `${number} ${horizontalUnit}` : number;
    const half = g.measureText(text).width / 2, centre = Math.min(x(t), end - half);
    if (centre + half > taken) continue;
    g.fillText(text, centre, bottom + 11);
    taken = centre - half - 8;
  }
  // The words stand around the middle of the axis and may go up to the ends of the chart.
  const middle = (top + bottom) / 2, room = 2 * Math.min(middle, bottom + MARGIN.bottom - middle);
  g.save();
  g.translate(8, middle);
  g.rotate(-Math.PI / 2);
  g.fillText(scale.log ? `|${unit || "1"}|, logarithmic` : axisWords(g, words, shown, room), 0, 0);
  g.restore();
  if (across) g.fillText(axisWords(g, across, horizontalUnit, right - left), (left + right) / 2, bottom + 11 + MARGIN.words);
  g.strokeStyle = colour.of("muted");
  line(g, left, bottom, right, bottom);
}
