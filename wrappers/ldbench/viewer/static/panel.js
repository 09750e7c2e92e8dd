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

  drawHead() {
    const lines = this.lines(), unit = lines[0]?.column.unit ?? "", several = this.page.runs.length > 1;
    this.values = [];
    const legend = make("ul", {class: "legend"}, ...lines.map(line => {
      const value = make("b");
      this.values.push({...line, value});
      return make("li", {}, swatch(line.colour, line.dash, line.width), this.words(line), value);
    }));
    const button = (text, label, pressed, act) => {
      const made = make("button", {type: "button", title: label, "aria-label": label, onclick: act}, text);
      if (pressed !== null) made.setAttribute("aria-pressed", pressed);
      return made;
    };
    const toggle = part => () => {
      part.hidden = !part.hidden;
      this.redraw();
    };
    const buttons = make("div", {class: "choice", role: "group", "aria-label": "chart"});
    if (several && !this.over)
      buttons.append(button("Δ", "differences from the first run", this.mode === "difference", () => {
        this.mode = this.mode === "difference" ? "values" : "difference";
        this.limits = null;
        this.changed();
      }));
    buttons.append(
      button("box", "zoom to a box: drag over the chart", this.boxing, () => this.setBoxing(!this.boxing)),
      button("fit", "fit: all values, whole run", null, () => this.fit()),
      button("columns", "choose columns", !this.picker.box.hidden, toggle(this.picker.box)),
      button("⋯", "axes and saving", !this.menu.hidden, toggle(this.menu)),
      button("×", "remove this chart", null, () => {
        this.page.removeChart(this);
        this.page.write();
      }));
    drawAgain(this.head, () => this.head.replaceChildren(legend, buttons));
    this.picker.draw(unit);
    this.drawMenu();
    const what = lines.map(({column}) => column.words).join(", ");
    this.card.setAttribute("aria-label", `chart: ${what}`);
    const kind = this.mode === "difference" ? "differences of " : "", over = this.page.column(this.over)?.words ?? "time [s]";
    this.canvas.setAttribute("aria-label", `${kind}${what} [${unit}] over ${over}`);
    this.drawDots(lines);
  }

  drawMenu() {
    if (this.menu.hidden) return;
    const button = (text, label, act) => make("button", {type: "button", title: label, "aria-label": label, onclick: act}, text);
    const across = make("select", {"aria-label": "horizontal axis"}, make("option", {value: ""}, "time"),
      ...this.page.chartColumns().map(({name, words}) => make("option", {value: name}, words)));
    across.value = this.over;
    across.onchange = () => {
      Object.assign(this, {over: across.value, mode: "values", limits: null, acrossLimits: null});
      this.changed();
    };
    const log = make("input", {type: "checkbox", checked: this.log, "data-key": "log"});
    log.onchange = () => this.setLog(log.checked);
    drawAgain(this.menu, () => this.menu.replaceChildren(
      make("label", {}, "over ", across), make("label", {}, log, "logarithmic values"),
      make("span", {class: "choice", role: "group", "aria-label": "zoom of the values"},
        button("−", "show more values", () => this.zoomValues(2)), button("+", "show fewer values", () => this.zoomValues(0.5))),
      make("span", {class: "choice", role: "group", "aria-label": "save"},
        button("SVG", "save the chart as SVG", () => save(`${this.fileName()}.svg`, chartAsSvg(this))),
        button("PNG", "save the chart as PNG", async () => save(`${this.fileName()}.png`, await chartAsPng(this))),
        button("CSV", "save the values as CSV", () => save(`${this.fileName()}.csv`, chartAsCsv(this))))));
  }

  fileName() { return [...this.page.runs.map(run => run.name), ...this.names].join("_").slice(0, 100); }

  setLog(on) {
    Object.assign(this, {log: on, limits: null});
    this.changed();
  }

  // The chart is another one now: draw it, and tell the address.
  changed() {
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

  fillLegend() {
    const {t, runs: [first], mark} = this.page;
    for (const {run, column: known, value} of this.values) {
      const column = this.asOnAxis(known);
      const at = time => this.mode === "difference"
        ? {x: run.at(column.name, time) - first.at(column.name, time)} : run.reading(column.name, time);
      const here = at(t), before = mark === null ? null : at(mark);
      const since = before && Number.isFinite(here.x) && Number.isFinite(before.x)
        ? ` (${here.x >= before.x ? "+" : ""}${shortWords(column.scale * (here.x - before.x), 5)})` : "";
      value.textContent = `${readingWords(here, column, false, 6)}${since} ${column.unit}`;
    }
  }

  // Cursors, or where the runs are on their curves.
  placeCursor() {
    const [start, end] = this.page.window, {t, mark} = this.page;
    for (const [cursor, time] of [[this.cursor, t], [this.second, mark]]) {
      cursor.hidden = Boolean(this.over) || time === null || time < start || time > end;
      if (!cursor.hidden) cursor.style.transform = `translateX(${this.x(time) - 0.75}px)`;
    }
    if (!this.over) return;
    (this.curves ?? []).forEach((curve, k) => {
      const dot = this.dots.children[k], place = this.pointAt(curve, t);
      if (!dot) return;
      dot.hidden = !place;
      if (place) dot.style.transform = `translate(${place[0]}px, ${place[1]}px)`;
    });
  }

  drawDots(lines) {
    this.dots.replaceChildren(...(this.over ? lines : []).map(({colour}) => {
      const dot = make("i", {class: "dot", hidden: true});
      dot.style.backgroundColor = colour;
      return dot;
    }));
  }

  // Values -------------------------------------------------------------------------------------

  zoomValues(factor, y = (this.box.top + this.box.bottom) / 2) {
    const {low, high, log} = this.scale, about = this.scale.value(y);
    if (log) this.limits = [low, high].map(v => about * (v / about) ** factor);
    else this.limits = [low, high].map(v => about + factor * (v - about));
    if (!(this.limits[1] - this.limits[0] > 1e-12 * Math.abs(about))) this.limits = [low, high];
    this.draw();
    this.page.placeCursors();
    this.page.write();
  }

  panValues(dy) {
    const {box, scale} = this;
    this.limits = [box.bottom - dy, box.top - dy].map(y => scale.value(y));
    this.draw();
    this.page.write();
  }

  // All values and the whole run.
  fit() {
    Object.assign(this, {limits: null, acrossLimits: null});
    if (!this.over) this.page.wholeRun();
    this.draw();
    this.page.placeCursors();
    this.page.write();
  }

  setBoxing(on) {
    this.boxing = on;
    this.canvas.style.touchAction = on ? "none" : "";
    this.drawHead();
  }

  // Zoom to a box of pixels, in time and in values; over another column, in both columns.
  zoomBox(x1, y1, x2, y2) {
    const {box, scale} = this, clampX = x => Math.min(Math.max(x, box.left), box.right);
    const [a, b] = [clampX(Math.min(x1, x2)), clampX(Math.max(x1, x2))];
    const [top, bottom] = [y1, y2].map(y => Math.min(Math.max(y, box.top), box.bottom)).sort((p, q) => p - q);
    if (b - a < 5 || bottom - top < 5) return;
    this.limits = [scale.value(bottom), scale.value(top)];
    if (this.over) {
      const [low, high] = this.across, at = x => low + (high - low) * (x - box.left) / (box.right - box.left);
      this.acrossLimits = [at(a), at(b)];
      this.draw();
    } else {
      const [start, end] = [this.time(a), this.time(b)];
      this.page.setWindow(start, end - start);
    }
    this.page.placeCursors();
    this.page.write();
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
        if (from) {
          from = null;
          this.frame.hidden = true;
        }
        if (x < this.box.left || event.altKey || this.over) return this.zoomValues(1 / factor, y);
        const {start, end: last} = this.page;
        this.page.zoomTime(1 / factor, Math.min(Math.max(this.time(x), start), last));
      },
    });
    this.canvas.addEventListener("dblclick", () => this.fit());
  }

  drawFrame([x0, y0], x, y) {
    this.frame.hidden = false;
    const {style} = this.frame;
    style.transform = `translate(${Math.min(x0, x)}px, ${Math.min(y0, y)}px)`;
    style.width = `${Math.abs(x - x0)}px`;
    style.height = `${Math.abs(y - y0)}px`;
  }

  scrub(x, y) {
    const [start, end] = this.page.window;
    this.page.pause();
    if (!this.over) return this.page.goToRow(Math.min(Math.max(this.time(x), start), end));
    const near = this.nearest(x, y);
    if (near) this.page.go(near.curve.t[near.i]);
  }
}
