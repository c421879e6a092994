// Method and gain: what is in force, what is wanted, why it may not be, and the question before it is sent.

import { ask, byId, element, number } from "/page/dom.js";
import { post } from "/page/server.js";

export class Adjust {
  // tell(text): what became of it.
  constructor(tell) {
    Object.assign(this, { tell, inForce: null, refusals: {} });
    byId("adjust-go").onclick = () => this.send();
    byId("adjust-cancel").onclick = () => byId("adjust").close();
  }

  // Returns the button that opens the dialog.
  hello({ methods, max_added_damping_ratio: most }) {
    this.most = most;
    byId("adjust-method").replaceChildren(...methods.map((method) => element("option", { value: method, textContent: method })));
    byId("adjust-gain").max = String(most);
    this.button = element("button", { textContent: "Method, gain" });
    this.button.dataset.action = "adjust";
    this.button.onclick = () => this.open();
    return this.button;
  }

  status({ method, added_damping_ratio: gain, refusals }, readOnly) {
    this.inForce = method === null || gain === null ? null : { method, gain };
    const unknown = this.inForce === null ? "the controller has not said yet what is in force" : "";
    this.refusals = Object.fromEntries(Object.entries(refusals).map(([setting, why]) => [setting, readOnly || why || unknown]));
    const both = this.refusals.method && this.refusals.gain;
    this.button.setAttribute("aria-disabled", both ? "true" : "false");
    this.button.title = both ? this.refusals.gain : "Change the estimator or the added damping ratio.";
    this.showRefusals();
  }

  showRefusals() {
    for (const [setting, bounds] of [["method", ""], ["gain", `from 0 to ${this.most}`]]) {
      byId(`adjust-${setting}`).disabled = this.refusals[setting] !== "";
      const why = this.refusals[setting] || bounds;
      const place = byId(`adjust-${setting}-why`);
      if (place.textContent !== why) place.textContent = why;
    }
  }

  open() {
    if (this.refusals.method && this.refusals.gain) return this.tell(`Method, gain: ${this.refusals.gain}`);
    byId("adjust-method").value = this.inForce.method;
    byId("adjust-gain").value = String(Number(this.inForce.gain.toFixed(4)));
    this.showRefusals();
    byId("adjust").showModal();
  }

  // What differs from what is in force; null: as it is.
  wanted() {
    const method = byId("adjust-method").value;
    const gain = byId("adjust-gain").valueAsNumber;
    const same = Math.abs(gain - this.inForce.gain) < 5e-5;
    return {
      method: method === this.inForce.method || byId("adjust-method").disabled ? null : method,
      added_damping_ratio: same || byId("adjust-gain").disabled ? null : gain,
    };
  }

  async send() {
    const wanted = this.wanted();
    const { method, added_damping_ratio: gain } = wanted;
    byId("adjust").close();
    if (method === null && gain === null) return this.tell("Method, gain: as before");
    if (Number.isNaN(gain)) return this.tell(`Method, gain: the added damping ratio is a number from 0 to ${this.most}`);
    const changes = [method && `Method ${this.inForce.method} becomes ${method}.`, gain !== null && `Added damping ratio ${number(this.inForce.gain, 3)} becomes ${number(gain, 3)}.`].filter(Boolean);
    if (!(await ask("Method and gain", `${changes.join(" ")} The arm will be damped in another way. Is everybody out of its reach?`, "Change"))) return this.tell("Method, gain: cancelled");
    try {
      await post("/api/adjust", { ...wanted, confirmed: true });
      this.tell("Method, gain: in force");
    } catch (error) {
      this.tell(`Method, gain: ${error.message}`);
    }
  }
}
