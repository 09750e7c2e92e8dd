// Pictures of lines and letters for a paper: contexts that write as SVG or as PDF what a canvas would draw. Sizes are those of the
// screen, 96 px to the inch. Whatever is drawn while a name is set carries it in SVG: `named({column: "N_LF", unit: "kN"})`.

const DIGITS_ABOVE = "⁰¹²³⁴⁵⁶⁷⁸⁹";

// The part of a canvas context that charts and scene use.
class Vector {
  constructor(w, h) {
    Object.assign(this, {w, h, parts: [], path: [], saved: [], name: {}, font: "11px"});
    Object.assign(this, {state: {at: [1, 0, 0, 1, 0, 0], clip: null, alpha: 1}, lineWidth: 1, dash: []});
    Object.assign(this, {fillStyle: "#000", strokeStyle: "#000", textAlign: "left", textBaseline: "alphabetic"});
  }

  set globalAlpha(alpha) { this.state.alpha = alpha; }

  named(name) { this.name = name ?? {}; }
  setLineDash(dash) { this.dash = dash; }
  beginPath() { this.path = []; }
  moveTo(x, y) { this.path.push(["M", x, y]); }
  lineTo(x, y) { this.path.push([this.path.length ? "L" : "M", x, y]); }
  closePath() { this.path.push(["Z"]); }
  arc(x, y, r) { this.path.push(["O", x, y, r]); }
  rect(x, y, w, h) { this.path.push(["M", x, y], ["L", x + w, y], ["L", x + w, y + h], ["L", x, y + h], ["Z"]); }
  save() { this.saved.push({...this.state}); }
  restore() { this.state = this.saved.pop(); }
  clip() { this.state.clip = {path: this.path, at: this.state.at}; }

  translate(x, y) {
    const [a, b, c, d, e, f] = this.state.at;
    this.state.at = [a, b, c, d, a * x + c * y + e, b * x + d * y + f];
  }

  rotate(angle) {
    const [a, b, c, d, e, f] = this.state.at, cos = Math.cos(angle), sin = Math.sin(angle);
    this.state.at = [a * cos + c * sin, b * cos + d * sin, c * cos - a * sin, d * cos - b * sin, e, f];
  }

  stroke() { if (this.path.length) this.put(this.path, null); }
  fill() { if (this.path.length) this.put(null, this.path); }
  clearRect() {}

  fillRect(x, y, w, h) { this.put(null, [["M", x, y], ["L", x + w, y], ["L", x + w, y + h], ["L", x, y + h], ["Z"]]); }

  get size() { return Number.parseFloat(this.font); }

  measureText(text) { return {width: this.size * textWidth(text)}; }

  fillText(text, x, y) { this.letters(String(text), x, y, false); }
  strokeText(text, x, y) { this.letters(String(text), x, y, true); }

  letters(text, x, y, outlined) {
    this.write(text, x, this.textBaseline === "middle" ? y + 0.35 * this.size : y, outlined);
  }
}

class SvgContext extends Vector {
  put(line, area) {
    const d = pathWords(line ?? area);
    this.element("path", area ? {d, fill: this.fillStyle} : {d, fill: "none", stroke: this.strokeStyle,
      "stroke-width": this.lineWidth, "stroke-dasharray": this.dash.join(" "), "stroke-linejoin": "round"});
  }

  write(text, x, y, outlined) {
    const anchor = {left: "start", center: "middle", right: "end"}[this.textAlign];
    const look = outlined ? {fill: "none", stroke: this.strokeStyle, "stroke-width": this.lineWidth, "stroke-linejoin": "round"}
      : {fill: this.fillStyle};
    this.element("text", {x: short(x), y: short(y), "font-size": this.size, "text-anchor": anchor, ...look}, plain(text));
  }

  element(tag, facts, inside = "") {
    const {at, clip, alpha} = this.state, turned = at.some((v, k) => v !== [1, 0, 0, 1, 0, 0][k]);
    if (clip && !clip.id) {
      clip.id = `clip${this.parts.length}`;
      this.parts.push(`<clipPath id="${clip.id}"><path d="${pathWords(clip.path)}"/></clipPath>`);
    }
    const names = Object.entries(this.name).map(([key, value]) => [`data-${key}`, plain(value)]);
    const all = {...Object.fromEntries(names), ...facts, transform: turned ? `matrix(${at.map(v => +v.toFixed(4)).join(" ")})` : "",
                 "clip-path": clip ? `url(#${clip.id})` : "", opacity: alpha === 1 ? "" : alpha};
    const words = Object.entries(all).filter(([, value]) => value !== "").map(([name, value]) => ` ${name}="${value}"`);
    this.parts.push(`<${tag}${words.join("")}>${inside}</${tag}>`);
  }

  blob() {
    const {w, h} = this;
    return new Blob([`<svg xmlns="http://www.w3.org/2000/svg" width="${w}" height="${h}" viewBox="0 0 ${w} ${h}" `
      + `font-family="Helvetica, Arial, sans-serif">${this.parts.join("\n")}</svg>\n`], {type: "image/svg+xml"});
  }
}

function pathWords(path) {
  return path.map(([kind, x, y, r]) => kind === "Z" ? "z" : kind !== "O" ? `${kind}${short(x)} ${short(y)}`
    : `M${short(x - r)} ${short(y)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`).join("");
}

const ROUND = 0.5523;           // of the radius: how far the handles of four cubics lie that make a circle

// A page of PDF 1.4 with the fonts that every reader has.
class PdfContext extends Vector {
  constructor(w, h) {
    super(w, h);
    this.alphas = [];
  }

  put(line, area) {
    const look = line ? [`${colourNumbers(this.strokeStyle)} RG`, `${short(this.lineWidth)} w 1 j`, `[${this.dash.join(" ")}] 0 d`]
      : [`${colourNumbers(this.fillStyle)} rg`];
    this.group([...look, pathOperators(line ?? area), line ? "S" : "f"]);
  }

  write(text, x, y, outlined) {
    const share = {left: 0, center: 0.5, right: 1}[this.textAlign];
    const look = outlined ? `${colourNumbers(this.strokeStyle)} RG ${short(this.lineWidth)} w 1 j 1 Tr`
      : `${colourNumbers(this.fillStyle)} rg 0 Tr`;
    const start = `1 0 0 -1 ${short(x - share * this.size * textWidth(text))} ${short(y)} Tm`;
    this.group(["BT", look, start, ...pieces(text).map(({font, codes, above}) =>
      `/${font} ${short(this.size * (above ? 0.7 : 1))} Tf ${short(above ? 0.35 * this.size : 0)} Ts <${codes}> Tj`), "ET"]);
  }

  group(operators) {
    const {at, clip, alpha} = this.state, found = ["q"];
    if (clip) found.push("q", `${clip.at.map(v => +v.toFixed(5)).join(" ")} cm`.replace(/^1 0 0 1 0 0 cm$/, ""),
                         pathOperators(clip.path), "W n");
    if (alpha !== 1) {
      if (!this.alphas.includes(alpha)) this.alphas.push(alpha);
      found.push(`/A${this.alphas.indexOf(alpha)} gs`);
    }
    found.push(`${at.map(v => +v.toFixed(5)).join(" ")} cm`, ...operators, "Q", ...clip ? ["Q"] : []);
    this.parts.push(found.filter(Boolean).join("\n"));
  }

  blob() {
    const points = 0.75, [w, h] = [this.w, this.h].map(v => short(points * v));
    const content = `${points} 0 0 ${-points} 0 ${h} cm\n${this.parts.join("\n")}\n`;
    const states = this.alphas.map((alpha, k) => `/A${k} <</CA ${alpha} /ca ${alpha}>>`).join(" ");
    const fonts = [["F", "Helvetica", "/Encoding /WinAnsiEncoding"], ["S", "Symbol", ""]].map(([key, name, more]) =>
      `/${key} <</Type /Font /Subtype /Type1 /BaseFont /${name} ${more}>>`).join(" ");
    const resources = `<</Font <<${fonts}>> /ExtGState <<${states}>>>>`;
    const objects = ["<</Type /Catalog /Pages 2 0 R>>", "<</Type /Pages /Kids [3 0 R] /Count 1>>",
      `<</Type /Page /Parent 2 0 R /MediaBox [0 0 ${w} ${h}] /Contents 4 0 R /Resources ${resources}>>`,
      `<</Length ${content.length}>>\nstream\n${content}endstream`];
    let text = "%PDF-1.4\n";
    const places = objects.map((object, k) => {
      const place = text.length;
      text += `${k + 1} 0 obj\n${object}\nendobj\n`;
      return place;
    });
    const table = places.map(place => `${String(place).padStart(10, "0")} 00000 n \n`).join("");
    const count = objects.length + 1;
    const trailer = `<</Size ${count} /Root 1 0 R>>\nstartxref\n${text.length}\n%%EOF\n`;
    text += `xref\n0 ${count}\n0000000000 65535 f \n${table}trailer\n${trailer}`;
    return new Blob([text], {type: "application/pdf"});       // all of it is ASCII, so that characters are bytes
  }
}

function pathOperators(path) {
  return path.map(([kind, x, y, r]) => {
    if (kind === "Z") return "h";
    if (kind !== "O") return `${short(x)} ${short(y)} ${kind === "M" ? "m" : "l"}`;
    const k = ROUND * r, cubic = (...ends) => `${ends.map(([a, b]) => `${short(x + a)} ${short(y + b)}`).join(" ")} c`;
    return [`${short(x + r)} ${short(y)} m`, cubic([r, k], [k, r], [0, r]), cubic([-k, r], [-r, k], [-r, 0]),
            cubic([-r, -k], [-k, -r], [0, -r]), cubic([k, -r], [r, -k], [r, 0]), "h"].join("\n");
  }).join("\n");
}

// #rgb, #rrggbb or #rrggbbaa as three numbers up to 1.
function colourNumbers(colour) {
  const hex = colour.length < 6 ? [...colour.slice(1)].map(c => c + c) : colour.slice(1).match(/../g);
  return hex.slice(0, 3).map(pair => +(Number.parseInt(pair, 16) / 255).toFixed(3)).join(" ");
}

// Widths of the letters of Helvetica from the space on, and of the signs that the font Symbol has, in thousandths of the size.
const WIDTHS = (
  "278 278 355 556 556 889 667 191 333 333 389 584 278 333 278 278 556 556 556 556 556 556 556 556 556 556 278 278 584 "
  + "584 584 556 1015 667 667 722 722 667 611 778 722 278 500 667 556 833 722 778 667 778 722 667 611 722 667 944 667 667 "
  + "611 278 278 278 469 556 333 556 556 500 556 556 278 556 556 222 222 500 222 833 556 556 556 556 333 500 278 556 500 "
  + "722 500 500 500 334 260 334 584"
).split(" ").map(Number);
const SYMBOLS = {"−": [0x2d, 549], "Δ": [0x44, 612], "Φ": [0x46, 763], "Ω": [0x57, 768], "≈": [0xbb, 549], "→": [0xae, 987],
                 "←": [0xac, 987], "∫": [0xf2, 274]};
const WINDOWS = {"…": 0x85, "–": 0x96, "“": 0x93, "”": 0x94, "’": 0x92};

// A letter as PDF has it: font, code, width, and whether it stands above the line.
function glyph(letter) {
  const code = letter.codePointAt(0), digit = DIGITS_ABOVE.indexOf(letter);
  if (digit >= 0) return {font: "F", code: 0x30 + digit, width: 389, above: true};
  if (letter === "⁻") return {font: "S", code: 0x2d, width: 384, above: true};
  if (SYMBOLS[letter]) return {font: "S", code: SYMBOLS[letter][0], width: SYMBOLS[letter][1], above: false};
  const known = code >= 32 && code < 127 || code >= 160 && code < 256 ? code : WINDOWS[letter] ?? 0x3f;
  return {font: "F", code: known, width: WIDTHS[known - 32] ?? 556, above: false};
}

// Stretches of a text in one font: {font, above, codes}, these in hexadecimal numbers.
function pieces(text) {
  const found = [];
  for (const {font, code, above} of [...text].map(glyph)) {
    if (found.at(-1)?.font !== font || found.at(-1).above !== above) found.push({font, above, codes: ""});
    found.at(-1).codes += code.toString(16).padStart(2, "0");
  }
  return found;
}

// The width of a text over the size of its letters.
function textWidth(text) { return [...text].reduce((sum, letter) => sum + glyph(letter).width, 0) / 1000; }

function short(x) { return +x.toFixed(2); }

function plain(text) {
  return String(text).replace(/[&<>"]/g, mark => `&#${mark.charCodeAt(0)};`).replace(/[^\t\n\r -\ud7ff\ue000-\ufffd]/g, "?");
}
