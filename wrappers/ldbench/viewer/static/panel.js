// A chart in its card: legend, buttons, the choice of columns, a menu, and what mouse and fingers do.

class Panel extends Chart {
  constructor(page, state) {
    super(page, state);
    this.canvas = make("canvas", {tabindex: "0", role: "img"});
    this.cursor = make("div", {class: "cursor"});
    this.second = make("div", {class: "cursor second", hidden: true});
    this.frame = make("div", {class: "frame", hidden: true});
    this.dots = make("div");
    this.holder = make("div", {class: "chart"}, this.canvas, this.cursor, this.second, this.dots, this.frame);
    this.head = make("div", {class: "head"});
    this.picker = new Picker(this);
    this.menu = make("div", {class: "menu", hidden: true});
    this.card = make("section", {class: "card"}, this.head, this.picker.box, this.menu, this.holder);
    this.hover = new Hover(this);
    this.boxing = false;
    this.listen();
  }

  words({run, column}) {
    return (this.mode === "difference" ? "Δ " : "") + column.words + (this.page.runs.length > 1 ? `, ${run.name}` : "");
  }

  // The legend: of one run, each column with its look; of several, each column once, and behind it the looks and values of
  // all runs, whose names stand with their looks at the top of the page; the last value has the unit.
  legend(lines) {
    const isLast = (line, k) => !lines.slice(k + 1).some(({column}) => column.name === line.column.name);
    this.values = lines.map((line, k) => ({...line, value: make("b"), isLast: isLast(line, k)}));
    if (this.page.runs.length < 2)
      return this.values.map(one => make("li", {}, swatch(one), one.column.words, one.value));
    return this.names.map(name => this.values.filter(one => one.column.name === name)).filter(some => some.length)
      .map(some => make("li", {}, (this.mode === "difference" ? "Δ " : "") + some[0].column.words,
                        ...some.map(one => make("span", {title: one.run.name}, swatch(one), one.value))));
  }

  drawHead() {
    const lines = this.lines(), unit = lines[0]?.column.unit ?? "";
    const toggle = part => () => {
      part.hidden = !part.hidden;
      this.redraw();
    };
    const buttons = [
      this.page.runs.length > 1 && !this.over && button("Δ", "differences from the first run", () =>
        this.changed({mode: this.mode === "difference" ? "values" : "difference", limits: null}), this.mode === "difference"),
      button("box", "zoom to a box: drag over the chart", () => this.setBoxing(!this.boxing), this.boxing),
      button("fit", "fit: all values, whole run", () => this.fit()),
      button("columns", "choose columns", toggle(this.picker.box), !this.picker.box.hidden),
      button("⋯", "axes and saving", toggle(this.menu), !this.menu.hidden),
      button("×", "remove this chart", () => {
        this.page.removeChart(this);
        this.page.write();
      })].filter(Boolean);
    drawAgain(this.head, () => this.head.replaceChildren(make("ul", {class: "legend"}, ...this.legend(lines)),
      make("div", {class: "choice", role: "group", "aria-label": "chart"}, ...buttons)));
    this.picker.draw(unit);
    this.drawMenu();
    const what = lines.map(({column}) => column.words).join(", ");
    this.card.setAttribute("aria-label", `chart: ${what}`);
    const kind = this.mode === "difference" ? "differences of " : "", over = this.page.column(this.over)?.words ?? "time [s]";
    this.canvas.setAttribute("aria-label", `${kind}${what} [${unit}] over ${over}`);
    this.dots.replaceChildren(...(this.over ? lines : []).map(({colour}) => {
      const dot = make("i", {class: "dot", hidden: true});
      dot.style.backgroundColor = colour;
      return dot;
    }));
  }

  drawMenu() {
    if (this.menu.hidden) return;
    const across = select("horizontal axis", [["", "time"], ...this.page.chartColumns().map(({name, words}) => [name, words])]);
    across.value = this.over;
    across.onchange = () => this.changed({over: across.value, mode: "values", limits: null, acrossLimits: null});
    const log = make("input", {type: "checkbox", checked: this.log, "data-key": "log", onchange: () => this.setLog(log.checked)});
    drawAgain(this.menu, () => this.menu.replaceChildren(
      make("label", {}, "over ", across), make("label", {}, log, "logarithmic values"),
      make("span", {class: "choice", role: "group", "aria-label": "zoom of the values"},
        button("−", "show more values", () => this.zoomValues(2)), button("+", "show fewer values", () => this.zoomValues(0.5))),
      make("span", {class: "choice", role: "group", "aria-label": "save"},
        ...pictureButtons("the chart", () => this.fileName(), kind => chartAs(kind, this)),
        button("CSV", "save the values as CSV", () => save(`${this.fileName()}.csv`, chartAsCsv(this))))));
  }

  fileName() { return [...this.page.runs.map(run => run.name), ...this.names].join("_").slice(0, 100); }

  setLog(log) { this.changed({log, limits: null}); }

  show(names) { this.changed({names, limits: null}); }

  // The chart is another one now: draw it, and tell the address.
  changed(state = {}) {
    Object.assign(this, state);
    this.redraw();
    this.page.write();
  }

  redraw() {
    this.drawHead();
    this.resize();
    this.draw();
    this.fillLegend();
    this.page.placeCursors();
  }

  // What is known of a line at a time, in the unit of the axis: {reading, column}; in a chart of differences, the difference.
  reading({run, column: known}, t) {
    const [first] = this.page.runs, column = this.asOnAxis(known), {name} = column, found = run.reading(name, t);
    return {column, reading: this.mode === "difference" ? found.above(first.reading(name, t)) : found};
  }

  valueWords(line, t) {
    const {reading, column} = this.reading(line, t);
    return [readingWords(reading, column, false, 6), column.unit];
  }

  fillLegend() {
    const {t, mark} = this.page;
    for (const line of this.values) {
      const {reading, column} = this.reading(line, t), [words, unit] = this.valueWords(line, t);
      const d = mark === null ? NOTHING : reading.above(this.reading(line, mark).reading);
      const since = d.unknown ? "" : ` (${d.exact && d.low >= 0 ? "+" : ""}${readingWords(d, column, false, 5)})`;
      line.value.textContent = words + since + (line.isLast ? ` ${unit}` : "");
    }
  }

  // A place across the chart in percent, because a printed page stretches the canvas to the width of the paper.
  shareOf(x) { return `${100 * x / this.w}%`; }

  // Cursors, or where the runs are on their curves.
  placeCursor() {
    const {t, mark, window: [start, end]} = this.page;
    for (const [cursor, time] of [[this.cursor, t], [this.second, mark]]) {
      cursor.hidden = Boolean(this.over) || time === null || time < start || time > end;
      if (!cursor.hidden) cursor.style.left = this.shareOf(this.x(time));
    }
    (this.curves ?? []).forEach((curve, k) => {
      const dot = this.dots.children[k], place = this.pointAt(curve, t);
      if (!dot) return;
      dot.hidden = !place;
      if (place) Object.assign(dot.style, {left: this.shareOf(place[0]), top: `${place[1]}px`});
    });
  }

  // Limits, of the values or of both axes, that the reader chose.
  setLimits(limits) {
    Object.assign(this, limits);
    this.draw();
    this.page.placeCursors();
    this.page.write();
  }

  zoomValues(factor, y = (this.box.top + this.box.bottom) / 2) {
    const {low, high, log} = this.scale, about = this.scale.value(y);
    const limits = [low, high].map(v => log ? about * (v / about) ** factor : about + factor * (v - about));
    this.setLimits({limits: limits[1] - limits[0] > 1e-12 * Math.abs(about) ? limits : [low, high]});
  }

  panValues(dy) { this.setLimits({limits: [this.box.bottom, this.box.top].map(y => this.scale.value(y - dy))}); }

  // All values and the whole run.
  fit() {
    if (!this.over) this.page.wholeRun();
    this.setLimits({limits: null, acrossLimits: null});
  }

  setBoxing(on) {
    this.boxing = on;
    this.canvas.style.touchAction = on ? "none" : "";
    this.redraw();
  }

  // Zoom to a box of pixels, in time and in values; over another column, in both columns.
  zoomBox(x1, y1, x2, y2) {
    const {box, scale} = this, clamp = (v, low, high) => Math.min(Math.max(v, low), high), sorted = (p, q) => p - q;
    const [a, b] = [x1, x2].map(x => clamp(x, box.left, box.right)).sort(sorted);
    const [top, bottom] = [y1, y2].map(y => clamp(y, box.top, box.bottom)).sort(sorted);
    if (b - a < 5 || bottom - top < 5) return;
    const limits = [scale.value(bottom), scale.value(top)], ends = [this.place(a), this.place(b)];
    if (!this.over) this.page.setWindow(ends[0], ends[1] - ends[0]);
    this.setLimits({limits, acrossLimits: this.over ? ends : null});
  }

  // A drag moves the time; from the values' axis it moves the values; with ctrl, or with the button, it draws a box. The
  // wheel and two fingers zoom in time, over the values' axis and with alt in values. Shift moves the window.
  listen() {
    let from = null, axis = false;
    const end = cancelled => {
      if (from && !cancelled) this.zoomBox(...from, ...this.corner);
      from = null;
      this.frame.hidden = true;
    };
    pointers(this.canvas, {
      press: (x, event, y) => {
        axis = x < this.box.left;
        this.corner = [x, y];
        from = !axis && (this.boxing || event.ctrlKey || event.metaKey) ? [x, y] : null;
        if (!from && !axis && !event.shiftKey) this.scrub(x, y);
      },
      drag: (dx, dy, x, event, y) => {
        this.corner = [x, y];
        if (from) return this.drawFrame(from, x, y);
        if (axis) return this.panValues(dy);
        if (!event.shiftKey) return this.scrub(x, y);
        const [start, stop] = this.page.window;
        this.page.setWindow(start - dx * (stop - start) / (this.box.right - this.box.left), stop - start);
      },
      release: end,
      zoom: (factor, x, y, event) => {
        end(true);
        if (x < this.box.left || event.altKey || this.over) return this.zoomValues(1 / factor, y);
        const {start, end: last} = this.page;
        this.page.zoomTime(1 / factor, Math.min(Math.max(this.place(x), start), last));
      },
    });
    this.canvas.addEventListener("dblclick", () => this.fit());
  }

  drawFrame([x0, y0], x, y) {
    this.frame.hidden = false;
    move(this.frame, Math.min(x0, x), Math.min(y0, y));
    Object.assign(this.frame.style, {width: `${Math.abs(x - x0)}px`, height: `${Math.abs(y - y0)}px`});
  }

  scrub(x, y) {
    const [start, end] = this.page.window;
    this.page.pause();
    if (!this.over) return this.page.goToRow(Math.min(Math.max(this.place(x), start), end));
    const near = this.nearest(x, y);
    if (near) this.page.go(near.curve.times[near.i]);
  }
}

// A button with a label; `pressed` where it can be.
function button(text, label, onclick, pressed) {
  const state = pressed === undefined ? {} : {"aria-pressed": String(pressed)};
  return make("button", {type: "button", title: label, "aria-label": label, onclick, ...state}, text);
}

function move(element, x, y) { element.style.transform = `translate(${x}px, ${y}px)`; }
