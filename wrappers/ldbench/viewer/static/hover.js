// What a chart shows at the pointer: a line, the time and the values there, without a click.

class Hover {
  constructor(chart) {
    this.chart = chart;
    this.line = make("div", {class: "cursor hover", hidden: true});
    this.box = make("div", {class: "tip", hidden: true});
    chart.holder.append(this.line, this.box);
    chart.canvas.addEventListener("pointermove", event => {
      if (event.buttons || event.pointerType === "touch") this.hide();
      else this.show(event.offsetX, event.offsetY);
    });
    for (const end of ["pointerleave", "pointerdown", "wheel"])
      chart.canvas.addEventListener(end, () => this.hide(), {passive: true});
  }

  // The lines of the pointer: over time, one in each chart.
  get lines() {
    return this.chart.over ? [] : this.chart.page.charts.filter(({over}) => !over).map(({hover}) => hover.line);
  }

  hide() {
    this.box.hidden = true;
    for (const line of this.lines) line.hidden = true;
  }

  show(x, y) {
    const {chart} = this, {left, right, top, bottom} = chart.box;
    if (x < left || x > right || y < top || y > bottom) return this.hide();
    const found = chart.over ? this.onCurve(x, y) : this.atTime(x);
    if (!found) return this.hide();
    const {words, t, at} = found;
    this.box.replaceChildren(make("b", {}, `${timeWords(t)} s`), ...words.map(([line, text]) =>
      make("span", {}, swatch(line), chart.page.runs.length > 1 ? `${line.run.name} ${text}` : text)));
    this.box.hidden = false;
    for (const line of this.lines) {
      line.hidden = false;
      move(line, at - 0.5, 0);
    }
    const width = this.box.offsetWidth, beyond = at + 12 + width > chart.w;
    move(this.box, beyond ? Math.max(at - 12 - width, 0) : at + 12, top);
  }

  // The values at the row that is nearest to the pointer, or between rows if they lie far apart.
  atTime(x) {
    const {chart} = this, [first] = chart.page.runs, here = chart.place(x);
    const row = first.t[first.row(here)], t = Math.abs(chart.x(row) - x) < 4 ? row : here;
    return {words: chart.lines().map(line => [line, chart.valueWords(line, t).join(" ")]), t, at: chart.x(t)};
  }

  onCurve(x, y) {
    const near = this.chart.nearest(x, y);
    if (!near) return null;
    const {curve: {line, across, times}, i} = near, t = times[i];
    return {t, at: near.x, words: [line.column, across].map(column =>
      [line, `${column.words} ${readingWords(line.run.reading(column.name, t), column, false, 6)} ${column.unit}`])};
  }
}
