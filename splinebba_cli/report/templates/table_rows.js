// The rows of a table, wherever they are: `value` to sort and compare by, `text` as it is shown, `element` to show.
"use strict";
const tableRows = (function () {
  const LONG = 40; // characters of a cell from which on it is broken into lines

  // Short tables: all rows stand in the page.
  class PlainRows {
    constructor(table) {
      this.elements = Array.from(table.tBodies[0].rows);
      this.count = this.elements.length;
    }
    value(row, column) {
      const cell = this.elements[row].cells[column];
      if (cell.dataset.v === undefined) return cell.textContent;
      return cell.dataset.v === "" ? null : Number(cell.dataset.v);
    }
    text(row, column) { return this.elements[row].cells[column].textContent; }
    element(row) { return this.elements[row]; }
    isMarked(row) { return this.elements[row].classList.contains("marked"); }
  }

  // Long tables: the rows are data beside the table; read when they are first needed.
  class KeptRows {
    constructor(table, source) {
      this.source = source;
      this.count = Number(source.dataset.count);
      this.headings = Array.from(table.tHead.rows[0].cells, (th) => ({
        numeric: th.classList.contains("n"),
        decimals: th.dataset.decimals === undefined ? null : Number(th.dataset.decimals),
      }));
    }
    get data() {
      if (this.kept === undefined) {
        this.kept = JSON.parse(this.source.textContent);
        this.marked = new Set(this.kept.marked);
      }
      return this.kept;
    }
    value(row, column) {
      const cells = this.data.columns[column];
      if (!cells.words) return cells[row];
      return cells.at[row] === null ? null : cells.words[cells.at[row]];
    }
    text(row, column) {
      const value = this.value(row, column);
      const decimals = this.headings[column].decimals;
      if (value === null) return "–";
      return typeof value === "number" && decimals !== null ? value.toFixed(decimals) : String(value);
    }
    element(row) {
      const tr = document.createElement("tr");
      if (this.isMarked(row)) tr.className = "marked";
      this.headings.forEach(({ numeric }, column) => {
        const cell = document.createElement(column === 0 && !numeric ? "th" : "td");
        if (cell.tagName === "TH") cell.scope = "row";
        else if (!numeric) cell.className = "t";
        cell.textContent = this.text(row, column);
        if (cell.textContent.length > LONG && !numeric) cell.classList.add("long");
        tr.append(cell);
      });
      return tr;
    }
    isMarked(row) { return this.data && this.marked.has(row); }
  }

  return (table, source) => (source ? new KeptRows(table, source) : new PlainRows(table));
})();
