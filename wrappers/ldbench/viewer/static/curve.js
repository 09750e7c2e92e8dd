// Charts of one column over another: curves through the rows of the window of time.

Object.assign(Chart.prototype, {
  // The points of a line, and its least and largest values. A long run has both columns for every row, or at kept rows.
  curve(line, start, end) {
    const {run, column} = line, across = run.column(this.over);
    const every = across && run.tracks[column.name] && run.tracks[this.over];
    const t = every ? run.rowTimes : run.t;
    const a = indexBefore(t, start), b = Math.min(indexBefore(t, end) + 1, t.length - 1);
    const part = name => (every ? run.tracks : run.exact)[name].subarray(a, b + 1);
    const found = {line, across: across ?? {unit: "", scale: 1, words: this.over}, t: t.subarray(a, b + 1),
                   horizontal: across ? part(this.over) : new Float64Array(0),
                   vertical: across ? part(column.name) : new Float64Array(0),
                   joined: every || !run.rowNumbers ? () => true : i => run.joined(a + i),
                   least: Infinity, most: -Infinity, smallest: Infinity};
    for (const x of found.vertical) {
      if (x < found.least) found.least = x;
      if (x > found.most) found.most = x;
      if (x !== 0 && Math.abs(x) < found.smallest) found.smallest = Math.abs(x);
    }
    for (const key of ["least", "most", "smallest"]) found[key] *= column.scale;
    return found;
  },

  // Limits of the horizontal axis, which `across` keeps, and the pixel of a value in shown units.
  horizontal(drawn) {
    let low = Infinity, high = -Infinity;
    for (const {horizontal, across} of drawn)
      for (const x of horizontal) {
        if (x * across.scale < low) low = x * across.scale;
        if (x * across.scale > high) high = x * across.scale;
      }
    this.across = this.acrossLimits ?? extent(low, high);
    this.curves = drawn;
    const {left, right} = this.box;
    return v => left + (right - left) * (v - this.across[0]) / (this.across[1] - this.across[0]);
  },

  // The pixel of a point of a curve.
  at(curve, x, y) {
    const {left, right} = this.box, [low, high] = this.across;
    return [left + (right - left) * (curve.across.scale * x - low) / (high - low), this.scale.y(curve.line.column.scale * y)];
  },

  drawCurve(g, curve) {
    const {horizontal, vertical, joined, line} = curve, few = vertical.length < 400;
    g.setLineDash(line.dash);
    g.beginPath();
    let pen = false;
    for (let i = 0; i < vertical.length; i++) {
      const [x, y] = this.at(curve, horizontal[i], vertical[i]), shown = Number.isFinite(x + y);
      if (shown && pen && joined(i)) g.lineTo(x, y);
      else if (shown) {
        g.moveTo(x, y);
        if (!joined(Math.min(i + 1, vertical.length - 1)) || few) g.fillRect(x - 1, y - 1, 2, 2);
      }
      pen = shown;
    }
    g.stroke();
    g.setLineDash([]);
  },

  // Where a curve is at a time [px]; null if nothing is known there.
  pointAt(curve, t) {
    const {run, column} = curve.line;
    const [x, y] = this.at(curve, run.at(this.over, t), run.at(column.name, t));
    return Number.isFinite(x + y) ? [x, y] : null;
  },

  // The point of all curves that is nearest to a pixel: {curve, i, x, y}; null beyond 40 px.
  nearest(px, py) {
    let best = null, least = 40 ** 2;
    for (const curve of this.curves ?? [])
      for (let i = 0; i < curve.vertical.length; i++) {
        const [x, y] = this.at(curve, curve.horizontal[i], curve.vertical[i]), d = (x - px) ** 2 + (y - py) ** 2;
        if (d < least) [least, best] = [d, {curve, i, x, y}];
      }
    return best;
  },
});
