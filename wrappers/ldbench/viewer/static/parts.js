// Small parts of the page: elements, colours, numbers in words.

const get = id => document.getElementById(id);

// Make an element with attributes, properties for `on...` and text or elements inside.
function make(tag, attributes = {}, ...inside) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on") || typeof value === "boolean") element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...inside);
  return element;
}

// Read the colours that the style sheet has now.
class Colours {
  constructor() {
    this.contacts = new Set(["LT", "LF", "RT", "RF"]);
    this.dashes = [[], [7, 3], [8, 3, 2, 3], [2, 2], [], [7, 3], [8, 3, 2, 3], [2, 2]];
    this.known = new Map();
  }

  of(name) {
    if (!this.known.has(name))
      this.known.set(name, getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim());
    return this.known.get(name);
  }

  series(k) { return this.of("series" + k % 8); }

  run(run) { return this.series(run.number); }

  dash(run) { return this.dashes[run.number % 8]; }
}

function timeWords(t) { return t.toFixed(6); }

function shortWords(x, digits = 7) {
  if (Number.isNaN(x)) return "–";
  const far = x !== 0 && (Math.abs(x) < 1e-4 || Math.abs(x) >= 1e7);
  const text = far ? x.toExponential(4) : String(+x.toPrecision(digits));
  return text.replaceAll("-", "−");
}

// Write a number as a column file does: 1.23456789E-03.
function asInFile(x) {
  if (Number.isNaN(x)) return "NaN";
  const [digits, exponent] = x.toExponential(8).split("e");
  return `${digits}E${exponent[0]}${exponent.slice(1).padStart(2, "0")}`;
}

function eventWords({what, force, peak}) {
  if (peak) return `${what}, ${kilonewtons(peak)}`;
  return force ? `${what}, lateral force ${kilonewtons(force)}` : what;
}
