// The stack of charts that the live view and a recording share: four curves over one window of time.

import uPlot from "/page/vendor/uPlot.esm.js";
import { element, number } from "/page/dom.js";
import { decimate } from "/page/samples.js";

const BAND_STD = 2;
const DASHED = [6, 4];
// Of overlays beside each other, so that they differ not by colour alone; a pixel of stroke and gap in turns.
export const DASHES = [DASHED, [2, 3], [12, 4], [10, 3, 2, 3], [4, 2, 1, 2], [1, 4]];
const SHRINK = 0.03; // of a range in each picture: it widens at once, and narrows slowly

export const CHARTS = [
  {
    title: "Tip deflection", unit: "mm", scale: 1e3, digits: 2, least: 0.5,
    curves: [{ topic: "estimate", column: "deflection_m", spread: "deflection_std_m", label: "estimate, band 2 std" }],
  },
  {
    title: "Accelerometer", unit: "m/s²", scale: 1, digits: 2, least: 1,
    curves: [{ topic: "fast", column: "acceleration_m_s2", label: "measured" }],
  },
  {
    title: "Capture delay", unit: "ms", scale: 1e3, digits: 1, least: 4,
    curves: [{ topic: "estimate", column: "delay_s", spread: "delay_std_s", label: "estimate, band 2 std" }],
  },
  {
    title: "Joint velocity", unit: "mrad/s", scale: 1e3, digits: 1, least: 2,
    curves: [
      { topic: "fast", column: "joint_velocity_command_rad_s", label: "command" },
      { topic: "estimate", column: "damping_rad_s", label: "damping part", second: true },
    ],
  },
];

// Of a recording that holds images and nothing else.
export const IMAGE_CHARTS = [
  {
    title: "Image displacement", unit: "px", scale: 1, digits: 2, least: 1,
    curves: [{ topic: "frames", column: "displacement_px", label: "tracked" }],
  },
];

const token = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// Overlays beside the curves of `topics`: { label, topics: {topic: Samples}, offset (s), colour, dash, charts (indices) }.
export class ChartStack {
  // charts: what to draw.
  // settled: whether the range of y may narrow slowly only, as a live picture needs.
  // onSelect(from, to): a stretch of time was drawn with the pointer; onReset: a double click.
  constructor(place, topics, { onSelect, onReset, settled = true, charts = CHARTS }) {
    Object.assign(this, { place, topics, abouts: charts, onSelect, onReset, settled, overlays: [], markers: [], changes: [], cursor: NaN });
    this.watched = new ResizeObserver(() => this.resize());
    this.build();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.build());
  }

  setOverlays(overlays) {
    this.overlays = overlays;
    this.build();
  }

  build() {
    this.destroy();
    // read once: to ask for a style in each frame makes the browser work out all of them anew
    this.ink = Object.fromEntries(["ink", "quiet"].map((name) => [name, token(`--${name}`)]));
    this.charts = this.abouts.map((about, index) => this.chart(about, index));
    this.resize();
  }

  destroy() {
    this.watched.disconnect();
    this.charts?.forEach((chart) => chart.plot.destroy());
    this.place.replaceChildren();
  }

  chart(about, index) {
    const value = element("output", { textContent: "-" });
    // live, topics come later; of a recording, all are there from the start
    const recorded = ({ topic }) => this.settled || this.topics[topic] !== undefined;
    const keys = about.curves.map((curve) => this.key(recorded(curve) ? curve.label : `${curve.label}: not recorded`, curve.second ? "--accent-2" : "--accent-1", curve.second ? [8, 5] : undefined));
    const over = this.overlays.filter((overlay) => overlay.charts.includes(index));
    keys.push(...over.map((overlay) => this.key(overlay.label, overlay.colour, overlay.dash ?? DASHED)));
    const unit = element("span", { className: "unit", textContent: about.unit });
    const plotPlace = element("div", { className: "plot" });
    const title = element("h2", {}, about.title, unit, ...keys, value);
    this.place.append(element("div", { className: "chart" }, title, plotPlace));
    const chart = { about, index, over, value, place: plotPlace, range: null };
    chart.plot = new uPlot(this.options(chart), [[]], plotPlace);
    this.watched.observe(plotPlace);
    return chart;
  }

  // A piece of the curve's stroke, and its name.
  key(label, colour, dash) {
    const line = element("i");
    line.style.background = stroke(token(colour), dash);
    return element("span", { className: "key" }, line, label);
  }

  options(chart) {
    const ink = token("--quiet");
    const grid = { stroke: token("--line"), width: 1 };
    const axis = { stroke: ink, grid, ticks: grid, font: "13px system-ui, sans-serif", size: 56, space: 20 };
    const series = [{}];
    const bands = [];
    for (const curve of chart.about.curves) {
      const name = curve.second ? "2" : "1";
      if (curve.spread) {
        series.push({ stroke: "transparent", points: { show: false } }, { stroke: "transparent", points: { show: false } });
        bands.push({ series: [series.length - 2, series.length - 1], fill: token(`--band-${name}`) });
      }
      series.push({ stroke: token(`--accent-${name}`), width: 2, dash: curve.second ? [8, 5] : undefined, points: { show: false }, spanGaps: false });
    }
    for (const overlay of chart.over) {
      const about = { stroke: token(overlay.colour), width: 1.5, dash: overlay.dash ?? DASHED };
      for (const curve of chart.about.curves.slice(0, 1)) series.push({ ...about, points: { show: false }, label: curve.label });
    }
    return {
      width: 300, height: 100, series, bands, legend: { show: false },
      cursor: { drag: { x: true, y: false, setScale: false }, points: { show: false }, y: false },
      scales: { x: { time: false, range: () => [this.from ?? 0, this.to ?? 1] }, y: { range: () => chart.range ?? [-1, 1] } },
      axes: [{ ...axis, size: 26, space: 60, values: (u, splits) => splits.map((s) => `${+s.toFixed(3)} s`) }, axis],
      padding: [6, 12, 0, 0],
      hooks: {
        draw: [(plot) => this.drawMarks(plot, chart)],
        setSelect: [(plot) => this.selected(plot)],
        ready: [(plot) => plot.over.addEventListener("dblclick", () => this.onReset())],
      },
    };
  }

  selected(plot) {
    const { left, width } = plot.select;
    if (width < 8) return;
    const [from, to] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.onSelect(from, to);
  }

  drawMarks(plot, chart) {
    const { ctx, bbox } = plot;
    let free = -Infinity; // where the last text ended: a state that would lie over it has no text
    const line = (time, colour, text, dash) => {
      if (time < this.from || time > this.to) return;
      const x = Math.round(plot.valToPos(time, "x", true)) + 0.5;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = colour;
      ctx.lineWidth = 1.5 * devicePixelRatio;
      ctx.setLineDash(dash);
      ctx.textAlign = "left";
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
      if (chart.index === 0 && text && (x > free || dash.length === 0)) {
        const { width } = ctx.measureText(text);
        const fits = x + 4 + width <= bbox.left + bbox.width; // else it stands before its line, where there is room
        const left = fits ? x + 4 : x - 4 - width;
        if (fits || left > free) ctx.fillText(text, left, bbox.top + 12 * devicePixelRatio);
        free = x + 8 + width;
      }
      ctx.restore();
    };
    this.changes.forEach(([time, state]) => line(time, this.ink.quiet, state, [3, 4]));
    this.markers.forEach((time, i) => line(time, this.ink.ink, `${i + 1}`, []));
    line(this.cursor, this.ink.ink, "", []);
  }

  resize() {
    for (const chart of this.charts) {
      chart.width = chart.place.clientWidth; // kept: to ask in each frame makes the browser lay the page out
      chart.plot.setSize({ width: chart.width, height: Math.max(60, chart.place.clientHeight) });
    }
    this.shown = null;
  }

  // Draw a window of time, s; the values at `at` stand beside the titles, and are written anew if `tell` says so: each
  // new text makes the browser lay out the page.
  draw(from, to, at, tell = true) {
    Object.assign(this, { from, to });
    for (const chart of this.charts) {
      const { data, value, lines } = this.data(chart, at);
      chart.range = nextRange(this.settled ? chart.range : null, lines, chart.about.least) ?? chart.range;
      const shown = `${number(value * chart.about.scale, chart.about.digits)} ${chart.about.unit}`;
      if (tell && chart.value.textContent !== shown) chart.value.textContent = shown;
      chart.plot.setData(data, false);
      chart.plot.setScale("x", { min: from, max: to });
    }
  }

  data(chart, at) {
    const groups = Math.max(100, chart.width / 2);
    const tables = [];
    const lines = []; // the curves without their bands, which may be much wider
    const { scale, curves } = chart.about;
    const add = (samples, { column, spread = null }, offset) => {
      const about = { from: this.from - offset, to: this.to - offset, groups, scale, offset, spread, factor: BAND_STD };
      const { x, y, low, high } = samples === undefined ? { x: [], y: [], low: [], high: [] } : decimate(samples, column, about);
      tables.push(spread === null ? [x, y] : [x, high, low, y]);
      lines.push(y);
    };
    for (const curve of curves) add(this.topics[curve.topic], curve, 0);
    for (const { topics, offset } of chart.over) add(topics[curves[0].topic], { ...curves[0], spread: null }, offset);
    const value = this.topics[curves[0].topic]?.valueAt(curves[0].column, at) ?? NaN;
    return { data: tables.length === 1 ? tables[0] : uPlot.join(tables), value, lines };
  }
}

// A background like a curve's stroke.
function stroke(colour, dash) {
  if (dash === undefined) return colour;
  let at = 0;
  const stops = dash.map((length, i) => `${i % 2 ? "transparent" : colour} ${at}px ${(at += length)}px`);
  return `repeating-linear-gradient(to right, ${stops.join(", ")})`;
}

// The range of y: as wide as the data and `least` at once, narrower slowly, so that the picture does not jump.
function nextRange(before, columns, least) {
  let low = Infinity;
  let high = -Infinity;
  for (const column of columns) {
    for (const y of column) {
      if (y === null || y === undefined) continue;
      if (y < low) low = y;
      if (y > high) high = y;
    }
  }
  if (low > high) return before;
  const middle = (low + high) / 2;
  const half = Math.max((high - low) * 0.6, least / 2);
  const wanted = [middle - half, middle + half];
  if (before === null) return wanted;
  return [0, 1].map((i) => {
    const widens = i === 0 ? wanted[0] < before[0] : wanted[1] > before[1];
    return widens ? wanted[i] : before[i] + SHRINK * (wanted[i] - before[i]);
  });
}
