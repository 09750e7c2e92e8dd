// Small parts of the page: elements, colours, numbers in words.

const get = id => document.getElementById(id);

// Make an element with attributes, properties for `on...` and text or elements inside.
function make(tag, attributes = {}, ...inside) {
  const element = setAll(document.createElement(tag), attributes);
  element.append(...inside);
  return element;
}

function setAll(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on") || typeof value === "boolean") element[name] = value;
    else element.setAttribute(name, value);
  }
  return element;
}

// What is drawn until the next name, for pictures that can say so: run, column, contact, side, unit, and the factor from SI to it.
function naming(g, name = {}) { g.named?.(name); }

// Give a canvas as many pixels as its place on the screen has: {g, w, h}, a context in CSS pixels and the size in these.
function prepare(canvas, w = canvas.clientWidth, h = canvas.clientHeight) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2), g = canvas.getContext("2d");
  [canvas.width, canvas.height] = [Math.round(w * ratio), Math.round(h * ratio)];
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  return {g, w, h};
}

// Draw straight lines: [x1, y1, x2, y2].
function strokes(g, ...lines) {
  g.beginPath();
  for (const [x1, y1, x2, y2] of lines) {
    g.moveTo(x1, y1);
    g.lineTo(x2, y2);
  }
  g.stroke();
}

// Draw the inside of an element anew; what had the focus keeps it, and what was scrolled stays there.
function drawAgain(holder, draw) {
  const key = element => element.dataset.key ?? element.getAttribute("aria-label"), {scrollTop} = holder;
  const had = holder.contains(document.activeElement) ? key(document.activeElement) : null;
  draw();
  holder.scrollTop = scrollTop;
  if (had) [...holder.querySelectorAll("button, select, input")].find(one => key(one) === had)?.focus({preventScroll: true});
}

const DASHES = [[], [7, 3], [8, 3, 2, 3], [2, 2]];
const FLANGE_DASHES = {L: [6, 2], R: [2, 2]};
const NEUTRAL = [0, 2, 3, 4, 7];        // series for columns that belong to no side

// The colours that the style sheet has now. Left is blue and right is orange.
class Colours {
  of(name) { return getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim(); }

  // The look of a column that belongs to a contact or to a side; null for others.
  ofColumn({contact, side}) {
    return side ? {colour: this.of(contact || `${side}T`), dash: contact?.[1] === "F" ? FLANGE_DASHES[side] : []} : null;
  }

  neutral(k) { return {colour: this.of("series" + NEUTRAL[k % 5]), dash: DASHES[k % 4]}; }

  run(run) { return this.of("series" + run.number % 8); }

  // The colours come again after eight runs, with other dashes.
  dash({number: k}) { return DASHES[(k + [0, 2, 1, 3][(k >> 3) % 4]) % 4]; }
}

// A stretch of a line as charts draw it.
function swatch({colour, dash, width}) {
  const ns = "http://www.w3.org/2000/svg", picture = document.createElementNS(ns, "svg");
  const stroke = document.createElementNS(ns, "path");
  setAll(picture, {class: "swatch", viewBox: "0 0 26 8", "aria-hidden": "true"});
  setAll(stroke, {d: "M0 4h26", stroke: colour, "stroke-width": width + 0.6, "stroke-dasharray": dash.join(" ")});
  picture.append(stroke);
  return picture;
}

// A time [s] with all decimals of a column file.
function timeWords(t) { return numberText(t, {decimals: 6}); }

// Write a number as a column file does: 1.23456789E-03.
function asInFile(x, digits = 8) {
  if (Number.isNaN(x)) return "NaN";
  const [figures, exponent] = x.toExponential(digits).split("e");
  return `${figures}E${exponent[0]}${exponent.slice(1).padStart(2, "0")}`;
}

// Give a file to the reader.
function save(name, blob) {
  const address = URL.createObjectURL(blob);
  make("a", {href: address, download: name.replace(/[^\w.+-]+/g, "_")}).click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
