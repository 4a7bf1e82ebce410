// Light or dark: as the reader's system says, until the reader says otherwise.
"use strict";
(function () {
  const KEY = "splinebba-report-theme";
  const root = document.documentElement;
  const system = matchMedia("(prefers-color-scheme: dark)");

  function remembered() {
    try { return localStorage.getItem(KEY); } catch { return null; } // a page of a file may have no storage
  }

  function remember(theme) {
    try { localStorage.setItem(KEY, theme); } catch { /* then it is asked again */ }
  }

  const shown = () => root.dataset.theme || (system.matches ? "dark" : "light");
  const button = document.createElement("button");
  button.type = "button";
  button.className = "theme";

  function label() {
    button.textContent = shown() === "dark" ? "Light theme" : "Dark theme";
  }

  const kept = remembered();
  if (kept === "light" || kept === "dark") root.dataset.theme = kept;
  button.addEventListener("click", () => {
    root.dataset.theme = shown() === "dark" ? "light" : "dark";
    remember(root.dataset.theme);
    label();
  });
  system.addEventListener("change", label);
  label();
  document.querySelector(".top").append(button);
})();
