// A chart as a picture or as numbers: SVG by a context that writes what a canvas would draw, PNG, and CSV.

// The part of a canvas context that charts use; it makes SVG.
class SvgContext {
  constructor(w, h) {
    Object.assign(this, {w, h, parts: [], path: "", state: {move: "", clip: "", alpha: 1}, saved: [], clips: 0});
    Object.assign(this, {fillStyle: "#000", strokeStyle: "#000", lineWidth: 1, dash: [], textAlign: "left", font: ""});
  }

  set globalAlpha(alpha) { this.state.alpha = alpha; }

  setLineDash(dash) { this.dash = dash; }
  beginPath() { this.path = ""; }
  moveTo(x, y) { this.path += `M${short(x)} ${short(y)}`; }
  lineTo(x, y) { this.path += `${this.path ? "L" : "M"}${short(x)} ${short(y)}`; }
  rect(x, y, w, h) { this.path += `M${short(x)} ${short(y)}h${short(w)}v${short(h)}h${short(-w)}z`; }
  save() { this.saved.push({...this.state}); }
  restore() { this.state = this.saved.pop(); }
  translate(x, y) { this.state.move += `translate(${short(x)} ${short(y)})`; }
  rotate(angle) { this.state.move += `rotate(${short(angle * 180 / Math.PI)})`; }

  clip() {
    this.state.clip = `clip${++this.clips}`;
    this.parts.push(`<clipPath id="${this.state.clip}"><path d="${this.path}"/></clipPath>`);
  }

  put(tag, facts, inside = "") {
    const {move, clip, alpha} = this.state;
    const all = {...facts, transform: move, "clip-path": clip && `url(#${clip})`, opacity: alpha === 1 ? "" : alpha};
    const words = Object.entries(all).filter(([, value]) => value !== "").map(([name, value]) => ` ${name}="${value}"`);
    this.parts.push(`<${tag}${words.join("")}>${inside}</${tag}>`);
  }

  stroke() {
    if (this.path) this.put("path", {d: this.path, fill: "none", stroke: this.strokeStyle, "stroke-width": this.lineWidth,
                                     "stroke-dasharray": this.dash.join(" "), "stroke-linejoin": "round"});
  }

  fillRect(x, y, w, h) { this.put("rect", {x: short(x), y: short(y), width: short(w), height: short(h), fill: this.fillStyle}); }

  measureText(text) { return {width: 6 * text.length}; }

  fillText(text, x, y) {
    const anchor = {left: "start", center: "middle", right: "end"}[this.textAlign];
    this.put("text", {x: short(x), y: short(y), fill: this.fillStyle, "text-anchor": anchor, "dominant-baseline": "central"},
             plain(text));
  }

  text() {
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${this.w}" height="${this.h}" viewBox="0 0 ${this.w} ${this.h}" `
      + `font-family="sans-serif" font-size="11">${this.parts.join("\n")}</svg>\n`;
  }
}

function short(x) { return +x.toFixed(2); }

function plain(text) {
  return String(text).replace(/[&<>"]/g, mark => `&#${mark.charCodeAt(0)};`).replace(/[^\t\n\r -\ud7ff\ue000-\ufffd]/g, "?");
}

// Draw a chart on paper with another context, and its legend below; of several runs with their names.
function paintWithLegend(chart, g, height) {
  const {colour} = chart.page, {left, right} = chart.box;
  g.fillStyle = colour.of("paper");
  g.fillRect(0, 0, chart.w, height);
  chart.paint(g);
  let [x, y] = [left, chart.h + 8];
  g.textAlign = "left";
  g.textBaseline = "middle";
  for (const look of chart.lines()) {
    const words = chart.words(look), width = 40 + g.measureText(words).width;
    if (x + width > right && x > left) [x, y] = [left, y + 16];
    g.strokeStyle = look.colour;
    g.lineWidth = look.width;
    g.setLineDash(look.dash);
    line(g, x, y, x + 24, y);
    g.setLineDash([]);
    g.fillStyle = colour.of("ink");
    g.fillText(words, x + 30, y);
    x += width + 14;
  }
}

function heightWithLegend(chart) { return chart.h + 16 * (chart.lines().length + 1); }

function chartAsSvg(chart) {
  const height = heightWithLegend(chart), g = new SvgContext(chart.w, height);
  paintWithLegend(chart, g, height);
  return new Blob([g.text()], {type: "image/svg+xml"});
}

function chartAsPng(chart) {
  const ratio = 3, height = heightWithLegend(chart), canvas = make("canvas"), g = canvas.getContext("2d");
  [canvas.width, canvas.height] = [ratio * chart.w, ratio * height];
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  paintWithLegend(chart, g, height);
  return new Promise(done => canvas.toBlob(done, "image/png"));
}

// The rows of the window in SI units, with all digits that the page has; of a long run those that are kept.
function chartAsCsv(chart) {
  const {runs, window: [start, end]} = chart.page, quoted = text => `"${text.replaceAll('"', '""')}"`;
  const wanted = [...new Set([...(chart.over ? [chart.over] : []), ...chart.names])];
  const columns = wanted.map(name => runs.map(run => run.column(name)).find(Boolean)).filter(Boolean);
  const rows = [["run", "time [s]", ...columns.map(({name, si}) => `${name} [${si || "1"}]`)].map(quoted)];
  for (const run of runs)
    for (let i = 0; i < run.t.length; i++)
      if (run.t[i] >= start && run.t[i] <= end)
        rows.push([quoted(run.name), asInFile(run.inFile.t[i]),
                   ...columns.map(({name}) => run.column(name) ? asInFile(run.exact[name][i]) : "")]);
  return new Blob([rows.map(row => row.join(",")).join("\r\n") + "\r\n"], {type: "text/csv"});
}
