// The state of the page in its address, so that a link opens what one sees.

// What an address says of a box to tick or of a menu where it is not as at first, and what sets it.
const tick = id => [() => get(id).checked !== get(id).defaultChecked && String(Number(get(id).checked)), (page, words) => {
  get(id).checked = words !== "0";
  get(id).onchange();
}];
const factor = id => [() => get(id).value !== "1" && get(id).value, (page, words) => {
  if (!EXAGGERATIONS.includes(Number(words))) return;
  get(id).value = words;
  get(id).onchange();
}];

// The state of the page besides time, runs, view and charts: what an address says of it, and what is done then. Words that make
// no sense are passed over.
const STATE = {
  align: tick("align"),
  w: [page => !page.shows(...page.stretch) && page.window.map(t => +t.toPrecision(10)).join(","),
      (page, words) => {
        const [from, to] = numbers(words, 2) ?? [];
        if (to > from) page.setWindow(from, to - from);
      }],
  mark: [({mark}) => mark !== null && String(+mark.toPrecision(9)),
         (page, words) => { if (numbers(words, 1)) page.setMark(Number(words)); }],
  displacement: factor("exaggerate-displacement"), roll: factor("exaggerate-roll"), gap: factor("exaggerate-gap"),
  follow: tick("follow"), arrows: tick("arrows"), normals: tick("normals"), digits: tick("digits"),
  cam: [({scene: {moved, camera: {y, z, width, height}}}) => moved && [y, z, width, height].map(v => +v.toPrecision(6)).join(","),
        (page, words) => {
          const [y, z, width, height] = numbers(words, 4) ?? [];
          if (width > 0 && height > 0) page.show({y, z, width, height});
        }],
  loop: [({player}) => player.looping && "1", ({player}, words) => player.loop(words !== "0")],
  speed: [({player}) => player.chosen && String(player.speed), ({player}, words) => player.choose(Number(words))],
};

class Address {
  constructor(page) {
    this.page = page;
  }

  read() { return new URLSearchParams(location.hash.slice(1)); }

  // A link to a moment of some runs, or to their first flange contact where t is null; everything else stays as it is.
  link(t, names = [], view = "whole") {
    const [run, ...others] = names.map(encodeURIComponent);
    return "#" + [t !== null && `t=${+t.toPrecision(9)}`, run !== undefined && `run=${run}`, ...others.map(name => `with=${name}`),
                  view !== "whole" && `view=${view}`].filter(Boolean).join("&");
  }

  // The runs that the address names, or those that are shown at first.
  named() {
    const {runs} = this.page.facts, link = this.read(), names = [link.get("run"), ...link.getAll("with")];
    const found = runs.map(run => names.includes(run.name));
    return found.includes(true) ? found : runs.map(run => run.shown);
  }

  async follow() {
    const {page} = this, link = this.read(), t = Number.parseFloat(link.get("t")), wanted = this.named();
    if (link.toString() === this.written) return;
    if (wanted.some((shown, k) => shown !== page.shown[k])) {
      page.pause();
      page.shown = wanted;
      await page.showRuns();
    }
    if (link.has("run") && !link.has("t")) page.go(page.opening());
    if (VIEWS.includes(link.get("view"))) page.look(link.get("view"));
    const charts = link.getAll("c").map(chartOf).filter(Boolean);
    if (charts.length) page.replaceCharts(charts);
    for (const [key, [, take]] of Object.entries(STATE)) if (link.has(key)) take(page, link.get(key));
    if (Number.isFinite(t) && Math.abs(t - page.t) > 1e-12) {
      page.pause();
      page.go(t);
    }
  }

  // The whole state; what is as at first is left out.
  full() {
    const {page} = this, more = new URLSearchParams();
    const asAtFirst = page.facts.runs.every((run, k) => run.shown === page.shown[k]);
    const names = asAtFirst && page.shown.every(Boolean) ? [] : page.runs.map(run => run.name);
    for (const [key, [say]] of Object.entries(STATE)) {
      const words = say(page);
      if (words) more.set(key, words);
    }
    const charts = page.charts.map(wordsOfChart);
    if (charts.join("\n") !== page.firstCharts) charts.forEach(words => more.append("c", words));
    const rest = more.toString();
    return this.link(page.t, names, page.scene.view) + (rest && `&${rest}`);
  }

  // The address does not change at every step: a browser refuses too many changes.
  write() {
    clearTimeout(this.writing);
    this.writing = setTimeout(() => {
      try {
        const words = this.full();
        history.replaceState(null, "", words);
        this.written = new URLSearchParams(words.slice(1)).toString();
      } catch {
        // a frame in a notebook has no address
      }
    }, 250);
  }
}

// So many numbers, separated by commas; null if they are not.
function numbers(words, count) {
  const found = (words ?? "").split(",").map(word => word.trim() ? Number(word) : NaN);
  return found.length === count && found.every(Number.isFinite) ? found : null;
}

// A chart in words: `N_LF,N_RF;d;x:Y;log;y:0:5;across:1:2`. Names are encoded, so that they hold no comma, colon or semicolon.
function wordsOfChart({names, mode, over, log, limits, acrossLimits}) {
  const both = (key, ends) => ends && `${key}:${ends.map(v => +v.toPrecision(7)).join(":")}`;
  return [names.map(encodeURIComponent).join(","), mode === "difference" && "d", over && `x:${encodeURIComponent(over)}`,
          log && "log", both("y", limits), over && both("across", acrossLimits)].filter(Boolean).join(";");
}

function chartOf(words) {
  const [names, ...more] = words.split(";"), found = {names: names.split(",").map(decoded).filter(Boolean)};
  for (const word of more) {
    const [key, ...values] = word.split(":");
    if (key === "d") found.mode = "difference";
    if (key === "log") found.log = true;
    if (key === "x") found.over = decoded(values[0] ?? "");
    const limits = values.map(Number);
    const known = {y: "limits", across: "acrossLimits"}[key];
    if (known && limits.length === 2 && limits[1] > limits[0]) found[known] = limits;
  }
  return found.names.length ? found : null;
}

function decoded(word) {
  try {
    return decodeURIComponent(word);
  } catch {
    return "";
  }
}
