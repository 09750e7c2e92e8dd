// The choice of a chart's columns: a search, the columns by group, and a column made of two others.

class Picker {
  constructor(panel) {
    this.panel = panel;
    this.search = make("input", {type: "search", placeholder: "search columns", "aria-label": "search columns",
                                 oninput: () => this.filter()});
    this.list = make("div", {class: "columns"});
    this.scroll = make("div", {class: "scroll"}, this.list);
    this.maker = make("div", {class: "maker"});
    this.box = make("div", {class: "picker", hidden: true}, this.search, this.scroll, this.maker);
  }

  // Columns of one unit share a chart; a column of another unit replaces them.
  draw(unit) {
    if (this.box.hidden) return;
    const {panel} = this, {page} = panel, columns = page.chartColumns();
    const made = panel.names.map(name => page.column(name)).filter(column => column && !columns.includes(column));
    drawAgain(this.scroll, () => this.list.replaceChildren(...[...page.facts.groups, DERIVED_GROUP].map(group => {
      const some = [...columns, ...made].filter(column => column.group === group);
      return some.length ? make("fieldset", {}, make("legend", {}, group), ...some.map(column => {
        const box = make("input", {type: "checkbox", checked: panel.names.includes(column.name), "data-key": column.name,
                                   onchange: () => panel.show(!box.checked ? panel.names.filter(name => name !== column.name)
                                     : column.unit === unit ? [...panel.names, column.name] : [column.name])});
        return make("label", {"data-words": `${column.words} ${column.name} ${group}`.toLowerCase()}, box,
                    column.unit ? `${column.words} [${column.unit}]` : column.words);
      })) : "";
    })));
    this.drawMaker(columns);
    this.filter();
  }

  filter() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const label of this.list.querySelectorAll("label"))
      label.hidden = !words.every(word => label.dataset.words.includes(word));
    for (const group of this.list.children) group.hidden = !group.querySelector("label:not([hidden])");
  }

  // Two columns and a sign make a third one.
  drawMaker(columns) {
    const names = columns.map(({name, words}) => [name, words]);
    const a = select("first column", names), b = select("second column", names), sign = select("sign", Object.entries(SIGNS));
    const said = make("span", {role: "status"});
    const add = make("button", {type: "button", onclick: () => {
      const name = a.value + sign.value + b.value;
      if (this.panel.page.column(name)) this.panel.show([name]);
      else said.textContent = "a sum and a difference need two columns of one unit";
    }}, "show");
    this.maker.replaceChildren("made of two:", a, sign, b, add, said);
  }
}

// A menu of values and their words.
function select(label, choices) {
  return make("select", {"aria-label": label}, ...choices.map(([value, words]) => make("option", {value}, words)));
}
