// The page: what is shown, the time that everything shares, and what keys, buttons and the address do to it.

const SPEEDS = [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1];
const EXAGGERATIONS = [1, 2, 5, 10, 20, 50];
const REFRESH = 80;             // time between updates of the numbers while the page plays [ms]

class Page {
  constructor(facts) {
    this.facts = facts;
    this.shapes = facts.shapes.map(unflattened);
    this.loaded = new Map();
    this.shown = facts.runs.map(run => run.shown);
    this.runs = [];
    this.events = [];
    this.colour = new Colours();
    this.t = 0;
    this.window = [0, 1];
    this.playing = false;
    this.charts = [];
    this.values = new Values();
    this.scene = new Scene(get("scene"), this.colour);
  }

  async open() {
    get("title").textContent = this.facts.title;
    document.title = this.facts.title;
    this.fillControls();
    this.shown = this.named();
    this.drawSummary();
    await this.showRuns();
    this.followAddress();
    this.say();
    performance.mark("ready");
    document.documentElement.dataset.ready = "yes";
  }

  // Runs ------------------------------------------------------------------------------------

  async load(k) {
    if (!this.loaded.has(k)) {
      const facts = this.facts.runs[k], holder = get("run" + k);
      const run = new Run(facts, k, await readRun(facts.index, holder.textContent));
      holder.remove();
      const rest = run.shape === null ? {axle: 0, roll: 0} : this.shapes[run.shape];
      Object.assign(run, {axle: rest.axle, axleRoll: rest.roll});
      run.largest = Math.max(...run.events.map(event => event.peak ?? 0), 0);
      this.loaded.set(k, run);
    }
    return this.loaded.get(k);
  }

  async showRuns() {
    const wanted = this.shown.map((shown, k) => shown ? k : -1).filter(k => k >= 0);
    for (const k of wanted) await this.load(k);
    this.runs = wanted.map(k => this.loaded.get(k));
    this.events = this.runs.flatMap((run, k) => run.events.map(event => ({...event, run})))
      .sort((a, b) => a.t - b.t);
    this.start = Math.min(...this.runs.map(run => run.start));
    this.end = Math.max(...this.runs.map(run => run.end));
    this.window = [this.start, this.end];
    if (!this.speedChosen) {
      const wish = (this.end - this.start) / 20;
      get("speed").value = SPEEDS.findLast(speed => speed <= wish * 1.5) ?? SPEEDS[0];
    }
    if (!this.charts.length) defaultCharts(this.runs).forEach(([names, mode]) => this.addChart(names, mode));
    get("scrub").min = this.start;
    get("scrub").max = this.end;
    get("subtitle").textContent = this.runs.map(run => run.title).filter(Boolean).join(" · ");
    this.drawRunList();
    this.drawEventList();
    this.drawAbout();
    this.values.draw(this.runs, this.columns(), this.facts.groups);
    this.charts.forEach(chart => chart.drawHead());
    this.resize();
    this.go(Math.min(Math.max(this.t, this.start), this.end));
  }

  drawRunList() {
    const nav = get("runs");
    nav.hidden = this.facts.runs.length < 2;
    nav.replaceChildren(...this.facts.runs.map((run, k) => {
      const box = make("input", {type: "checkbox", checked: this.shown[k]});
      box.onchange = () => {
        this.shown[k] = box.checked;
        if (!this.shown.includes(true)) this.shown[k] = true;
        this.showRuns().then(() => this.write());
      };
      const model = run.model && this.differ("model") ? `, ${run.model}` : "";
      const text = make("span", {title: run.file}, run.name + model);
      return make("label", {}, box, this.swatch(this.colour.series(k), this.colour.dashes[k % 8]), text);
    }));
  }

  differ(fact) { return new Set(this.facts.runs.map(run => run[fact])).size > 1; }

  swatch(colour, dash) {
    const swatch = make("span", {class: "swatch", "aria-hidden": "true"});
    swatch.style.borderTopColor = colour;
    swatch.style.borderTopStyle = !dash.length ? "solid" : dash[0] > 2 ? "dashed" : "dotted";
    return swatch;
  }

  drawAbout() {
    get("about").replaceChildren(...this.runs.map(run => make("dl", {},
      make("dt", {}, run.heading),
      ...[run.file, run.title, run.model && `normal contact: ${run.model}`, ...run.profiles,
          run.rows > run.t.length && `${run.rows} rows, ${run.t.length} of them kept to the last digit; of the others `
            + "displacements and normal forces, and of every column the least and largest value",
          run.ending && `ended: ${run.ending}`, ...run.notes].filter(Boolean).map(text => make("dd", {}, text)))));
  }

  drawSummary() {
    const {summary} = this.facts;
    get("summary").hidden = !summary.length;
    if (!summary.length) return;
    const cell = ({text, run, t, with: others}) => make("td", {}, t === null ? text
      : make("a", {href: this.link(t, [run, ...others]), onclick: () => get("runs").scrollIntoView()}, text));
    const head = make("tr", {}, make("th", {}, "runs"), ...this.facts.runs.slice(0, summary[0].cells.length).map(run =>
      make("th", {}, make("a", {href: this.link(0, [run.name])}, run.name))));
    const body = summary.map(row => make("tr", {}, make("th", {scope: "row"}, row.words), ...row.cells.map(cell)));
    get("summary").replaceChildren(make("details", {open: true},
      make("summary", {}, "Summary; a number opens its moment"),
      make("table", {}, make("thead", {}, head), make("tbody", {}, ...body))));
  }

  // Table of values ---------------------------------------------------------------------------

  // Each name once, over all runs that are shown.
  columns() {
    const found = new Map();
    for (const column of this.runs.flatMap(run => run.columns))
      if (!found.has(column.name)) found.set(column.name, column);
    return [...found.values()];
  }

  fillNumbers() {
    this.values.fill(this.t);
    for (const chart of this.charts) chart.fillLegend();
    this.fillPose();
  }

  fillPose() {
    get("pose").textContent = this.runs.map(run => {
      const {y, z, roll} = run.pose(this.t), what = this.runs.length > 1 ? `${run.name}: ` : "";
      const have = [["Y", y, "Y", "mm"], ["Z", z, "Z", "mm"], ["roll", roll, "Φ", "mrad"]]
        .filter(([name]) => run.has(name))
        .map(([, x, words, unit]) => `${words} ${(1e3 * x).toFixed(3)} ${unit}`);
      return what + (have.join(", ") || "no displacements in the file");
    }).join("; ").replaceAll("-", "−");
  }

  // Charts ------------------------------------------------------------------------------------

  addChart(names, mode) {
    const chart = new Panel(this, names, mode);
    get("charts").append(chart.card);
    this.charts.push(chart);
    return chart;
  }

  drawCharts() { this.charts.forEach(chart => chart.draw()); }

  placeCursors() {
    const [start, end] = this.window, inside = this.t >= start && this.t <= end;
    for (const chart of this.charts) {
      chart.cursor.hidden = !inside;
      chart.cursor.style.transform = `translateX(${chart.x(this.t) - 0.75}px)`;
    }
  }

  zoomTime(factor, about = this.t) {
    const [start, end] = this.window;
    const shortest = Math.max((this.end - this.start) * 1e-7, 1e-9);
    const length = Math.min(Math.max((end - start) * factor, shortest), this.end - this.start);
    const share = (about - start) / (end - start);
    this.setWindow(about - share * length, length);
  }

  setWindow(start, length) {
    start = Math.min(Math.max(start, this.start), this.end - length);
    this.window = [start, start + length];
    this.drawCharts();
    this.placeCursors();
    this.drawOverview();
  }

  // Time --------------------------------------------------------------------------------------

  // Move to a time; everything follows. `settled`: the time stays, so the address and the reader are told.
  go(t, settled = true) {
    this.t = Math.min(Math.max(t, this.start), this.end);
    const [start, end] = this.window;
    if (this.t < start || this.t > end) this.setWindow(this.t - 0.1 * (end - start), end - start);
    this.scene.draw(this.runs, this.shapes, this.t);
    this.placeCursors();
    get("scrub").value = this.t;
    get("clock").textContent = `${timeWords(this.t)} s`;
    const now = performance.now();
    if (settled || now - (this.filled ?? 0) > REFRESH) {
      this.filled = now;
      this.fillNumbers();
    }
    if (settled) {
      this.write();
      this.say();
    }
  }

  goToRow(t) {
    const run = this.runs[0];
    this.go(run.t[run.row(t)]);
  }

  stepRow(count) {
    this.pause();
    const {t} = this.runs[0], last = t.length - 1;
    // A step from a time between two rows goes to one of them.
    const i = indexBefore(t, this.t), between = t[i] < this.t && count < 0 ? 1 : 0;
    this.go(t[Math.min(Math.max(i + count + between, 0), last)]);
  }

  stepEvent(direction) {
    this.pause();
    const aside = 1e-9 * (this.end - this.start);
    const next = direction > 0 ? this.events.find(event => event.t > this.t + aside)
      : this.events.findLast(event => event.t < this.t - aside);
    if (next) this.go(next.t);
  }

  play() {
    if (this.t >= this.end) this.go(this.start, false);
    this.playing = true;
    this.drawPlay();
    let before = performance.now();
    const frame = now => {
      if (!this.playing) return;
      const t = this.t + Math.max(now - before, 0) / 1e3 * Number(get("speed").value);
      before = now;
      if (t >= this.end) {
        this.pause();
        this.go(this.end);
      } else {
        this.go(t, false);
        requestAnimationFrame(frame);
      }
    };
    requestAnimationFrame(frame);
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.drawPlay();
    this.go(this.t);
  }

  drawPlay() {
    get("play-shape").setAttribute("d", this.playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2l10 6-10 6z");
    get("play").setAttribute("aria-label", this.playing ? "pause" : "play");
  }

  changeSpeed(step) {
    const k = SPEEDS.indexOf(Number(get("speed").value));
    get("speed").value = SPEEDS[Math.min(Math.max(k + step, 0), SPEEDS.length - 1)];
    this.speedChosen = true;
  }

  drawEventList() {
    const several = this.runs.length > 1;
    get("events").replaceChildren(make("option", {value: ""}, this.events.length ? "go to …" : "none in the file"),
      ...this.events.map((event, k) => make("option", {value: String(k)},
        `${timeWords(event.t)} s  ${several ? event.run.name + ": " : ""}${eventWords(event)}`)));
  }

  drawOverview() {
    const canvas = get("overview"), g = canvas.getContext("2d"), ratio = Math.min(window.devicePixelRatio || 1, 2);
    const {clientWidth: w, clientHeight: h} = canvas;
    canvas.width = Math.round(w * ratio);
    canvas.height = Math.round(h * ratio);
    g.scale(ratio, ratio);
    const x = t => 7 + (w - 14) * (t - this.start) / (this.end - this.start || 1);
    g.fillStyle = this.colour.of("back");
    g.fillRect(0, 4, w, h - 8);
    g.fillStyle = this.colour.of("faint");
    g.fillRect(x(this.window[0]), 4, Math.max(x(this.window[1]) - x(this.window[0]), 2), h - 8);
    const run = this.runs[0], name = run.has("Y") ? "Y" : run.columns[0]?.name;
    if (name) {
      const [t, y] = run.series(name), {points, band} = thinned({t, x: y}, w / 4);
      const found = points ? {from: points.t, low: points.x, high: points.x} : band;
      const low = Math.min(...found.low.filter(Number.isFinite)), high = Math.max(...found.high.filter(Number.isFinite));
      g.strokeStyle = this.colour.of("muted");
      g.beginPath();
      found.from.forEach((t, k) => {
        for (const v of [found.low[k], found.high[k]])
          if (Number.isFinite(v)) g.lineTo(x(t), h - 8 - (h - 16) * (v - low) / (high - low || 1));
      });
      g.stroke();
    }
    this.events.forEach(event => {
      g.fillStyle = event.peak ? this.colour.of("RT") : this.colour.of("ink");
      g.fillRect(x(event.t) - 0.75, event.peak ? 0 : h - 9, 1.5, 9);
    });
  }

  // Address and words -------------------------------------------------------------------------

  address() { return new URLSearchParams(location.hash.slice(1)); }

  link(t, names = [], view = "whole") {
    const [run, ...others] = names.map(encodeURIComponent);
    return `#t=${+t.toPrecision(9)}` + (run === undefined ? "" : `&run=${run}`)
      + others.map(name => `&with=${name}`).join("") + (view === "whole" ? "" : `&view=${view}`);
  }

  // The runs that the address names, or those that are shown at first.
  named() {
    const link = this.address(), names = [link.get("run"), ...link.getAll("with")];
    const found = this.facts.runs.map(run => names.includes(run.name));
    return found.includes(true) ? found : this.facts.runs.map(run => run.shown);
  }

  async followAddress() {
    const link = this.address(), t = Number.parseFloat(link.get("t")), wanted = this.named();
    if (wanted.some((shown, k) => shown !== this.shown[k])) {
      this.pause();
      this.shown = wanted;
      await this.showRuns();
    }
    if (Object.hasOwn(VIEWS, link.get("view"))) this.look(link.get("view"));
    if (Number.isFinite(t) && Math.abs(t - this.t) > 1e-12) {
      this.pause();
      this.go(t);
    }
  }

  // The address does not change at every step: a browser refuses too many changes.
  write() {
    clearTimeout(this.writing);
    this.writing = setTimeout(() => {
      const asAtFirst = this.facts.runs.every((run, k) => run.shown === this.shown[k]);
      const names = asAtFirst && this.shown.every(Boolean) ? [] : this.runs.map(run => run.name);
      try {
        history.replaceState(null, "", this.link(this.t, names, this.scene.view));
      } catch {
        // a frame in a notebook has no address
      }
    }, 250);
  }

  say() {
    const aside = 1e-6 * (this.end - this.start);
    const here = this.events.filter(event => Math.abs(event.t - this.t) <= aside).map(eventWords);
    const words = [`${timeWords(this.t)} s`, ...here, get("pose").textContent];
    for (const c of Object.keys(this.facts.contacts)) {
      const contact = this.runs[0].contact(c, this.t);
      if (contact) words.push(`${this.facts.contacts[c]} ${kilonewtons(contact.N)}`);
    }
    get("said").textContent = words.slice(0, 2).join(", ");
    get("scrub").setAttribute("aria-valuetext", words.slice(0, 1 + here.length).join(", "));
    get("scene").setAttribute("aria-label", `wheels on rails at ${words.join(", ")}`);
  }

  // Controls ----------------------------------------------------------------------------------

  look(view) {
    this.scene.choose(view);
    for (const button of get("views").children) button.setAttribute("aria-pressed", button.value === view);
    this.redrawScene();
  }

  redrawScene() { this.scene.draw(this.runs, this.shapes, this.t); }

  fillControls() {
    get("views").append(...Object.entries(VIEWS).map(([view, {words}]) => make("button",
      {type: "button", value: view, "aria-pressed": String(view === "whole"), onclick: () => {
        this.look(view);
        this.write();
      }}, words)));
    get("speed").append(...SPEEDS.map(speed => make("option", {value: String(speed)}, `1:${Math.round(1 / speed)}`)));
    get("speed").onchange = () => { this.speedChosen = true; };
    for (const what of ["displacement", "roll"]) {
      const select = get("exaggerate-" + what);
      select.append(...EXAGGERATIONS.map(k => make("option", {value: String(k)}, String(k))));
      select.onchange = () => {
        this.scene.settings[what] = Number(select.value);
        this.redrawScene();
      };
    }
    for (const what of ["logarithmic", "normals"]) get(what).onchange = () => {
      this.scene.settings[what] = get(what).checked;
      this.redrawScene();
    };
    const onClick = {
      "play": () => this.playing ? this.pause() : this.play(),
      "row-back": () => this.stepRow(-1), "row-on": () => this.stepRow(1),
      "event-back": () => this.stepEvent(-1), "event-on": () => this.stepEvent(1),
      "time-in": () => this.zoomTime(0.5), "time-out": () => this.zoomTime(2), "time-whole": () => this.wholeRun(),
      "scene-in": () => this.zoomScene(1.4), "scene-out": () => this.zoomScene(1 / 1.4),
      "scene-reset": () => this.look(this.scene.view),
      "add-chart": () => {
        const names = this.columns().map(column => column.name);
        const unseen = names.find(name => !this.charts.some(chart => chart.names.includes(name)));
        const chart = this.addChart([unseen ?? names[0]]);
        chart.picker.hidden = false;
        chart.redraw();
      },
      "theme": () => this.nextTheme(),
      "help": () => {
        get("keys").hidden = !get("keys").hidden;
        get("help").setAttribute("aria-expanded", !get("keys").hidden);
      },
    };
    for (const [id, act] of Object.entries(onClick)) get(id).onclick = act;
    get("digits").onchange = () => this.fillNumbers();
    get("scrub").oninput = () => {
      this.pause();
      this.goToRow(Number(get("scrub").value));
    };
    get("events").onchange = () => {
      const chosen = this.events[get("events").value];
      get("events").value = "";
      this.pause();
      if (chosen) this.go(chosen.t);
    };
    this.listenToScene();
    document.addEventListener("keydown", event => this.key(event));
    window.addEventListener("hashchange", () => this.followAddress());
    window.addEventListener("resize", () => this.resize());
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.dark.onchange = () => this.applyTheme();
    window.addEventListener("beforeprint", () => this.applyTheme("light"));
    window.addEventListener("afterprint", () => this.applyTheme());
    this.theme = "auto";
    this.applyTheme();
  }

  wholeRun() { this.setWindow(this.start, this.end - this.start); }

  zoomScene(factor, ...about) {
    this.scene.zoom(factor, ...about);
    this.redrawScene();
  }

  nextTheme() {
    this.theme = {auto: "light", light: "dark", dark: "auto"}[this.theme];
    get("theme").textContent = `theme: ${this.theme}`;
    this.applyTheme();
  }

  applyTheme(wanted = this.theme) {
    document.documentElement.dataset.theme = wanted === "auto" ? this.dark.matches ? "dark" : "light" : wanted;
    this.colour.known.clear();
    if (!this.runs.length) return;
    this.drawRunList();
    this.charts.forEach(chart => chart.drawHead());
    this.resize();
    this.fillNumbers();
  }

  resize() {
    this.scene.resize();
    this.charts.forEach(chart => chart.resize());
    if (!this.runs.length) return;
    this.drawCharts();
    this.drawOverview();
    this.placeCursors();
    this.redrawScene();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const {target} = event;
    if (target.matches("select, input:not([type=checkbox], [type=range])")) return;
    if (event.key === " " && target.matches("button, summary, a, input[type=checkbox]")) return;
    const actions = target === this.scene.canvas && SCENE_KEYS[event.key] ? SCENE_KEYS : KEYS;
    const act = actions[event.key];
    if (!act) return;
    event.preventDefault();
    act(this, event);
  }

  // Drag moves the scene, the wheel and two fingers zoom.
  listenToScene() {
    const {canvas} = this.scene;
    pointers(canvas, {
      drag: (dx, dy) => {
        this.scene.pan(dx, dy);
        this.redrawScene();
      },
      zoom: (factor, x, y) => this.zoomScene(factor, x, y),
    });
  }

}

function defaultCharts(runs) {
  const has = name => runs.some(run => run.has(name));
  const wanted = runs.length > 1
    ? [[["Y"]], [["Y"], "difference"], [["N_LF", "N_RF"]], [["roll"]], [["E_drift"]]]
    : [[["Y"]], [["N_LF", "N_RF"]], [["N_LT", "N_RT"]], [["KE_lat", "PE_elastic_L", "PE_elastic_R"]], [["E_drift"]]];
  const found = wanted.map(([names, mode]) => [names.filter(has), mode]).filter(([names]) => names.length);
  return found.length ? found : runs[0].columns.slice(0, 3).map(column => [[column.name]]);
}

function unflattened(shape) {
  const pairs = a => Array.from({length: a.length / 2}, (_, k) => [a[2 * k], a[2 * k + 1]]);
  const sides = shape.sides.map(side => Object.fromEntries(Object.entries(side).map(([name, a]) => [name, pairs(a)])));
  sides.forEach(side => side.half = Math.min(...side.wheel.map(([u]) => u)));
  return {left: sides[0], right: sides.at(-1), axle: shape.axle, roll: shape.roll};
}

const page = new Page(JSON.parse(get("facts").textContent));
globalThis.ldbench = Object.assign(page, {difference});         // reachable from the console
page.open().catch(error => {
  get("subtitle").textContent = `This page could not be shown: ${error.message}`;
  throw error;
});
