// What a chart shows at the pointer: a line, the time and the values there, without a click.

class Hover {
  constructor(chart) {
    this.chart = chart;
    this.line = make("div", {class: "cursor hover", hidden: true});
    this.box = make("div", {class: "tip", hidden: true});
    chart.holder.append(this.line, this.box);
    const {canvas} = chart;
    canvas.addEventListener("pointermove", event => {
      if (event.buttons || event.pointerType === "touch") return this.hide();
      const place = canvas.getBoundingClientRect();
      this.show(event.clientX - place.left, event.clientY - place.top);
    });
    for (const end of ["pointerleave", "pointerdown", "wheel"])
      canvas.addEventListener(end, () => this.hide(), {passive: true});
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
    this.box.replaceChildren(make("b", {}, `${timeWords(t)} s`), ...words.map(([look, text]) =>
      make("span", {}, swatch(look.colour, look.dash, look.width), text)));
    this.box.hidden = false;
    for (const line of this.lines) {
      line.hidden = false;
      line.style.transform = `translateX(${at - 0.5}px)`;
    }
    const beyond = at + 12 + this.box.offsetWidth > chart.w;
    this.box.style.transform = `translate(${beyond ? Math.max(at - 12 - this.box.offsetWidth, 0) : at + 12}px, ${top}px)`;
  }

  // The values at the row that is nearest to the pointer, or between rows if they lie far apart.
  atTime(x) {
    const {chart} = this, {page} = chart, first = page.runs[0], here = chart.time(x);
    const row = first.t[first.row(here)], t = Math.abs(chart.x(row) - x) < 4 ? row : here;
    const words = chart.lines().map(line => {
      const {run} = line, column = chart.asOnAxis(line.column);
      const reading = chart.mode === "difference" ? {x: run.at(column.name, t) - first.at(column.name, t)}
        : run.reading(column.name, t);
      return [line, `${readingWords(reading, column, false, 6)} ${column.unit}`];
    });
    return {words, t, at: chart.x(t)};
  }

  onCurve(x, y) {
    const near = this.chart.nearest(x, y);
    if (!near) return null;
    const {curve: {line, across, t, horizontal, vertical}, i} = near;
    const value = (column, v) => `${shortWords(column.scale * v, 6)} ${column.unit}`;
    return {t: t[i], at: near.x, words: [[line, `${line.column.words} ${value(line.column, vertical[i])}`],
                                         [line, `${across.words} ${value(across, horizontal[i])}`]]};
  }
}
