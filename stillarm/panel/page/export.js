// What is seen, as files: the samples of the window as CSV, the charts as PNG.

import { save } from "/page/dom.js";

// beside: samples of other methods, whose names stand before their columns'.
export function saveCsv(name, topics, from, to, markers = [], beside = {}) {
  const everyCycle = Object.entries(topics).filter(([topic]) => topic === "fast" || topic === "estimate");
  const present = everyCycle.length ? everyCycle.map(([, samples]) => [samples, ""]) : Object.values(topics).map((samples) => [samples, ""]);
  present.push(...Object.entries(beside).map(([method, samples]) => [samples, `${method}_`]));
  const rows = new Map();
  const names = [];
  for (const [samples, prefix] of present) {
    const begin = names.length;
    names.push(...samples.names.map((column) => prefix + column));
    for (let row = samples.rowAt(from); row < samples.end; row++) {
      const at = row % samples.capacity;
      const time = samples.times[at];
      if (time > to) break;
      const key = time.toFixed(6);
      if (!rows.has(key)) rows.set(key, []);
      samples.columns.forEach((column, c) => (rows.get(key)[begin + c] = column[at]));
    }
  }
  const left = markers.map((time, i) => [time, i + 1]).filter(([time]) => time >= from && time <= to);
  const lines = [["time_s", ...names, "marker"].join(",")];
  for (const [time, values] of [...rows].sort((a, b) => a[0] - b[0])) {
    const marker = left.length && left[0][0] <= Number(time) ? left.shift()[1] : "";
    lines.push([time, ...names.map((_, i) => (Number.isFinite(values[i]) ? values[i] : "")), marker].join(","));
  }
  save(name, new Blob([lines.join("\n") + "\n"], { type: "text/csv" }));
}

export function savePng(name, stack) {
  const style = getComputedStyle(document.documentElement);
  const titleHeight = 24 * devicePixelRatio;
  const canvases = stack.charts.map(({ plot, about }) => [plot.ctx.canvas, `${about.title}, ${about.unit}`]);
  const out = document.createElement("canvas");
  out.width = Math.max(...canvases.map(([canvas]) => canvas.width));
  out.height = canvases.reduce((sum, [canvas]) => sum + canvas.height + titleHeight, 0);
  const context = out.getContext("2d");
  context.fillStyle = style.getPropertyValue("--card");
  context.fillRect(0, 0, out.width, out.height);
  context.fillStyle = style.getPropertyValue("--ink");
  context.font = `600 ${15 * devicePixelRatio}px system-ui, sans-serif`;
  let y = 0;
  for (const [canvas, title] of canvases) {
    context.fillText(title, 12 * devicePixelRatio, y + 17 * devicePixelRatio);
    context.drawImage(canvas, 0, y + titleHeight);
    y += canvas.height + titleHeight;
  }
  out.toBlob((blob) => save(name, blob));
}
