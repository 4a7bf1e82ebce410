// Tables that are sorted by their headings, filtered and turned over page by page; all of it on all rows.
"use strict";
(function () {
  const PAGE = 50; // rows on a page
  const FILTERED = 12; // tables with more rows get a filter
  const collator = new Intl.Collator("en", { numeric: true });

  function element(tag, properties, ...children) {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...children);
    return made;
  }

  function button(text, act, label) {
    const made = element("button", { type: "button", textContent: text });
    if (label) made.setAttribute("aria-label", label);
    made.addEventListener("click", act);
    return made;
  }

  // A length or an angle with its unit, as a number that can be compared; NaN of anything else.
  const UNITS = { nm: 1e-9, µm: 1e-6, mm: 1e-3, m: 1, km: 1e3, "m″": 1e-3 / 3600, "″": 1 / 3600, "°": 1, px: 1, "%": 1 };
  function quantity(text) {
    const parts = text.match(/^([-−]?[\d.]+(?:e[-+]?\d+)?) ?(\S*)$/);
    return parts && parts[2] in UNITS ? Number(parts[1].replace("−", "-")) * UNITS[parts[2]] : NaN;
  }

  // Numbers by which the rows of a column are sorted; NaN: no value.
  function sortKeys(rows, column) {
    const values = Array.from({ length: rows.count }, (_, row) => rows.value(row, column));
    const words = Array.from(new Set(values.filter((value) => typeof value === "string"))).sort(collator.compare);
    if (words.length && words.every((word) => word === "–" || word === "" || !Number.isNaN(quantity(word)))) {
      return Float64Array.from(values, (value) => (value === null ? NaN : quantity(value)));
    }
    if (!words.length) return Float64Array.from(values, (value) => (value === null ? NaN : value));
    const rank = new Map(words.map((word, number) => [word, number]));
    return Float64Array.from(values, (value) => (typeof value === "string" ? rank.get(value) : NaN));
  }

  class ReportTable {
    constructor(table) {
      this.table = table;
      this.body = table.tBodies[0];
      this.frame = table.closest(".table");
      this.headings = Array.from(table.tHead.rows[0].cells);
      this.titles = this.headings.map((th) => th.textContent.replace(/\u00a0/g, " ").trim());
      this.numeric = this.headings.map((th) => th.classList.contains("n"));
      this.source = this.frame.querySelector("script.rows");
      this.rows = tableRows(table, this.source);
      this.sorted = null; // {column, sign}
      this.order = Array.from({ length: this.rows.count }, (_, row) => row);
      this.found = this.order;
      this.page = 0;
      if (this.rows.count > 1) this.addSorting();
      if (this.rows.count > FILTERED) this.addTools();
      if (this.source) this.addPager();
    }

    addSorting() {
      this.headings.forEach((th, column) => {
        if (!this.titles[column]) return;
        // no <button>: browsers repeat the head of a table on every printed page only without one
        const made = element("span", { className: "sort", tabIndex: 0 }, ...th.childNodes);
        made.setAttribute("role", "button");
        made.addEventListener("click", () => this.sort(column));
        made.addEventListener("keydown", (event) => {
          if (event.key !== "Enter" && event.key !== " ") return;
          event.preventDefault();
          this.sort(column);
        });
        th.append(made);
      });
    }

    // First upwards, then downwards, then as it was.
    sort(column) {
      const before = this.sorted && this.sorted.column === column ? this.sorted.sign : 0;
      this.sorted = before < 0 ? null : { column, sign: before > 0 ? -1 : 1 };
      for (const th of this.headings) th.removeAttribute("aria-sort");
      this.order = Array.from({ length: this.rows.count }, (_, row) => row);
      if (this.sorted) {
        const { sign } = this.sorted;
        const keys = sortKeys(this.rows, column);
        const missing = this.order.filter((row) => Number.isNaN(keys[row]));
        const present = this.order.filter((row) => !Number.isNaN(keys[row]));
        present.sort((a, b) => sign * (keys[a] - keys[b]));
        this.order = present.concat(missing);
        this.headings[column].setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
      }
      this.search();
    }

    addTools() {
      const name = this.table.caption.textContent;
      this.input = element("input", { type: "search", placeholder: "text, or > 3", spellcheck: false });
      this.input.setAttribute("aria-label", `Filter: ${name}`);
      this.choice = element("select", {}, new Option("all columns", ""),
        ...this.titles.map((title, column) => new Option(title, column)));
      this.choice.setAttribute("aria-label", `Column to filter by: ${name}`);
      this.status = element("output", { className: "count" });
      this.status.setAttribute("aria-live", "polite");
      this.input.addEventListener("input", () => {
        clearTimeout(this.waiting);
        this.waiting = setTimeout(() => this.search(), 120);
      });
      this.input.addEventListener("change", () => { // Enter, or the field is left
        clearTimeout(this.waiting);
        this.search();
      });
      this.choice.addEventListener("change", () => this.search());
      const copy = button("Copy as CSV", () => this.copy(copy), `Copy as CSV: ${name}`);
      const tools = element("div", { className: "tools" }, this.input, this.choice);
      if (this.frame.dataset.marked > 0) {
        this.only = button(`Only marked (${this.frame.dataset.marked})`, () => {
          this.only.setAttribute("aria-pressed", this.only.getAttribute("aria-pressed") !== "true");
          this.search();
        });
        this.only.setAttribute("aria-pressed", "false");
        tools.append(this.only);
      }
      tools.append(copy, this.status);
      this.frame.prepend(tools);
      this.say();
    }

    search() {
      const chosen = this.choice && this.choice.value !== "" ? Number(this.choice.value) : null;
      const filter = this.input ? tableFilter(this.input.value, this.titles, this.numeric, chosen) : null;
      this.message = filter && filter.message;
      this.found = this.order;
      if (this.only && this.only.getAttribute("aria-pressed") === "true") {
        this.found = this.found.filter((row) => this.rows.isMarked(row));
      }
      if (filter && filter.matches) this.found = this.found.filter((row) => filter.matches(this.rows, row));
      this.page = 0;
      this.show();
    }

    show() {
      const first = this.page * PAGE;
      const shown = this.source ? this.found.slice(first, first + PAGE) : this.found;
      this.body.replaceChildren(...shown.map((row) => this.rows.element(row)));
      if (this.source) {
        [...this.body.rows].forEach((tr, number) => tr.setAttribute("aria-rowindex", first + number + 2));
        this.turn();
      }
      this.say();
    }

    say() {
      if (!this.status) return;
      const all = `${this.rows.count} rows`;
      this.status.value = this.message || (this.found.length < this.rows.count ? `${this.found.length} of ${all}` : all);
    }

    addPager() {
      const go = (page) => () => { this.page = page(); this.show(); };
      this.range = element("span", {});
      this.back = [button("«", go(() => 0), "First page"), button("‹", go(() => this.page - 1), "Previous page")];
      this.forth = [button("›", go(() => this.page + 1), "Next page"), button("»", go(() => this.last), "Last page")];
      const pager = element("div", { className: "pager" }, ...this.back, this.range, ...this.forth);
      pager.setAttribute("role", "group");
      pager.setAttribute("aria-label", `Pages: ${this.table.caption.textContent}`);
      this.frame.querySelector(".scroll").after(pager);
      this.table.setAttribute("aria-rowcount", this.rows.count + 1);
      this.frame.querySelector(".first").hidden = true;
      this.turn();
    }

    get last() { return Math.max(0, Math.ceil(this.found.length / PAGE) - 1); }

    turn() {
      const { length } = this.found;
      const first = this.page * PAGE;
      this.range.textContent = length ? `Rows ${first + 1}–${Math.min(first + PAGE, length)} of ${length}` : "No rows";
      for (const made of this.back) made.disabled = this.page === 0;
      for (const made of this.forth) made.disabled = this.page === this.last;
    }

    async copy(made) {
      const cell = (text) => (/[",\r\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
      const line = (texts) => texts.map(cell).join(",");
      const lines = this.found.map((row) => line(this.titles.map((_, column) => this.rows.text(row, column))));
      const text = [line(this.titles), ...lines].join("\n") + "\n";
      let said = `Copied ${lines.length} rows`;
      try { await navigator.clipboard.writeText(text); } catch { said = "The browser does not let the page copy"; }
      this.status.value = said;
    }
  }

  for (const table of document.querySelectorAll(".table table")) new ReportTable(table);
})();
