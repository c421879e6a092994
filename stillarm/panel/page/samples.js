// Samples of one topic: times and columns in rings, and the server's binary messages (stillarm/panel/live/packing.py).

const HEAD_BYTES = 8;
export const LOST_S = 0.1; // three datagrams of a topic of every cycle
const LOST_ROWS = 3; // of a topic that is sent more rarely

export function unpack(buffer) {
  const view = new DataView(buffer);
  const kind = view.getUint8(0);
  const columns = view.getUint8(1);
  const rows = view.getUint16(2, true);
  const times = new Float64Array(buffer, HEAD_BYTES, rows);
  const values = [];
  for (let c = 0; c < columns; c++) values.push(new Float32Array(buffer, HEAD_BYTES + 8 * rows + 4 * rows * c, rows));
  return { kind, times, values };
}

export class Samples {
  // capacity: rows that are kept; the oldest ones give way. lost: after a pause of so many seconds, and of some rows,
  // something is missing, and no line belongs there.
  constructor(columns, capacity, lost = Infinity) {
    Object.assign(this, { lost, step: 0 });
    this.names = columns;
    this.capacity = capacity;
    this.times = new Float64Array(capacity);
    this.columns = columns.map(() => new Float32Array(capacity));
    this.end = 0; // rows ever added: row r lies at r % capacity
    this.begin = 0;
  }

  clear() {
    this.begin = this.end;
  }

  add(times, values) {
    for (let i = 0; i < times.length; i++) {
      // a time that goes back is another run of the controller
      if (this.end > this.begin && times[i] < this.newest() - 0.5) this.clear();
      const step = times[i] - this.newest(); // NaN at first
      if (step > Math.max(this.lost, LOST_ROWS * this.step)) this.put((this.newest() + times[i]) / 2, () => NaN);
      this.step = step || 0;
      this.put(times[i], (c) => values[c][i]);
    }
    this.begin = Math.max(this.begin, this.end - this.capacity);
  }

  put(time, value) {
    const at = this.end % this.capacity;
    this.times[at] = time;
    for (let c = 0; c < this.columns.length; c++) this.columns[c][at] = value(c);
    this.end++;
  }

  newest() {
    return this.end > this.begin ? this.times[(this.end - 1) % this.capacity] : NaN;
  }

  oldest() {
    return this.end > this.begin ? this.times[this.begin % this.capacity] : NaN;
  }

  column(name) {
    return this.columns[this.names.indexOf(name)];
  }

  // The first row whose time is not before `time`.
  rowAt(time) {
    let low = this.begin;
    let high = this.end;
    while (low < high) {
      const middle = Math.floor((low + high) / 2);
      if (this.times[middle % this.capacity] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  valueAt(name, time) {
    const row = this.rowAt(time + 1e-9) - 1;
    return row < this.begin ? NaN : this.column(name)[row % this.capacity];
  }
}

// Least and greatest value of each group of rows between two times, in the order in which they come: no peak is lost.
// Groups begin at multiples of their size, so that the picture stands still while it scrolls. spread: a column whose
// multiple by `factor` makes a band: its greatest upper and least lower edge in each group.
// Returns { x, y, low, high } of one length: two points a group, or one where a group is a single row.
export function decimate(samples, name, { from, to, groups, scale, offset = 0, spread = null, factor = 0 }) {
  const { times, capacity } = samples;
  const values = samples.column(name);
  const spreads = spread === null ? null : samples.column(spread);
  const first = Math.max(samples.begin, samples.rowAt(from) - 1);
  const last = Math.min(samples.end, samples.rowAt(to) + 1);
  const size = Math.max(1, Math.ceil((last - first) / groups));
  const found = { x: [], y: [], low: [], high: [] };
  const put = (row, y, low, high) => {
    found.x.push(times[row % capacity] + offset);
    found.y.push(y);
    if (spreads === null) return;
    found.low.push(low);
    found.high.push(high);
  };
  for (let row = first; row < last; ) {
    const next = Math.min(last, (Math.floor(row / size) + 1) * size);
    let [least, greatest, leastAt, greatestAt, low, high] = [Infinity, -Infinity, row, row, Infinity, -Infinity];
    for (let r = row; r < next; r++) {
      const at = r % capacity;
      const value = values[at];
      if (value < least) [least, leastAt] = [value, r];
      if (value > greatest) [greatest, greatestAt] = [value, r];
      if (spreads === null) continue;
      const wide = factor * spreads[at];
      if (value - wide < low) low = value - wide;
      if (value + wide > high) high = value + wide;
    }
    const missing = least > greatest;
    const rising = leastAt <= greatestAt;
    const edges = low > high ? [null, null] : [low * scale, high * scale];
    put(row, missing ? null : (rising ? least : greatest) * scale, ...edges);
    if (next - row > 1) put(Math.floor((row + next) / 2), missing ? null : (rising ? greatest : least) * scale, ...edges);
    row = next;
  }
  return found;
}
