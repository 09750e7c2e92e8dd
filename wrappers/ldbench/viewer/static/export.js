// Charts and the scene as pictures, and charts as numbers: SVG, PDF, PNG and CSV. Pictures are in the colours of paper.

const PNG_PIXELS = 3;           // of a picture for each one on the screen

// Draw a chart on paper with another context, and its legend below; of several runs with their names.
function paintWithLegend(chart, g, height) {
  const {colour} = chart.page, {left, right} = chart.box;
  naming(g, {what: "paper"});
  g.fillStyle = colour.of("paper");
  g.fillRect(0, 0, chart.w, height);
  chart.paint(g);
  let [x, y] = [left, chart.h + 8];
  g.textAlign = "left";
  g.textBaseline = "middle";
  for (const look of chart.lines()) {
    naming(g, {...chart.nameOf(look), what: "legend"});
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
  naming(g);
}

// With the legend below.
function heightWithLegend(chart) { return chart.h + 16 * (chart.lines().length + 1); }

const CONTEXTS = {svg: SvgContext, pdf: PdfContext};

// What `draw` draws in a context of this size, as a file of a kind: "svg", "pdf" or "png".
function pictureOf(kind, w, h, draw) {
  if (CONTEXTS[kind]) {
    const g = new CONTEXTS[kind](w, h);
    draw(g);
    return g.blob();
  }
  const canvas = make("canvas"), g = canvas.getContext("2d");
  [canvas.width, canvas.height] = [PNG_PIXELS * w, PNG_PIXELS * h];
  g.setTransform(PNG_PIXELS, 0, 0, PNG_PIXELS, 0, 0);
  draw(g);
  return new Promise(done => canvas.toBlob(done, "image/png"));
}

// Draw in the light colours.
function onPaper(draw) {
  const {dataset} = document.documentElement, before = dataset.theme;
  dataset.theme = "light";
  try {
    return draw();
  } finally {
    dataset.theme = before;
  }
}

function chartAs(kind, chart) {
  const height = heightWithLegend(chart);
  return onPaper(() => pictureOf(kind, chart.w, height, g => paintWithLegend(chart, g, height)));
}

// The scene as it is seen, with its scales.
function sceneAs(kind, page) {
  const {scene} = page, {g: screen, w, h} = scene;
  return onPaper(() => pictureOf(kind, w, h, g => {
    naming(g, {what: "paper"});
    g.fillStyle = page.colour.of("paper");
    g.fillRect(0, 0, w, h);
    scene.g = g;
    try {
      page.redrawScene();
    } finally {
      scene.g = screen;
    }
  }));
}

// Buttons that save a picture, with the words for what is saved.
function pictureButtons(what, fileName, picture) {
  return ["svg", "pdf", "png"].map(kind => button(kind.toUpperCase(), `save ${what} as ${kind.toUpperCase()}`,
    async () => save(`${fileName()}.${kind}`, await picture(kind))));
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
