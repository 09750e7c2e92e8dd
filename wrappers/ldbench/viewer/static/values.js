// The table of all values at the cursor: the row of every run there, and the difference of two runs or of two moments.

class Values {
  draw(runs, columns, groups) {
    this.runs = runs;
    const several = runs.length > 1, cell = (kind, words = "") => make("td", {class: kind}, words);
    const row = (words, title, ...cells) => make("tr", {}, make("th", {scope: "row", title}, words), ...cells);
    const head = make("tr", {}, make("th", {}, "quantity"), ...runs.map(run => make("th", {}, several ? run.name : "value")),
      make("th", {class: "apart"}, several ? "difference" : "since mark"), make("th"));
    this.rowTimes = runs.map(() => make("td"));
    this.rowApart = cell("apart");
    const body = [row("time of the row", "", ...this.rowTimes, this.rowApart, cell("unit", "s"))];
    this.cells = [];
    for (const group of groups) {
      const some = columns.filter(column => column.group === group);
      if (some.length) body.push(make("tr", {class: "group"}, make("th", {colspan: runs.length + 3}, group)));
      for (const column of some) {
        const values = runs.map(run => make("td", {"data-run": run.name, "data-column": column.name}));
        const apart = cell("apart"), unit = cell("unit");
        this.cells.push({column, values, apart, unit});
        body.push(row(column.words, column.name, ...values, apart, unit));
      }
    }
    get("values").replaceChildren(make("thead", {}, head), make("tbody", {}, ...body));
  }

  // The row of a run at a time; where that row is not kept, its values are known about, or between two limits.
  fill(t, mark) {
    const si = get("digits").checked, kept = this.runs.map(run => run.keptRow(t));
    this.runs.forEach((run, k) => {
      this.rowTimes[k].textContent = kept[k] !== null ? timeWords(run.inFile.t[kept[k]]) : `≈ ${timeWords(t - run.shift)}`;
    });
    get("values").className = this.runs.length > 2 ? "alone many" : this.runs.length < 2 && mark === null ? "alone" : "";
    get("between").hidden = !kept.includes(null);
    const before = this.runs.length === 1 && mark !== null ? this.runs[0].keptRow(mark) : null;
    this.rowApart.textContent = before !== null && kept[0] !== null
      ? shortWords(this.runs[0].t[kept[0]] - this.runs[0].t[before]) : "";
    for (const {column, values, apart, unit} of this.cells) {
      this.runs.forEach((run, k) => {
        const reading = kept[k] !== null ? {x: run.value(column.name, kept[k])} : run.reading(column.name, t);
        values[k].textContent = readingWords(reading, column, si);
      });
      unit.textContent = si ? column.si : column.unit;
      const d = this.difference(column.name, kept, before);
      apart.textContent = si ? asInFile(d) : shortWords(column.scale * d);
    }
  }

  difference(name, kept, before) {
    const [a, b] = this.runs;
    if (kept[0] === null || !a.has(name)) return NaN;
    if (!b) return before === null ? NaN : a.value(name, kept[0]) - a.value(name, before);
    return b.has(name) ? interpolate(b.t, b.exact[name], a.t[kept[0]]) - a.value(name, kept[0]) : NaN;
  }
}
