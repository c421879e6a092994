// Starts the page: signs in, opens the socket, and gives each view what concerns it.

import { byId } from "/page/dom.js";
import { Commission } from "/page/commission.js";
import { Health } from "/page/health.js";
import { Live } from "/page/live.js";
import { Operate } from "/page/operate.js";
import { Recordings } from "/page/recordings.js";
import { LiveSocket, signIn } from "/page/server.js";

const views = ["live", "recordings", "commission"];

function show(name) {
  for (const view of views) {
    const chosen = view === name;
    byId(`view-${view}`).hidden = !chosen;
    byId(`tab-${view}`).setAttribute("aria-selected", String(chosen));
    byId(`tab-${view}`).tabIndex = chosen ? 0 : -1;
  }
  if (name === "recordings") recordings.list();
  if (name === "commission") commission.show();
}

const refused = await signIn();
const health = new Health();
const operate = new Operate();
const socket = new LiveSocket(text, (buffer) => live.binary(buffer), (open) => health.connected(open));
export const live = new Live(socket); // for a browser's console and for tests: live.topics has every sample
const recordings = new Recordings();
const commission = new Commission();

const takers = {
  hello: (message) => {
    live.hello(message);
    operate.hello(message);
    byId("log").replaceChildren();
    message.log.forEach((line) => health.log(line));
    if (refused) operate.tell(refused);
  },
  status: (message) => {
    live.status(message);
    operate.status(message);
    health.status(message);
  },
  loop_second: (message) => health.loop(message),
  link: (message) => (health.link = message),
  log: (message) => health.log(message),
};

function text(message) {
  takers[message.type]?.(message);
}

for (const view of views) byId(`tab-${view}`).onclick = () => show(view);
byId("tabs").addEventListener("keydown", ({ key }) => {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[key];
  if (step === undefined) return;
  const now = views.findIndex((view) => byId(`tab-${view}`).getAttribute("aria-selected") === "true");
  const next = views[(now + step + views.length) % views.length];
  show(next);
  byId(`tab-${next}`).focus();
});

let frames = 0;
function eachFrame() {
  requestAnimationFrame(eachFrame);
  document.documentElement.dataset.frames = String(++frames);
  if (!byId("view-live").hidden) live.draw();
  if (!byId("view-recordings").hidden) recordings.draw();
  live.tellAge();
  if (frames % 30 === 0 && live.topics.frames) health.camera(live.topics.frames);
}
eachFrame();
