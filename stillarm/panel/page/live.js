// The live view: samples as they come, drawn in every frame of the screen; pause, zoom, five minutes back, markers.

import { Beside } from "/page/beside.js";
import { ChartStack } from "/page/charts.js";
import { drawView } from "/page/camera.js";
import { byId, number } from "/page/dom.js";
import { saveCsv, savePng } from "/page/export.js";
import { LOST_S, Samples, unpack } from "/page/samples.js";

const KEPT_S = 300;
const ROWS = { fast: 310_000, estimate: 310_000, frames: 80_000 };
const VIEW_KIND = 255;
const OLD_MS = 300;
const TOLD_EVERY_MS = 95; // ten numbers a second are as many as can be read; by time, since a busy computer draws few pictures
const AGE_TOLD_EVERY_MS = 160;

export class Live {
  constructor(socket) {
    Object.assign(this, { socket, topics: {}, kinds: [], window: 10, paused: null, origin: NaN, exact: true, toldMs: -Infinity, ageToldMs: -Infinity });
    this.stack = new ChartStack(byId("live-charts"), this.topics, {
      onSelect: (from, to) => this.zoom(from, to),
      onReset: () => this.follow(),
    });
    this.beside = new Beside(
      (methods) => socket.want(methods),
      (overlays) => this.stack.setOverlays(overlays),
    );
    byId("live-pause").onclick = () => (this.paused === null ? this.hold(this.end()) : this.follow());
    byId("live-window").onchange = ({ target }) => (this.window = Number(target.value));
    byId("live-back").oninput = ({ target }) => this.back(Number(target.value));
    byId("live-marker").onclick = () => this.stack.markers.push(this.paused ?? this.newest());
    byId("live-csv").onclick = () => this.save();
    byId("live-png").onclick = () => savePng("stillarm-live.png", this.stack);
  }

  save() {
    saveCsv("stillarm-live.csv", this.topics, this.end() - this.window, this.end(), this.stack.markers, this.beside.topics());
  }

  hello(message) {
    const { kinds, view_rate_hz: rate } = message;
    this.kinds = kinds;
    this.beside.hello(message);
    for (const { topic, columns } of kinds) this.topics[topic] ??= new Samples(columns, ROWS[topic], topic === "frames" ? Infinity : LOST_S);
    byId("camera-none").textContent = rate > 0 ? "waiting for an image" : "no images: telemetry.view_rate_hz is 0 in the configuration";
  }

  status(message) {
    const { origin_s: origin, origin_exact: exact } = message;
    Object.assign(this, { origin: origin ?? NaN, exact });
    this.beside.status(message);
  }

  binary(buffer) {
    if (new DataView(buffer).getUint8(0) === VIEW_KIND) return void this.view(buffer);
    const message = unpack(buffer);
    if (this.beside.take(message)) return;
    const { kind, times, values } = message;
    this.topics[this.kinds[kind]?.topic]?.add(times, values);
  }

  async view(buffer) {
    await drawView(buffer, byId("camera-view"));
    byId("camera-none").textContent = "";
  }

  newest() {
    return this.topics.fast?.newest() ?? NaN;
  }

  end() {
    return this.paused ?? this.newest();
  }

  hold(time) {
    this.paused = time;
    byId("live-pause").textContent = "Resume";
    byId("live-pause").setAttribute("aria-pressed", "true");
  }

  follow() {
    this.paused = null;
    this.window = Number(byId("live-window").value);
    byId("live-pause").textContent = "Pause";
    byId("live-pause").setAttribute("aria-pressed", "false");
    this.tellBack();
  }

  zoom(from, to) {
    this.hold(to);
    this.window = to - from;
    this.tellBack();
  }

  back(seconds) {
    if (seconds === 0) return this.follow();
    this.hold(Math.max(this.newest() - seconds, this.topics.fast?.oldest() ?? 0));
    this.tellBack();
  }

  tellBack() {
    const seconds = this.paused === null ? 0 : Math.min(KEPT_S, this.newest() - this.paused);
    byId("live-back").value = seconds;
    byId("live-back-told").textContent = this.paused === null ? "live" : `${number(seconds, 1)} s ago`;
  }

  // Once a frame of the screen.
  draw() {
    const end = this.end();
    const now = performance.now();
    const tell = now - this.toldMs >= TOLD_EVERY_MS;
    if (tell) this.toldMs = now;
    if (Number.isFinite(end)) this.stack.draw(end - this.window, end, end, tell);
    if (tell && this.paused !== null) this.tellBack();
  }

  ageMs() {
    return (this.socket.clock.nowS() - (this.origin + this.newest())) * 1000;
  }

  tellAge() {
    const age = this.ageMs();
    const place = byId("age");
    place.dataset.ageMs = Number.isFinite(age) ? age.toFixed(1) : "";
    const now = performance.now();
    if (now - this.ageToldMs < AGE_TOLD_EVERY_MS) return;
    this.ageToldMs = now;
    const shown = age > 9999 ? `${number(age / 1000, 0)} s` : `${number(age, 0)} ms`;
    place.textContent = Number.isFinite(age) ? `newest sample ${this.exact ? "" : "at least "}${shown} old` : "no sample yet";
    place.dataset.old = String(age > OLD_MS);
  }
}
