// Columns that are made of other columns: those of derived_columns in page.py, and sums, differences, products and ratios of any
// two.

const DERIVED_GROUP = "derived";
const LONGEST = 200;            // characters of a name in an expression
const SIGNS = {"+": "+", "-": "−", "*": "·", "/": "/"};

// Sums of forces, and ratios of two sums where the divisor is positive; page.py has the limits of them for a long run.
function addDerived(run) {
  const sum = forces => forces.reduce((a, b) => a + b, 0), ratio = (top, bottom) => bottom > 0 ? top / bottom : NaN;
  for (const {of, over, sign, ...column} of run.derived) addColumn(run, column, [...of, ...over], (...forces) =>
    ratio(sign * sum(forces.slice(0, of.length)), over.length ? sum(forces.slice(of.length)) : 1));
}

// The column of an expression such as `N_LF+N_RF`, made when it is first asked for; undefined if it is none.
function addExpression(run, name) {
  for (let k = 1; k < Math.min(name.length - 1, LONGEST); k++) {
    const sign = name[k], a = run.known.get(name.slice(0, k)), b = run.known.get(name.slice(k + 1));
    const product = sign === "*", ratio = sign === "/";
    if (!SIGNS[sign] || !a || !b) continue;
    if (!product && !ratio && (a.unit !== b.unit || a.scale !== b.scale)) continue;      // sums and differences need one unit
    const unit = product ? [a.unit, b.unit].filter(Boolean).join("·") : !ratio ? a.unit
      : a.unit === b.unit ? "" : `${a.unit || "1"}/${b.unit}`.replace(/\/$/, "");
    const si = product ? `${a.si}.${b.si}` : !ratio ? a.si : a.si === b.si ? "1" : `${a.si}/${b.si}`;
    const scale = product ? a.scale * b.scale : ratio ? a.scale / b.scale : a.scale, parts = [a.name, b.name];
    run.made.set(name, {sign, parts});
    return addColumn(run, {name, words: `${a.words} ${SIGNS[sign]} ${b.words}`, unit, si, scale, group: DERIVED_GROUP}, parts,
                     OPERATIONS[sign]);
  }
  return undefined;
}

// Values at the rows that are kept are computed when they are first needed.
function addColumn(run, column, from, rule) {
  let made = null;
  Object.defineProperty(run.exact, column.name, {configurable: true, get: () => made ??= run.t.map((_, i) =>
    rule(...from.map(name => run.exact[name][i])))});
  run.known.set(column.name, column);
  return column;
}
