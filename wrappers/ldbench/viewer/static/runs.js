// The runs of the page: which are shown, what is known of them, and the summary of all.

function drawChoice(page) {
  const {runs} = page.facts, several = new Set(runs.map(run => run.model)).size > 1;
  get("runs").hidden = runs.length < 2;
  get("align").parentElement.hidden = page.runs.length < 2;
  get("runs").replaceChildren(...runs.map((run, k) => {
    const box = make("input", {type: "checkbox", checked: page.shown[k], onchange: () => {
      page.shown[k] = box.checked;
      if (!page.shown.includes(true)) page.shown[k] = true;
      page.showRuns(page.window[0] > page.start || page.window[1] < page.end).then(() => page.write());
    }});
    const look = {number: k}, name = run.name + (run.model && several ? `, ${run.model}` : "");
    return make("label", {}, box, swatch({colour: page.colour.run(look), dash: page.colour.dash(look), width: 2.2}),
                make("span", {title: run.file}, name));
  }));
}

// What is known of the runs that are shown; of more than two, one click away.
function drawAbout({runs}) {
  get("about").replaceChildren(...runs.map(run => {
    const words = [run.file, run.title, run.model && `normal contact: ${run.model}`, ...run.profiles,
      run.rows > run.t.length && `${run.rows} rows, ${run.t.length} of them kept to the last digit; of the others displacements `
        + "and normal forces, and of every column the least and largest value",
      ...unlistedWords(run), run.ending && `ended: ${run.ending}`, ...run.notes].filter(Boolean);
    return make("details", {open: runs.length < 3}, make("summary", {}, run.heading),
                make("ul", {}, ...words.map(text => make("li", {}, text))), ...namelist(run));
  }));
}

// The input of a run, which can be run again.
function namelist(run) {
  if (!run.namelist) return [];
  const button = make("button", {type: "button", onclick: () =>
    save(`${run.name}.nml`, new Blob([run.namelist], {type: "text/plain"}))}, "save");
  return [make("details", {class: "namelist"}, make("summary", {}, `namelist of ${run.name}`), button,
               make("pre", {}, run.namelist))];
}

function drawSummary({facts: {summary, note, runs}, address}) {
  get("summary").hidden = !summary.length;
  if (!summary.length) return;
  const cell = ({text, run, t, with: others}) => make("td", {}, t === null ? text
    : make("a", {href: address.link(t, [run, ...others]), onclick: () => get("runs").scrollIntoView()}, text));
  const heads = runs.slice(0, summary[0].cells.length).map(run =>
    make("th", {}, make("a", {href: address.link(0, [run.name])}, run.name)));
  const body = summary.map(row => make("tr", {}, make("th", {scope: "row"}, row.words), ...row.cells.map(cell)));
  get("summary").replaceChildren(make("details", {open: window.innerWidth > 860},
    make("summary", {}, "Summary; a number opens its moment"), make("p", {class: "small"}, note),
    make("table", {}, make("thead", {}, make("tr", {}, make("th", {}, "runs"), ...heads)), make("tbody", {}, ...body))));
}

// How much later each run is shown, so that the first flange contacts of all runs come together.
function alignment(runs) {
  const [first] = runs.map(run => run.firstFlange), known = first !== null && first !== undefined;
  return runs.map(run => known && Number.isFinite(run.firstFlange) ? first - run.firstFlange : 0);
}
