// Curves against time below the scene, with a cursor that moves with the slider: chosen from a list, and zoomed together.
"use strict";

const DASHES = ["", "7 4", "2 3", "10 3 2 3"]; // of the first run, the second, ...
const DARK = "#2d3748"; // one quantity of one run
const BLOCK = 3; // pixels for a swing: of more swings than fit, the envelope is drawn

function make(tag, parent, properties = {}) {
  return parent.appendChild(Object.assign(document.createElement(tag), properties));
}

function makePath(svg, name, d, color = "", dash = "") {
  const path = document.createElementNS(svg.namespaceURI, "path");
  path.setAttribute("class", name);
  path.setAttribute("d", d);
  path.style.stroke = color;
  path.style.strokeDasharray = dash;
  if (name === "curve envelope") path.style.fill = color;
  svg.appendChild(path);
}

// A run's name in its colour of `RUN_COLORS`, or another, underlined with its dashes.
function markRun(label, run, color = RUN_COLORS[run % RUN_COLORS.length]) {
  label.style.color = color;
  if (run) label.style.textDecoration = `underline ${run === 1 ? "dashed" : "dotted"}`;
  return label;
}

// A quantity at a time, between samples on the straight line through them.
function valueAt({ times, values }, t) {
  const before = lastBefore(times, t);
  const after = Math.min(before + 1, times.length - 1);
  const share = after > before ? Math.min(1, Math.max(0, (t - times[before]) / (times[after] - times[before] || 1))) : 0;
  return values[before] + share * (values[after] - values[before]);
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

// The quantities of a run as the page holds them, by name; values as numbers of 0 to 65535 from low to high.
function quantitiesOf({ times, quantities }) {
  const at = floats(times);
  return new Map(
    quantities.map(({ name, unit, low, high, data }) => {
      const levels = new Uint16Array(bytes(data).buffer);
      return [name, { unit, times: at, step: (high - low) / 65535, values: Float64Array.from(levels, (v) => low + ((high - low) * v) / 65535) }];
    }),
  );
}

// How often values turn back between two rows by more than `least`: rounding does not count.
function turningPoints(values, from, to, least) {
  let count = 0;
  let way = 0;
  let end = values[from]; // the farthest since the last turning point
  for (let i = from + 1; i <= to; i++) {
    if (way * (values[i] - end) >= 0 && way) end = values[i];
    else if (Math.abs(values[i] - end) > least) {
      if (way) count++;
      way = Math.sign(values[i] - end);
      end = values[i];
    }
  }
  return count;
}

// Everything below the scene. `runs` [{label, quantities}], the first one's `plots` are offered; `shown` are the first to be
// seen. Returns show(t), zoom(factor, about) and redraw().
function addPlots(section, runs, plots, shown, origin, axis, duration, seek) {
  let [from, to] = [0, duration]; // s after the start: what all plots show
  let t = 0;
  const names = [...new Set(runs.flatMap(({ quantities }) => [...quantities.keys()]))].filter((name) => name !== "distance");
  const offers = [
    ...plots.map((plot) => ({ ...plot, group: "Together" })),
    ...names.map((name) => ({ title: name, curves: [{ name, label: name, color: DARK, minus: 0 }], group: "One quantity" })),
  ];
  if (runs.length > 1 && runs[1].quantities.has("distance")) {
    offers.push({ title: "distance of the tips", curves: [{ name: "distance", label: "distance", color: DARK, minus: 0 }], group: "Together" });
  }

  // The curves of an offer, of every run that has them.
  function curvesOf({ curves }) {
    return runs.flatMap(({ quantities }, run) =>
      curves.flatMap(({ name, label, color, minus }) => {
        const quantity = quantities.get(name);
        if (!quantity) return [];
        const alone = curves.length === 1 && runs.length > 1;
        const who = runs.length > 1 ? (alone ? `${runs[run].label}:` : `${label}${"′".repeat(run)}`) : label;
        return [{ ...quantity, label: who, minus, color: alone ? RUN_COLORS[run % RUN_COLORS.length] : color, run, dash: DASHES[run % DASHES.length] }];
      }),
    );
  }

  // Of which runs an offer has nothing, in words.
  function lackingOf({ title, curves }) {
    const lacking = runs.filter(({ quantities }) => curves.every(({ name }) => name !== "distance" && !quantities.has(name)));
    return lacking.map(({ label }) => `${label}: no ${title}`);
  }

  function addPlot(first) {
    const figure = make("figure", section);
    const caption = make("figcaption", figure);
    const select = make("select", caption, { className: "quantity", ariaLabel: "What is plotted" });
    for (const group of ["Together", "One quantity"]) {
      const list = make("optgroup", select, { label: group });
      offers.forEach((offer, i) => offer.group === group && list.append(new Option(offer.title, i)));
    }
    const values = make("div", caption, { className: "values" });
    const area = make("div", figure, { className: "curves" });
    const cursor = make("div", area, { className: "cursor" });
    let curves = [];
    let labels = [];
    let own = false; // whether each value needs its own unit

    function draw() {
      area.replaceChildren(cursor);
      const svg = area.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "svg"));
      svg.setAttribute("viewBox", "0 0 1000 1000");
      svg.setAttribute("preserveAspectRatio", "none");
      const width = Math.max(60, area.clientWidth);
      const rows = curves.map(({ times }) => [lastBefore(times, from), Math.min(times.length - 1, lastBefore(times, to) + 1)]);
      const ranges = curves.map(({ values, minus }, i) => {
        let [low, high] = [Infinity, -Infinity];
        for (let k = rows[i][0]; k <= rows[i][1]; k++) {
          low = Math.min(low, values[k] - minus);
          high = Math.max(high, values[k] - minus);
        }
        return [low, high];
      });
      const low = Math.min(...ranges.map(([least]) => least));
      const high = Math.max(...ranges.map(([, most]) => most), low + 1e-12 * Math.abs(low) || low + 1e-12);
      for (const { place, label } of ticks(low, high, 3)) {
        makePath(svg, "tick", `M0 ${1000 * (1 - place)}H1000`);
        make("i", area, { className: "y", textContent: label }).style.bottom = `${100 * place}%`;
      }
      for (const { place, label } of ticks(origin + from, origin + to, 4)) {
        makePath(svg, "tick", `M${1000 * place} 0V1000`);
        if ((1 - place) * width > 50) make("i", area, { className: "x", textContent: label }).style.left = `${100 * place}%`;
      }
      make("i", area, { className: "x name", textContent: axis });
      let enveloped = false;
      curves.forEach(({ times, values, minus, color, dash }, i) => {
        const x = (k) => ((1000 * (times[k] - from)) / (to - from)).toFixed(2);
        const y = (value) => (1000 * (1 - (value - minus - low) / (high - low))).toFixed(1);
        const [a, z] = rows[i];
        const turns = turningPoints(values, a, z, 0.02 * (high - low));
        if (turns / 2 <= width / BLOCK) {
          const points = Array.from({ length: z - a + 1 }, (_, k) => `${x(a + k)} ${y(values[a + k])}`);
          makePath(svg, "curve", `M${points.join("L")}`, color, dash);
          return;
        }
        enveloped = true;
        const count = Math.max(4, Math.min(width, Math.floor(turns / 4))); // two swings and more in each
        const upper = [];
        const lower = [];
        for (let k = 0; k < count; k++) {
          const part = values.subarray(a + Math.floor((k * (z - a)) / count), a + Math.floor(((k + 1) * (z - a)) / count) + 1);
          const where = x(a + Math.floor(((k + 0.5) * (z - a)) / count));
          upper.push(`${where} ${y(part.reduce((p, q) => Math.max(p, q)))}`);
          lower.unshift(`${where} ${y(part.reduce((p, q) => Math.min(p, q)))}`);
        }
        makePath(svg, "curve envelope", `M${upper.join("L")}L${lower.join("L")}Z`, color);
      });
      figure.classList.toggle("enveloped", enveloped);
      area.append(cursor);
      showAt();
    }

    function choose(index) {
      const offer = offers[index];
      select.value = index;
      curves = curvesOf(offer);
      const units = new Set(curves.map(({ unit }) => unit)); // a slide among joints that turn has its own
      figure.ariaLabel = `${offer.title} against time`;
      values.replaceChildren();
      own = units.size > 1;
      if (!own && curves[0]?.unit) make("b", values, { textContent: curves[0].unit });
      labels = curves.map(({ color, run }) => markRun(make("span", values), run, color));
      for (const words of lackingOf(offer)) make("b", values, { textContent: words });
      draw();
    }

    function showAt() {
      const place = (t - from) / (to - from);
      cursor.hidden = place < 0 || place > 1;
      cursor.style.left = `${100 * place}%`;
      curves.forEach((curve, i) => {
        const { minus, step, label, unit } = curve;
        const value = valueAt(curve, t) - minus;
        const text = Math.abs(value) <= step ? "0" : short(value);
        labels[i].textContent = `${label} ${text}${own ? ` ${unit}` : ""}`;
      });
    }

    const pick = (event) => {
      const { left, width } = area.getBoundingClientRect();
      if (event.buttons) seek(from + ((to - from) * (event.clientX - left)) / width);
    };
    area.addEventListener("pointerdown", (event) => (area.setPointerCapture(event.pointerId), pick(event)));
    area.addEventListener("pointermove", pick);
    area.addEventListener("wheel", (event) => {
      const { left, width } = area.getBoundingClientRect();
      zoom(event.deltaY < 0 ? 0.8 : 1.25, from + ((to - from) * (event.clientX - left)) / width);
      event.preventDefault();
    });
    area.addEventListener("dblclick", () => zoom(Infinity));
    select.addEventListener("change", () => choose(+select.value));
    choose(Math.max(0, offers.findIndex(({ title }) => title === first)));
    return { draw, showAt };
  }

  // Make the time that is seen longer by a factor, about a time.
  function zoom(factor, about = t) {
    const length = Math.min(duration, Math.max(duration / 1000, (to - from) * factor));
    const share = Math.min(1, Math.max(0, (about - from) / (to - from)));
    from = Math.max(0, Math.min(duration - length, about - share * length)) || 0;
    to = from + length;
    redraw();
  }

  function redraw() {
    all.forEach(({ draw }) => draw());
  }

  function show(time) {
    t = time;
    const length = to - from;
    if (t < from || t > to) {
      from = Math.max(0, Math.min(duration - length, t - 0.1 * length));
      to = from + length;
      redraw();
    }
    all.forEach(({ showAt }) => showAt());
  }

  const all = offers.length ? shown.map(addPlot) : [];
  return { show, zoom, redraw };
}
