// The page of a collation: matrix, switches of the codes, charts of one simulation, its numbers.

const DASHES = [[], [6, 3], [2, 2]], WIDTHS = [1.6, 1.9, 2.1];
const COLOURS = 6;
const FAR = 3;              // ranges of the median code, beyond which a curve leaves its chart
const LEFT = 58, RIGHT = 8, TOP = 8, BOTTOM = 24;       // margins of a chart
const state = {task: 0, front: -1, shown: [], number: "main", as: "value"};
let facts, medians;
const charts = [];

function element(name, words, parent, look) {
  const made = document.createElement(name);
  if (words !== undefined) made.textContent = words;
  if (look) made.className = look;
  if (parent) parent.append(made);
  return made;
}

const byId = id => document.getElementById(id);

// The row of heads and the body of a table that is drawn anew.
function emptied(id) {
  byId(id).replaceChildren();
  return [element("tr", undefined, element("thead", undefined, byId(id))), element("tbody", undefined, byId(id))];
}

// A number as Quantity.text shows it.
function text(name, x) {
  const {digits, scale} = facts.numbers[name], shown = x === null || x === undefined ? NaN : scale * x;
  return digits < 0 && !Number.isNaN(shown) ? scientific(shown) : numberText(shown, {decimals: digits});
}

const unit = name => facts.numbers[name].unit ? ` [${facts.numbers[name].unit}]` : "";

// A relative difference as signed_percent of collation_matrix.py shows it.
function percent(x) {
  return Math.abs(x) >= 10 ? `× ${numberText(1 + x, {digits: 3})}` : percentText(x, {sign: true});
}

function median(values) {
  const known = values.filter(x => x !== null && x !== undefined).sort((a, b) => a - b), half = known.length >> 1;
  return !known.length ? null : known.length % 2 ? known[half] : (known[half - 1] + known[half]) / 2;
}

function fromMedian(name, x, task) {
  const middle = medians[task][name];
  if (x === null || x === undefined || middle === null || name === "energy_error") return "";
  if (name === "rebound") return numberText(x - middle, {decimals: 4, sign: true});
  if (name === "processor_time") return middle ? `× ${numberText(x / middle)}` : "";
  return middle ? percent((x - middle) / Math.abs(middle)) : "";
}

function curveOf(k, name) {
  const entry = facts.codes[k].entries[state.task];
  if (!entry || !entry.curves[name]) return null;
  entry.open ??= {};
  const [t, x] = entry.curves[name];
  return entry.open[name] ??= {t, x: x.map(v => v ?? NaN), until: entry.until ?? Infinity, opening: entry.opening[name] ?? 0};
}

function swatch(k) {
  const made = document.createElement("span");
  made.innerHTML = `<svg class="swatch" viewBox="0 0 28 8" aria-hidden="true"><path d="M0 4H28" class="code${k % COLOURS}" stroke-dasharray="${dashesOf(k).join(" ")}"/></svg>`;
  return made.firstChild;
}

const dashesOf = k => DASHES[Math.floor(k / COLOURS) % DASHES.length];

// ---- matrix --------------------------------------------------------------------------
const numberOf = task => state.number === "main" ? task.main : state.number;

function drawMatrix() {
  const [head, body] = emptied("matrix");
  element("th", "code", head);
  for (const task of facts.tasks) {
    const cell = element("th", task.name, head);
    cell.title = task.words;
    element("small", facts.numbers[numberOf(task)].short + unit(numberOf(task)), cell);
  }
  facts.codes.forEach((code, k) => {
    const row = element("tr", undefined, body);
    const name = element("th", undefined, row);
    name.append(swatch(k), ` ${code.name}`);
    name.title = code.name;
    code.entries.forEach((entry, j) => row.append(matrixCell(entry, k, j)));
  });
}

function matrixCell(entry, k, j) {
  const cell = element("td", undefined, null, entry ? entry.shade : "");
  if (j === state.task && k === state.front) cell.classList.add("chosen");
  const name = numberOf(facts.tasks[j]);
  const words = !entry ? "–" : entry.error ? "cannot be used" : text(name, entry.numbers[name]);
  const button = element("button", undefined, cell);
  button.type = "button";
  const apart = entry && !entry.error ? fromMedian(name, entry.numbers[name], j) : "";
  button.append(state.as === "median" && apart ? apart : words);
  if (entry && !entry.error) {
    const v = entry.verdict;
    element("small", `${v.passed} / ${v.doubtful} / ${v.failed}`, button);
    button.title = `${facts.codes[k].name}, ${facts.tasks[j].words}: ${v.passed} checks passed, ${v.doubtful} doubtful, ${v.failed} failed`
      + (entry.reasons[name] ? `; no ${facts.numbers[name].short}: ${entry.reasons[name]}` : apart ? `; from the median: ${apart}` : "");
  } else {
    button.title = entry ? entry.error : "not submitted";
  }
  button.addEventListener("click", () => {
    state.front = state.front === k && state.task === j ? -1 : k;
    if (state.front === k) state.shown[k] = true;
    choose(j);
  });
  return cell;
}

// ---- codes ---------------------------------------------------------------------------
function drawCodes() {
  byId("codes").replaceChildren();
  facts.codes.forEach((code, k) => {
    const label = element("label", undefined, byId("codes"), k === state.front ? "front" : "");
    const box = element("input", undefined, label);
    box.type = "checkbox";
    box.checked = state.shown[k];
    box.addEventListener("change", () => {
      state.shown[k] = box.checked;
      drawCharts();
    });
    label.append(swatch(k));
    element("span", code.name, label);
  });
}

// ---- charts --------------------------------------------------------------------------
class Chart {
  constructor(known) {
    this.known = known;
    [this.scale, this.unit] = known.impact ? [1e3, "ms"] : [1, "s"];
    this.window = null;
    const card = element("section", undefined, byId("charts"), known.impact ? "card impact" : "card");
    element("h2", `${known.words} [${known.unit}]`, card);
    const place = element("div", undefined, card, "chart");
    this.canvas = element("canvas", undefined, place);
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${known.words} of all codes`);
    this.told = element("p", "", card, "told muted");
    this.canvas.addEventListener("pointerdown", event => {
      if (event.pointerType !== "touch") this.from = this.timeAt(event.offsetX);
    });
    this.canvas.addEventListener("pointermove", event => this.hover(event.offsetX, event.offsetY));
    this.canvas.addEventListener("pointerup", event => this.zoom(event.offsetX));
    this.canvas.addEventListener("pointerleave", () => this.clear());
    this.canvas.addEventListener("dblclick", () => this.show(null));
  }

  show(window) {
    this.window = window;
    this.draw();
  }

  rest() {
    const parts = this.known.impact ? ["time since the contact closed in each code"] : [];
    if (!matchMedia("(pointer: coarse)").matches) parts.push("drag to zoom, double click for all");
    return parts.join("; ");
  }

  clear() {
    this.from = this.at = undefined;
    this.told.textContent = this.rest();
    this.draw();
  }

  timeAt(x) {
    const [start, end] = this.limits, width = this.canvas.clientWidth - LEFT - RIGHT;
    return start + (end - start) * Math.min(1, Math.max(0, (x - LEFT) / width));
  }

  zoom(x) {
    const to = this.timeAt(x), from = this.from;
    this.from = undefined;
    const [start, end] = this.limits;
    if (from !== undefined && Math.abs(to - from) > 0.01 * (end - start)) this.show([Math.min(from, to), Math.max(from, to)]);
  }

  // The limits of time and values of what is shown; curves far beyond the median code hide no others.
  fit() {
    this.drawn = facts.codes.map((_, k) => state.shown[k] ? curveOf(k, this.known.name) : null);
    const curves = this.drawn.filter(curve => curve && curve.t.length > 1);
    let [start, end] = within(curves.map(({t}) => [t[0], t[t.length - 1]]));
    if (this.known.impact) {
      const last = Math.max(...curves.map(({opening}) => opening));
      if (last > 0) end = Math.min(end, 1.25 * last);
    }
    if (this.window) [start, end] = this.window;
    let [low, high] = within(curves.map(curve => rangeOf(curve, start, this.window ? end : Math.min(end, curve.until))).filter(range => range[1] >= range[0]));
    if (this.known.impact) low = Math.min(0, low);
    const spare = 0.04 * (high - low) || 1e-9;
    this.limits = [start, end];
    this.range = [low - (this.known.impact ? 0 : spare), high + spare];
    return end > start && high >= low;
  }

  draw() {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight, ratio = window.devicePixelRatio || 1;
    if (!width) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const pen = this.canvas.getContext("2d"), looks = getComputedStyle(document.documentElement);
    pen.scale(ratio, ratio);
    pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
    const colour = name => looks.getPropertyValue(name).trim();
    this.any = this.fit();
    pen.fillStyle = colour("--muted");
    if (!this.any) {
      pen.fillText("no code that is shown has it", LEFT, height / 2);
      return;
    }
    const [start, end] = this.limits, [low, high] = this.range;
    this.x = t => LEFT + (t - start) / (end - start) * (width - LEFT - RIGHT);
    this.y = v => height - BOTTOM - (v - low) / (high - low) * (height - TOP - BOTTOM);
    this.grid(pen, colour, width, height);
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, TOP, width - LEFT - RIGHT, height - TOP - BOTTOM);
    pen.clip();
    for (const k of [...this.drawn.keys()].filter(k => k !== state.front).concat(state.front)) if (this.drawn[k]) this.line(pen, colour, k);
    if (this.at) {
      pen.fillStyle = colour(`--code${this.at.code % COLOURS}`);
      pen.beginPath();
      pen.arc(this.x(this.at.t), this.y(this.at.v), 4.5, 0, 7);
      pen.fill();
    }
    pen.restore();
  }

  line(pen, colour, k) {
    const {t, x} = this.drawn[k], group = Math.floor(k / COLOURS) % DASHES.length;
    pen.strokeStyle = colour(`--code${k % COLOURS}`);
    pen.globalAlpha = state.front >= 0 && k !== state.front ? 0.45 : 1;
    pen.lineWidth = WIDTHS[group] + (k === state.front || this.at && this.at.code === k ? 1.2 : 0);
    pen.setLineDash(dashesOf(k));
    pen.beginPath();
    t.forEach((time, i) => {
      if (Number.isNaN(x[i])) return;
      if (i && !Number.isNaN(x[i - 1])) pen.lineTo(this.x(time), this.y(x[i]));
      else pen.moveTo(this.x(time), this.y(x[i]));
    });
    pen.stroke();
    pen.globalAlpha = 1;
    pen.setLineDash([]);
  }

  grid(pen, colour, width, height) {
    const across = ticks(this.limits[0] * this.scale, this.limits[1] * this.scale, width / 90);
    const up = ticks(this.range[0] * this.known.scale, this.range[1] * this.known.scale, height / 45);
    pen.fillStyle = colour("--faint");
    for (const {value} of across) pen.fillRect(this.x(value / this.scale) - 0.5, TOP, 1, height - TOP - BOTTOM);
    for (const {value} of up) pen.fillRect(LEFT, this.y(value / this.known.scale) - 0.5, width - LEFT - RIGHT, 1);
    pen.fillStyle = colour("--muted");
    pen.textAlign = "center";
    for (const {value, words} of across) pen.fillText(words, Math.min(this.x(value / this.scale), width - 16), height - 9);
    pen.textAlign = "right";
    for (const {value, words} of up) pen.fillText(words, LEFT - 6, this.y(value / this.known.scale) + 4);
    pen.textAlign = "left";
    pen.fillText(this.unit, 4, height - 9);
  }

  // The nearest curve is told.
  hover(px, py) {
    if (!this.any || !this.x) return;
    const t = this.timeAt(px);
    let best = null, least = 40;
    this.drawn.forEach((curve, k) => {
      if (!curve || t < curve.t[0] || t > curve.t[curve.t.length - 1]) return;
      const v = valueAt(curve, t), far = Math.abs(this.y(v) - py);
      if (far < least) [best, least] = [{code: k, t, v}, far];
    });
    this.at = best;
    this.told.textContent = best
      ? `${facts.codes[best.code].name}: ${numberText(best.v * this.known.scale, {digits: 5})} ${this.known.unit} at ${numberText(t * this.scale, {digits: 5})} ${this.unit}`
      : this.rest();
    this.draw();
  }
}

// The smallest and the largest value of a curve in a window of time.
function rangeOf({t, x}, start, end) {
  const near = [...x].filter((v, i) => t[Math.min(i + 1, t.length - 1)] >= start && t[i] <= end && !Number.isNaN(v));
  return [Math.min(...near), Math.max(...near)];
}

// One range that holds all, but for what goes beyond FAR times the range of the median.
function within(ranges) {
  if (!ranges.length) return [0, -1];
  const lows = ranges.map(range => range[0]), highs = ranges.map(range => range[1]);
  const middle = median(ranges.map(([low, high]) => high - low)), far = middle > 0 ? FAR * middle : Infinity;
  return [Math.max(Math.min(...lows), median(lows) - far), Math.min(Math.max(...highs), median(highs) + far)];
}

function valueAt({t, x}, at) {
  const b = Math.max(1, t.findIndex(time => time >= at)), a = b - 1;
  return t[b] > t[a] ? x[a] + (x[b] - x[a]) * (at - t[a]) / (t[b] - t[a]) : x[a];
}

function ticks(low, high, count) {
  const rough = (high - low) / Math.max(2, count), power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find(k => k * power >= rough);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push({value: k * step, words: numberText(k * step, {decimals: digits})});
  return found;
}

const drawCharts = () => charts.forEach(chart => chart.clear());

// ---- numbers -------------------------------------------------------------------------
function drawNumbers() {
  const task = facts.tasks[state.task], [head, body] = emptied("numbers");
  const names = task.numbers.filter(name => medians[state.task][name] !== null);
  byId("numbers-title").textContent = `Numbers of ${task.words}, each with its distance from the median`;
  for (const words of ["", ...names.map(name => facts.numbers[name].short + unit(name)), "passed / doubtful / failed"]) element("th", words, head);
  names.forEach((name, k) => { head.children[k + 1].title = facts.numbers[name].words; });
  const middle = element("tr", undefined, body, "middle");
  element("th", "median", middle);
  for (const name of names) element("td", text(name, medians[state.task][name]), middle);
  element("td", "", middle);
  facts.codes.forEach((code, k) => {
    const entry = code.entries[state.task];
    if (!entry) return;
    const row = element("tr", undefined, body);
    element("th", undefined, row).append(swatch(k), ` ${code.name}`);
    for (const name of names) {
      const cell = element("td", text(name, entry.numbers[name]), row);
      if (entry.reasons[name]) cell.title = entry.reasons[name];
      const apart = fromMedian(name, entry.numbers[name], state.task);
      if (apart) element("small", apart, cell);
    }
    const v = entry.verdict;
    element("td", entry.error ? "cannot be used" : `${v.passed} / ${v.doubtful} / ${v.failed}`, row, entry.shade);
  });
}

function fillRows(id, rows) {
  const table = document.querySelector(`#${id} table`);
  table.replaceChildren();
  for (const cells of rows) {
    const row = element("tr", undefined, table);
    cells.forEach((words, k) => element(k ? "td" : "th", words, row));
  }
}

// ---- the page ------------------------------------------------------------------------
function choose(task) {
  state.task = (task + facts.tasks.length) % facts.tasks.length;
  byId("task").value = state.task;
  for (const chart of charts) chart.window = null;
  drawMatrix();
  drawCodes();
  drawNumbers();
  fillRows("findings", facts.codes.flatMap(({name, entries: {[state.task]: entry}}) =>
    (entry ? entry.error ? [entry.error] : entry.findings : []).map(line => [name, line])));
  drawCharts();
}

function setTheme(choice) {
  const dark = choice === "dark" || (choice === "auto" && matchMedia("(prefers-color-scheme: dark)").matches);
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  byId("theme").textContent = `theme: ${choice}`;
  state.theme = choice;
  drawCharts();
}

async function begin() {
  facts = JSON.parse(new TextDecoder().decode(await inflate(byId("facts").textContent)));
  medians = facts.tasks.map((task, j) => Object.fromEntries(task.numbers.map(
    name => [name, median(facts.codes.map(code => code.entries[j] && code.entries[j].numbers[name]))])));
  state.shown = facts.codes.map(() => true);
  byId("title").textContent = facts.title;
  const used = facts.codes.flatMap(code => code.entries).filter(entry => entry && !entry.error).length;
  byId("subtitle").textContent = `LD benchmark: ${facts.codes.length} codes, ${used} files; ldbench ${facts.version}`;
  element("option", "peak, or force at derailment", byId("number")).value = "main";
  for (const name in facts.numbers) element("option", facts.numbers[name].short, byId("number")).value = name;
  facts.tasks.forEach((task, j) => { element("option", task.words, byId("task")).value = j; });
  for (const known of facts.charts) charts.push(new Chart(known));
  fillRows("facts-of-codes", [["folder", ...Object.values(facts.keys)],
    ...facts.codes.map(code => [code.name, ...Object.keys(facts.keys).map(key => code.facts[key] ?? "–")])]);
  document.querySelector("#lines summary").textContent = `What could not be used: ${facts.lines.length || "nothing"}`;
  for (const line of facts.lines) element("li", line, document.querySelector("#lines ul"));
  for (const id of ["number", "as"]) byId(id).addEventListener("change", () => {
    state[id] = byId(id).value;
    drawMatrix();
  });
  byId("task").addEventListener("change", () => choose(Number(byId("task").value)));
  byId("previous").addEventListener("click", () => choose(state.task - 1));
  byId("next").addEventListener("click", () => choose(state.task + 1));
  for (const [id, value] of [["all", true], ["none", false]]) byId(id).addEventListener("click", () => {
    state.shown.fill(value);
    drawCodes();
    drawCharts();
  });
  const themes = ["auto", "light", "dark"];
  byId("theme").addEventListener("click", () => setTheme(themes[(themes.indexOf(state.theme) + 1) % 3]));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => setTheme(state.theme));
  new ResizeObserver(drawCharts).observe(byId("charts"));
  const first = facts.tasks.findIndex((_, j) => facts.codes.some(code => code.entries[j] && !code.entries[j].error));
  setTheme("auto");
  choose(Math.max(0, first));
  document.documentElement.dataset.ready = "yes";
}

begin();
