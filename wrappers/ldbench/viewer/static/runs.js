// The runs of the page: which are shown, what is known of them, and the summary of all.

class RunList {
  constructor(page) {
    this.page = page;
  }

  drawChoice() {
    const {page} = this, {runs} = page.facts, nav = get("runs");
    const several = new Set(runs.map(run => run.model)).size > 1;
    nav.hidden = runs.length < 2;
    get("align").parentElement.hidden = page.runs.length < 2;
    nav.replaceChildren(...runs.map((run, k) => {
      const box = make("input", {type: "checkbox", checked: page.shown[k]});
      box.onchange = () => {
        page.shown[k] = box.checked;
        if (!page.shown.includes(true)) page.shown[k] = true;
        const zoomed = page.window[0] > page.start || page.window[1] < page.end;
        page.showRuns(zoomed).then(() => page.write());
      };
      const look = {number: k}, model = run.model && several ? `, ${run.model}` : "";
      return make("label", {}, box, swatch(page.colour.run(look), page.colour.dash(look), 2.2),
                  make("span", {title: run.file}, run.name + model));
    }));
  }

  drawAbout() {
    get("about").replaceChildren(...this.page.runs.flatMap(run => [make("dl", {},
      make("dt", {}, run.heading),
      ...[run.file, run.title, run.model && `normal contact: ${run.model}`, ...run.profiles,
          run.rows > run.t.length && `${run.rows} rows, ${run.t.length} of them kept to the last digit; of the others `
            + "displacements and normal forces, and of every column the least and largest value",
          ...unlistedWords(run), run.ending && `ended: ${run.ending}`, ...run.notes].filter(Boolean)
        .map(text => make("dd", {}, text))), this.namelist(run)].filter(Boolean)));
  }

  // The input of a run, which can be run again.
  namelist(run) {
    return run.namelist && make("details", {class: "namelist"}, make("summary", {}, `namelist of ${run.name}`),
      make("button", {type: "button", onclick: () => save(`${run.name}.nml`, new Blob([run.namelist], {type: "text/plain"}))},
           "save"), make("pre", {}, run.namelist));
  }

  drawSummary() {
    const {page} = this, {summary} = page.facts;
    get("summary").hidden = !summary.length;
    if (!summary.length) return;
    const cell = ({text, run, t, with: others, leaning}) => make("td", leaning ? {class: "leaning"} : {}, t === null ? text
      : make("a", {href: page.address.link(t, [run, ...others]), onclick: () => get("runs").scrollIntoView()}, text));
    const head = make("tr", {}, make("th", {}, "runs"), ...page.facts.runs.slice(0, summary[0].cells.length).map(run =>
      make("th", {}, make("a", {href: page.address.link(0, [run.name])}, run.name))));
    const body = summary.map(row => make("tr", {}, make("th", {scope: "row"}, row.words), ...row.cells.map(cell)));
    get("summary").replaceChildren(make("details", {open: window.innerWidth > 860},
      make("summary", {}, "Summary; a number opens its moment"),
      make("p", {class: "small"}, page.facts.note),
      make("table", {}, make("thead", {}, head), make("tbody", {}, ...body))));
  }
}

// How much later each run is shown, so that the first flange contacts of all runs come together.
function alignment(runs) {
  const [first] = runs.map(run => run.firstFlange), known = first !== null && first !== undefined;
  return runs.map(run => known && Number.isFinite(run.firstFlange) ? first - run.firstFlange : 0);
}
