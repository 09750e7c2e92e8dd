// The runs of the page: which are shown, what is known of them, and the summary of all.

function drawChoice(page) {
  const {runs} = page.facts, several = new Set(runs.map(run => run.model)).size > 1;
  get("runs").hidden = runs.length < 2;
  get("align").parentElement.hidden = page.runs.length < 2;
  get("runs").replaceChildren(...runs.map((run, k) => {
    const box = make("input", {type: "checkbox", checked: page.shown[k], onchange: () => {
      page.shown[k] = box.checked;
      if (!page.shown.includes(true)) page.shown[k] = true;
      page.showRuns(!page.shows(...page.stretch) && !page.shows(page.start, page.end)).then(() => page.write());
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
  const cell = ({text, run, t, with: others}) => {
    const at = text.indexOf("("), words = at < 0 ? [text] : [text.slice(0, at), make("span", {class: "range"}, text.slice(at))];
    return make("td", {}, ...t === null ? words
      : [make("a", {href: address.link(t, [run, ...others]), onclick: () => get("runs").scrollIntoView()}, ...words)]);
  };
  const heads = runs.slice(0, summary[0].cells.length).map(run =>
    make("th", {}, make("a", {href: address.link(null, [run.name])}, run.name)));
  const body = summary.map(row => make("tr", {}, make("th", {scope: "row"}, row.words), ...row.cells.map(cell)));
  get("summary").replaceChildren(make("details", {open: window.innerWidth > 860},
    make("summary", {}, "Summary; a number opens its moment"), make("p", {class: "small"}, note),
    make("table", {}, make("thead", {}, make("tr", {}, make("th", {}, "runs"), ...heads)), make("tbody", {}, ...body))));
}

const SQUEEZED = 10;            // times the length of the shortest run that a time axis has at most at first

// The time that the axes show at first: the runs that end in it each take a tenth of it or more, which a long run would squeeze.
function commonStretch(runs) {
  const start = Math.min(...runs.map(run => run.start)), ends = runs.map(run => run.end);
  const most = start + SQUEEZED * (Math.min(...ends) - start);
  return [start, Math.max(...ends.filter(end => end <= most))];
}

// Say which runs go on behind the stretch that is shown, with a button for all of the time, and for the stretch again.
function drawBeyond(page) {
  const {runs, stretch: [start, end]} = page, longer = runs.filter(run => run.end > end);
  get("beyond").hidden = !longer.length;
  if (!longer.length) return;
  const words = t => `${numberText(t, {digits: 3})} s`, first = `${start ? `${words(start)} to ` : "first "}${words(end)}`;
  const names = longer.length > 3 ? `${longer.length} runs` : longer.map(run => run.name).join(", ");
  const inside = page.shows(start, end), button = make("button", {type: "button", onclick: () => page.wholeRun()},
                                                       inside ? `all ${words(page.end)}` : first);
  drawAgain(get("beyond"), () => get("beyond").replaceChildren(
    `${runs.length - longer.length} of ${runs.length} runs end in the ${first}; ${names} ${longer.length > 1 ? "go" : "goes"} on `
      + `to ${words(page.end)}. `, button));
}

// Where and when the pressure is largest, with a button that goes there: of each of two runs, or of the run in which it is largest.
function drawHardest(page) {
  const known = page.runs.filter(run => run.hardest).sort((a, b) => b.hardest.p - a.hardest.p);
  const found = page.runs.length > 2 ? known.slice(0, 1) : known;
  get("hardest").hidden = !found.length;
  get("hardest").replaceChildren(...found.map(run => {
    const {t, p, what, y, z} = run.hardest, mm = x => numberText(1e3 * x, {decimals: 3});
    const words = `largest pressure${page.runs.length > 2 ? " of the runs" : ""}: ${page.runs.length > 1 ? `${run.name}, ` : ""}`
      + `${pressureText(p)}, ${what}, at ${timeWords(t)} s, y ${mm(y)} mm, z ${mm(z)} mm`;
    return make("span", {}, `${words} `, make("button", {type: "button", "aria-label": `go to the largest pressure of ${run.name}`,
      onclick: () => {
        page.pause();
        page.go(run.rowTime(t + run.shift));
      }}, "go there"));
  }));
}

// How much later each run is shown, so that the first flange contacts of all runs come together.
function alignment(runs) {
  const [first] = runs.map(run => run.firstFlange), known = first !== null && first !== undefined;
  return runs.map(run => known && Number.isFinite(run.firstFlange) ? first - run.firstFlange : 0);
}
