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

  // The row of each run at a time. The difference is that of two runs at the row of the first one, or of a run since the row at
  // the mark.
  fill(t, mark) {
    const si = get("digits").checked, [first, other] = this.runs, at = this.runs.map(run => run.rowTime(t));
    const before = other || mark === null ? null : first.rowTime(mark);
    this.runs.forEach((run, k) => { this.rowTimes[k].textContent = timeWords(at[k] - run.shift); });
    get("values").className = this.runs.length > 2 ? "alone many" : this.runs.length < 2 && mark === null ? "alone" : "";
    this.rowApart.textContent = before === null ? "" : shortNumber(at[0] - before);
    const shown = [];
    for (const {column, values, apart, unit} of this.cells) {
      const show = (cell, reading) => {
        shown.push(reading);
        cell.textContent = readingWords(reading, column, si);
      };
      const here = this.runs.map((run, k) => run.reading(column.name, at[k]));
      here.forEach((reading, k) => show(values[k], reading));
      show(apart, other ? other.reading(column.name, at[0]).above(here[0])
        : before === null ? NOTHING : here[0].above(first.reading(column.name, before)));
      unit.textContent = si ? column.si : column.unit;
    }
    get("between").hidden = shown.every(reading => reading.exact || reading.unknown);
  }
}
