// State, grounds, health, deadlines, camera and log as words and numbers.

import { byId, element, facts, number, plain } from "/page/dom.js";

const LOG_LINES = 100;
const TRACKING = ["measured", "no image", "few features"];

export class Health {
  constructor() {
    this.link = null;
    this.heard = false;
  }

  state(word, reason) {
    const place = byId("state");
    const shown = word[0].toUpperCase() + word.slice(1);
    if (byId("state-word").textContent !== shown) byId("state-word").textContent = shown;
    if (byId("state-reason").textContent !== reason) byId("state-reason").textContent = reason;
    place.dataset.state = { "no connection": "silent", "no telemetry": this.heard ? "silent" : "unheard" }[word] ?? word;
  }

  connected(open) {
    if (!open) this.state("no connection", "the panel's server does not answer; the loop goes on without it");
  }

  status({ silent, words, ground, damping_allowed: allowed, held, settings }) {
    this.heard ||= !silent;
    if (silent) return this.state("no telemetry", "no controller is heard");
    this.state(words.state || "unknown", ground.message || "nothing is missing");
    byId("remedy").textContent = ground.remedy && `To do: ${plain(ground.remedy)}.`;
    facts(byId("health"), [
      ["damping", words.damping_status || "-"],
      ["damping allowed", allowed ? "yes" : held ? "no, held by this panel" : "no"],
      ["method", settings.method ?? "-"],
      ["added damping ratio", settings.added_damping_ratio === null ? "-" : number(settings.added_damping_ratio, 3)],
      ["capture delay", words.delay_status || "-"],
      ["deflection", words.deflection_status || "-"],
      ["trust", [words.trust, words.estimate_reason].filter(Boolean).join(": ") || "-"],
      ...this.linkFacts(),
    ]);
  }

  linkFacts() {
    const link = this.link;
    if (link === null) return [];
    return [
      ["images taken, lost", `${link.accepted}, ${link.lost}`],
      ["values refused", `${link.values_refused}`],
      ["deadlines missed", `${link.deadline_misses}`],
      ["recorder", link.recorder_alive ? "runs" : "has ended"],
    ];
  }

  loop({ cycles, missed, wakeup_latency: late, compute, edges_us: edges }) {
    facts(byId("loop-facts"), [
      ["cycles, missed", `${cycles}, ${missed}`],
      ["wake-up p50, p99.9", `${number(late.p50_us, 0)}, ${number(late.p999_us, 0)} µs`],
      ["computing p50, p99.9", `${number(compute.p50_us, 0)}, ${number(compute.p999_us, 0)} µs`],
    ]);
    drawHistogram(byId("histogram"), edges, late.counts, compute.counts);
  }

  camera(frames) {
    const at = (frames.end - 1) % frames.capacity;
    if (frames.end === frames.begin) return;
    const status = frames.column("status")[at];
    facts(byId("camera-facts"), [
      ["tracking", TRACKING[status] ?? `not measured (status ${status})`],
      ["features, agreeing", `${frames.column("features")[at]}, ${frames.column("inliers")[at]}`],
      ["displacement", `${number(frames.column("displacement_px")[at], 2)} px`],
    ]);
  }

  log({ time_s: time, level, text }) {
    const line = element("li", { className: level }, element("time", { textContent: `${number(time, 1)} s` }), plain(text));
    const place = byId("log");
    place.prepend(line);
    while (place.children.length > LOG_LINES) place.lastChild.remove();
  }
}

function drawHistogram(canvas, edges, late, compute) {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name);
  const width = (canvas.width = canvas.clientWidth * devicePixelRatio);
  const height = (canvas.height = canvas.clientHeight * devicePixelRatio);
  const context = canvas.getContext("2d");
  const text = 12 * devicePixelRatio;
  const bottom = height - 1.5 * text;
  const highest = bottom - 1.5 * text; // above it stand the names
  const step = width / edges.length;
  // by the logarithm, so that one late cycle among a thousand is seen
  const share = (count) => (count ? 0.12 + (0.88 * Math.log10(count)) / 3.3 : 0);
  context.font = `${text}px system-ui, sans-serif`;
  edges.forEach((edge, i) => {
    context.fillStyle = colour("--accent-1");
    context.fillRect(i * step + 1, bottom - share(late[i]) * highest, step / 2 - 1, share(late[i]) * highest);
    context.fillStyle = colour("--accent-2");
    context.fillRect((i + 0.5) * step, bottom - share(compute[i]) * highest, step / 2 - 1, share(compute[i]) * highest);
    context.fillStyle = colour("--quiet");
    if (i % 4 === 0) context.fillText(edge >= 1000 ? `${edge / 1000} ms` : `${edge} µs`, i * step, height - 0.3 * text);
  });
  context.fillStyle = colour("--accent-1");
  context.fillText("wake-up", width - 13 * text, text);
  context.fillStyle = colour("--accent-2");
  context.fillText("computing", width - 6.5 * text, text);
}
