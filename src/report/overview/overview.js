// Draws the charts of the page from the tables that it carries: dots with intervals, strips of all values, lines with bands, and
// points of a plane. Every mark has its values on hover and on the arrow keys.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const SVG = "http://www.w3.org/2000/svg";
  const MARKERS = ["circle", "square", "diamond", "triangle", "cross", "plus"];
  const label = (text) => data.labels[text] ?? String(text).replaceAll("_", " ");

  // ---- tables

  const cell = (column, row) => Array.isArray(column) ? column[row] : column.levels[column.codes[row]];

  function rowsOf(table) {
    const columns = Object.entries(table.columns);
    const first = columns[0]?.[1];
    const count = !first ? 0 : Array.isArray(first) ? first.length : first.codes.length;
    return Array.from({ length: count }, (_, row) => Object.fromEntries(columns.map(([name, column]) => [name, cell(column, row)])));
  }

  const distinct = (values) => [...new Set(values)];

  // A cell in words: numbers with their unit, which ends the name of their column.
  function shownValue(column, value) {
    if (typeof value !== "number") return label(value);
    const plain = (size) => String(+size.toPrecision(6)).replace("-", "−");
    const [scale, unit] = unitOf(column);
    return unit ? `${plain(scale * value)} ${unit}` : plain(value);
  }

  function unitOf(column) {
    const units = { m: [1e3, "mm"], s: [1, "s"], hz: [1, "Hz"], n: [1, "N"] };
    return units[/(?<!per|samples)_(m|s|hz|n)$/.exec(column)?.[1]] ?? [1, ""];
  }

  // Rows in the order of their numbers where a category is one; texts keep the order of their first rows.
  function sorted(rows, columns) {
    if (!columns.some((column) => rows.some((row) => typeof row[column] === "number"))) return rows;
    const places = columns.map((column) => {
      const values = distinct(rows.map((row) => row[column]));
      if (values.every((value) => typeof value === "number")) values.sort((a, b) => a - b);
      return new Map(values.map((value, place) => [value, place]));
    });
    const order = (row) => columns.map((column, k) => places[k].get(row[column]));
    return rows.map((row) => [order(row), row]).sort(([a], [b]) => {
      const k = a.findIndex((place, index) => place !== b[index]);
      return k < 0 ? 0 : a[k] - b[k];
    }).map(([, row]) => row);
  }

  // ---- small helpers

  function node(name, attributes, parent, text) {
    const made = name === name.toLowerCase() && ["svg", "g", "path", "line", "circle", "text", "rect", "title"].includes(name)
      ? document.createElementNS(SVG, name) : document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    parent?.append(made);
    return made;
  }

  const number = (value) => {
    if (value === null || value === undefined) return "–";
    const size = Math.abs(value);
    const digits = size === 0 ? 0 : Math.min(4, Math.max(0, 2 - Math.floor(Math.log10(size))));
    return value.toFixed(digits).replace("-", "−");
  };

  const tickText = (value) => String(value).replace("-", "−");

  function ticks(low, high, wanted) {
    const step = 10 ** Math.floor(Math.log10((high - low) / wanted));
    const nice = [1, 2, 5, 10].map((factor) => factor * step).find((size) => (high - low) / size <= wanted) ?? 10 * step;
    const all = [];
    for (let k = Math.ceil(low / nice - 1e-9); k * nice <= high + 1e-9 * nice; k++) all.push(+(k * nice).toPrecision(12));
    return all;
  }

  function logTicks(low, high) {
    const all = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power++)
      for (const factor of [1, 2, 5]) {
        const value = factor * 10 ** power;
        if (value >= low * 0.999 && value <= high * 1.001) all.push(+value.toPrecision(6));
      }
    return all;
  }

  // A scale from values to pixels, with its ticks.
  function scaleOf(values, axis, from, to) {
    const finite = values.filter((value) => Number.isFinite(value) && (!axis.log || value > 0));
    let [low, high] = [Math.min(...finite), Math.max(...finite)];
    if (!finite.length) [low, high] = [axis.log ? 1 : 0, axis.log ? 10 : 1];
    if (axis.zero) [low, high] = [Math.min(0, low), Math.max(0, high)];
    if (axis.log) {
      [low, high] = [low / 1.15, high * 1.15];
      const place = (value) => from + (to - from) * Math.log(value / low) / Math.log(high / low);
      return { place, ticks: logTicks(low, high) };
    }
    if (high === low) high = low + 1;
    const room = 0.04 * (high - low);
    if (!(axis.zero && low === 0)) low -= room;
    high += room;
    return { place: (value) => from + (to - from) * (value - low) / (high - low), ticks: ticks(low, high, Math.abs(to - from) < 260 ? 4 : 7) };
  }

  function marker(kind, x, y, size) {
    const s = size;
    switch (kind) {
      case "square": return `M${x - s} ${y - s}h${2 * s}v${2 * s}h${-2 * s}z`;
      case "diamond": return `M${x} ${y - 1.3 * s}l${1.3 * s} ${1.3 * s}l${-1.3 * s} ${1.3 * s}l${-1.3 * s} ${-1.3 * s}z`;
      case "triangle": return `M${x} ${y - 1.2 * s}l${1.2 * s} ${2.1 * s}h${-2.4 * s}z`;
      case "cross": return `M${x - s} ${y - s}l${2 * s} ${2 * s}M${x + s} ${y - s}l${-2 * s} ${2 * s}`;
      case "plus": return `M${x - 1.2 * s} ${y}h${2.4 * s}M${x} ${y - 1.2 * s}v${2.4 * s}`;
      default: return `M${x - s} ${y}a${s} ${s} 0 1 0 ${2 * s} 0a${s} ${s} 0 1 0 ${-2 * s} 0z`;
    }
  }

  // ---- a chart and its controls

  class Chart {
    constructor(figure) {
      this.figure = figure;
      this.spec = data.charts[+figure.dataset.chart];
      this.rows = sorted(rowsOf(data.tables[this.spec.table]), this.spec.category);
      this.chosen = Object.fromEntries(this.spec.facets);
      this.hidden = new Set();
      this.controls = node("div", { class: "controls" });
      this.legend = node("div", { class: "legend", role: "group", "aria-label": "Series" });
      this.plot = node("div", { class: "plot" });
      this.tip = node("div", { class: "tip", role: "status", hidden: "" });
      this.selection = node("p", { class: "selection" });
      figure.querySelector("figcaption").before(this.controls, this.selection, this.legend, this.plot);
      this.plot.after(this.tip);
      this.numbers = node("details", { class: "numbers" }, figure);
      node("summary", {}, this.numbers, "Numbers as a table");
      this.numbers.addEventListener("toggle", () => this.numbers.open && this.tabulate());
      this.width = 0;
      new ResizeObserver(() => {
        const width = Math.round(this.plot.clientWidth);
        if (width && width !== this.width) { this.width = width; this.draw(); }
      }).observe(this.plot);
      this.choices();
    }

    // One group of buttons for every facet that leaves a choice.
    choices() {
      this.buttons = [];
      for (const [column] of this.spec.facets) {
        const values = distinct(this.rows.map((row) => row[column])).filter((value) => value !== "" && value !== null);
        if (values.length < 2) continue;
        // The same order in every chart.
        if (column === "training") values.sort().reverse();
        const group = node("div", { role: "group", "aria-label": column }, this.controls);
        for (const value of values) {
          const button = node("button", { type: "button" }, group, label(value));
          this.buttons.push({ column, value, button });
          button.addEventListener("click", () => {
            this.chosen[column] = value;
            this.settle();
            this.draw();
          });
        }
      }
      this.settle();
    }

    // A facet offers the values that the facets before it leave; a chosen value that is not among them gives way.
    settle() {
      let rows = this.rows;
      for (const [column] of this.spec.facets) {
        const possible = new Set(rows.map((row) => row[column]));
        if (!possible.has(this.chosen[column])) [this.chosen[column]] = possible;
        for (const one of this.buttons.filter((other) => other.column === column)) {
          one.button.disabled = !possible.has(one.value);
          one.button.setAttribute("aria-pressed", one.value === this.chosen[column]);
        }
        rows = rows.filter((row) => row[column] === this.chosen[column]);
      }
    }

    get shown() {
      return this.rows.filter((row) => this.spec.facets.every(([column]) => row[column] === this.chosen[column]));
    }

    // The marks of the chosen rows: series, values and the text of the tip.
    marks() {
      const { x, y, series, category, interval, columns, x_columns: xColumns, paper } = this.spec;
      const value = (row, column, axis) => row[column] === null || row[column] === undefined ? NaN : axis.scale * row[column];
      const of = (row, column, name, xColumn) => {
        const main = y ?? x;
        const mark = {
          row, series: name, category: category.map((key) => shownValue(key, row[key])).join(" · "),
          x: y ? value(row, xColumn ?? x.column, x) : value(row, column, x), y: y ? value(row, column, y) : NaN,
        };
        if (interval) [mark.low, mark.high] = interval.map((key) => value(row, key, main));
        if (paper) mark.paper = value(row, paper, main);
        return mark;
      };
      const main = (y ?? x).column;
      if (!columns.length) return this.shown.map((row) => of(row, main, series ? label(row[series]) : ""));
      return columns.flatMap(([column, name], k) => this.shown.map((row) => of(row, column, name, xColumns[k])));
    }

    draw() {
      if (!this.width) return;
      const marks = this.marks().filter((mark) => Number.isFinite(this.spec.y ? mark.y : mark.x));
      this.names = distinct(marks.map((mark) => mark.series));
      this.drawLegend();
      const visible = marks.filter((mark) => !this.hidden.has(mark.series));
      this.plot.textContent = "";
      this.targets = [];
      const kind = this.spec.kind;
      // Without a visible series the axes stay as they are with all.
      const shape = visible.length ? visible : marks;
      const svg = kind === "dots" || kind === "strips" ? this.drawLanes(shape, visible) : this.drawPlane(shape, visible);
      this.selection.textContent = this.describe();
      svg.setAttribute("tabindex", "0");
      svg.setAttribute("role", "img");
      svg.setAttribute("aria-label", `${this.spec.title}. ${visible.length} values; arrow keys step through them.`);
      this.listen(svg);
      if (this.numbers.open) this.tabulate();
    }

    // What the buttons have selected, for paper.
    describe() {
      const facets = this.spec.facets.map(([column]) => this.chosen[column]).filter((value) => value !== "" && value !== undefined);
      const hidden = this.names.filter((name) => this.hidden.has(name));
      const parts = facets.map(label).concat(hidden.length ? [`not shown: ${hidden.join(", ")}`] : []);
      return parts.length ? `Selected: ${parts.join("; ")}.` : "";
    }

    drawLegend() {
      this.legend.textContent = "";
      if (this.names.length < 2 || (this.spec.kind !== "lines" && this.spec.kind !== "points" && this.byCategory())) return;
      this.names.forEach((name, k) => {
        const button = node("button", { type: "button", "aria-pressed": !this.hidden.has(name) }, this.legend);
        const key = node("svg", { width: 16, height: 12, "aria-hidden": "true" }, button);
        node("path", { d: marker(MARKERS[k % 6], 8, 6, 4), class: `mark s${k % 8}` }, key);
        button.append(name);
        button.addEventListener("click", () => {
          this.hidden.has(name) ? this.hidden.delete(name) : this.hidden.add(name);
          this.draw();
        });
      });
    }

    // Whether series only repeat the categories.
    byCategory() {
      const { series, category, columns } = this.spec;
      return !columns.length && category.length === 1 && category[0] === series;
    }

    canvas(height) {
      return node("svg", { width: this.width, height, viewBox: `0 0 ${this.width} ${height}` }, this.plot);
    }

    xAxis(svg, scale, top, bottom) {
      let free = -Infinity;
      for (const tick of scale.ticks) {
        const [at, text] = [scale.place(tick), tickText(tick)];
        const half = 3.6 * text.length;
        node("line", { x1: at, x2: at, y1: top, y2: bottom, class: "grid" }, svg);
        if (at - half < free || at + half > this.width) continue;
        free = at + half + 6;
        node("text", { x: at, y: bottom + 16, "text-anchor": "middle" }, svg, text);
      }
      node("text", { x: this.width / 2, y: bottom + 34, "text-anchor": "middle", class: "axis" }, svg, this.spec.x.label);
    }

    // Lines of marks, one a category; names above the line.
    drawLanes(marks, visible) {
      const categories = distinct(marks.map((mark) => mark.category));
      const several = this.spec.kind === "dots" && !this.byCategory();
      const lane = (name) => distinct(marks.filter((mark) => mark.category === name).map((mark) => mark.series));
      const heights = categories.map((name) => 20 + (several ? 13 * lane(name).length : 16));
      const total = heights.reduce((sum, height) => sum + height, 0);
      const svg = this.canvas(total + 48);
      const ends = marks.flatMap((mark) => [mark.x, mark.low, mark.high]).filter(Number.isFinite);
      const scale = scaleOf(ends, this.spec.x, 8, this.width - 12);
      this.xAxis(svg, scale, 4, total + 4);
      let top = 4;
      categories.forEach((name, k) => {
        node("text", { x: 4, y: top + 14, class: "name" }, svg, clipped(name, this.width));
        const inside = visible.filter((mark) => mark.category === name);
        const order = lane(name);
        if (this.spec.kind === "strips") inside.length && this.strip(svg, inside, scale, top + 28);
        else for (const mark of inside) this.dot(svg, mark, scale, top + 25 + (several ? 13 * order.indexOf(mark.series) : 0));
        top += heights[k];
      });
      return svg;
    }

    dot(svg, mark, scale, y) {
      const k = this.names.indexOf(mark.series);
      if (Number.isFinite(mark.low) && Number.isFinite(mark.high))
        node("line", { x1: scale.place(mark.low), x2: scale.place(mark.high), y1: y, y2: y, class: `interval s${k % 8}` }, svg);
      node("path", { d: marker(MARKERS[k % 6], scale.place(mark.x), y, 4), class: `mark s${k % 8}` }, svg);
      this.targets.push({ x: scale.place(mark.x), y, mark });
    }

    strip(svg, marks, scale, y) {
      const k = this.names.indexOf(marks[0].series);
      marks.forEach((mark, index) => {
        const shift = marks.length > 30 ? 6 * Math.sin(7.1 * index) : 0;
        node("circle", { cx: scale.place(mark.x), cy: y + shift, r: marks.length > 30 ? 1.7 : 3.2, class: `cloud s${k % 8}` }, svg);
        this.targets.push({ x: scale.place(mark.x), y: y + shift, mark });
      });
      if (marks.length < 5) return;
      const sorted = marks.map((mark) => mark.x).sort((a, b) => a - b);
      const quantile = (share) => scale.place(sorted[Math.round(share * (sorted.length - 1))]);
      node("rect", { x: quantile(0.25), y: y - 8, width: quantile(0.75) - quantile(0.25), height: 16, class: "box" }, svg);
      node("line", { x1: quantile(0.5), x2: quantile(0.5), y1: y - 8, y2: y + 8, class: "median" }, svg);
    }

    drawPlane(marks, visible) {
      const height = Math.round(Math.min(420, 0.72 * this.width) + 52);
      const svg = this.canvas(height);
      const [left, right, top, bottom] = [52, this.width - 12, 18, height - 44];
      const yEnds = marks.flatMap((mark) => [mark.y, mark.low, mark.high, mark.paper]).filter(Number.isFinite);
      const x = scaleOf(marks.map((mark) => mark.x), this.spec.x, left, right);
      const y = scaleOf(yEnds, this.spec.y, bottom, top);
      this.xAxis(svg, x, top, bottom);
      for (const tick of y.ticks) {
        node("line", { x1: left, x2: right, y1: y.place(tick), y2: y.place(tick), class: "grid" }, svg);
        node("text", { x: left - 6, y: y.place(tick) + 4, "text-anchor": "end" }, svg, tickText(tick));
      }
      node("text", { x: 4, y: 11, class: "axis" }, svg, this.spec.y.label);
      this.names.forEach((name, k) => {
        const line = visible.filter((mark) => mark.series === name && Number.isFinite(mark.x));
        if (line.length) this.series(svg, line, k, x, y);
      });
      return svg;
    }

    series(svg, marks, k, x, y) {
      const at = (mark) => `${x.place(mark.x).toFixed(1)} ${y.place(mark.y).toFixed(1)}`;
      const isLine = this.spec.kind === "lines";
      if (isLine) marks.sort((one, other) => one.x - other.x);
      const sparse = marks.length <= 40;
      if (isLine && marks.every((mark) => Number.isFinite(mark.low))) {
        const upper = marks.map((mark) => `${x.place(mark.x)} ${y.place(mark.high)}`);
        const lower = marks.map((mark) => `${x.place(mark.x)} ${y.place(mark.low)}`).reverse();
        node("path", { d: `M${[...upper, ...lower].join("L")}z`, class: `band s${k % 8}` }, svg);
      }
      if (isLine || this.spec.joined) node("path", { d: `M${marks.map(at).join("L")}`, class: `line s${k % 8}` }, svg);
      for (const mark of marks) {
        if (isLine ? sparse : !this.spec.joined)
          node("path", { d: marker(MARKERS[k % 6], x.place(mark.x), y.place(mark.y), sparse ? 4 : 1.6), class: `${sparse ? "mark" : "cloud"} s${k % 8}` }, svg);
        if (Number.isFinite(mark.paper))
          node("path", { d: marker("diamond", x.place(mark.x), y.place(mark.paper), 5), class: `paper s${k % 8}` }, svg);
        this.targets.push({ x: x.place(mark.x), y: y.place(mark.y), mark });
      }
    }

    // ---- values on hover and on the arrow keys

    listen(svg) {
      this.ring = node("circle", { r: 8, class: "ring", visibility: "hidden" }, svg);
      const hide = () => { this.tip.hidden = true; this.ring.setAttribute("visibility", "hidden"); };
      svg.addEventListener("pointermove", (event) => {
        const box = svg.getBoundingClientRect();
        const [px, py] = [event.clientX - box.left, event.clientY - box.top];
        let best = null;
        for (const target of this.targets) {
          const distance = Math.hypot(target.x - px, target.y - py);
          if (distance < (best?.distance ?? 30)) best = { distance, target };
        }
        best ? this.show(best.target) : hide();
      });
      svg.addEventListener("pointerleave", hide);
      svg.addEventListener("blur", hide);
      svg.addEventListener("keydown", (event) => {
        const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
        if (!step || !this.targets.length) return;
        event.preventDefault();
        this.current = ((this.current ?? (step > 0 ? -1 : 0)) + step + this.targets.length) % this.targets.length;
        this.show(this.targets[this.current]);
      });
    }

    show(target) {
      const { mark, x, y } = target;
      const { spec } = this;
      const named = [mark.category, mark.series].filter((text, k, all) => text && all.indexOf(text) === k).join(", ");
      const values = spec.y
        ? `${spec.x.label}: ${number(mark.x)}; ${spec.y.label}: ${number(mark.y)}`
        : `${spec.x.label}: ${number(mark.x)}`;
      const range = Number.isFinite(mark.low) ? ` [${number(mark.low)}, ${number(mark.high)}]` : "";
      const paper = Number.isFinite(mark.paper) ? `; paper: ${number(mark.paper)}` : "";
      this.tip.textContent = `${named ? named + ". " : ""}${values}${range}${paper}`;
      this.tip.hidden = false;
      const width = Math.min(280, this.width);
      this.tip.style.left = `${Math.max(0, Math.min(this.width - width, x - width / 2))}px`;
      this.tip.style.top = `${this.plot.offsetTop + y + 14}px`;
      this.ring.setAttribute("cx", x);
      this.ring.setAttribute("cy", y);
      this.ring.setAttribute("visibility", "visible");
    }

    tabulate() {
      const MOST = 400;
      this.numbers.querySelector("div")?.remove();
      const frame = node("div", { class: "scroll", tabindex: "0" }, this.numbers);
      // What a row is about first.
      const first = [...this.spec.facets.map(([column]) => column), ...this.spec.category, this.spec.series];
      const rest = Object.keys(data.tables[this.spec.table].columns);
      const names = distinct([...first.filter((name) => rest.includes(name)), ...rest]);
      const table = node("table", {}, frame);
      const head = node("tr", {}, node("thead", {}, table));
      for (const name of names) node("th", { scope: "col" }, head, unitOf(name)[1] ? `${name.replace(/_[a-z]+$/, "")} (${unitOf(name)[1]})` : name);
      const body = node("tbody", {}, table);
      for (const row of this.shown.slice(0, MOST)) {
        const line = node("tr", {}, body);
        for (const name of names) node("td", {}, line, inTable(name, row[name]));
      }
      if (this.shown.length > MOST) node("p", { class: "note" }, frame, `The first ${MOST} of ${this.shown.length} rows.`);
    }
  }

  // A cell of a table whose head states the unit.
  function inTable(column, value) {
    if (value === null) return "";
    return typeof value === "number" ? String(+(unitOf(column)[0] * value).toPrecision(6)).replace("-", "−") : String(value);
  }

  // A name that fits into a line of about 6.6 pixels a letter.
  function clipped(name, width) {
    const most = Math.floor((width - 8) / 6.6);
    return name.length > most ? `${name.slice(0, most - 1)}…` : name;
  }

  for (const figure of document.querySelectorAll("figure[data-chart]")) figure.chart = new Chart(figure);

  // ---- claims by verdict

  const filter = document.querySelector(".filter");
  filter?.addEventListener("click", (event) => {
    const chosen = event.target.closest("button");
    if (!chosen) return;
    for (const button of filter.children) button.setAttribute("aria-pressed", button === chosen);
    for (const row of document.querySelectorAll("tr[data-verdicts]"))
      row.hidden = chosen.dataset.verdict !== "all" && !row.dataset.verdicts.split(",").includes(chosen.dataset.verdict);
  });
})();
