// What happened: events that the files list, and contacts and lift-offs that only the rows tell.

// The events of the runs that are shown, in order of time: all of them, and those that the files list.
function gatherEvents(runs) {
  const all = runs.flatMap(run => [...run.events, ...(run.found ??= eventsOfRows(run))].map(event =>
    ({...event, t: event.t + run.shift, run}))).sort((a, b) => a.t - b.t);
  return {all, listed: all.filter(event => !event.fromRows)};
}

// Fill the list of events; what the file does not list is said, too.
function drawEventList(runs, listed) {
  const name = run => runs.length > 1 ? `${run.name}: ` : "", option = (value, words, disabled = false) =>
    make("option", {value, disabled}, words);
  get("events").replaceChildren(option("", listed.length ? "go to …" : "none in the file"),
    ...listed.map((event, k) => option(k, `${timeWords(event.t)} s  ${name(event.run)}${eventWords(event)}`)),
    ...runs.flatMap(run => unlistedWords(run).map(words => option("", name(run) + words, true))));
}

function eventWords({what, force, peak, pressure, fromRows}) {
  if (pressure) return `${what}, ${pressureText(pressure)}`;
  if (peak) return `${what}, ${forceText(peak)}`;
  return (force ? `${what}, lateral force ${forceText(force)}` : what) + (fromRows ? ", by the rows" : "");
}

// Whether an event is the largest force of a contact, or the largest pressure.
function isLargest({peak, pressure}) { return Boolean(peak ?? pressure); }

// How many events of each kind the file does not list.
function unlistedWords(run) {
  return Object.entries(run.unlisted).map(([what, count]) => {
    const reached = (run.found ?? []).some(event => event.what === what);
    return `${count} more of “${what}” that the file does not list${reached ? "; the key e goes to those that rows show" : ""}`;
  });
}

// Contacts of flanges, lift-offs and landings that the file does not list: where forces begin and end.
function eventsOfRows(run) {
  const found = [], series = name => run.has(name) ? run.series(name) : [];
  for (const [side, words] of [["L", "left"], ["R", "right"]]) {
    const [, tread] = series(`N_${side}T`), [t, flange] = series(`N_${side}F`);
    const [contact, liftOff, landing] = ["flange contact", "wheel lift-off", "wheel landing"].map(kind => `${words} ${kind}`);
    if (!t || ![contact, liftOff, landing].some(kind => run.unlisted[kind])) continue;
    const see = (what, i) => {
      const time = t[i] - run.shift, aside = 3 * (t[Math.min(i + 1, t.length - 1)] - t[Math.max(i - 1, 0)]);
      if (run.unlisted[what] && !run.events.some(event => event.what === what && Math.abs(event.t - time) <= aside))
        found.push({t: time, what, force: null, fromRows: true});
    };
    const carried = i => isClosed(flange[i]) || isClosed(tread?.[i] ?? 0);
    for (let i = 1; i < t.length; i++) {
      if (isClosed(flange[i]) && !isClosed(flange[i - 1])) see(contact, i - 1);
      if (tread && carried(i) !== carried(i - 1)) carried(i) ? see(landing, i - 1) : see(liftOff, i);
    }
  }
  return found;
}
