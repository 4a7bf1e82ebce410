"use strict";
// Figures that can be enlarged and asked.
(function () {
  const tip = document.createElement("div");
  tip.className = "tip";
  tip.setAttribute("role", "tooltip");
  tip.hidden = true;
  document.body.append(tip);

  // Titles of elements become tips of the page: at once, beside the pointer, and on touch screens.
  function takeTitles(svg) {
    if (svg.dataset.asked) return;
    svg.dataset.asked = "yes";
    for (const title of svg.querySelectorAll("title")) {
      title.parentNode.dataset.tip = title.textContent;
      title.remove();
    }
  }

  function textsAt(x, y) {
    const found = new Set();
    for (const element of document.elementsFromPoint(x, y)) {
      const holder = element.closest("[data-tip]");
      if (holder) found.add(holder.dataset.tip);
    }
    return [...found];
  }

  // What lies under the pointer, else the nearest thing within some pixels: lines are thin and fingers are not.
  function nearest(x, y, reach) {
    const here = textsAt(x, y);
    if (here.length) return here;
    for (let radius = 3; radius <= reach; radius += 3) {
      for (let step = 0; step < 12; step++) {
        const angle = (step * Math.PI) / 6;
        const there = textsAt(x + radius * Math.cos(angle), y + radius * Math.sin(angle));
        if (there.length) return there;
      }
    }
    return [];
  }

  function showTip(texts, x, y) {
    tip.replaceChildren();
    for (const text of texts.slice(0, 4)) tip.append(Object.assign(document.createElement("p"), { textContent: text }));
    if (texts.length > 4) tip.append(Object.assign(document.createElement("p"), { textContent: `and ${texts.length - 4} more` }));
    tip.hidden = !texts.length;
    if (tip.hidden) return;
    const box = tip.getBoundingClientRect();
    const width = document.documentElement.clientWidth;
    tip.style.left = `${Math.max(4, Math.min(x + 14, width - box.width - 4))}px`;
    tip.style.top = `${y + 18 + box.height > innerHeight ? Math.max(4, y - box.height - 12) : y + 18}px`;
  }

  function hideTip() {
    tip.hidden = true;
  }

  function askable(svg) {
    let waiting = 0;
    svg.addEventListener("pointermove", (event) => {
      if (event.buttons) return hideTip();
      takeTitles(svg);
      cancelAnimationFrame(waiting);
      waiting = requestAnimationFrame(() => showTip(nearest(event.clientX, event.clientY, 6), event.clientX, event.clientY));
    });
    svg.addEventListener("click", (event) => {
      takeTitles(svg);
      showTip(nearest(event.clientX, event.clientY, 15), event.clientX, event.clientY);
    });
    svg.addEventListener("pointerleave", (event) => {
      cancelAnimationFrame(waiting);
      if (event.pointerType === "mouse") hideTip();
    });
  }

  // The part of a drawing that is seen: [x, y, width, height] of its view box.
  class View {
    constructor(svg) {
      this.svg = svg;
      this.whole = svg.getAttribute("viewBox").split(" ").map(Number);
      this.show(this.whole);
    }

    get factor() {
      return this.whole[2] / this.box[2];
    }

    show([x, y, width, height]) {
      const [left, top, wide, high] = this.whole;
      x = Math.min(Math.max(x, left), left + wide - width);
      y = Math.min(Math.max(y, top), top + high - height);
      this.box = [x, y, width, height];
      this.svg.setAttribute("viewBox", this.box.join(" "));
      this.svg.style.setProperty("--shrink", String(this.factor ** -0.75)); // marks and letters grow slowly
      this.svg.classList.toggle("zoomed", this.factor > 1.001);
      if (this.onchange) this.onchange();
    }

    place(clientX, clientY) {
      const box = this.svg.getBoundingClientRect();
      return [(clientX - box.left) / box.width, (clientY - box.top) / box.height];
    }

    zoom(step, [u, v] = [0.5, 0.5]) {
      const [x, y, width, height] = this.box;
      const factor = Math.min(Math.max(this.factor * step, 1), 200);
      const wide = this.whole[2] / factor;
      const high = this.whole[3] / factor;
      this.show([x + u * (width - wide), y + v * (height - high), wide, high]);
    }

    move(right, down) {
      const [x, y, width, height] = this.box;
      this.show([x + right * width, y + down * height, width, height]);
    }

    reset() {
      this.show(this.whole);
    }
  }

  const KEYS = {
    "+": (view) => view.zoom(1.5),
    "=": (view) => view.zoom(1.5),
    "-": (view) => view.zoom(1 / 1.5),
    "0": (view) => view.reset(),
  };
  const ARROWS = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.15], ArrowDown: [0, 0.15] };

  function onKey(view, event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (KEYS[event.key]) KEYS[event.key](view);
    else if (ARROWS[event.key] && view.factor > 1.001) view.move(...ARROWS[event.key]);
    else return;
    hideTip();
    event.preventDefault();
  }

  function draggable(view) {
    const fingers = new Map();
    const svg = view.svg;
    const spread = () => {
      const [a, b] = [...fingers.values()];
      return [Math.hypot(a[0] - b[0], a[1] - b[1]), (a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
    };
    svg.addEventListener("pointerdown", (event) => {
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      hideTip();
    });
    svg.addEventListener("pointermove", (event) => {
      const last = fingers.get(event.pointerId);
      if (!last) return;
      const before = fingers.size === 2 ? spread() : null;
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      if (before) {
        const after = spread();
        view.zoom(after[0] / Math.max(before[0], 1), view.place(after[1], after[2]));
      } else if (view.factor > 1.001) {
        svg.setPointerCapture(event.pointerId);
        const box = svg.getBoundingClientRect();
        view.move((last[0] - event.clientX) / box.width, (last[1] - event.clientY) / box.height);
      }
    });
    for (const name of ["pointerup", "pointercancel", "pointerleave"]) {
      svg.addEventListener(name, (event) => {
        if (name !== "pointerleave" || !svg.hasPointerCapture(event.pointerId)) fingers.delete(event.pointerId);
      });
    }
  }

  function button(label, text, press) {
    const made = document.createElement("button");
    made.type = "button";
    made.setAttribute("aria-label", label);
    made.title = label;
    made.textContent = text;
    made.addEventListener("click", press);
    return made;
  }

  const HINT = "Ctrl + wheel, drag, double click";

  // Metres of a unit of the drawing, by its scale bar; 0 where it has none.
  function metresOfUnit(svg) {
    const bar = svg.querySelector("[data-metres]");
    return bar ? Number(bar.dataset.metres) / bar.querySelector("path").getBBox().width : 0;
  }

  function lengthText(metres) {
    const [value, unit] = metres >= 1 ? [metres, "m"] : [1000 * metres, "mm"];
    return `${Number(value.toPrecision(3))} ${unit}`;
  }

  function zoomable(svg) {
    const view = new View(svg);
    const unit = metresOfUnit(svg);
    const hint = Object.assign(document.createElement("span"), { textContent: HINT });
    const scroll = svg.closest(".scroll");
    const bar = document.createElement("div");
    bar.className = "zoom";
    bar.setAttribute("role", "group");
    bar.setAttribute("aria-label", "Enlarge the figure");
    bar.append(
      button("Enlarge", "+", () => view.zoom(1.5)),
      button("Reduce", "−", () => view.zoom(1 / 1.5)),
      button("Show all of the figure", "⤢", () => view.reset()),
      hint,
    );
    view.onchange = () => {
      const across = view.factor > 1.001 && unit ? view.box[2] * unit : 0;
      hint.textContent = across ? `${lengthText(across)} across` : HINT;
    };
    scroll.before(bar);
    for (const part of [bar, scroll]) part.addEventListener("keydown", (event) => onKey(view, event));
    svg.addEventListener("dblclick", () => view.reset());
    svg.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      hideTip();
      view.zoom(Math.exp(-Math.max(-100, Math.min(event.deltaY, 100)) / 250), view.place(event.clientX, event.clientY));
    }, { passive: false });
    draggable(view);
  }

  // A folded list of drawings becomes a list to choose from.
  function choosable(list) {
    const parts = [...list.querySelectorAll(":scope > details")];
    const label = document.createElement("label");
    const select = document.createElement("select");
    label.append(`${list.dataset.label} `, select);
    parts.forEach((part, index) => select.append(new Option(part.querySelector("summary").textContent, index)));
    const choose = () => parts.forEach((part, index) => (part.open = index === select.selectedIndex));
    list.classList.add("chosen");
    list.prepend(label);
    select.addEventListener("change", choose);
    choose();
  }

  document.querySelectorAll("figure svg").forEach(askable);
  document.querySelectorAll("figure svg.map").forEach(zoomable);
  document.querySelectorAll(".choice").forEach(choosable);
  addEventListener("keydown", (event) => event.key === "Escape" && hideTip());
  addEventListener("scroll", hideTip, { passive: true, capture: true });
})();
