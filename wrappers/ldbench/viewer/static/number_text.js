// Numbers as a reader sees them: what number_text.py writes, for the pages.

const LEAST = 1e-4, MOST = 1e7;     // sizes below and from which a power of ten stands
const DIGITS = 4;                   // of a number of which nothing else is asked
const UNKNOWN = "–";
const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const ALL = 100;                    // decimals that JavaScript can write, which show whether a number is a tie

// A number; a dash for null, NaN and infinity. decimals: so many behind the point. digits: so many significant digits, and all those
// before the point. With both, so many significant digits and at most so many decimals; with neither, four significant digits.
// sign: a plus stands before a number above zero. trim: no zeros stand at the end.
function numberText(x, {decimals = null, digits = null, sign = false, trim = false} = {}) {
  if (!Number.isFinite(x)) return UNKNOWN;
  const size = Math.abs(x), known = decimalsOf(size, digits ?? DIGITS);
  let words;
  if (size >= MOST || (decimals === null && size > 0 && size < LEAST)) words = scientific(size, (digits ?? DIGITS) - 1);
  else {
    words = fixed(size, decimals === null ? known : digits === null ? decimals : Math.min(known, decimals));
    if (trim) words = trimmed(words);
  }
  const before = x < 0 ? "−" : sign ? "+" : "";
  return (/[1-9]/.test(words) ? before : "") + words;
}

// How many decimals a number has that is written in so many significant digits; at least 0.
function decimalsOf(x, digits) {
  return x ? Math.max(digits - 1 - Number(x.toExponential(digits - 1).split("e")[1]), 0) : 0;
}

// JavaScript rounds a tie up, Python to the even digit: `rounded` has so many decimals, `exact` has all.
function evenly(rounded, exact, decimals) {
  const end = exact.length - ALL + decimals, kept = exact.slice(0, end);
  return /[02468]\.?$/.test(kept) && /^50*$/.test(exact.slice(end)) ? kept.replace(/\.$/, "") : rounded;
}

function fixed(size, decimals) { return evenly(size.toFixed(decimals), size.toFixed(ALL), decimals); }

// A number without zeros at the end.
function trimmed(words) { return words.includes(".") ? words.replace(/\.?0+$/, "") : words; }

// A number with a power of ten and at most so many decimals: 1.3·10⁻¹².
function scientific(x, decimals = 1) {
  if (!x) return "0";
  const size = Math.abs(x), [rounded, exponent] = size.toExponential(decimals).split("e");
  const mantissa = trimmed(evenly(rounded, size.toExponential(ALL).split("e")[0], decimals));
  const power = `10${exponent.replace("+", "").replace("-", "⁻").replace(/\d/g, digit => SUPERSCRIPTS[digit])}`;
  return (x < 0 ? "−" : "") + (mantissa === "1" ? power : `${mantissa}·${power}`);
}

// A number of which so many digits are known, without zeros at the end.
function shortNumber(x, digits = 7) { return numberText(Number(x.toPrecision(digits)), {digits, trim: true}); }

// A share in percent with two significant digits and at most so many decimals: 0.05 %, 1.2 %, 12 %.
function percentText(share, {decimals = 2, sign = false} = {}) {
  const words = share === null ? UNKNOWN : numberText(100 * share, {decimals, digits: 2, sign});
  return words === UNKNOWN ? words : `${/[1-9]/.test(words) ? words : "0"} %`;
}

// A pressure [Pa] in whole MPa.
function pressureText(p) { return `${numberText(1e-6 * p, {decimals: 0})} MPa`; }

// A force [N] in kN, in three digits and at most one decimal.
function forceText(force) { return `${numberText(1e-3 * force, {decimals: 1, digits: 3})} kN`; }
