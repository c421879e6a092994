// Commissioning: the steps with what will move and how far, the check, and the moves after they were asked for twice.

import { ask, byId, element, plain } from "/page/dom.js";
import { get, post } from "/page/server.js";

const POLL_MS = 500;

export class Commission {
  constructor() {
    byId("check").onclick = () => this.start("check", {});
    byId("commission").onclick = () => this.go();
    byId("commission-stop").onclick = () => this.start("stop", {});
    this.polling = false;
  }

  tell(text) {
    byId("commission-told").textContent = plain(text);
  }

  async go() {
    const moves = this.steps.map(({ name, moves }) => `${name}: ${moves}`).slice(2, 4).join(" ");
    if (await ask("Go: move the arm", `${moves} It takes about a minute and a half. Is the arm free to move?`, "Move the arm")) await this.start("go", { confirmed: true });
  }

  async start(what, body) {
    try {
      await post(`/api/commission/${what}`, body);
      this.tell("");
      await this.show();
    } catch (error) {
      this.tell(error.message);
    }
  }

  async show() {
    try {
      const told = await get("/api/commission");
      this.draw(told);
      const runs = Object.values(told.jobs).some(({ running }) => running);
      if (!runs || this.polling || byId("view-commission").hidden) return;
      this.polling = true;
      setTimeout(() => {
        this.polling = false;
        this.show();
      }, POLL_MS);
    } catch (error) {
      this.tell(error.message);
    }
  }

  draw({ steps, jobs, picture, model_out: modelOut }) {
    this.steps = steps;
    const row = ({ name, does, moves }) => element("li", {}, element("strong", { textContent: name }), element("span", { textContent: plain(does) }), element("span", { className: "moves", textContent: moves }));
    byId("steps").replaceChildren(...steps.map(row));
    const job = jobs.commission ?? jobs.check;
    const moving = jobs.commission?.running === true;
    byId("commission-progress").hidden = !moving;
    byId("commission-progress").value = job?.done ?? 0;
    byId("commission-stop").disabled = !moving;
    byId("commission-lines").hidden = job === undefined;
    byId("commission-lines").textContent = [jobs.check, jobs.commission].filter(Boolean).flatMap(({ lines }) => lines).join("\n");
    if (jobs.commission && !moving) this.tell(jobs.commission.good ? `Go: name ${modelOut} as the configuration's model.` : "No go: see the last line.");
    const image = byId("commission-picture");
    image.hidden = !picture || moving;
    if (!image.hidden && !image.src) image.src = "/api/commission/picture";
  }
}
