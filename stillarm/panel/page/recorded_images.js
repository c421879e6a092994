// The recorded images of an opened recording: the newest one at the cursor's time, asked for one at a time, so that a
// slow answer is followed by the image of the time that it then is.

import { drawView } from "/page/camera.js";
import { byId, number, plain } from "/page/dom.js";

const EVERY_MS = 40; // 25 images a second, well below the server's limit for an address with several pages

export class RecordedImages {
  constructor() {
    this.askedMs = -Infinity;
    this.close();
  }

  // Shows nothing until the next recording with images.
  close() {
    Object.assign(this, { address: null, from: NaN, until: NaN });
    byId("rec-view").hidden = true;
    byId("rec-view-told").textContent = "";
  }

  // address: of the recording's images on the server.
  open(address) {
    Object.assign(this, { address, from: NaN, until: NaN });
  }

  // Once a frame of the screen.
  follow(time) {
    if (this.address === null || this.asking || (time >= this.from && time < this.until)) return;
    if (performance.now() - this.askedMs < EVERY_MS) return;
    this.askedMs = performance.now();
    this.asking = true;
    this.show(this.address, time)
      .catch((error) => {
        this.close();
        byId("rec-view-told").textContent = plain(error.message);
      })
      .finally(() => (this.asking = false));
  }

  async show(address, time) {
    const answer = await fetch(`${address}?time=${time}`);
    if (!answer.ok) throw new Error((await answer.json()).error);
    const buffer = await answer.arrayBuffer();
    if (address !== this.address) return;
    const taken = Number(answer.headers.get("X-Time-S"));
    const frame = await drawView(buffer, byId("rec-view"));
    byId("rec-view").dataset.frame = String(frame);
    // before the first image, the first is shown
    Object.assign(this, { from: Math.min(taken, time), until: Number(answer.headers.get("X-Until-S").replace("inf", "Infinity")) });
    byId("rec-view-told").textContent = `frame ${frame}, read at ${number(taken, 3)} s`;
  }
}
