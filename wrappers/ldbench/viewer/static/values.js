// The table of all values at the cursor: the nearest row of every run, and the difference of two runs.

class Values {
  draw(runs, columns, groups) {
    this.runs = runs;
    const several = runs.length > 1, two = runs.length === 2;
    const head = make("tr", {}, make("th", {}, "quantity"),
      ...runs.map(run => make("th", {}, several ? run.name : "value")),
      ...(two ? [make("th", {}, "difference")] : []), make("th", {}, ""));
    this.rowTimes = runs.map(() => make("td"));
    const body = [make("tr", {}, make("th", {scope: "row"}, "time of the row"), ...this.rowTimes,
                       ...(two ? [make("td")] : []), make("td", {class: "unit"}, "s"))];
    this.cells = [];
    for (const group of groups) {
      const some = columns.filter(column => column.group === group);
      if (!some.length) continue;
      body.push(make("tr", {class: "group"}, make("th", {colspan: 9}, group)));
      for (const column of some) {
        const values = runs.map(run => make("td", {"data-run": run.name, "data-column": column.name}));
        const apart = two ? make("td") : null, unit = make("td", {class: "unit"});
        this.cells.push({column, values, apart, unit});
        body.push(make("tr", {}, make("th", {scope: "row", title: column.name}, column.words), ...values,
                       ...(apart ? [apart] : []), unit));
      }
    }
    get("values").replaceChildren(make("thead", {}, head), make("tbody", {}, ...body));
  }

  fill(t) {
    const si = get("digits").checked, rows = this.runs.map(run => run.row(t));
    this.runs.forEach((run, k) => { this.rowTimes[k].textContent = timeWords(run.t[rows[k]]); });
    for (const {column, values, apart, unit} of this.cells) {
      this.runs.forEach((run, k) => {
        const x = run.value(column.name, rows[k]);
        values[k].textContent = si ? asInFile(x) : shortWords(column.scale * x);
      });
      unit.textContent = si ? column.si : column.unit;
      if (apart) {
        const [a, b] = this.runs;
        const d = a.has(column.name) && b.has(column.name)
          ? interpolate(b.t, b.exact[column.name], a.t[rows[0]]) - a.value(column.name, rows[0]) : NaN;
        apart.textContent = si ? asInFile(d) : shortWords(column.scale * d);
      }
    }
  }
}
