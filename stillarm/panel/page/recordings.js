// Recordings: the list, a recording's charts with scrubbing and playing, methods, diagnosis, and comparison.

import { CHARTS, ChartStack, DASHES, IMAGE_CHARTS } from "/page/charts.js";
import { byId, element, facts, number, plain } from "/page/dom.js";
import { saveCsv, savePng } from "/page/export.js";
import { RecordedImages } from "/page/recorded_images.js";
import { Samples, unpack } from "/page/samples.js";
import { get, post } from "/page/server.js";

const INTERVALS = 30_000; // pairs of points at most for a chunk: full resolution up to a minute of it
const CHUNK_S = 30;
const MOST_S = 1200;
const POLL_MS = 400;
const REPLAY_COLUMNS = ["deflection_m", "deflection_std_m", "delay_s", "delay_std_s"];
const COLOURS = [1, 2, 3, 4, 5, 6].map((n) => `--over-${n}`);

const path = (key, rest = "") => `/api/opened/${key}${rest}`;

async function series(key, topic, columns, begin, end) {
  const samples = new Samples(columns, Math.ceil((Math.min(end - begin, MOST_S) + 1) * 1100) + 10);
  for (let from = begin; from < Math.min(end + 0.001, begin + MOST_S); from += CHUNK_S) {
    const to = Math.min(from + CHUNK_S, end + 0.001);
    const query = new URLSearchParams({ topic, from, to, intervals: INTERVALS });
    const answer = await fetch(path(key, `/series?${query}`));
    if (!answer.ok) throw new Error((await answer.json()).error);
    const { times, values } = unpack(await answer.arrayBuffer());
    samples.add(times, values);
  }
  return samples;
}

async function load(name) {
  const about = await get(`/api/recordings/${encodeURIComponent(name)}`);
  const topics = {};
  for (const [topic, columns] of Object.entries(about.topics)) topics[topic] = await series(about.key, topic, columns, about.begin_s, about.end_s);
  return { about, topics };
}

export class Recordings {
  constructor() {
    Object.assign(this, { open: null, time: 0, playing: false, last: 0, methods: new Map(), other: null, zoomed: null });
    this.images = new RecordedImages();
    byId("rec-play").onclick = () => this.play(!this.playing);
    byId("rec-time").oninput = ({ target }) => this.seek(Number(target.value));
    byId("rec-window").onchange = () => (this.zoomed = null);
    byId("rec-replay").onclick = () => this.job("replay");
    byId("rec-diagnose").onclick = () => this.job("diagnose");
    byId("rec-report").onclick = () => this.report();
    byId("rec-compare").onchange = ({ target }) => this.compare(target.value);
    byId("report-close").onclick = () => byId("report-dialog").close();
    byId("rec-csv").onclick = () => saveCsv(`${this.open.about.name}.csv`, this.open.topics, ...this.span());
    byId("rec-png").onclick = () => savePng(`${this.open.about.name}.png`, this.stack);
  }

  tell(text) {
    byId("rec-told").textContent = plain(text);
  }

  async list() {
    try {
      const { recordings } = await get("/api/recordings");
      this.names = recordings.map(({ name }) => name);
      byId("rec-list").replaceChildren(...recordings.map((one) => this.entry(one)));
      this.tell(recordings.length ? "" : "no recordings (*.mcap) in the panel's folder; name another one with --recordings");
      this.offerCompare();
    } catch (error) {
      this.tell(error.message);
    }
  }

  entry({ name, bytes, changed_s: changed }) {
    const size = bytes < 1e5 ? `${number(bytes / 1e3, 1)} kB` : `${number(bytes / 1e6, 1)} MB`;
    const button = element("button", { title: new Date(changed * 1000).toLocaleString() }, element("span", { textContent: name }), element("small", { textContent: size }));
    button.dataset.name = name;
    button.onclick = () => this.choose(name);
    button.setAttribute("aria-pressed", String(this.open?.about.name === name));
    return element("li", {}, button);
  }

  async choose(name) {
    this.tell(`${name}: reading`);
    try {
      this.open = await load(name);
    } catch (error) {
      return this.tell(`${name}: ${error.message}`);
    }
    Object.assign(this, { methods: new Map(), other: null, zoomed: null });
    const { about, topics } = this.open;
    byId("rec-empty").hidden = true;
    this.stack?.destroy();
    this.stack = new ChartStack(byId("rec-charts"), topics, {
      onSelect: (from, to) => (this.zoomed = [from, to]),
      onReset: () => (this.zoomed = null),
      settled: false,
      charts: topics.fast || topics.estimate ? CHARTS : IMAGE_CHARTS,
    });
    this.stack.changes = about.changes;
    const slider = byId("rec-time");
    Object.assign(slider, { min: about.begin_s, max: about.end_s, disabled: false });
    for (const id of ["rec-play", "rec-csv", "rec-png"]) byId(id).disabled = false;
    this.seek(about.begin_s);
    this.describe();
    this.findImages();
    this.tell(about.end_s - about.begin_s > MOST_S ? `only the first ${MOST_S / 60} min are drawn` : "");
    await this.list();
  }

  // The server looks for the recording's images and tracks them again; that takes the computer's time.
  async findImages() {
    const { about } = this.open;
    const say = (text) => (byId("rec-view-told").textContent = plain(text));
    this.images.close();
    byId("rec-images-card").hidden = !about.topics.frames;
    if (!about.topics.frames) return;
    try {
      if (!about.images) await this.finished("images", about.key, (job) => this.open.about.key === about.key && say(`looking for images: ${number(100 * job.done, 0)} %`));
      if (this.open.about.key !== about.key) return;
      say("");
      this.images.open(path(about.key, "/view"));
    } catch (error) {
      if (this.open.about.key === about.key) say(error.message);
    }
  }

  // Starts a job and waits for its good end; throws with its last line otherwise. tell(job): its progress.
  async finished(what, key, tell) {
    await post(path(key, `/${what}`));
    for (;;) {
      const { job } = await get(path(key, `/${what}`));
      tell(job);
      if (!job.running) {
        if (!job.good) throw new Error(job.lines.at(-1) ?? `${what} failed`);
        return;
      }
      await new Promise((resolve) => setTimeout(resolve, POLL_MS));
    }
  }

  describe() {
    const { about } = this.open;
    byId("rec-card").hidden = false;
    byId("rec-title").textContent = about.name;
    facts(byId("rec-facts"), [
      ["length", `${number(about.end_s - about.begin_s, 1)} s`],
      ["method", about.method],
      ["kind", `${about.kind}${about.cut ? ", its end is missing" : ""}`],
      ["program", about.program_version],
    ]);
    byId("rec-report").hidden = !about.diagnosed;
    this.offerMethods();
    this.offerCompare();
    byId("rec-states-card").hidden = about.changes.length === 0;
    const states = about.changes.map(([time, state, reason]) => element("li", {}, element("time", { textContent: `${number(time, 2)} s` }), reason ? `${state}: ${reason}` : state));
    byId("rec-states").replaceChildren(...states);
  }

  offerCompare() {
    if (!this.open) return;
    const others = this.names?.filter((name) => name !== this.open.about.name) ?? [];
    const options = ["", ...others].map((name) => element("option", { value: name, textContent: name || "nothing" }));
    byId("rec-compare").replaceChildren(...options);
    byId("rec-compare").value = this.other?.about.name ?? "";
  }

  async compare(name) {
    this.other = null;
    try {
      if (name) this.other = await load(name);
    } catch (error) {
      this.tell(`${name}: ${error.message}`);
    }
    this.overlay();
  }

  offerMethods() {
    const { methods } = this.open.about;
    const place = byId("rec-methods");
    place.hidden = methods.length === 0;
    const boxes = methods.map((method, i) => {
      const box = element("input", { type: "checkbox", checked: this.methods.has(method) });
      box.onchange = () => this.toggle(method, i, box.checked);
      return element("label", {}, box, method);
    });
    place.replaceChildren(element("legend", { textContent: "Methods" }), ...boxes);
  }

  async toggle(method, number, shown) {
    const { about } = this.open;
    if (!shown) this.methods.delete(method);
    else this.methods.set(method, { colour: COLOURS[number % COLOURS.length], dash: DASHES[number % DASHES.length], samples: await series(about.key, `replay_${method}`, REPLAY_COLUMNS, about.begin_s, about.end_s) });
    this.overlay();
  }

  overlay() {
    const overlays = [...this.methods].map(([label, { colour, dash, samples }]) => ({ label, colour, dash, topics: { estimate: samples }, offset: 0, charts: [0, 2] }));
    if (this.other) {
      const offset = this.open.about.begin_s - this.other.about.begin_s;
      overlays.push({ label: this.other.about.name, colour: "--accent-2", topics: this.other.topics, offset, charts: [0, 1, 2, 3] });
    }
    this.stack.setOverlays(overlays);
  }

  async job(what) {
    const { key } = this.open.about;
    const say = (text) => (byId("rec-job-told").textContent = text);
    byId("rec-job").hidden = false;
    byId("rec-progress").value = 0;
    try {
      await this.finished(what, key, (job) => {
        byId("rec-progress").value = job.running ? job.done : 1;
        say(job.running ? `${job.label || what}: ${number(100 * job.done, 0)} %` : job.lines.at(-1) ?? "");
      });
      if (this.open.about.key !== key) return;
      this.open.about = await get(path(key));
      this.describe();
      say(what === "replay" ? "Choose methods to draw." : "The report is ready.");
      if (what === "diagnose") this.report();
    } catch (error) {
      say(error.message);
    }
  }

  report() {
    byId("report-frame").src = path(this.open.about.key, "/report");
    byId("report-dialog").showModal();
  }

  play(on) {
    this.playing = on;
    this.last = performance.now();
    byId("rec-play").textContent = on ? "Pause" : "Play";
    if (on && this.time >= this.open.about.end_s) this.seek(this.open.about.begin_s);
    if (on && byId("rec-window").value === "0") byId("rec-window").value = "5";
  }

  seek(time) {
    this.time = time;
    byId("rec-time").value = time;
    byId("rec-time-told").textContent = `${number(time, 2)} s`;
  }

  span() {
    const { begin_s: begin, end_s: end } = this.open.about;
    if (this.zoomed) return this.zoomed;
    const window = Number(byId("rec-window").value);
    if (window === 0) return [begin, end];
    const from = Math.max(begin, Math.min(this.time - window / 2, end - window));
    return [from, from + window];
  }

  // Once a frame of the screen.
  draw() {
    if (!this.open) return;
    const now = performance.now();
    if (this.playing) {
      this.seek(Math.min(this.open.about.end_s, this.time + ((now - this.last) / 1000) * Number(byId("rec-speed").value)));
      if (this.time >= this.open.about.end_s) this.play(false);
    }
    this.last = now;
    this.images.follow(this.time);
    this.stack.cursor = this.time;
    const key = JSON.stringify([this.span(), this.time, this.stack.charts.map(({ range }) => range)]);
    if (key === this.stack.shown) return;
    this.stack.draw(...this.span(), this.time);
    this.stack.shown = key;
  }
}
