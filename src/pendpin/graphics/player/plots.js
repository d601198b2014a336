// Curves against time below the scene, with a cursor that moves with the slider.
"use strict";

function make(tag, parent, properties = {}) {
  return parent.appendChild(Object.assign(document.createElement(tag), properties));
}

function makePath(svg, name, d, color = "") {
  const path = document.createElementNS(svg.namespaceURI, "path");
  path.setAttribute("class", name);
  path.setAttribute("d", d);
  path.style.stroke = color;
  svg.appendChild(path);
}

// Round numbers from low to high with their labels, `count` to three times as many.
function ticks(low, high, count) {
  const step = roundLength((high - low) / count);
  const digits = -Math.floor(Math.log10(step * 1.0001));
  const first = Math.ceil(low / step);
  const label = (value) => {
    const size = Math.max(Math.abs(low), Math.abs(high));
    if (value === 0) return "0";
    if (size < 1e5 && size >= 1e-3) return value.toFixed(Math.max(0, digits));
    return value.toExponential(Math.max(0, Math.floor(Math.log10(Math.abs(value) * 1.0001)) + digits));
  };
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, i) => {
    const value = (first + i) * step;
    return { place: (value - low) / (high - low), label: label(value) };
  });
}

function short(value) {
  const text = Number(value.toPrecision(3));
  return Math.abs(text) >= 1e5 || (text && Math.abs(text) < 1e-3) ? text.toExponential() : String(text);
}

// One plot: `values` (a Float32Array for each curve, from 0 at `low` to 1 at `high`) at `times` in s after the start.
// Returns what moves its cursor to time t; `onTime` is called with the time at which it is clicked.
function addPlot(section, { title, unit, names, colors, low, high, values }, times, start, duration, onTime) {
  const figure = make("figure", section, { ariaLabel: `${title} against time` });
  const caption = make("figcaption", figure, { textContent: `${title}, ${unit}` });
  const area = make("div", figure, { className: "curves" });
  const svg = area.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "svg"));
  svg.setAttribute("viewBox", "0 0 1000 1000");
  svg.setAttribute("preserveAspectRatio", "none");
  for (const { place, label } of ticks(low, high, 3)) {
    makePath(svg, "tick", `M0 ${1000 * (1 - place)}H1000`);
    make("i", area, { className: "y", textContent: label }).style.bottom = `${100 * place}%`;
  }
  for (const { place, label } of ticks(start, start + duration, 4)) {
    makePath(svg, "tick", `M${1000 * place} 0V1000`);
    make("i", area, { className: "x", textContent: label }).style.left = `${100 * place}%`;
  }
  const labels = values.map((curve, i) => {
    const points = Array.from(curve, (y, j) => `${((1000 * times[j]) / duration).toFixed(2)} ${(1000 * (1 - y)).toFixed(1)}`);
    makePath(svg, "curve", `M${points.join("L")}`, colors[i]);
    const label = make("span", caption);
    label.style.color = colors[i];
    return label;
  });
  const cursor = make("div", area, { className: "cursor" });
  const pick = (event) => {
    const { left, width } = area.getBoundingClientRect();
    if (event.buttons) onTime((duration * (event.clientX - left)) / width);
  };
  area.addEventListener("pointerdown", (event) => (area.setPointerCapture(event.pointerId), pick(event)));
  area.addEventListener("pointermove", pick);

  return (t) => {
    cursor.style.left = `${(100 * t) / duration}%`;
    const now = lastBefore(times, t);
    values.forEach((curve, i) => {
      const value = low + (high - low) * curve[now];
      const rounding = 1e-6 * (high - low); // of the numbers of 24 bits that the page holds
      labels[i].textContent = `${names[i]} ${Math.abs(value) < rounding ? 0 : short(value)}`;
    });
  };
}
