// The whole run behind the slider: the first run's displacement, the window, and the events.

function drawOverview(page) {
  const canvas = get("overview"), g = canvas.getContext("2d"), ratio = Math.min(window.devicePixelRatio || 1, 2);
  const {clientWidth: w, clientHeight: h} = canvas;
  canvas.width = Math.round(w * ratio);
  canvas.height = Math.round(h * ratio);
  g.scale(ratio, ratio);
  const x = t => 7 + (w - 14) * (t - page.start) / (page.end - page.start || 1);
  g.fillStyle = page.colour.of("back");
  g.fillRect(0, 4, w, h - 8);
  g.fillStyle = page.colour.of("faint");
  g.fillRect(x(page.window[0]), 4, Math.max(x(page.window[1]) - x(page.window[0]), 2), h - 8);
  const run = page.runs[0], name = run.has("Y") ? "Y" : run.columns[0]?.name;
  if (name) {
    const [t, y] = run.series(name), {points, band} = thinned({t, x: y}, w / 4);
    const found = points ? {from: points.t, low: points.x, high: points.x} : band;
    const low = Math.min(...found.low.filter(Number.isFinite)), high = Math.max(...found.high.filter(Number.isFinite));
    g.strokeStyle = page.colour.of("muted");
    g.beginPath();
    found.from.forEach((t, k) => {
      for (const v of [found.low[k], found.high[k]])
        if (Number.isFinite(v)) g.lineTo(x(t), h - 8 - (h - 16) * (v - low) / (high - low || 1));
    });
    g.stroke();
  }
  for (const event of page.events.listed) {
    g.fillStyle = page.colour.of(event.peak ? "accent" : "ink");
    g.fillRect(x(event.t) - 0.75, event.peak ? 0 : h - 9, 1.5, 9);
  }
  if (page.mark === null) return;
  g.fillStyle = page.colour.of("second");
  g.fillRect(x(page.mark) - 1, 0, 2, h);
}
