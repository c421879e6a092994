// The Escape key, wherever it is pressed: in the page, in a frame, whose keys stay there, or in an open list of choices,
// which keeps the press to itself and lets the release through alone.

export class StopKey {
  // stop(): what the key is for.
  constructor(stop) {
    Object.assign(this, { stop, pressed: false });
    this.hear(window);
  }

  // place: a window, or the document of a frame, which may run no script of its own.
  hear(place) {
    const taken = (event) => event.key === "Escape" && !event.repeat;
    place.addEventListener("keydown", (event) => taken(event) && this.press(), { capture: true });
    place.addEventListener("keyup", (event) => taken(event) && this.release(), { capture: true });
  }

  press() {
    this.pressed = true;
    this.stop();
  }

  release() {
    if (!this.pressed) this.stop();
    this.pressed = false;
  }
}
