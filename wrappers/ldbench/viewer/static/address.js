// The state of the page in its address, so that a link opens what one sees.

const FLAGS = ["align", "follow", "loop", "arrows", "plain", "digits"];

class Address {
  constructor(page) {
    this.page = page;
  }

  read() { return new URLSearchParams(location.hash.slice(1)); }

  // A link to a moment of some runs; everything else stays as it is.
  link(t, names = [], view = "whole") {
    const [run, ...others] = names.map(encodeURIComponent);
    return `#t=${+t.toPrecision(9)}` + (run === undefined ? "" : `&run=${run}`)
      + others.map(name => `&with=${name}`).join("") + (view === "whole" ? "" : `&view=${view}`);
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
    if (Object.hasOwn(VIEWS, link.get("view"))) page.look(link.get("view"));
    this.followState(link);
    if (Number.isFinite(t) && Math.abs(t - page.t) > 1e-12) {
      page.pause();
      page.go(t);
    }
  }

  // What else a link says; words that make no sense are passed over.
  followState(link) {
    const {page} = this, pair = numbers(link.get("w"), 2), camera = numbers(link.get("cam"), 4);
    const mark = numbers(link.get("mark"), 1), state = {};
    for (const flag of FLAGS) if (link.has(flag)) state[flag] = link.get(flag) !== "0";
    for (const what of ["displacement", "roll", "gap"]) {
      const factor = Number(link.get(what));
      if (EXAGGERATIONS.includes(factor)) state[what] = factor;
    }
    if (SPEEDS.includes(Number(link.get("speed")))) state.speed = Number(link.get("speed"));
    const charts = link.getAll("c").map(chartOf).filter(Boolean);
    if (charts.length) state.charts = charts;
    if (mark) [state.mark] = mark;
    if (pair && pair[1] > pair[0]) state.window = pair;
    if (camera && camera[2] > 0 && camera[3] > 0) state.camera = camera;
    if (Object.keys(state).length) page.take(state);
  }

  // The whole state; what is as at first is left out.
  full() {
    const {page} = this, {scene, player} = page, more = new URLSearchParams();
    const asAtFirst = page.facts.runs.every((run, k) => run.shown === page.shown[k]);
    const names = asAtFirst && page.shown.every(Boolean) ? [] : page.runs.map(run => run.name);
    const [start, end] = page.window, {settings, camera} = scene, six = x => +x.toPrecision(6);
    if (start > page.start || end < page.end) more.set("w", `${+start.toPrecision(10)},${+end.toPrecision(10)}`);
    if (scene.moved) more.set("cam", [camera.y, camera.z, camera.width / camera.zoom, camera.height / camera.zoom].map(six));
    if (page.mark !== null) more.set("mark", +page.mark.toPrecision(9));
    for (const what of ["displacement", "roll", "gap"]) if (settings[what] !== 1) more.set(what, settings[what]);
    const on = {align: page.aligned, follow: settings.follow, loop: player.looping, arrows: settings.logarithmic,
                plain: !settings.normals, digits: get("digits").checked};
    for (const flag of FLAGS) if (on[flag]) more.set(flag, "1");
    if (player.chosen) more.set("speed", player.speed);
    const charts = page.charts.map(wordsOfChart);
    if (charts.join("\n") !== page.firstCharts) charts.forEach(words => more.append("c", words));
    const rest = more.toString();
    return this.link(page.t, names, scene.view) + (rest && `&${rest}`);
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
