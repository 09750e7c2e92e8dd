// Loads scripts of the page into a context with small stubs, and answers the question that comes as JSON by standard
// input: {scripts: [path], task, ...}. The answer is JSON too.
"use strict";
const fs = require("node:fs");
const vm = require("node:vm");

const NO_PAGE = "there is no page here";

// What the scripts see of a browser. There is no document: page.js stops where it would open its page.
function sandbox() {
  const document = {getElementById() { throw new Error(NO_PAGE); }};
  return vm.createContext({atob, Blob, DecompressionStream, Response, URLSearchParams, document, location: {hash: ""}});
}

function load(context, scripts) {
  for (const path of scripts) {
    try {
      vm.runInContext(fs.readFileSync(path, "utf8"), context, {filename: path});
    } catch (error) {
      if (error.message !== NO_PAGE) throw error;
    }
  }
}

// What a page with these runs, at time t, does when its address has the fragment.
async function follow(context, {runs, t, fragments}) {
  const Address = vm.runInContext("Address", context), answers = [];
  for (const fragment of fragments) {
    context.location.hash = fragment;
    const said = {}, page = {
      facts: {runs}, t, shown: runs.map(run => run.shown), pause() {}, showRuns() {}, opening: () => 7e-3,
      go(time) { said.time = time; }, look(view) { said.view = view; },
    };
    await new Address(page).follow();
    answers.push({...said, shown: page.facts.runs.filter((_, k) => page.shown[k]).map(run => run.name)});
  }
  return answers;
}

// The fragments by which a page links to moments.
function link(context, {moments}) {
  const address = new (vm.runInContext("Address", context))({});
  return moments.map(({t, names, view}) => address.link(t, names, view));
}

// What is known of columns at some times, as [low, high]: of a run, {facts, body}, or of the difference of two.
async function read(context, {runs, names, times}) {
  const [Run, readRun] = ["Run", "readRun"].map(name => vm.runInContext(name, context));
  const [first, other] = await Promise.all(runs.map(async ({facts, body}, k) =>
    new Run(facts, k, await readRun(facts.index, body))));
  const readings = name => times.map(t =>
    other ? other.reading(name, t).above(first.reading(name, t)) : first.reading(name, t));
  return Object.fromEntries(names.map(name => [name, readings(name).map(({low, high}) => [low, high])]));
}

// Readings in words.
function say(context, {readings}) {
  const [Reading, words] = ["Reading", "readingWords"].map(name => vm.runInContext(name, context));
  return readings.map(([low, high]) => words(new Reading(low, high), {scale: 1}));
}

// Numbers in words by functions of number_text.js: `calls` are of its function, a number as JSON or text has it, and options.
function write(context, {calls}) {
  return calls.map(([name, x, options]) => vm.runInContext(name, context)(x === null ? null : Number(x), options));
}

// What lists of words have in common, for an axis.
function common(context, {lists}) { return lists.map(vm.runInContext("commonWords", context)); }

// The names of the contacts.
function contacts(context) { return vm.runInContext("CONTACTS", context); }

async function main() {
  const question = JSON.parse(fs.readFileSync(0, "utf8")), context = sandbox();
  load(context, question.scripts);
  process.stdout.write(JSON.stringify(await {common, contacts, follow, link, read, say, write}[question.task](context, question)));
}

main();
