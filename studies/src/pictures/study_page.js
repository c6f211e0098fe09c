"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const page = document.getElementById("page"), tip = document.getElementById("tip");

  const kSvg = new Set(["svg", "path", "line", "circle", "text"]);
  const make = (parent, name, attributes = {}, text) => {
    const made = kSvg.has(name) ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    parent.append(made);
    return made;
  };
  /// Four digits of a number; what is none as it is.
  const short = (value) => {
    if (typeof value !== "number" || (Number.isInteger(value) && Math.abs(value) < 1e9)) return String(value ?? "-");
    return String(Number(value.toPrecision(4)));
  };
  const spelt = (column) => column.replaceAll("_", " ");
  const distinct = (rows, key) => [...new Set(rows.map((row) => row[key]))];
  const stroke = (index) => ({
    stroke: `var(--s${index % 8})`,
    ...(index < 8 ? {} : { "stroke-dasharray": ["6 2", "2 2", "8 2 2 2"][(Math.floor(index / 8) - 1) % 3] }),
  });

  // ---- The numbers of a row beside the pointer.

  const show_tip = (row, columns, x, y) => {
    const table = document.createElement("table");
    for (const column of columns) {
      const line = make(table, "tr");
      make(line, "th", {}, spelt(column));
      make(line, "td", {}, short(row[column]));
    }
    tip.replaceChildren(table);
    tip.hidden = false;
    const beside = x + 16 + tip.offsetWidth < innerWidth ? x + 16 : x - 16 - tip.offsetWidth;
    tip.style.left = `${Math.max(beside, 4)}px`;
    tip.style.top = `${Math.max(Math.min(y + 14, innerHeight - tip.offsetHeight - 6), 4)}px`;
  };
  const hide_tip = () => { tip.hidden = true; };

  /// Marks are {x, y, row} in the drawing's units. The nearest one to the pointer is told, or that which the arrow keys
  /// went on to.
  const tell_marks = (svg, marks, columns, distance) => {
    if (marks.length === 0) return;
    const ring = make(svg, "circle", { class: "near", r: 4.5, visibility: "hidden" });
    let at = 0;
    const tell = (index, x, y) => {
      at = index;
      const mark = marks[index];
      for (const [key, value] of [["cx", mark.x], ["cy", mark.y], ["visibility", "visible"]]) ring.setAttribute(key, value);
      show_tip(mark.row, columns, x, y);
    };
    const box = () => svg.getBoundingClientRect();
    const leave = () => {
      ring.setAttribute("visibility", "hidden");
      hide_tip();
    };
    const follow = (event) => {
      const { left, top, width } = box();
      const scale = svg.viewBox.baseVal.width / width;
      const x = scale * (event.clientX - left), y = scale * (event.clientY - top);
      let nearest = 0;
      marks.forEach((mark, i) => { if (distance(mark, x, y) < distance(marks[nearest], x, y)) nearest = i; });
      tell(nearest, event.clientX, event.clientY);
    };
    const step = (by) => {
      const index = (at + by + marks.length) % marks.length, { left, top, width } = box();
      const scale = width / svg.viewBox.baseVal.width;
      tell(index, left + scale * marks[index].x, top + scale * marks[index].y);
    };
    svg.setAttribute("tabindex", "0");
    svg.addEventListener("pointermove", follow);
    svg.addEventListener("pointerdown", follow);
    svg.addEventListener("pointerleave", leave);
    svg.addEventListener("focus", () => { if (svg.matches(":focus-visible")) step(0); });
    svg.addEventListener("blur", leave);
    svg.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (!by) return;
      event.preventDefault();
      step(by);
    });
  };
  window.addEventListener("scroll", hide_tip, { passive: true });

  // ---- Axes.

  const linear_ticks = (low, high) => {
    const power = 10 ** Math.floor(Math.log10((high - low) / 5));
    const step = [1, 2, 2.5, 5, 10].map((k) => k * power).find((s) => (high - low) / s <= 5.001);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) found.push(Number((k * step).toPrecision(6)));
    return found;
  };
  const log_ticks = (low, high) => {
    const of = (digits) => {
      const found = [];
      for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; ++power)
        for (const digit of digits) found.push(Number(`${digit}e${power}`));
      return found.filter((value) => value >= low * 0.999 && value <= high * 1.001);
    };
    const found = [[1, 2, 5], [1]].map(of).find((ticks) => ticks.length <= 6) || of([1]).filter((_, i) => i % 2 === 0);
    return found.length >= 2 ? found : linear_ticks(low, high);
  };
  /// From values to shares of the axis, 0 to 1.
  const axis = (low, high, log) => ({
    share: (value) => Math.min(Math.max(log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low), 0), 1),
    ticks: log ? log_ticks(low, high) : linear_ticks(low, high),
  });
  const is_drawn = (value, chart) => typeof value === "number" && (!chart.log || value > 0);
  /// The axis of a figure's measure, the same for all its panels.
  const measure_axis = (chart, rows) => {
    const measures = [chart.y, chart.reference, chart.high].filter(Boolean);
    const values = rows.flatMap((row) => measures.map((measure) => row[measure])).filter((value) => is_drawn(value, chart));
    let [low, high] = chart.range || [chart.log ? Math.min(...values) / 1.15 : 0, Math.max(...values) * 1.15];
    if (!(high > low && Number.isFinite(high))) [low, high] = [chart.log ? 0.1 : 0, 1];
    return axis(low, high, chart.log);
  };
  /// The axis of a column over which figures run; numbers that grow by factors get a logarithmic one.
  const column_axis = (values) => {
    const sorted = [...values].sort((a, b) => a - b);
    const first = sorted[0], last = sorted[sorted.length - 1], middle = sorted[Math.floor((sorted.length - 1) / 2)];
    if (first === last) return { share: () => 0.5, ticks: [first] };
    return axis(first, last, first > 0 && sorted.length > 2 && (middle - first) / (last - first) < 0.2);
  };

  // ---- Figures.

  const kWidth = 250, kHeight = 175, kLeft = 44, kRight = 10, kTop = 8, kBottom = 31;
  const path_of = (points) => points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(2)} ${y.toFixed(2)}`).join("");

  const add_key = (parent, names, chart, dots) => {
    const key = make(parent, "div", { class: "key" });
    const item = (name, attributes) => {
      const span = make(key, "span"), svg = make(span, "svg", { viewBox: "0 0 24 8", "aria-hidden": "true" });
      if (dots) make(svg, "circle", { cx: 12, cy: 4, r: 4, fill: attributes.stroke });
      else make(svg, "path", { d: "M0 4H24", "stroke-width": 2.5, fill: "none", ...attributes });
      span.append(name);
    };
    if (names.length > 1 || chart.reference) names.forEach((name, index) => item(name, stroke(index)));
    if (chart.reference) item(chart.reference_name, { stroke: "var(--reference)", "stroke-dasharray": "4 3" });
    if (chart.low) key.append("shaded: 95 % interval");
  };

  /// A measure over the column x: a panel for each of the others' values, a line for each series.
  const draw_lines = (parent, chart, table, x, others) => {
    const { rows, series } = table;
    const names = distinct(rows, series);
    const along = column_axis(distinct(rows, x)), up = measure_axis(chart, rows);
    const at_x = (row) => kLeft + (kWidth - kLeft - kRight) * along.share(row[x]);
    const at_y = (value) => kHeight - kBottom - (kHeight - kTop - kBottom) * up.share(value);
    const panel_of = (row) => others.map((key) => `${spelt(key)} ${short(row[key])}`).join(", ");
    add_key(parent, names, chart, false);
    const panels = make(parent, "div", { class: "panels" });
    for (const name of new Set(rows.map(panel_of))) {
      const box = make(panels, "div", { class: "panel" });
      if (name) make(box, "h3", {}, name);
      const svg = make(box, "svg", { viewBox: `0 0 ${kWidth} ${kHeight}`, role: "img", "aria-label": `${chart.title}, ${name}` });
      for (const value of up.ticks) {
        make(svg, "line", { class: "axis", x1: kLeft, x2: kWidth - kRight, y1: at_y(value), y2: at_y(value) });
        make(svg, "text", { x: kLeft - 4, y: at_y(value) + 4, "text-anchor": "end" }, short(value * (chart.factor || 1)));
      }
      for (const value of along.ticks)
        make(svg, "text", { x: at_x({ [x]: value }), y: kHeight - kBottom + 15, "text-anchor": "middle" }, short(value));
      make(svg, "text", { x: kWidth - kRight, y: kHeight - 4, "text-anchor": "end" }, spelt(x));
      const marks = [];
      names.forEach((solver, index) => {
        const mine = rows.filter((row) => row[series] === solver && panel_of(row) === name).sort((a, b) => a[x] - b[x]);
        const line = (measure) => mine.filter((row) => is_drawn(row[measure], chart)).map((row) => [at_x(row), at_y(row[measure])]);
        if (chart.reference)
          make(svg, "path", { d: path_of(line(chart.reference)), fill: "none", stroke: "var(--reference)", "stroke-dasharray": "4 3" });
        if (chart.low)
          make(svg, "path", { d: path_of([...line(chart.high), ...line(chart.low).reverse()]), fill: `var(--s${index % 8})`, opacity: 0.15 });
        make(svg, "path", { d: path_of(line(chart.y)), fill: "none", "stroke-width": 1.7, ...stroke(index) });
        for (const row of mine.filter((one) => is_drawn(one[chart.y], chart))) {
          const mark = { x: at_x(row), y: at_y(row[chart.y]), row };
          make(svg, "circle", { cx: mark.x.toFixed(2), cy: mark.y.toFixed(2), r: mine.length > 20 ? 1.3 : 2.6, fill: `var(--s${index % 8})` });
          marks.push(mark);
        }
      });
      tell_marks(svg, marks, table.columns, (mark, px, py) => Math.hypot(mark.x - px, mark.y - py));
    }
  };

  /// A measure with its interval for each series, a panel for each of the others' values.
  const draw_dots = (parent, chart, table, others) => {
    const { rows, series } = table, names = distinct(rows, series), along = measure_axis(chart, rows);
    const left = 116, at = (value) => left + (kWidth - left - 14) * along.share(value);
    const panel_of = (row) => others.map((key) => short(row[key])).join(", ");
    const panels = make(parent, "div", { class: "panels" });
    for (const name of new Set(rows.map(panel_of))) {
      const mine = rows.filter((row) => panel_of(row) === name);
      const box = make(panels, "div", { class: "panel" });
      make(box, "h3", {}, name);
      const height = 16 * mine.length + 26;
      const svg = make(box, "svg", { viewBox: `0 0 ${kWidth} ${height}`, role: "img", "aria-label": `${chart.title}, ${name}` });
      for (const value of along.ticks) {
        make(svg, "line", { class: "axis", x1: at(value), x2: at(value), y1: 4, y2: height - 18 });
        make(svg, "text", { x: at(value), y: height - 6, "text-anchor": "middle" }, short(value * (chart.factor || 1)));
      }
      const marks = [];
      mine.forEach((row, i) => {
        const y = 14 + 16 * i, text = String(row[series]), colour = `var(--s${names.indexOf(row[series]) % 8})`;
        make(svg, "text", { x: left - 8, y: y + 4, "text-anchor": "end" }, text.length > 17 ? `${text.slice(0, 16)}\u2026` : text);
        if (!is_drawn(row[chart.y], chart)) return;
        if (chart.low) make(svg, "line", { x1: at(row[chart.low]), x2: at(row[chart.high]), y1: y, y2: y, stroke: colour, "stroke-width": 1.6 });
        make(svg, "circle", { cx: at(row[chart.y]), cy: y, r: 3.4, fill: colour });
        marks.push({ x: at(row[chart.y]), y, row });
      });
      tell_marks(svg, marks, table.columns, (mark, px, py) => Math.abs(mark.y - py));
    }
  };

  const draw_charts = (table) => {
    // Figures run over the numbers that take the most values; panels part by what else varies.
    const keys = table.keys.filter((key) => key !== table.series);
    const count = (key) => distinct(table.rows, key).length;
    const numbers = keys.filter((key) => table.rows.every((row) => typeof row[key] === "number"));
    const x = numbers.reduce((best, key) => (best === undefined || count(key) > count(best) ? key : best), undefined);
    const others = keys.filter((key) => key !== x && (x === undefined || count(key) > 1));
    for (const chart of table.charts) {
      const section = make(page, "section");
      make(section, "h2", {}, chart.title);
      if (x === undefined) draw_dots(section, chart, table, others);
      else draw_lines(section, chart, table, x, others);
    }
  };

  // ---- Tables.

  const save = (name, type, text) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  const csv_cell = (value) => (/[",\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
  const csv_of = (table) => {
    const lines = [table.columns, ...table.rows.map((row) => table.columns.map((column) => row[column]))];
    return lines.map((line) => line.map((value) => csv_cell(String(value ?? ""))).join(",")).join("\n") + "\n";
  };

  /// The number that a cell is or begins with, as "0.063 (0.057)" does and "3dmatch" does not; else NaN.
  const number_in = (value) => {
    if (typeof value === "number") return value;
    const found = /^\s*[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?(?!\w)/i.exec(value ?? "");
    return found ? Number(found[0]) : NaN;
  };
  const draw_table = (table) => {
    make(page, "h2", {}, table.title);
    for (const paragraph of table.caption) make(page, "p", { class: "soft" }, paragraph);
    const bar = make(page, "div");
    make(bar, "button", { type: "button" }, "Save as CSV").addEventListener("click", () => save(`${table.name}.csv`, "text/csv", csv_of(table)));
    make(bar, "button", { type: "button" }, "Save as JSON").addEventListener("click",
      () => save(`${table.name}.json`, "application/json", JSON.stringify(table.rows, null, 1) + "\n"));
    const made = make(make(page, "div", { class: "wide", tabindex: 0, role: "region", "aria-label": table.title }), "table");
    const head = make(make(made, "thead"), "tr"), body = make(made, "tbody");
    const texts = new Set(table.columns.filter((column) => table.rows.every((row) => Number.isNaN(number_in(row[column])))));
    const fill = (rows) => {
      body.replaceChildren();
      for (const row of rows) {
        const line = make(body, "tr");
        for (const column of table.columns) make(line, "td", texts.has(column) ? { class: "text" } : {}, short(row[column]));
      }
    };
    table.columns.forEach((column, index) => {
      const meaning = table.meanings ? table.meanings[index] : "";
      const th = make(head, "th", { class: texts.has(column) ? "text" : "", title: meaning, tabindex: 0, scope: "col" }, spelt(column));
      const sort = () => {
        const sign = th.getAttribute("aria-sort") === "ascending" ? -1 : 1;
        for (const other of head.children) other.removeAttribute("aria-sort");
        th.setAttribute("aria-sort", sign < 0 ? "descending" : "ascending");
        const compare = (a, b) => {
          if (texts.has(column)) return sign * String(a[column]).localeCompare(String(b[column]), undefined, { numeric: true });
          const p = number_in(a[column]), q = number_in(b[column]);
          if (Number.isNaN(p) || Number.isNaN(q)) return Number.isNaN(p) - Number.isNaN(q);  // what is no number comes last
          return sign * (p - q);
        };
        fill([...table.rows].sort(compare));
      };
      th.addEventListener("click", sort);
      th.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        sort();
      });
    });
    fill(table.rows);
    if (!table.meanings) return;
    const details = make(page, "details");
    make(details, "summary", {}, "What the columns mean");
    const list = make(details, "ul");
    table.columns.forEach((column, index) => make(list, "li", {}, `${spelt(column)}: ${table.meanings[index]}`));
  };

  for (const paragraph of data.summary) make(page, "p", {}, paragraph);
  for (const table of data.tables) {
    if (table.charts && table.rows.length > 0) draw_charts(table);
    draw_table(table);
  }
})();
