// A chart in its card: legend, buttons, the choice of columns, and what mouse and fingers do.

class Panel extends Chart {
  constructor(page, names, mode) {
    super(page, names, mode);
    this.canvas = make("canvas", {tabindex: "0", role: "img"});
    this.cursor = make("div", {class: "cursor"});
    this.head = make("div", {class: "head"});
    this.picker = make("div", {class: "picker", hidden: true});
    this.card = make("section", {class: "card"}, this.head, this.picker,
                     make("div", {class: "chart"}, this.canvas, this.cursor));
    this.listen();
  }

  drawHead() {
    const lines = this.lines(), unit = lines[0]?.column.unit ?? "";
    const several = this.page.runs.length > 1;
    this.values = [];
    const legend = make("ul", {class: "legend"}, ...lines.map(({run, column, colour, dash}) => {
      const value = make("b");
      this.values.push({run, column, value});
      const words = (this.mode === "difference" ? "Δ " : "") + column.words + (several ? `, ${run.name}` : "");
      return make("li", {}, this.page.swatch(colour, dash), words, value);
    }));
    const button = (text, label, pressed, act) => {
      const made = make("button", {type: "button", title: label, "aria-label": label, onclick: act}, text);
      if (pressed !== null) made.setAttribute("aria-pressed", pressed);
      return made;
    };
    const buttons = make("div", {class: "choice", role: "group", "aria-label": "chart"});
    if (several) buttons.append(button("Δ", "differences from the first run", this.mode === "difference", () => {
      this.mode = this.mode === "difference" ? "values" : "difference";
      this.redraw();
    }));
    buttons.append(
      button("columns", "choose columns", !this.picker.hidden, () => {
        this.picker.hidden = !this.picker.hidden;
        this.redraw();
      }),
      button("×", "remove this chart", null, () => {
        this.card.remove();
        this.page.charts = this.page.charts.filter(other => other !== this);
      }));
    this.head.replaceChildren(legend, buttons);
    this.drawPicker(unit);
    const what = lines.map(({column}) => column.words).join(", ");
    this.card.setAttribute("aria-label", `chart: ${what}`);
    const kind = this.mode === "difference" ? "differences of " : "";
    this.canvas.setAttribute("aria-label", `${kind}${what} [${unit}] over time [s]`);
  }

  // Columns of one unit share a chart; a column of another unit replaces them.
  drawPicker(unit) {
    if (this.picker.hidden) return;
    this.picker.replaceChildren(...this.page.facts.groups.map(group => {
      const columns = this.page.columns().filter(column => column.group === group);
      return columns.length ? make("fieldset", {}, make("legend", {}, group), ...columns.map(column => {
        const box = make("input", {type: "checkbox", checked: this.names.includes(column.name)});
        box.onchange = () => {
          if (!box.checked) this.names = this.names.filter(name => name !== column.name);
          else this.names = column.unit === unit ? [...this.names, column.name] : [column.name];
          this.redraw();
        };
        return make("label", {}, box, column.unit ? `${column.words} [${column.unit}]` : column.words);
      })) : "";
    }));
  }

  redraw() {
    this.drawHead();
    this.resize();
    this.draw();
    this.fillLegend();
    this.page.placeCursors();
  }

  fillLegend() {
    const {t, runs: [first]} = this.page;
    for (const {run, column: {name, scale, unit}, value} of this.values) {
      const x = this.mode === "difference" ? run.at(name, t) - first.at(name, t) : run.shownAt(name, t);
      value.textContent = `${shortWords(scale * x, 6)} ${unit}`;
    }
  }

  // A drag moves the time, the wheel and two fingers zoom in time; with shift a drag moves the window.
  listen() {
    pointers(this.canvas, {
      press: (x, event) => event.shiftKey || this.scrub(x),
      drag: (dx, dy, x, event) => {
        if (!event.shiftKey) return this.scrub(x);
        const [start, end] = this.page.window;
        this.page.setWindow(start - dx * (end - start) / this.inner, end - start);
      },
      zoom: (factor, x) => {
        const {start, end} = this.page;
        this.page.zoomTime(1 / factor, Math.min(Math.max(this.time(x), start), end));
      },
    });
  }

  scrub(x) {
    const [start, end] = this.page.window;
    this.page.pause();
    this.page.goToRow(Math.min(Math.max(this.time(x), start), end));
  }
}
