// The way to the server: requests with what its guard asks for, the socket with its reconnection, and its clock.

const RETRY_MS = [200, 500, 1000, 2000];
const PING_MS = 1000;

export async function get(path) {
  return answered(await fetch(path, { credentials: "same-origin" }));
}

export async function post(path, body = {}) {
  const headers = { "Content-Type": "application/json", "X-Stillarm-Panel": "1" };
  return answered(await fetch(path, { method: "POST", headers, body: JSON.stringify(body), credentials: "same-origin" }));
}

async function answered(answer) {
  const told = await answer.json().catch(() => ({}));
  if (!answer.ok) throw new Error(told.error ?? `the panel answered with status ${answer.status}`);
  return told;
}

// Exchanges the address's token for a session, and takes it out of the address.
export async function signIn() {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (token === null) return "";
  history.replaceState(null, "", location.pathname);
  try {
    await post("/api/session", { token });
    return "";
  } catch (error) {
    return error.message;
  }
}

// The server's monotonic clock, by the ping with the shortest way there and back of the last minute.
class ServerClock {
  constructor() {
    this.pings = [];
  }

  take(sentMs, serverS, nowMs) {
    this.pings.push({ way: nowMs - sentMs, offset: serverS - (sentMs + nowMs) / 2000 });
    if (this.pings.length > 60) this.pings.shift();
    this.offset = this.pings.reduce((best, ping) => (ping.way < best.way ? ping : best)).offset;
  }

  nowS() {
    return this.offset === undefined ? NaN : performance.now() / 1000 + this.offset;
  }
}

export class LiveSocket {
  constructor(onText, onBinary, onConnected) {
    Object.assign(this, { onText, onBinary, onConnected, failures: 0, clock: new ServerClock(), beside: [] });
    this.open();
    setInterval(() => this.ping(), PING_MS);
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = (this.socket = new WebSocket(`${scheme}://${location.host}/api/live`));
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.failures = 0;
      this.clock = new ServerClock();
      this.onConnected(true);
      for (let i = 0; i < 5; i++) setTimeout(() => this.ping(), 100 * i);
    };
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.text(JSON.parse(data)) : this.onBinary(data));
    socket.onclose = () => {
      this.onConnected(false);
      setTimeout(() => this.open(), RETRY_MS[Math.min(this.failures++, RETRY_MS.length - 1)]);
    };
  }

  text(message) {
    if (message.type === "pong") this.clock.take(message.ping, message.server_s, performance.now());
    else this.onText(message);
  }

  // Methods that the server shall run, as long as this page asks: each ping says so.
  want(methods) {
    this.beside = methods;
    this.ping();
  }

  ping() {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ ping: performance.now(), beside: this.beside }));
  }
}
