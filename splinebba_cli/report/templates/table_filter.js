// What is typed into the filter of a table: words, or a comparison such as `> 3`, `|x| > 3`, `σ X <= 0.5`.
"use strict";
const tableFilter = (function () {
  const COMPARISON = /^(.*?)(<=|>=|!=|≤|≥|≠|<|>|=)\s*([-+−]?\d*[.,]?\d+(?:e[-+]?\d+)?)$/i;
  const TESTS = {
    "<": (a, b) => a < b, "<=": (a, b) => a <= b, "≤": (a, b) => a <= b,
    ">": (a, b) => a > b, ">=": (a, b) => a >= b, "≥": (a, b) => a >= b,
    "=": (a, b) => a === b, "!=": (a, b) => a !== b, "≠": (a, b) => a !== b,
  };
  const plain = (text) => text.normalize("NFC").toLowerCase().replace(/\s+/g, " ").trim();
  const withoutUnit = (text) => plain(text).replace(/ ?\[[^\]]*\]$/, "");

  // The column that a comparison is about, or null: the chosen one, unless its name is typed.
  function columnOf(name, headings, chosen) {
    if (name === "" || name === "x") return chosen;
    const found = headings.findIndex((text) => plain(text) === name || withoutUnit(text) === name);
    return found < 0 ? null : found;
  }

  function comparison(parts, headings, numeric, chosen) {
    let name = plain(parts[1]);
    const size = name.startsWith("|") && name.endsWith("|") && name.length > 1;
    if (size) name = plain(name.slice(1, -1));
    const column = columnOf(name, headings, chosen);
    if (column === null) return name === "" || name === "x" ? { message: "Choose the column to compare." } : null;
    if (!numeric[column]) return null;
    const bound = Number(parts[3].replace("−", "-").replace(",", "."));
    const test = TESTS[parts[2]];
    return {
      matches: (rows, row) => {
        const value = rows.value(row, column);
        return typeof value === "number" && test(size ? Math.abs(value) : value, bound);
      },
    };
  }

  // Texts of whole rows in small letters, made once.
  function haystacks(rows, columns) {
    rows.haystacks ??= Array.from({ length: rows.count }, (_, row) =>
      Array.from({ length: columns }, (_, column) => rows.text(row, column)).join("\n").toLowerCase());
    return rows.haystacks;
  }

  // `{matches(rows, row)}`, `{message}` where something is missing, or null where nothing is asked.
  return function (typed, headings, numeric, chosen) {
    const text = plain(typed);
    if (text === "") return null;
    const parts = text.match(COMPARISON);
    const compared = parts && comparison(parts, headings, numeric, chosen);
    if (compared) return compared;
    const words = text.split(" ");
    if (chosen !== null) {
      return { matches: (rows, row) => {
        const cell = rows.text(row, chosen).toLowerCase();
        return words.every((word) => cell.includes(word));
      } };
    }
    return { matches: (rows, row) => {
      const all = haystacks(rows, headings.length)[row];
      return words.every((word) => all.includes(word));
    } };
  };
})();
