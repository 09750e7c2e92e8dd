// The page: what is shown, the time that everything shares, and what buttons do to it.

const EXAGGERATIONS = [1, 2, 5, 10, 20, 50];
const REFRESH = 80;             // time between updates of the numbers while the page plays [ms]

class Page {
  constructor(facts) {
    Object.assign(this, {facts, shapes: facts.shapes.map(unflattened), loaded: new Map(), runs: [], charts: [], window: [0, 1],
                         t: 0, mark: null, colour: new Colours(), values: new Values()});     // mark: time of the second cursor
    this.address = new Address(this);
    this.player = new Player(this);
    this.track = new Track(this);
    this.scene = new Scene(get("scene"), this.colour);
    this.fillControls();
  }

  async open() {
    this.shown = this.address.named();
    drawSummary(this);
    await this.showRuns();
    this.look("whole");
    await this.address.follow();
    this.say();
    performance.mark("ready");
    document.documentElement.dataset.ready = "yes";
  }

  // A run is read when it is first shown, once.
  load(k) {
    if (!this.loaded.has(k)) this.loaded.set(k, this.read(k));
    return this.loaded.get(k);
  }

  async read(k) {
    const facts = this.facts.runs[k], holder = get("run" + k);
    const run = new Run(facts, k, await readRun(facts.index, holder.textContent));
    holder.remove();
    const {axle, roll} = this.shapes[run.shape] ?? {axle: 0, roll: 0};
    return Object.assign(run, {axle, axleRoll: roll, largest: Math.max(...run.events.map(event => event.peak ?? 0), 0)});
  }

  // Load and show the runs that are chosen, over the whole time or over the window of before.
  async showRuns(sameWindow = false) {
    const wanted = [...this.shown.keys()].filter(k => this.shown[k]);
    const turn = this.turn = (this.turn ?? 0) + 1, runs = await Promise.all(wanted.map(k => this.load(k)));
    if (turn !== this.turn) return;             // other runs have been chosen meanwhile
    this.runs = runs;
    this.placeRuns();
    const {start, end, window: [from, to]} = this;
    this.window = sameWindow && from < end && to > start ? [Math.max(from, start), Math.min(to, end)] : this.stretch;
    this.player.suit(this.stretch[1] - this.stretch[0]);
    if (!this.charts.length) {
      defaultCharts(this.runs).forEach(([names, mode]) => this.addChart({names, mode}));
      this.firstCharts = this.charts.map(wordsOfChart).join("\n");
    }
    get("subtitle").textContent = this.runs.length < 3 ? this.runs.map(run => run.title).filter(Boolean).join("; ") : "";
    drawChoice(this);
    drawAbout(this);
    this.values.draw(this.runs, this.columns(), this.facts.groups);
    this.charts.forEach(chart => chart.drawHead());
    this.resize();
    // A moment that somebody chose stays when other runs are shown.
    this.go(this.opened === undefined || this.t === this.opened ? this.opened = this.opening() : this.t);
  }

  // The row of the first flange contact's largest force, of the first run that has one.
  opening() {
    const run = this.runs.find(one => Number.isFinite(one.opens));
    return run ? run.rowTime(run.opens + run.shift) : this.start;
  }

  // Every run at its time, aligned or not; everything that depends on it follows.
  placeRuns() {
    const {runs} = this, shifts = get("align").checked ? alignment(runs) : runs.map(() => 0);
    runs.forEach((run, k) => run.place(shifts[k]));
    this.events = gatherEvents(runs);
    this.start = Math.min(...runs.map(run => run.start));
    this.end = Math.max(...runs.map(run => run.end));
    this.stretch = commonStretch(runs);
    drawEventList(runs, this.events.listed);
    drawHardest(this);
  }

  // Each column of the files once, over all runs that are shown.
  columns() { return distinct(this.runs.flatMap(run => run.columns)); }

  // Columns of the files, and the derived ones.
  chartColumns() {
    const derived = this.runs.flatMap(run => [...run.known.values()].filter(one => one.group === DERIVED_GROUP));
    return distinct([...this.columns(), ...derived]);
  }

  column(name) { return this.runs.map(run => run.column(name)).find(Boolean); }

  // All numbers at the cursor, with the time since the mark and the frequency that belongs to it.
  fillNumbers() {
    const apart = this.mark === null ? 0 : this.t - this.mark;
    get("apart").hidden = this.mark === null;
    get("apart").textContent = `Δt ${shortNumber(1e3 * apart, 6)} ms` + (apart ? `, ${shortNumber(1 / Math.abs(apart), 5)} Hz` : "");
    this.values.fill(this.t, this.mark);
    for (const chart of this.charts) chart.fillLegend();
    this.fillPose();
  }

  fillPose() {
    const words = this.runs.map(run => {
      const at = Math.min(Math.max(this.t, run.start), run.end);
      const have = [["Y", "Y", "mm"], ["Z", "Z", "mm"], ["roll", "Φ", "mrad"]].filter(([name]) => run.has(name))
        .map(([name, words, unit]) => `${words} ${decimalWords(run.reading(name, at), 1e3)} ${unit}`);
      return (this.runs.length > 1 ? `${run.name}: ` : "") + (have.join(", ") || "no displacements in the file");
    });
    get("pose").replaceChildren(...words.map(text => make("span", {}, text)));
  }

  addChart(state) {
    const chart = new Panel(this, state);
    get("charts").append(chart.card);
    this.charts.push(chart);
    return chart;
  }

  removeChart(chart) {
    chart.card.remove();
    this.charts = this.charts.filter(other => other !== chart);
  }

  // The charts of a link, as far as their columns are known.
  replaceCharts(charts) {
    const known = charts.map(chart => ({...chart, names: chart.names.filter(name => this.column(name)),
                                        over: this.column(chart.over ?? "") ? chart.over : ""}))
      .filter(chart => chart.names.length).slice(0, 50);
    if (!known.length) return;
    [...this.charts].forEach(chart => this.removeChart(chart));
    known.forEach(chart => this.addChart(chart).drawHead());
    this.resize();
    this.fillNumbers();
  }

  placeCursors() { this.charts.forEach(chart => chart.placeCursor()); }

  zoomTime(factor, about = this.t) {
    const [start, end] = this.window;
    const shortest = Math.max((this.end - this.start) * 1e-7, 1e-9);
    const length = Math.min(Math.max((end - start) * factor, shortest), this.end - this.start);
    const share = (about - start) / (end - start);
    this.setWindow(about - share * length, length);
    this.write();
  }

  setWindow(start, length) {
    length = Math.min(length, this.end - this.start);
    start = Math.min(Math.max(start, this.start), this.end - length);
    this.window = [start, start + length];
    this.charts.forEach(chart => chart.draw());
    this.placeCursors();
    drawOverview(this);
    drawBeyond(this);
  }

  // Whether the window has these ends.
  shows(from, to) { return this.window[0] === from && this.window[1] === to; }

  // The stretch that the runs have in common; if it is shown already, all of the longest run.
  wholeRun() {
    const [from, to] = this.shows(...this.stretch) ? [this.start, this.end] : this.stretch;
    this.setWindow(from, to - from);
    this.write();
  }

  // Move to a time; everything follows. `settled`: the time stays, so the address and the reader are told.
  go(t, settled = true) {
    const before = this.t, [start, end] = this.window;
    this.t = Math.min(Math.max(t, this.start), this.end);
    if (this.t !== before && (this.t < start || this.t > end)) this.setWindow(this.t - 0.1 * (end - start), end - start);
    this.scene.draw(this.runs, this.shapes, this.t, !settled);
    drawPatches(this);
    this.placeCursors();
    get("scrub").value = this.track.share(this.t);
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
    const i = indexBefore(t, this.t), aside = t[i] < this.t && count < 0 ? 1 : 0;
    let k = Math.min(Math.max(i + count + aside, 0), last);
    while (k > 0 && count < 0 && t[k] === this.t) k--;          // rows before and after a rigid impact are at one time
    this.go(t[k]);
  }

  stepEvent(direction) {
    this.pause();
    const aside = 1e-9 * (this.end - this.start), {all} = this.events;
    const next = direction > 0 ? all.find(({t}) => t > this.t + aside) : all.findLast(({t}) => t < this.t - aside);
    if (next) this.go(next.t);
  }

  pause() { this.player.pause(); }

  // The second cursor: here, or nowhere if it is here already.
  setMark(t = this.mark === this.t ? null : this.t) {
    this.mark = t;
    get("mark").setAttribute("aria-pressed", t !== null);
    this.placeCursors();
    this.fillNumbers();
    drawOverview(this);
    this.write();
  }

  write() { this.address.write(); }

  say() {
    const aside = 1e-6 * (this.end - this.start);
    const here = this.events.all.filter(({t}) => Math.abs(t - this.t) <= aside).map(eventWords);
    const words = [`${timeWords(this.t)} s`, ...here, [...get("pose").children].map(one => one.textContent).join("; ")];
    for (const c of Object.keys(this.facts.contacts)) {
      if (this.runs[0].contact(c, this.t)) words.push(`${this.facts.contacts[c]} ${forceWords(this.runs[0], c, this.t)}`);
    }
    get("said").textContent = words.slice(0, 2).join(", ");
    get("scrub").setAttribute("aria-valuetext", words.slice(0, 1 + here.length).join(", "));
    get("scene").setAttribute("aria-label", `wheels on rails at ${words.join(", ")}`);
  }

  look(view) {
    this.scene.show(view, viewOf(view, this.shapes[this.runs[0]?.shape]));
    for (const button of get("views").children) button.setAttribute("aria-pressed", button.value === view);
    this.redrawScene();
    this.write();
  }

  // A part of the track that is not the view of a name.
  show(part) {
    this.scene.show(this.scene.view, part);
    this.scene.moved = true;
    this.redrawScene();
    this.write();
  }

  // The part of the track that holds what is drawn now.
  fitScene() {
    const {view} = this.scene, [first] = this.runs, shape = this.shapes[first.shape];
    this.show(view === "whole" || !shape ? fitAll(this.scene, this.runs, this.shapes, this.t)
      : fitContact(this.scene, first, shape, this.t, view));
  }

  pictureName() { return [...this.runs.map(run => run.name), this.scene.view, `${timeWords(this.t)}s`].join("_").slice(0, 100); }

  redrawScene() { this.scene.draw(this.runs, this.shapes, this.t); }

  // Zoom about a place on the screen; without one, nearer goes to the contact that is in view.
  zoomScene(factor, ...about) {
    const {scene} = this, [first] = this.runs, side = {left: "L", right: "R"}[scene.view];
    const point = about.length || factor < 1 || !first ? null : scene.anchor(first, this.shapes[first.shape], this.t, side);
    const [x, y] = point ? scene.px(...point) : [-1, -1];
    scene.zoom(factor, ...(x > 0 && x < scene.w && y > 0 && y < scene.h ? [x, y] : about));
    this.redrawScene();
    this.write();
  }

  panScene(dx, dy) {
    this.scene.pan(dx, dy);
    this.redrawScene();
    this.write();
  }

  fillControls() {
    const onChange = act => () => {
      if (!this.runs.length) return;
      act();
      this.write();
    };
    for (const what of ["displacement", "roll", "gap"]) {
      const select = get("exaggerate-" + what);
      select.append(...EXAGGERATIONS.map(k => make("option", {value: k}, k)));
      select.onchange = onChange(() => this.redrawScene());
    }
    for (const id of ["arrows", "normals", "follow"]) get(id).onchange = onChange(() => this.redrawScene());
    get("digits").onchange = onChange(() => this.fillNumbers());
    get("align").onchange = onChange(() => {
      this.placeRuns();
      this.wholeRun();
      this.go(this.t);
    });
    for (const button of document.querySelectorAll("[data-key]")) button.onclick = event => KEYS[button.dataset.key](this, event);
    const onClick = {
      "scene-in": () => this.zoomScene(1.4), "scene-out": () => this.zoomScene(1 / 1.4),
      "theme": () => {
        this.theme = {auto: "light", light: "dark", dark: "auto"}[this.theme];
        get("theme").textContent = `theme: ${this.theme}`;
        this.applyTheme();
      },
      "add-chart": () => {
        const names = this.columns().map(column => column.name);
        const unseen = names.find(name => !this.charts.some(chart => chart.names.includes(name)));
        const chart = this.addChart({names: [unseen ?? names[0]]});
        chart.picker.box.hidden = false;
        chart.changed();
      },
    };
    for (const [id, act] of Object.entries(onClick)) get(id).onclick = act;
    get("patches-save").append(...pictureButtons("the patches", () => `${this.pictureName()}_patches`,
                                                 kind => patchesAs(kind, this)));
    get("scene-save").append(...pictureButtons("the picture", () => this.pictureName(), kind => sceneAs(kind, this)));
    get("scrub").oninput = () => {
      this.pause();
      this.goToRow(this.track.time(Number(get("scrub").value)));
    };
    get("events").onchange = () => {
      const chosen = this.events.listed[get("events").value];
      get("events").value = "";
      this.pause();
      if (chosen) this.go(chosen.t);
    };
    pointers(this.scene.canvas, {drag: (dx, dy) => this.panScene(dx, dy), zoom: (factor, x, y) => this.zoomScene(factor, x, y)});
    document.addEventListener("keydown", event => pressKey(this, event));
    window.addEventListener("hashchange", () => this.address.follow());
    window.addEventListener("resize", () => this.resize());
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.dark.onchange = () => this.applyTheme();
    window.addEventListener("beforeprint", () => this.applyTheme("light"));
    window.addEventListener("afterprint", () => this.applyTheme());
    this.theme = "auto";
    this.applyTheme();
  }

  applyTheme(wanted = this.theme) {
    document.documentElement.dataset.theme = wanted === "auto" ? this.dark.matches ? "dark" : "light" : wanted;
    if (!this.runs.length) return;
    drawChoice(this);
    this.charts.forEach(chart => chart.drawHead());
    this.resize();
    this.fillNumbers();
  }

  resize() {
    this.scene.resize();
    this.charts.forEach(chart => chart.resize());
    if (!this.runs.length) return;
    this.charts.forEach(chart => chart.draw());
    drawOverview(this);
    drawBeyond(this);
    this.placeCursors();
    this.redrawScene();
    drawPatches(this);
  }
}

// The charts at first. Differences are shown of runs of one exercise.
function defaultCharts(runs) {
  const has = name => runs.some(run => run.has(name)), alike = new Set(runs.map(run => run.task).filter(Boolean)).size < 2;
  const wanted = runs.length > 1
    ? [[["Y"]], ...(alike ? [[["Y"], "difference"]] : []), [["N_LF"]], [["N_RF"]], [["roll"]], [["E_drift"]]]
    : [[["Y"]], [["N_LF", "N_RF"]], [["N_LT", "N_RT"]], [["KE_lat", "PE_elastic_L", "PE_elastic_R"]], [["E_drift"]]];
  const found = wanted.map(([names, mode]) => [names.filter(has), mode]).filter(([names]) => names.length);
  return found.length ? found : runs[0].columns.slice(0, 3).map(column => [[column.name]]);
}

// The first column of each name.
function distinct(columns) {
  const names = columns.map(column => column.name);
  return columns.filter((column, k) => names.indexOf(column.name) === k);
}

async function start(facts) {
  const page = new Page(JSON.parse(new TextDecoder().decode(await inflate(facts))));
  globalThis.ldbench = Object.assign(page, {difference});       // reachable from the console
  await page.open();
}

start(get("facts").textContent).catch(error => {
  get("subtitle").textContent = `This page could not be shown: ${error.message}`;
  throw error;
});
