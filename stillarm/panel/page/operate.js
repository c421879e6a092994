// The operator's buttons. The server decides what is possible; a button that is not says why, and stays reachable.

import { ask, byId, element, plain } from "/page/dom.js";
import { Adjust } from "/page/adjust.js";
import { post } from "/page/server.js";
import { StopKey } from "/page/stop_key.js";

const ORDER = ["arm", "disarm", "allow_damping", "hold_damping", "clear", "strike"];

export class Operate {
  constructor() {
    this.buttons = {};
    this.refusals = {};
    this.adjust = new Adjust((text) => this.tell(text));
    this.stops = [...document.querySelectorAll("button.stop")]; // the header's, and one in each dialog
    for (const button of this.stops) button.addEventListener("click", () => this.stop());
    const key = new StopKey(() => this.stop());
    byId("report-frame").addEventListener("load", ({ target }) => target.contentDocument && key.hear(target.contentDocument));
  }

  // What was asked for in a dialog is off.
  stop() {
    document.querySelectorAll("dialog[open]").forEach((dialog) => dialog.close(""));
    this.act("stop");
  }

  hello(message) {
    const { meanings, signed_in: signedIn, read_only: readOnly } = message;
    Object.assign(this, { meanings, signedIn, readOnly });
    this.buttons = Object.fromEntries(ORDER.map((action) => [action, this.button(action)]));
    byId("actions").replaceChildren(...Object.values(this.buttons), this.adjust.hello(message));
    byId("access").textContent = signedIn ? "" : readOnly;
  }

  button(action) {
    const { label, does } = this.meanings[action];
    const button = element("button", { textContent: label, title: does });
    button.onclick = () => this.act(action);
    button.dataset.action = action;
    return button;
  }

  status({ actions, settings }) {
    this.adjust.status(settings, this.signedIn ? "" : this.readOnly);
    this.refusals = this.signedIn ? actions : Object.fromEntries(Object.keys(actions).map((action) => [action, this.readOnly]));
    for (const [action, button] of [...Object.entries(this.buttons), ...this.stops.map((stop) => ["stop", stop])]) {
      const why = this.refusals[action];
      button.setAttribute("aria-disabled", why ? "true" : "false");
      button.title = plain(why) || this.meanings[action].does;
    }
  }

  async act(action) {
    if (!this.meanings) return;
    const { label, asks } = this.meanings[action];
    const why = this.refusals[action];
    if (why) return this.tell(`${label}: ${why}`);
    if (asks && !(await ask(label, asks, label))) return this.tell(`${label}: cancelled`);
    try {
      await post(`/api/operate/${action}`, { confirmed: asks !== "" });
      this.tell(`${label}: sent`);
    } catch (error) {
      this.tell(`${label}: ${error.message}`);
    }
  }

  tell(text) {
    byId("action-told").textContent = plain(text);
  }
}
