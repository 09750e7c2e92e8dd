// Columns that are made of other columns: forces of a wheel, L/V, and sums, differences, products and ratios of any two.
// For a long run, page.py adds the bands of forces of a wheel and of L/V over all rows.

const DERIVED_GROUP = "derived";
const OPERATIONS = {
  "+": (a, b) => a + b, "-": (a, b) => a - b, "*": (a, b) => a * b, "/": (a, b) => b === 0 ? NaN : a / b,
};
const LONGEST = 200;            // characters of a name in an expression
const SIGNS = {"+": "+", "-": "−", "*": "·", "/": "/"};

// Forces of the rail on the wheel. L is positive where the wheel presses its rail outwards. Python: lateral_over_vertical.
function standardDerived() {
  const found = [], sum = (...forces) => forces.reduce((a, b) => a + b);
  const force = (name, words, from) => ({name, words, unit: "kN", si: "N", scale: 1e-3, from, rule: sum});
  for (const [side, words, outwards] of [["L", "left wheel", -1], ["R", "right wheel", 1]]) {
    const of = kind => [`${kind}_${side}T`, `${kind}_${side}F`], forces = [...of("Fy"), ...of("Fz")];
    found.push({name: `LV_${side}`, words: `L/V, ${words}`, unit: "", si: "1", scale: 1, from: forces,
                rule: (yt, yf, zt, zf) => zt + zf > 0 ? outwards * (yt + yf) / (zt + zf) : NaN},
               force(`Fz_${side}`, `vertical force, ${words}`, of("Fz")), force(`Fy_${side}`, `lateral force, ${words}`, of("Fy")));
  }
  for (const [kind, words] of [["Fz", "vertical force"], ["Fy", "lateral force"]])
    found.push(force(kind + "_sum", `${words}, all contacts`, CONTACTS.map(c => `${kind}_${c}`)));
  return found;
}

function addDerived(run) {
  for (const {from, rule, ...column} of standardDerived())
    if (!run.has(column.name) && from.every(name => run.has(name))) addColumn(run, column, from, rule);
}

// The column of an expression such as `N_LF+N_RF`, made when it is first asked for; undefined if it is none.
function addExpression(run, name) {
  for (let k = 1; k < Math.min(name.length - 1, LONGEST); k++) {
    const operation = OPERATIONS[name[k]], a = run.known.get(name.slice(0, k)), b = run.known.get(name.slice(k + 1));
    const product = name[k] === "*", ratio = name[k] === "/";
    if (!operation || !a || !b) continue;
    if (!product && !ratio && (a.unit !== b.unit || a.scale !== b.scale)) continue;      // sums and differences need one unit
    const unit = product ? [a.unit, b.unit].filter(Boolean).join("·") : !ratio ? a.unit
      : a.unit === b.unit ? "" : `${a.unit || "1"}/${b.unit}`.replace(/\/$/, "");
    const si = product ? `${a.si}.${b.si}` : !ratio ? a.si : a.si === b.si ? "1" : `${a.si}/${b.si}`;
    const scale = product ? a.scale * b.scale : ratio ? a.scale / b.scale : a.scale;
    const column = {name, words: `${a.words} ${SIGNS[name[k]]} ${b.words}`, unit, si, scale};
    return addColumn(run, column, [a.name, b.name], operation);
  }
  return undefined;
}

function addColumn(run, facts, from, rule) {
  const combined = series => Float64Array.from(series[0], (_, i) => rule(...series.map(x => x[i])));
  const column = {...facts, group: DERIVED_GROUP};
  // Values are computed when they are first needed.
  const later = (holder, series) => {
    let made = null;
    Object.defineProperty(holder, column.name, {get: () => made ??= combined(series()), configurable: true});
  };
  later(run.exact, () => from.map(name => run.exact[name]));
  if (from.every(name => run.tracks[name])) later(run.tracks, () => from.map(name => run.tracks[name]));
  run.known.set(column.name, column);
  return column;
}
