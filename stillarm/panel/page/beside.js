// Methods beside the one in force: which are wanted, and their samples as they come. The server runs them while a page
// wants them; a page without a session cannot.

import { DASHES } from "/page/charts.js";
import { byId, element } from "/page/dom.js";
import { LOST_S, Samples } from "/page/samples.js";

const ROWS = 310_000; // five minutes, as of the other curves
const COLOURS = [1, 2, 3, 4, 5, 6].map((n) => `--over-${n}`);
const CHARTS = [0, 2]; // deflection and capture delay

export class Beside {
  // wish(methods): tells the server; overlay(overlays): draws.
  constructor(wish, overlay) {
    Object.assign(this, { wish, overlay, methods: [], chosen: new Set(), samples: new Map(), inForce: null });
  }

  hello({ beside, signed_in: signedIn, read_only: readOnly }) {
    Object.assign(this, { methods: beside.methods, columns: beside.columns, firstKind: beside.first_kind });
    const why = beside.why || (signedIn ? "" : readOnly);
    byId("beside-why").textContent = why;
    const boxes = this.methods.map((method) => {
      const box = element("input", { type: "checkbox", checked: this.chosen.has(method), disabled: why !== "" });
      box.dataset.method = method;
      box.onchange = () => this.choose(method, box.checked);
      return element("label", {}, box, element("span", { textContent: method }));
    });
    byId("beside-methods").replaceChildren(element("legend", { textContent: "Draw beside the one in force" }), ...boxes);
    this.inForce = null;
    this.ask();
  }

  status({ settings }) {
    if (settings.method === this.inForce) return;
    this.inForce = settings.method;
    for (const box of byId("beside-methods").querySelectorAll("input")) {
      const { method } = box.dataset;
      box.nextSibling.textContent = method === this.inForce ? `${method}, in force` : method;
    }
    this.ask();
  }

  choose(method, chosen) {
    if (chosen) this.chosen.add(method);
    else this.chosen.delete(method);
    this.ask();
  }

  // The method in force is drawn already.
  ask() {
    const wanted = [...this.chosen].filter((method) => method !== this.inForce);
    for (const method of this.samples.keys()) if (!wanted.includes(method)) this.samples.delete(method);
    for (const method of wanted) if (!this.samples.has(method)) this.samples.set(method, new Samples(this.columns, ROWS, LOST_S));
    this.wish(wanted);
    this.overlay(wanted.map((method) => this.curve(method)));
  }

  curve(label) {
    const number = this.methods.indexOf(label);
    const topics = { estimate: this.samples.get(label) };
    return { label, topics, colour: COLOURS[number % COLOURS.length], dash: DASHES[number % DASHES.length], offset: 0, charts: CHARTS };
  }

  // Whether a message was a method's.
  take({ kind, times, values }) {
    const method = this.methods[kind - this.firstKind];
    this.samples.get(method)?.add(times, values);
    return method !== undefined;
  }

  // For a file: the samples by method.
  topics() {
    return Object.fromEntries(this.samples);
  }
}
