// The replay player of `report.html`: draws the recorded drives tick by tick. One classic script, because browsers load no module
// from a page opened through file://; it asks the network for nothing. `SimrunReplay.mount(document)` builds the player into
// `<section id="replay">` from the JSON of `#episodes` and `#maps`; what these hold is written down in `episode.rs`.
//
// The parts, in this order: reading (packed text -> drive), world (the picture), strips (states and numbers over time),
// player (clock, panes, keys, permalink). Lengths are metres, angles radians, times seconds; names say so where it could be doubted.

const SimrunReplay = (() => {
  "use strict";

  // ---- Reading -----------------------------------------------------------------------------------------------------------------

  /** The JSON that `packed` holds: base64 of raw deflate. */
  async function unpack(packed) {
    const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
    const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return JSON.parse(await new Response(plain).text());
  }

  /** The values of a delta array, as Float64Array. */
  function running(deltas, scale = 1e-3) {
    let sum = 0;
    return Float64Array.from(deltas ?? [], (delta) => (sum += delta) * scale);
  }

  /** The columns of a pose, one entry a row. */
  function track(packed) {
    return packed && { x: running(packed.x), y: running(packed.y), heading: running(packed.heading) };
  }

  function metres([x, y]) {
    return [x * 1e-3, y * 1e-3];
  }

  /** The last of `list`, in order of tick, that begins at `tick` or before; undefined if there is none. */
  function inForce(list, tick) {
    let [low, high] = [0, list.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (list[middle].tick <= tick) low = middle + 1;
      else high = middle;
    }
    return list[low - 1];
  }

  /** The cells of a map, one state each, row 0 at the bottom. */
  function cells(map) {
    const states = new Uint8Array(map.cols * map.rows);
    let at = 0;
    for (let i = 0; i + 1 < map.cells.length; i += 2) states.fill(map.cells[i], at, (at += map.cells[i + 1]));
    return { ...map, states };
  }

  /** An episode with its columns summed up and in metres, its lists in one form; parts that are missing are empty. */
  function read(entry, raw, map) {
    const { robot } = raw;
    const pose = track(robot);
    const count = pose.x.length;
    const dt_s = raw.dt_s ?? 0.1;
    const times = Float64Array.from(pose.x, (_, tick) => Math.round(tick * dt_s * 1e9) / 1e9);
    // A contact cuts the last tick short.
    if (raw.end?.time_s !== undefined) times[count - 1] = raw.end.time_s;
    const speedMax = raw.v_max / 1e3 || running(robot.v).reduce((most, v) => Math.max(most, Math.abs(v)), 0) || 1;
    const series = [
      robot.v && { name: "speed", unit: "m/s", values: running(robot.v), floor: 0, ceiling: speedMax },
      robot.w && { name: "turn rate", unit: "rad/s", values: running(robot.w), floor: 0 },
      // Beyond a kilometre there is nothing.
      raw.clearance && { name: "clearance", unit: "m", values: running(raw.clearance).map((value) => (value < 1e3 ? value : NaN)), floor: 0 },
      ...Object.entries(raw.notes ?? {}).map(([key, { values, scale = 1 }]) => {
        const plain = running(values, 1 / scale);
        return { ...quantity(key), values: plain, stepped: plain.every(Number.isInteger) };
      }),
    ].filter(Boolean);
    return {
      entry, map, dt_s, count, times, pose, series, speedMax,
      belief: raw.belief && beliefAtTheEnd(track(raw.belief)),
      footprint: shape(raw.footprint ?? { radius_m: 0.25 }, 1),
      start: metres([raw.start?.x ?? robot.x[0], raw.start?.y ?? robot.y[0]]),
      goals: (raw.goals ?? []).map(({ row, x, y }) => ({ tick: row, at: metres([x, y]) })),
      tolerance_m: raw.goal_tolerance_m ?? 0,
      unknown: (raw.unknown ?? []).map((one) => ({ shape: shape(one), from: one.from_row ?? 0, to: one.to_row ?? Infinity })),
      movers: (raw.movers ?? []).map(({ shape: outline, present, x, y }) => ({ shape: shape(outline), present, x: running(x), y: running(y) })),
      seen: (raw.seen ?? []).map(([tick, movers]) => ({ tick, movers })),
      sensed: (raw.sensed ?? []).map(([tick, list]) => ({ tick, points: list.map(metres) })),
      grown: grown(raw.grown ?? []),
      lidar: raw.lidar && scans(raw.lidar),
      paths: (raw.paths ?? []).map(({ row, x, y, nodes = [] }) => {
        const ys = running(y);
        return { tick: row, points: Array.from(running(x), (at, i) => [at, ys[i]]), nodes: nodes.map(metres) };
      }),
      subGoals: (raw.sub_goal ?? []).map(([tick, x, y]) => ({ tick, at: metres([x, y]) })),
      states: (raw.states?.changes ?? []).map(([tick, index]) => ({ tick, index, name: raw.states.names[index] ?? "" })),
      contact: raw.contact && { tick: raw.contact.row, at: metres([raw.contact.x, raw.contact.y]) },
    };
  }

  /** A row's belief is that with which its tick began, where the row before ended: there it is shown. The last row has none. */
  function beliefAtTheEnd({ x, y, heading }) {
    const earlier = (column) => Float64Array.from(column, (_, tick) => column[tick + 1] ?? NaN);
    return { x: earlier(x), y: earlier(y), heading: earlier(heading) };
  }

  /** What the robot's map had gained by each change. */
  function grown(changes) {
    const now = new Set();
    return changes.map(([tick, entered, left]) => {
      for (const cell of running(entered, 1)) now.add(cell);
      for (const cell of running(left, 1)) now.delete(cell);
      return { tick, cells: [...now] };
    });
  }

  /** The scans of a lidar, ranges in metres; 0 is no echo. */
  function scans({ first, step, count, every, unit_mm = 1, ranges }) {
    const now = new Float64Array(count);
    return Array.from({ length: Math.floor(ranges.length / count) }, (_, k) => {
      for (let ray = 0; ray < count; ray++) now[ray] += ranges[k * count + ray] * unit_mm * 1e-3;
      return { tick: k * every, first: first * 1e-3, step: step * 1e-3, ranges: now.slice() };
    });
  }

  /** A footprint, obstacle or mover as a path of metres, with how far it reaches from its origin. */
  function shape(packed, scale = 1e-3) {
    const path = new Path2D();
    const corners = Array.isArray(packed) ? packed : packed.polygon;
    if (corners) {
      corners.forEach(([x, y], i) => (i ? path.lineTo(x * scale, y * scale) : path.moveTo(x * scale, y * scale)));
      path.closePath();
      return { path, reach: scale * Math.max(...corners.map(([x, y]) => Math.hypot(x, y))), front: scale * Math.max(...corners.map(([x]) => x)) };
    }
    const { x = 0, y = 0, r } = packed.disc ?? { r: packed.radius_m };
    path.arc(x * scale, y * scale, r * scale, 0, 2 * Math.PI);
    return { path, reach: r * scale, front: r * scale };
  }

  const UNITS = { mps: "m/s", radps: "rad/s", mps2: "m/s²", mps3: "m/s³", "1pm": "1/m", deg: "°", rad: "rad", m: "m", s: "s" };

  /** `clearance_min_m` -> clearance min, in m. */
  function quantity(key) {
    const [, stem, unit] = /^(.*?)(?:_(mps2|mps3|mps|radps|1pm|deg|rad|m|s))?$/.exec(key);
    return { name: stem.replaceAll("_", " "), unit: UNITS[unit] ?? "" };
  }

  /** A number at the length at which people compare it; `whole` has no decimals. */
  function short(value, whole = false) {
    if (!Number.isFinite(value)) return "–";
    if (value === 0) return "0";
    const size = Math.abs(value);
    return value.toFixed(whole || size >= 100 ? 0 : size >= 10 ? 1 : size >= 0.1 ? 2 : 3).replace("-", "−");
  }

  function measured(value, unit, whole) {
    return short(value, whole) + (unit && unit !== "°" ? ` ${unit}` : unit);
  }

  /** The index and the fraction of a tick at which a drive stands at `time`; after its end it stays there. */
  function locate(drive, time) {
    const last = drive.count - 1;
    if (!(time < drive.times[last])) return [last, 0];
    const tick = Math.max(0, Math.min(last - 1, Math.floor(time / drive.dt_s + 1e-6)));
    const part = (time - drive.times[tick]) / (drive.times[tick + 1] - drive.times[tick]);
    return [tick, part < 1e-6 ? 0 : part];
  }

  /** The pose of a track between two ticks: straight in position, the short way round in heading. */
  function poseAt({ x, y, heading }, tick, part = 0) {
    const next = Math.min(tick + 1, x.length - 1);
    const turn = heading[next] - heading[tick];
    const between = (column) => (part ? column[tick] + part * (column[next] - column[tick]) : column[tick]);
    return {
      x: between(x),
      y: between(y),
      heading: heading.length ? heading[tick] + (part ? part * Math.atan2(Math.sin(turn), Math.cos(turn)) : 0) : 0,
    };
  }

  // ---- World -------------------------------------------------------------------------------------------------------------------

  /** What can be hidden: key, words, whether it is what the robot believed or what was true, and whether a drive has it. */
  const LAYERS = [
    { key: "trail", words: "trail by speed", side: "true", has: () => true },
    { key: "movers", words: "movers, 1 s ahead", side: "true", has: (drive) => drive.movers.length > 0 },
    { key: "unknown", words: "obstacles not on the map", side: "true", has: (drive) => drive.unknown.length > 0 },
    { key: "path", words: "path", side: "believed", has: (drive) => drive.paths.length > 0 },
    { key: "goal", words: "sub-goal", side: "believed", has: (drive) => drive.subGoals.length > 0 },
    { key: "pose", words: "pose", side: "believed", has: (drive) => Boolean(drive.belief) },
    { key: "seen", words: "sensed movers", side: "believed", has: (drive) => drive.seen.some(({ movers }) => movers.length > 0) },
    { key: "sensed", words: "where sensed", side: "believed", has: (drive) => drive.sensed.length > 0 },
    { key: "grown", words: "added to its map", side: "believed", has: (drive) => drive.grown.length > 0 },
    { key: "lidar", words: "laser scan", side: "believed", has: (drive) => Boolean(drive.lidar) },
  ];

  /** From standing to full speed: steps between Okabe and Ito's vermillion, orange, sky blue and blue. */
  const SPEED_STOPS = [[213, 94, 0], [230, 159, 0], [86, 180, 233], [0, 114, 178]];
  const SPEED_STEPS = 16;
  const SPEED_COLOURS = Array.from({ length: SPEED_STEPS }, (_, i) => {
    const along = (i / (SPEED_STEPS - 1)) * (SPEED_STOPS.length - 1);
    const stop = Math.min(Math.floor(along), SPEED_STOPS.length - 2);
    const mixed = SPEED_STOPS[stop].map((from, c) => Math.round(from + (along - stop) * (SPEED_STOPS[stop + 1][c] - from)));
    return `rgb(${mixed.join()})`;
  });
  const STATE_COLOURS = ["#56B4E9", "#E69F00", "#CC79A7", "#009E73", "#F0E442", "#D55E00", "#0072B2", "#999999"];

  /** The largest of 1, 2, 5 × 10ⁿ that is at most `most`. */
  function round125(most) {
    const power = 10 ** Math.floor(Math.log10(most));
    return power * [5, 2, 1].find((step) => step * power <= most * (1 + 1e-9));
  }

  /** A canvas that keeps as many pixels as the screen shows of it, and tells when that changes. */
  class Surface {
    constructor(canvas, changed) {
      Object.assign(this, { canvas, width: 0, height: 0, ratio: 1, context: canvas.getContext("2d") });
      this.observer = new ResizeObserver(() => { this.fit(); changed(); });
      this.observer.observe(canvas);
    }

    fit(ratioMin = 1) {
      const box = this.canvas.getBoundingClientRect();
      this.ratio = Math.max(window.devicePixelRatio || 1, ratioMin);
      [this.width, this.height] = [box.width, box.height];
      const size = [box.width, box.height].map((side) => Math.max(1, Math.round(side * this.ratio)));
      if (this.canvas.width !== size[0] || this.canvas.height !== size[1]) [this.canvas.width, this.canvas.height] = size;
    }

    /** Cleared, in CSS pixels, with the page's own letters. */
    begin(style) {
      const { context: c } = this;
      c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
      c.clearRect(0, 0, this.width, this.height);
      c.font = `12px ${style.family}`;
      c.textBaseline = "middle";
      c.lineJoin = c.lineCap = "round";
      return c;
    }

    /** The nearest place at which a line one pixel wide is sharp. */
    sharp(place) {
      return (Math.round(place * this.ratio - 0.5) + 0.5) / this.ratio;
    }
  }

  /** A drawing of a surface's size that is kept from frame to frame, until its stamp or the colours change. */
  class Sheet {
    constructor(surface) {
      const canvas = document.createElement("canvas");
      Object.assign(this, { surface, canvas, context: canvas.getContext("2d"), stamp: "" });
    }

    /** Whether it has to be drawn anew; then it is empty. */
    begin(stamp, style) {
      const { canvas, ratio } = this.surface;
      const now = [stamp, style.edition, canvas.width, canvas.height, ratio].join();
      if (now === this.stamp) return false;
      this.stamp = now;
      [this.canvas.width, this.canvas.height] = [canvas.width, canvas.height];
      this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
      this.context.font = `12px ${style.family}`;
      this.context.textBaseline = "middle";
      this.context.lineJoin = this.context.lineCap = "round";
      return true;
    }

    lay(c) {
      const { ratio } = this.surface;
      c.setTransform(1, 0, 0, 1, 0, 0);
      c.drawImage(this.canvas, 0, 0);
      c.setTransform(ratio, 0, 0, ratio, 0, 0);
    }
  }

  /** Room that the fitted map leaves: at the sides and above, and below for the scale. */
  const [MARGIN, FOOT] = [8, 40];

  /** Draws one drive at one time into a surface, under a view that panes share. */
  class World {
    constructor(surface, drive) {
      Object.assign(this, { surface, drive, ground: new Sheet(surface), tracks: new Sheet(surface), trailed: 0 });
      const { pose: { x, y }, speedMax, series } = drive;
      const speeds = series.find(({ name }) => name === "speed")?.values;
      // Each segment's step of the ramp; its speed is the one with which its tick ended.
      this.steps = Uint8Array.from(x, (_, i) => Math.round(Math.min(1, Math.abs(speeds?.[i] ?? speedMax) / speedMax) * (SPEED_STEPS - 1)));
      const { cols, rows, resolution_m } = drive.map ?? {};
      this.bounds = drive.map ? [0, 0, cols * resolution_m, rows * resolution_m] : [Math.min(...x) - 1, Math.min(...y) - 1, Math.max(...x) + 1, Math.max(...y) + 1];
    }

    /** The view that shows the whole map. */
    fitted() {
      const [left, bottom, right, top] = this.bounds;
      const { width, height } = this.surface;
      const scale = Math.max(Math.min((width - 2 * MARGIN) / (right - left), (height - MARGIN - FOOT) / (top - bottom)), 1e-3);
      return { scale, x: (left + right) / 2, y: (bottom + top) / 2 - (FOOT - MARGIN) / 2 / scale };
    }

    screen(x, y) {
      return [this.surface.width / 2 + (x - this.view.x) * this.view.scale, this.surface.height / 2 - (y - this.view.y) * this.view.scale];
    }

    /** `path`, in metres of a frame that stands at `pose`, on the screen. */
    place(path, { x, y, heading }) {
      const { scale } = this.view;
      const [cos, sin] = [Math.cos(heading) * scale, Math.sin(heading) * scale];
      const placed = new Path2D();
      placed.addPath(path, new DOMMatrix([cos, -sin, -sin, -cos, ...this.screen(x, y)]));
      return placed;
    }

    draw(view, layers, tick, part, style, mapImages) {
      const { drive, surface } = this;
      this.view = view;
      const c = surface.begin(style);
      const place = [view.scale, view.x, view.y].join();
      if (this.ground.begin(place + layers.has("trail"), style)) {
        this.floor(this.ground.context, style, mapImages);
        if (layers.has("trail")) this.way(this.ground.context, style);
      }
      this.ground.lay(c);
      if (layers.has("unknown")) this.unknown(c, style, tick);
      if (layers.has("grown")) this.grown(c, style, tick);
      if (layers.has("path")) this.path(c, style, tick);
      if (layers.has("trail")) this.trail(c, style, place, tick, part);
      this.ends(c, style, tick);
      if (layers.has("lidar") && drive.lidar) this.lidar(c, style, tick);
      if (layers.has("movers")) this.movers(c, style, tick, part, layers.has("seen"));
      if (layers.has("sensed")) this.sensed(c, style, tick);
      if (layers.has("goal")) this.subGoal(c, style, tick);
      this.robot(c, style, tick, part, layers.has("pose"));
      this.contact(c, style, tick);
      this.scaleBar(c, style);
      if (layers.has("trail")) this.speeds(c, style);
    }

    floor(c, style, mapImages) {
      const { map } = this.drive;
      if (!map) return;
      const { scale } = this.view;
      const { cols, rows, resolution_m } = map;
      const [left, top] = this.screen(0, rows * resolution_m);
      const [width, height] = [cols, rows].map((count) => count * resolution_m * scale);
      // Cells stay sharp when they are larger than a pixel; smaller ones are averaged, so that thin walls do not vanish.
      c.imageSmoothingEnabled = resolution_m * scale * this.surface.ratio < 1;
      c.imageSmoothingQuality = "high";
      c.drawImage(mapImages.of(map, style), left, top, width, height);
      c.strokeStyle = style.wall;
      c.lineWidth = 1;
      c.strokeRect(left - 0.5, top - 0.5, width + 1, height + 1);
    }

    unknown(c, style, tick) {
      for (const { shape: { path }, from, to } of this.drive.unknown) {
        if (tick < from || tick >= to) continue;
        const placed = this.place(path, { x: 0, y: 0, heading: 0 });
        c.fillStyle = style.hatch(c);
        c.fill(placed);
        c.strokeStyle = style.unknown;
        c.lineWidth = 1.5;
        c.stroke(placed);
      }
    }

    grown(c, style, tick) {
      const { map, grown } = this.drive;
      const added = inForce(grown, tick);
      if (!added || !map) return;
      const side = map.resolution_m;
      c.fillStyle = style.belief;
      c.beginPath();
      for (const cell of added.cells) {
        const [x, y] = this.screen((cell % map.cols) * side, (Math.floor(cell / map.cols) + 1) * side);
        c.rect(x, y, side * this.view.scale, side * this.view.scale);
      }
      c.globalAlpha = 0.35;
      c.fill();
      c.globalAlpha = 1;
    }

    line(c, list) {
      c.beginPath();
      list.forEach(([x, y], i) => (i ? c.lineTo(...this.screen(x, y)) : c.moveTo(...this.screen(x, y))));
    }

    path(c, style, tick) {
      const path = inForce(this.drive.paths, tick);
      if (!path) return;
      this.line(c, path.points);
      c.strokeStyle = style.path;
      c.lineWidth = 2;
      c.setLineDash([7, 5]);
      c.stroke();
      c.setLineDash([]);
      c.fillStyle = style.path;
      for (const node of path.nodes) this.dot(c, ...this.screen(...node), 2.5);
    }

    dot(c, x, y, radius) {
      c.beginPath();
      c.arc(x, y, radius, 0, 2 * Math.PI);
      c.fill();
    }

    /** The whole drive, thin; the trail covers what has been driven. */
    way(c, style) {
      const { x, y } = this.drive.pose;
      c.beginPath();
      for (let i = 0; i < x.length; i++) c.lineTo(...this.screen(x[i], y[i]));
      c.strokeStyle = style.faint;
      c.lineWidth = 1.25;
      c.stroke();
    }

    /** What has been driven, by speed: the ticks that are past are kept, the one that is under way is added. */
    trail(c, style, place, tick, part) {
      if (tick < this.trailed) this.tracks.stamp = "";
      if (this.tracks.begin(place, style)) this.trailed = 0;
      this.segments(this.tracks.context, this.trailed, tick);
      this.trailed = tick;
      this.tracks.lay(c);
      if (!part) return;
      const [from, to] = [poseAt(this.drive.pose, tick), poseAt(this.drive.pose, tick, part)];
      c.beginPath();
      c.moveTo(...this.screen(from.x, from.y));
      c.lineTo(...this.screen(to.x, to.y));
      c.strokeStyle = SPEED_COLOURS[this.steps[tick + 1]];
      c.lineWidth = 3;
      c.stroke();
    }

    /** The ticks after row `from` up to row `to`, those of one colour in one stroke. */
    segments(c, from, to) {
      const { x, y } = this.drive.pose;
      c.lineWidth = 3;
      for (let i = from; i < to;) {
        const step = this.steps[i + 1];
        c.beginPath();
        c.moveTo(...this.screen(x[i], y[i]));
        while (i < to && this.steps[i + 1] === step) c.lineTo(...this.screen(x[++i], y[i]));
        c.strokeStyle = SPEED_COLOURS[step];
        c.stroke();
      }
    }

    /** Start, and the goal in force with how near is near enough. */
    ends(c, style, tick) {
      const { start, goals, tolerance_m } = this.drive;
      c.lineWidth = 2;
      c.strokeStyle = style.ink;
      c.fillStyle = style.floor;
      this.dot(c, ...this.screen(...start), 4.5);
      c.stroke();
      const goal = inForce(goals, tick) ?? goals[0];
      if (!goal) return;
      const [gx, gy] = this.screen(...goal.at);
      c.beginPath();
      c.arc(gx, gy, Math.max(tolerance_m * this.view.scale, 8), 0, 2 * Math.PI);
      c.lineWidth = 1.5;
      c.stroke();
      this.mark(c, gx, gy, 4.5, style.ink, style.floor, 2.5);
    }

    /** A cross with a rim, so that it is seen on any ground. */
    mark(c, x, y, size, colour, rim, width = 2) {
      c.beginPath();
      for (const side of [1, -1]) {
        c.moveTo(x - size, y - side * size);
        c.lineTo(x + size, y + side * size);
      }
      for (const [stroke, extra] of [[rim, 2.5], [colour, 0]]) {
        c.strokeStyle = stroke;
        c.lineWidth = width + extra;
        c.stroke();
      }
    }

    lidar(c, style, tick) {
      const scan = inForce(this.drive.lidar, tick);
      if (!scan) return;
      const at = poseAt(this.drive.pose, scan.tick);
      const from = this.screen(at.x, at.y);
      c.fillStyle = c.strokeStyle = style.lidar;
      c.lineWidth = 0.75;
      c.globalAlpha = 0.35;
      c.beginPath();
      const echoes = [];
      scan.ranges.forEach((range, ray) => {
        if (!(range > 0)) return;
        const angle = at.heading + scan.first + ray * scan.step;
        echoes.push(this.screen(at.x + range * Math.cos(angle), at.y + range * Math.sin(angle)));
        c.moveTo(...from);
        c.lineTo(...echoes.at(-1));
      });
      c.stroke();
      c.globalAlpha = 1;
      for (const [x, y] of echoes) c.fillRect(x - 1.25, y - 1.25, 2.5, 2.5);
    }

    movers(c, style, tick, part, seen) {
      const sensed = seen ? inForce(this.drive.seen, tick)?.movers ?? [] : [];
      const { movers, dt_s } = this.drive;
      const isThere = ({ present, x }, at) => at >= 0 && at < x.length && (!present || present.some(([from, to]) => from <= at && at < to));
      movers.forEach((mover, number) => {
        if (!isThere(mover, tick)) return;
        const { x, y } = mover;
        const goesOn = isThere(mover, tick + 1);
        const pose = poseAt({ x, y, heading: [] }, tick, goesOn ? part : 0);
        const placed = this.place(mover.shape.path, pose);
        c.fillStyle = style.mover;
        c.fill(placed);
        const place = this.screen(pose.x, pose.y);
        if (mover.shape.reach * this.view.scale < 2.5) this.dot(c, ...place, 2.5);
        c.strokeStyle = style.floor;
        c.lineWidth = 1;
        c.stroke(placed);
        if (sensed.includes(number)) {
          c.beginPath();
          c.arc(...place, mover.shape.reach * this.view.scale + 4, 0, 2 * Math.PI);
          c.strokeStyle = style.belief;
          c.lineWidth = 1.5;
          c.stroke();
        }
        const before = goesOn ? tick : tick - 1;
        if (!isThere(mover, before)) return;
        const [vx, vy] = [x, y].map((column) => (column[before + 1] - column[before]) / dt_s);
        if (Math.hypot(vx, vy) * this.view.scale > 5) this.arrow(c, place, this.screen(pose.x + vx, pose.y + vy), style);
      });
    }

    arrow(c, from, to, style) {
      const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
      c.beginPath();
      c.moveTo(...from);
      c.lineTo(...to);
      for (const side of [2.6, -2.6]) {
        c.moveTo(...to);
        c.lineTo(to[0] + 5 * Math.cos(angle + side), to[1] + 5 * Math.sin(angle + side));
      }
      for (const [stroke, width] of [[style.floor, 3.5], [style.arrow, 1.5]]) {
        c.strokeStyle = stroke;
        c.lineWidth = width;
        c.stroke();
      }
    }

    sensed(c, style, tick) {
      const sensed = inForce(this.drive.sensed, tick);
      for (const [x, y] of sensed?.points ?? []) this.mark(c, ...this.screen(x, y), 3, style.sensed, style.floor, 1.5);
    }

    subGoal(c, style, tick) {
      const goal = inForce(this.drive.subGoals, tick);
      if (!goal) return;
      const [x, y] = this.screen(...goal.at);
      c.beginPath();
      for (const [dx, dy] of [[0, -6], [6, 0], [0, 6], [-6, 0]]) c.lineTo(x + dx, y + dy);
      c.closePath();
      c.fillStyle = style.path;
      c.fill();
      c.strokeStyle = style.floor;
      c.lineWidth = 1.25;
      c.stroke();
    }

    robot(c, style, tick, part, believed) {
      const { drive, view } = this;
      const { path, reach, front } = drive.footprint;
      const pose = poseAt(drive.pose, tick, part);
      const [x, y] = this.screen(pose.x, pose.y);
      const placed = this.place(path, pose);
      if (reach * view.scale < 7) {
        // Too small to be found: a ring points it out.
        c.beginPath();
        c.arc(x, y, 10, 0, 2 * Math.PI);
        c.strokeStyle = style.robot;
        c.lineWidth = 1.5;
        c.stroke();
      }
      c.fillStyle = style.robot;
      c.fill(placed);
      c.strokeStyle = style.floor;
      c.lineWidth = 1.25;
      c.stroke(placed);
      const nose = Math.max(front * view.scale, 9);
      c.beginPath();
      c.moveTo(x, y);
      c.lineTo(x + nose * Math.cos(pose.heading), y - nose * Math.sin(pose.heading));
      for (const [stroke, width] of [[style.floor, 4], [style.ink, 2]]) {
        c.strokeStyle = stroke;
        c.lineWidth = width;
        c.stroke();
      }
      if (!believed || !drive.belief) return;
      const belief = poseAt(drive.belief, tick, Number.isNaN(drive.belief.x[tick + 1]) ? 0 : part);
      if (Number.isNaN(belief.x)) return;
      const [bx, by] = this.screen(belief.x, belief.y);
      c.strokeStyle = style.belief;
      c.lineWidth = 2;
      c.setLineDash([4, 3]);
      c.stroke(this.place(path, belief));
      c.setLineDash([]);
      c.beginPath();
      c.moveTo(bx, by);
      c.lineTo(bx + nose * Math.cos(belief.heading), by - nose * Math.sin(belief.heading));
      c.stroke();
    }

    contact(c, style, tick) {
      const { contact } = this.drive;
      if (!contact || tick < contact.tick) return;
      const [x, y] = this.screen(...contact.at);
      c.beginPath();
      for (let i = 0; i < 16; i++) {
        const reach = i % 2 ? 5 : 12;
        c.lineTo(x + reach * Math.sin((i * Math.PI) / 8), y - reach * Math.cos((i * Math.PI) / 8));
      }
      c.closePath();
      c.fillStyle = style.contact;
      c.fill();
      c.strokeStyle = style.floor;
      c.lineWidth = 1.5;
      c.stroke();
    }

    plate(c, style, x, y, width, height) {
      c.fillStyle = style.plate;
      c.beginPath();
      c.roundRect(x, y, width, height, 4);
      c.fill();
    }

    scaleBar(c, style) {
      const metres = round125(Math.min(140, this.surface.width / 4) / this.view.scale);
      const [width, bottom] = [metres * this.view.scale, this.surface.height - 16];
      const words = `${metres} m`;
      const wide = Math.max(width, c.measureText(words).width) + 16;
      this.plate(c, style, 8, bottom - 22, wide, 30);
      const { surface } = this;
      const [left, right, base] = [surface.sharp(16), surface.sharp(16 + width), surface.sharp(bottom)];
      c.strokeStyle = c.fillStyle = style.ink;
      c.lineWidth = 1;
      c.lineCap = "butt";
      c.beginPath();
      c.moveTo(left, base - 5);
      c.lineTo(left, base);
      c.lineTo(right, base);
      c.lineTo(right, base - 5);
      c.stroke();
      c.fillText(words, 16, bottom - 12);
    }

    speeds(c, style) {
      const [width, bottom] = [96, this.surface.height - 16];
      const left = this.surface.width - width - 16;
      this.plate(c, style, left - 8, bottom - 22, width + 16, 30);
      for (let i = 0; i < SPEED_STEPS; i++) {
        c.fillStyle = SPEED_COLOURS[i];
        c.fillRect(left + (i * width) / SPEED_STEPS, bottom - 3, width / SPEED_STEPS + 0.5, 4);
      }
      c.fillStyle = style.ink;
      c.fillText("0", left, bottom - 12);
      c.textAlign = "right";
      c.fillText(`${short(this.drive.speedMax)} m/s`, left + width, bottom - 12);
      c.textAlign = "left";
    }
  }

  /** Maps as images of one pixel a cell, painted once for each set of colours. */
  class MapImages {
    constructor() { this.forget(); }

    forget() { this.images = new WeakMap(); }

    of(map, style) {
      if (this.images.has(map)) return this.images.get(map);
      const image = document.createElement("canvas");
      [image.width, image.height] = [map.cols, map.rows];
      const c = image.getContext("2d");
      const pixels = c.createImageData(map.cols, map.rows);
      const probe = new OffscreenCanvas(3, 1).getContext("2d", { willReadFrequently: true });
      const colours = [style.floor, style.wall, style.uncharted].map((colour, i) => {
        probe.fillStyle = colour;
        probe.fillRect(i, 0, 1, 1);
        return probe.getImageData(i, 0, 1, 1).data;
      });
      for (let row = 0; row < map.rows; row++) {
        for (let col = 0; col < map.cols; col++) {
          pixels.data.set(colours[map.states[row * map.cols + col]] ?? colours[2], 4 * ((map.rows - 1 - row) * map.cols + col));
        }
      }
      c.putImageData(pixels, 0, 0);
      this.images.set(map, image);
      return image;
    }
  }

  // ---- Strips ------------------------------------------------------------------------------------------------------------------

  const STRIP = { left: 44, right: 12, band: 22, row: 62, head: 18, axis: 24, top: 4 };

  /** The state of the planner as a band and each number as a strip, over one axis of time. */
  class Strips {
    constructor(surface, drive, ranges) {
      Object.assign(this, { surface, drive, ranges, hover_s: null, sheet: new Sheet(surface) });
      this.banded = drive.states.length > 0;
      this.height = STRIP.top + (this.banded ? STRIP.band + 8 : 0) + STRIP.row * drive.series.length + STRIP.axis;
      surface.canvas.style.height = `${this.height}px`;
    }

    across(time) {
      return STRIP.left + (time / this.duration_s) * (this.surface.width - STRIP.left - STRIP.right);
    }

    /** The time at `x` pixels from the left. */
    timeAt(x) {
      const along = (x - STRIP.left) / (this.surface.width - STRIP.left - STRIP.right);
      return Math.max(0, Math.min(1, along)) * this.duration_s;
    }

    rowTop(i) {
      return STRIP.top + (this.banded ? STRIP.band + 8 : 0) + i * STRIP.row;
    }

    draw(time, tick, duration_s, style) {
      this.duration_s = Math.max(duration_s, 1e-9);
      const { surface } = this;
      if (this.sheet.begin(this.duration_s, style)) this.paint(this.sheet.context, style);
      const c = surface.begin(style);
      this.sheet.lay(c);
      const bottom = this.height - STRIP.axis;
      this.cursor(c, this.across(time), bottom, style.ink, 1.5);
      this.timeLabel(c, style, time, bottom, style.ink);
      // Where the pointer is, the numbers are those of its time.
      const hovers = this.hover_s !== null;
      if (hovers) {
        [tick] = locate(this.drive, this.hover_s);
        this.cursor(c, this.across(this.hover_s), bottom, style.faint, 1);
        this.timeLabel(c, style, this.hover_s, bottom, style.muted, inForce(this.drive.states, tick)?.name);
      }
      c.textAlign = "right";
      this.drive.series.forEach(({ values, unit, stepped }, i) => {
        const value = values[Math.min(tick, values.length - 1)];
        c.fillStyle = hovers ? style.muted : style.ink;
        c.font = `600 12px ${style.family}`;
        const text = [measured(value, unit, stepped), surface.width - STRIP.right, this.rowTop(i) + STRIP.head / 2];
        c.strokeStyle = style.page;
        c.lineWidth = 4;
        c.strokeText(...text);
        c.fillText(...text);
        if (!Number.isFinite(value)) return;
        c.beginPath();
        c.arc(this.across(this.drive.times[tick]), this.down(i, value), 3, 0, 2 * Math.PI);
        c.fillStyle = style.series;
        c.fill();
        c.strokeStyle = style.page;
        c.lineWidth = 1.5;
        c.stroke();
      });
      c.textAlign = "left";
    }

    cursor(c, x, bottom, colour, width) {
      const at = width === 1 ? this.surface.sharp(x) : x;
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.beginPath();
      c.moveTo(at, 0);
      c.lineTo(at, bottom + 3);
      c.stroke();
    }

    timeLabel(c, style, time, bottom, colour, state) {
      const words = `${time.toFixed(1)} s${state ? ` · ${state}` : ""}`;
      c.font = `600 12px ${style.family}`;
      const width = c.measureText(words).width + 10;
      const x = Math.max(0, Math.min(this.surface.width - width, this.across(time) - width / 2));
      // No half of a number looks out from behind it.
      c.fillStyle = style.page;
      for (const { x: middle, half } of this.numbers) {
        if (middle + half > x - 3 && middle - half < x + width + 3) c.fillRect(middle - half - 1, bottom + 5, 2 * half + 2, 16);
      }
      c.fillStyle = colour;
      c.beginPath();
      c.roundRect(x, bottom + 4, width, 17, 3);
      c.fill();
      c.fillStyle = style.page;
      c.textAlign = "left";
      c.fillText(words, x + 5, bottom + 13);
    }

    down(i, value) {
      const [low, high] = this.ranges(this.drive.series[i]);
      const top = this.rowTop(i) + STRIP.head;
      return top + (1 - (value - low) / (high - low)) * (STRIP.row - STRIP.head - 8);
    }

    /** All that does not move with the cursor. */
    paint(c, style) {
      const { surface, drive } = this;
      const [left, right, bottom] = [STRIP.left, surface.width - STRIP.right, this.height - STRIP.axis];
      c.lineCap = "butt";
      // The axis: whole steps of seconds, and a stroke through all strips at each.
      const step = round125(Math.max(this.duration_s / Math.max(2, (right - left) / 70), 0.1) * 2);
      c.lineWidth = 1;
      c.fillStyle = style.muted;
      c.textAlign = "center";
      this.numbers = [];
      for (let i = 0; i * step <= this.duration_s * (1 + 1e-9); i++) {
        const x = surface.sharp(this.across(i * step));
        c.strokeStyle = style.rule;
        c.beginPath();
        c.moveTo(x, STRIP.top + (this.banded ? STRIP.band : 0));
        c.lineTo(x, bottom);
        c.stroke();
        const number = `${+(i * step).toFixed(3)}${i ? "" : " s"}`;
        c.fillText(number, x, bottom + 13);
        this.numbers.push({ x, half: c.measureText(number).width / 2 });
      }
      if (this.banded) this.band(c, style);
      drive.series.forEach((one, i) => this.strip(c, style, one, i, left, right));
      // A tooth where a new path came into force.
      c.fillStyle = style.path;
      for (const { tick } of drive.paths.slice(1)) {
        const x = this.across(drive.times[Math.min(tick, drive.count - 1)]);
        c.beginPath();
        for (const [dx, dy] of [[-3.5, 6], [3.5, 6], [0, 0]]) c.lineTo(x + dx, bottom - 5 + dy);
        c.fill();
      }
    }

    band(c, style) {
      const { states, times, count } = this.drive;
      c.textAlign = "left";
      states.forEach(({ tick, index, name }, i) => {
        const until = states[i + 1]?.tick ?? count - 1;
        const [from, to] = [tick, Math.max(until, tick)].map((at) => this.across(times[Math.min(at, count - 1)]));
        c.fillStyle = STATE_COLOURS[index % STATE_COLOURS.length];
        c.fillRect(from, STRIP.top, Math.max(to - from, 1), STRIP.band);
        if (to - from < c.measureText(name).width + 10) return;
        c.fillStyle = index % STATE_COLOURS.length === 6 ? "#fff" : "#111";
        c.fillText(name, from + 5, STRIP.top + STRIP.band / 2 + 0.5);
      });
      c.fillStyle = style.muted;
      c.textAlign = "right";
      c.fillText("state", STRIP.left - 6, STRIP.top + STRIP.band / 2 + 0.5);
    }

    strip(c, style, one, i, left, right) {
      const { surface, drive: { times } } = this;
      const [low, high] = this.ranges(one);
      const [top, base] = [surface.sharp(this.down(i, high)), surface.sharp(this.down(i, low))];
      c.strokeStyle = style.rule;
      c.lineWidth = 1;
      c.beginPath();
      for (const y of [top, base]) {
        c.moveTo(left, y);
        c.lineTo(right, y);
      }
      c.stroke();
      c.textAlign = "right";
      c.fillStyle = style.muted;
      c.fillText(short(high, one.stepped), left - 6, top + 1);
      c.fillText(short(low, one.stepped), left - 6, base - 1);
      c.textAlign = "left";
      c.fillStyle = style.ink;
      c.fillText(one.name, left, this.rowTop(i) + STRIP.head / 2);
      if (low < 0 && high > 0) {
        c.setLineDash([2, 3]);
        c.beginPath();
        c.moveTo(left, surface.sharp(this.down(i, 0)));
        c.lineTo(right, surface.sharp(this.down(i, 0)));
        c.stroke();
        c.setLineDash([]);
      }
      // A column of pixels shows the least and the greatest of its ticks, so that nothing short is lost.
      c.strokeStyle = style.series;
      c.lineWidth = 1.5;
      c.lineJoin = "round";
      c.beginPath();
      const pixel = 1 / surface.ratio;
      let [drawing, column, least, most, y] = [false, -1, 0, 0, 0];
      const flush = () => {
        if (!drawing || least === most) return;
        c.lineTo(column, least);
        c.lineTo(column, most);
        c.lineTo(column, y);
      };
      for (let tick = 0; tick < one.values.length && tick < times.length; tick++) {
        const value = one.values[tick];
        if (Number.isNaN(value)) {
          flush();
          [drawing, column] = [false, -1];
          continue;
        }
        const x = this.across(times[tick]);
        const before = y;
        y = this.down(i, value);
        if (drawing && x - column < pixel) {
          [least, most] = [Math.min(least, y), Math.max(most, y)];
          continue;
        }
        flush();
        if (drawing && one.stepped) c.lineTo(x, before);
        if (drawing) c.lineTo(x, y);
        else c.moveTo(x, y);
        [drawing, column, least, most] = [true, x, y, y];
      }
      flush();
      c.stroke();
    }
  }

  /** The range of a series over all panes, so that two strips side by side are to one scale. */
  function rangesOver(drives) {
    const known = new Map();
    for (const { name, values, floor, ceiling } of drives.flatMap(({ series }) => series)) {
      const range = known.get(name) ?? [floor ?? Infinity, ceiling ?? -Infinity];
      for (const value of values) {
        if (value < range[0]) range[0] = value;
        if (value > range[1]) range[1] = value;
      }
      known.set(name, range);
    }
    return ({ name }) => {
      const [low, high] = known.get(name);
      if (!(low <= high)) return [0, 1];
      return low < high ? [low, high] : [low - 0.5, high + 0.5];
    };
  }

  // ---- Player ------------------------------------------------------------------------------------------------------------------

  const RATES = [0.25, 0.5, 1, 2, 4, 8, 16];
  const KEYS = [
    ["space", "play, pause"], ["← →", "one tick"], ["shift ← →", "one second"], ["home, end", "start, end"], ["j, k or ↓ ↑", "next, previous episode"],
    ["s", "side by side with the next stack"], ["f", "the whole map"], ["+ −", "zoom at the robot"], ["c", "keep the robot in the middle"],
  ];
  const ICONS = {
    play: "M5 3l9 5.5L5 14z", pause: "M4 3h3v11H4zM10 3h3v11h-3z", back: "M11 3L4.5 8.5 11 14zM3 3h1.5v11H3z", step: "M6 3l6.5 5.5L6 14zM12.5 3H14v11h-1.5z",
  };

  /** What people look for first among the metrics of a drive. */
  const STATS_FIRST = ["time_s", "length_m", "clearance_min_m", "speed_mean_mps", "replans"];

  /** An element with attributes and children; `on…` are listeners. */
  function make(tag, attributes = {}, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
      else if (value !== undefined && value !== false) element.setAttribute(name, value === true ? "" : value);
    }
    element.append(...children.filter((child) => child !== undefined && child !== null));
    return element;
  }

  function icon(name) {
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    svg.setAttribute("viewBox", "0 0 17 17");
    svg.setAttribute("aria-hidden", "true");
    const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    path.setAttribute("d", ICONS[name]);
    svg.append(path);
    return svg;
  }

  async function copy(text) {
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      // Without the permission, or where file:// counts as insecure.
      const area = make("textarea", { style: "position:fixed;opacity:0" });
      area.value = text;
      document.body.append(area);
      area.select();
      document.execCommand("copy");
      area.remove();
    }
  }

  /** One drive with its picture, its strips and its words. */
  class Pane {
    constructor(player, drive, ranges) {
      Object.assign(this, { player, drive });
      const { entry } = drive;
      // At once, not with the next frame: a canvas that has changed its size is empty.
      const changed = () => player.draw();
      this.canvas = make("canvas", { tabindex: 0, role: "img", "aria-describedby": "replay-keys" });
      const chart = make("canvas", {
        role: "img", "aria-label": `Over time: state of the planner, ${drive.series.map(({ name }) => name).join(", ")}. Click to go to a time.`,
      });
      const zoom = make("div", { class: "replay-zoom" },
        make("button", { type: "button", "aria-label": "zoom in", title: "zoom in (+)", onclick: () => player.zoom(1.5) }, "+"),
        make("button", { type: "button", "aria-label": "zoom out", title: "zoom out (−)", onclick: () => player.zoom(1 / 1.5) }, "−"),
        make("button", { type: "button", "aria-label": "show the whole map", title: "the whole map (f)", onclick: () => player.fit() }, "fit"));
      this.clock = make("div", { class: "replay-now" });
      this.frame = make("div", { class: "replay-world" }, make("div", { class: "replay-head" }, this.clock, zoom), this.canvas);
      this.copyButton = make("button", { type: "button", onclick: () => player.copy(entry.command, this.copyButton) }, "Copy");
      const keys = Object.keys(entry.stats ?? {}).filter((key) => Number.isFinite(entry.stats[key]));
      const rank = (key) => (STATS_FIRST.indexOf(key) + 1 || STATS_FIRST.length + 1);
      const stats = keys.sort((a, b) => rank(a) - rank(b)).map((key) => {
        const [{ name, unit }, value] = [quantity(key), entry.stats[key]];
        return make("div", {}, make("dt", {}, name), make("dd", {}, measured(value, unit, !unit && Number.isInteger(value))));
      });
      this.element = make("article", { class: "replay-pane", "aria-label": `${entry.stack ?? ""}, ${entry.outcome ?? ""}` },
        make("header", {}, make("h3", {}, entry.stack ?? entry.id), make("span", { class: "replay-outcome", "data-outcome": entry.outcome ?? "" }, words(entry.outcome))),
        make("p", { class: "replay-sentence" }, [entry.sentence, entry.cause].filter(Boolean).join(": ")),
        this.frame,
        make("div", { class: "replay-side" },
          make("div", { class: "replay-strips" }, chart),
          stats.length ? make("dl", {}, ...stats) : undefined,
          entry.command ? make("div", { class: "replay-command" }, make("code", { tabindex: 0 }, entry.command), this.copyButton) : undefined));
      this.world = new World(new Surface(this.canvas, changed), drive);
      this.strips = new Strips(new Surface(chart, changed), drive, ranges);
      const [left, bottom, right, top] = this.world.bounds;
      this.frame.style.setProperty("--replay-aspect", Math.min(3, Math.max(0.6, (right - left) / (top - bottom))).toFixed(4));
      this.listenWorld();
      this.listenChart(chart);
    }

    listenChart(chart) {
      const seek = (event) => this.player.seek(this.strips.timeAt(event.offsetX), true);
      chart.addEventListener("pointerdown", (event) => {
        chart.setPointerCapture(event.pointerId);
        this.player.pause();
        seek(event);
      });
      chart.addEventListener("pointermove", (event) => {
        this.strips.hover_s = event.pointerType === "mouse" ? this.strips.timeAt(event.offsetX) : null;
        if (chart.hasPointerCapture(event.pointerId)) seek(event);
        else this.player.invalidate();
      });
      chart.addEventListener("pointerleave", () => {
        this.strips.hover_s = null;
        this.player.invalidate();
      });
      chart.addEventListener("pointerup", () => this.player.settle());
    }

    /** Drag pans, the wheel zooms once the picture has the focus (or with ctrl), two fingers do both. */
    listenWorld() {
      const { canvas, player } = this;
      const down = new Map();
      // A click that trembles is no drag.
      let dragged = 0;
      const middle = () => {
        const all = [...down.values()];
        const [x, y] = [0, 1].map((axis) => all.reduce((sum, place) => sum + place[axis], 0) / all.length);
        return { x, y, spread: all.length > 1 ? Math.hypot(all[0][0] - all[1][0], all[0][1] - all[1][1]) : 0 };
      };
      canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        down.set(event.pointerId, [event.offsetX, event.offsetY]);
        dragged = 0;
      });
      canvas.addEventListener("pointermove", (event) => {
        if (!down.has(event.pointerId)) return;
        const before = middle();
        down.set(event.pointerId, [event.offsetX, event.offsetY]);
        const after = middle();
        dragged += Math.hypot(after.x - before.x, after.y - before.y) + Math.abs(after.spread - before.spread);
        if (dragged < 4) return;
        if (after.spread && before.spread) player.zoom(after.spread / before.spread, this, [after.x, after.y]);
        player.pan(before.x - after.x, after.y - before.y);
      });
      for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => down.delete(event.pointerId));
      canvas.addEventListener("dblclick", (event) => player.zoom(2, this, [event.offsetX, event.offsetY]));
      canvas.addEventListener("wheel", (event) => {
        if (document.activeElement !== canvas && !event.ctrlKey && !event.metaKey) return;
        event.preventDefault();
        const pixels = event.deltaY * (event.deltaMode ? 16 : 1);
        player.zoom(Math.exp(-Math.max(-120, Math.min(120, pixels)) / 300), this, [event.offsetX, event.offsetY]);
      }, { passive: false });
    }

    draw(time, duration_s) {
      const { player, drive, world, strips } = this;
      const [tick, part] = locate(drive, time);
      world.draw(player.viewOf(this), player.layers, tick, part, player.style, player.mapImages);
      strips.draw(time, tick, duration_s, player.style);
      this.tell(tick);
    }

    /** The words above the picture, and in its label while it stands still. */
    tell(tick) {
      const { player, drive } = this;
      if (tick === this.toldTick && player.playing === this.toldPlaying) return;
      [this.toldTick, this.toldPlaying] = [tick, player.playing];
      const state = inForce(drive.states, tick);
      const time = drive.times[tick];
      const shown = `${time.toFixed(Math.abs(time - time.toFixed(1)) > 1e-6 ? 2 : 1)} s`;
      const { x, y, heading } = poseAt(drive.pose, tick);
      const turned = ((((Math.round((heading * 180) / Math.PI) + 179) % 360) + 360) % 360) - 179;
      this.clock.replaceChildren(make("b", {}, shown),
        ...(state ? [make("i", { style: `background:${STATE_COLOURS[state.index % STATE_COLOURS.length]}` }), make("span", {}, state.name)] : []),
        make("span", { class: "replay-pose" }, `x ${x.toFixed(2)} m   y ${y.toFixed(2)} m   ${turned}°`.replaceAll("-", "−")));
      if (player.playing) return;
      this.canvas.setAttribute("aria-label",
        `${drive.entry.stack ?? "Robot"} at ${shown}: x ${x.toFixed(2)} m, y ${y.toFixed(2)} m, heading ${turned}°${state ? `, ${state.name}` : ""}`);
    }

    remove() {
      for (const { observer } of [this.world.surface, this.strips.surface]) observer.disconnect();
      this.element.remove();
    }
  }

  function words(name) {
    return (name ?? "").replaceAll("_", " ");
  }

  class Player {
    constructor(root, entries, maps) {
      Object.assign(this, {
        root, entries, maps, panes: [], time: 0, rate: 1, playing: false, view: null, follow: false, request: 0, last: 0, wanted: 0, written: null, edition: 0,
        byId: new Map(entries.map((entry) => [entry.id, entry])), drives: new Map(), unpacked: new Map(), mapImages: new MapImages(),
        layers: new Set(LAYERS.map(({ key }) => key)), calm: window.matchMedia("(prefers-reduced-motion: reduce)"),
      });
      this.build();
      this.restyle();
      for (const query of ["(prefers-color-scheme: dark)", "print"]) window.matchMedia(query).addEventListener("change", () => this.restyle());
      // Paper is light, as wide as it is, and finer than screens.
      for (const [event, paper] of [["beforeprint", true], ["afterprint", false]]) {
        window.addEventListener(event, () => {
          this.root.classList.toggle("replay-paper", paper);
          this.restyle(paper ? 3 : 1);
        });
      }
      window.addEventListener("hashchange", () => this.readFragment());
      document.addEventListener("keydown", (event) => this.key(event));
      document.addEventListener("click", (event) => {
        const link = event.target.closest?.("a.episode[href^='#']");
        const id = link && this.idOf(link.getAttribute("href").slice(1));
        if (!id || event.ctrlKey || event.metaKey || event.shiftKey) return;
        event.preventDefault();
        this.select(id, { play: !this.calm.matches, focus: true });
      });
      if (!this.readFragment()) this.select(entries[0].id, { quiet: true });
    }

    // -- the controls

    build() {
      const button = (name, label, action) => make("button", { type: "button", class: `replay-${name}`, "aria-label": label, title: label, onclick: action }, icon(name));
      this.playButton = button("play", "play (space)", () => this.toggle());
      this.scrub = make("input", { type: "range", min: 0, max: 1, step: 1, value: 0, class: "replay-scrub", "aria-label": "time",
        oninput: () => { this.pause(); this.seek(this.longest().times[Number(this.scrub.value)]); }, onchange: () => this.settle() });
      this.timeLabel = make("output", { class: "replay-time" });
      this.rateSelect = make("select", { "aria-label": "speed of the replay", onchange: () => { this.rate = Number(this.rateSelect.value); } },
        ...RATES.map((rate) => make("option", { value: rate, selected: rate === 1 }, `${rate}×`)));
      this.episodeSelect = make("select", { "aria-label": "episode", class: "replay-episode", onchange: () => this.select(this.episodeSelect.value) },
        ...this.entries.map(({ id, outcome }) => make("option", { value: id }, outcome ? `${id} – ${words(outcome)}` : id)));
      this.besideSelect = make("select", { "aria-label": "side by side with", class: "replay-beside", onchange: () => this.beside(this.besideSelect.value) });
      this.besideLabel = make("label", {}, "side by side with ", this.besideSelect);
      this.status = make("p", { class: "replay-status", role: "status", "aria-live": "polite" });
      this.layerFields = { true: make("fieldset", {}, make("legend", {}, "What was true")), believed: make("fieldset", {}, make("legend", {}, "What was believed")) };
      this.layerLabels = new Map(LAYERS.map(({ key, words: text, side }) => {
        const box = make("input", { type: "checkbox", checked: true, onchange: () => {
          this.layers[box.checked ? "add" : "delete"](key);
          this.invalidate();
        } });
        const label = make("label", {}, box, make("span", { class: `replay-swatch replay-swatch-${key}`, "aria-hidden": "true" }), text);
        this.layerFields[side].append(label);
        return [key, label];
      }));
      this.problem = make("p", { class: "replay-unable", role: "alert", hidden: true });
      this.stage = make("div", { class: "replay-panes" });
      this.transport = make("div", { class: "replay-bar replay-transport", hidden: true },
        this.playButton, button("back", "one tick back (←)", () => this.step(-1)), button("step", "one tick on (→)", () => this.step(1)),
        this.scrub, this.timeLabel, this.rateSelect);
      this.root.classList.add("replay");
      this.root.setAttribute("aria-label", this.root.getAttribute("aria-label") ?? "replay");
      this.root.replaceChildren(
        make("div", { class: "replay-bar replay-choice" },
          button("back", "previous episode (k)", () => this.neighbour(-1)), this.episodeSelect, button("step", "next episode (j)", () => this.neighbour(1)), this.besideLabel),
        this.problem, this.stage, this.transport,
        make("div", { class: "replay-bar replay-layers" }, ...Object.values(this.layerFields)),
        make("details", { class: "replay-keys" }, make("summary", {}, "Keys"),
          make("dl", { id: "replay-keys" }, ...KEYS.map(([key, does]) => make("div", {}, make("dt", {}, make("kbd", {}, key)), make("dd", {}, does))))),
        this.status);
    }

    key(event) {
      const { target } = event;
      if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
      const inside = this.root.contains(target);
      if (!inside && (target !== document.body || !this.inSight())) return;
      const typing = target.matches?.("select, textarea, [contenteditable], input:not([type=range]):not([type=checkbox])");
      const scrubbing = target === this.scrub;
      const arrows = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      const second = Math.max(1, Math.round(1 / this.panes[0]?.drive.dt_s || 1));
      const action = {
        " ": () => this.toggle(), ArrowLeft: () => this.step(arrows * (event.shiftKey ? second : 1)), ArrowRight: () => this.step(arrows * (event.shiftKey ? second : 1)),
        Home: () => this.jump(0), End: () => this.jump(this.duration()), j: () => this.neighbour(1), k: () => this.neighbour(-1),
        ArrowDown: () => this.neighbour(1), ArrowUp: () => this.neighbour(-1), s: () => this.nextBeside(), f: () => this.fit(),
        "+": () => this.zoom(1.5), "=": () => this.zoom(1.5), "-": () => this.zoom(1 / 1.5), c: () => this.toggleFollow(),
      }[event.key];
      // What the focused control does with a key comes first; unless the player has the focus the page scrolls by its own keys, and letters are left to
      // those who dictate.
      const taken = typing || (event.key === " " && target.matches?.("button, summary, input[type=checkbox], a"))
        || (scrubbing && /^Arrow(Up|Down)$/.test(event.key)) || (!inside && /^(ArrowUp|ArrowDown|Home|End|[^ ])$/.test(event.key));
      if (!action || taken || !this.panes.length) return;
      event.preventDefault();
      action();
    }

    inSight() {
      const { top, bottom } = this.stage.getBoundingClientRect();
      return Math.min(bottom, window.innerHeight) - Math.max(top, 0) > Math.min(bottom - top, window.innerHeight) / 2;
    }

    // -- episodes

    idOf(text) {
      if (this.byId.has(text)) return text;
      try {
        const plain = decodeURIComponent(text);
        return this.byId.has(plain) ? plain : undefined;
      } catch {
        return undefined;
      }
    }

    map(id) {
      if (!this.unpacked.has(id)) this.unpacked.set(id, unpack(this.maps[id]).then(cells));
      return this.unpacked.get(id);
    }

    /** The drive of an episode, unpacked when it is first asked for. */
    drive(id) {
      if (!this.drives.has(id)) {
        const entry = this.byId.get(id);
        const loading = unpack(entry.data).then(async (raw) => {
          const map = raw.map ? cells(raw.map) : raw.map_id && this.maps[raw.map_id] ? await this.map(raw.map_id) : undefined;
          return read(entry, raw, map);
        });
        this.drives.set(id, loading);
        loading.catch(() => this.drives.delete(id));
        if (this.drives.size > 12) this.drives.delete(this.drives.keys().next().value);
      }
      return this.drives.get(id);
    }

    /**
     * Shows an episode, beside `vs` if that took place in the same world; `quiet` leaves the address as it is. The latest call wins.
     */
    async select(id, { time = 0, vs, play = this.playing, focus = false, quiet = false } = {}) {
      const turn = ++this.wanted;
      this.current = this.byId.get(id);
      const ids = vs && vs !== id && this.companions(id).some((entry) => entry.id === vs) ? [id, vs] : [id];
      let drives;
      try {
        drives = await Promise.all(ids.map((one) => this.drive(one)));
      } catch (error) {
        if (turn !== this.wanted) return;
        this.problem.textContent = `${id} could not be read: ${error.message}`;
        this.problem.hidden = false;
        return;
      }
      // Another one was asked for meanwhile.
      if (turn !== this.wanted) return;
      this.problem.hidden = true;
      this.transport.hidden = false;
      const sameWorld = this.panes[0]?.drive.entry.world === drives[0].entry.world;
      const ranges = rangesOver(drives);
      for (const pane of this.panes) pane.remove();
      this.panes = drives.map((drive) => new Pane(this, drive, ranges));
      this.stage.dataset.panes = this.panes.length;
      this.stage.replaceChildren(...this.panes.map(({ element }) => element));
      if (!sameWorld) this.view = null;
      this.playing = play;
      this.last = 0;
      this.scrub.max = this.longest().count - 1;
      this.episodeSelect.value = id;
      this.offerBeside(id, ids[1]);
      for (const { key, has } of LAYERS) this.layerLabels.get(key).hidden = !drives.some(has);
      for (const field of Object.values(this.layerFields)) field.hidden = ![...field.querySelectorAll("label")].some(({ hidden }) => !hidden);
      for (const link of document.querySelectorAll("a.episode")) {
        if (ids.includes(this.idOf(link.getAttribute("href").slice(1)))) link.setAttribute("aria-current", "true");
        else link.removeAttribute("aria-current");
      }
      this.seek(time, !play);
      // A page that was merely opened keeps its address.
      if (!quiet) this.settle();
      this.say(drives.map(({ entry }) => entry.sentence ?? `${entry.stack}: ${words(entry.outcome)}`).join(" "));
      if (!focus) return;
      this.root.scrollIntoView({ block: "start", behavior: this.calm.matches ? "auto" : "smooth" });
      this.panes[0].canvas.focus({ preventScroll: true });
    }

    neighbour(step) {
      const next = this.entries[this.entries.indexOf(this.current) + step];
      if (!next) return;
      const inside = this.stage.contains(document.activeElement);
      this.select(next.id).then(() => { if (inside) this.panes[0]?.canvas.focus({ preventScroll: true }); });
    }

    /** Other drives of the same world. */
    companions(id) {
      const { world } = this.byId.get(id);
      return world === undefined ? [] : this.entries.filter((entry) => entry.world === world && entry.id !== id);
    }

    offerBeside(id, chosen = "") {
      const others = this.companions(id);
      this.besideSelect.replaceChildren(make("option", { value: "" }, "–"),
        ...others.map(({ id: other, stack, point }) => make("option", { value: other }, point === this.byId.get(id).point ? stack ?? other : `${stack}, point ${point}`)));
      this.besideSelect.value = chosen;
      this.besideLabel.hidden = others.length === 0;
    }

    beside(vs) {
      const inside = this.stage.contains(document.activeElement);
      const { id } = this.panes[0].drive.entry;
      this.select(id, { time: this.time, vs }).then(() => { if (inside) this.panes[0]?.canvas.focus({ preventScroll: true }); });
    }

    nextBeside() {
      const { options, selectedIndex } = this.besideSelect;
      if (options.length > 1) this.beside(options[(selectedIndex + 1) % options.length].value);
    }

    // -- time

    longest() {
      return this.panes.map(({ drive }) => drive).reduce((a, b) => (b.count > a.count ? b : a));
    }

    duration() {
      const { times, count } = this.longest();
      return times[count - 1];
    }

    /** Goes to a time; to the nearest tick if `snap`. */
    seek(time, snap = false) {
      const drive = this.longest();
      const within = Math.max(0, Math.min(this.duration(), Number.isFinite(time) ? time : 0));
      const [tick, part] = locate(drive, within);
      this.time = snap ? drive.times[tick + (part >= 0.5 ? 1 : 0)] : within;
      this.invalidate();
    }

    jump(time) {
      this.pause();
      this.seek(time, true);
      this.settle();
    }

    step(ticks) {
      const drive = this.longest();
      const [tick, part] = locate(drive, this.time);
      const from = tick + (part && ticks < 0 ? 1 : 0);
      this.jump(drive.times[Math.max(0, Math.min(drive.count - 1, from + ticks))]);
    }

    toggle() {
      if (this.playing) return this.jump(this.time);
      if (this.time >= this.duration()) this.time = 0;
      Object.assign(this, { playing: true, last: 0 });
      this.invalidate();
    }

    pause() {
      this.playing = false;
      this.invalidate();
    }

    // -- view

    viewOf(pane) {
      if (!this.view) return pane.world.fitted();
      if (!this.follow) return this.view;
      const [tick, part] = locate(pane.drive, this.time);
      const { x, y } = poseAt(pane.drive.pose, tick, part);
      return { ...this.view, x, y };
    }

    fit() {
      Object.assign(this, { view: null, follow: false });
      this.invalidate();
    }

    pan(dx, dy) {
      const from = this.viewOf(this.panes[0]);
      this.follow = false;
      this.view = { ...from, x: from.x + dx / from.scale, y: from.y + dy / from.scale };
      this.invalidate();
    }

    /** Zooms about a place on a pane, or about the robot. */
    zoom(factor, pane = this.panes[0], place) {
      const from = this.viewOf(pane);
      const { width, height } = pane.world.surface;
      const fitted = pane.world.fitted().scale;
      const scale = Math.max(fitted / 2, Math.min(fitted * 200, from.scale * factor));
      if (place) {
        const [dx, dy] = [place[0] - width / 2, height / 2 - place[1]];
        this.view = { scale, x: from.x + dx / from.scale - dx / scale, y: from.y + dy / from.scale - dy / scale };
      } else {
        const [tick, part] = locate(pane.drive, this.time);
        const { x, y } = poseAt(pane.drive.pose, tick, part);
        this.view = { scale, x, y };
      }
      if (scale <= fitted && factor < 1) this.view = null;
      this.invalidate();
    }

    toggleFollow() {
      this.follow = !this.follow;
      if (this.follow && !this.view) this.zoom(4);
      this.invalidate();
    }

    // -- drawing

    /** Reads the colours anew and draws at once, with at least `ratio` pixels to a CSS pixel. */
    restyle(ratio = 1) {
      const computed = getComputedStyle(this.root);
      const colour = (name) => computed.getPropertyValue(`--replay-${name}`).trim() || "#888";
      const names = ["page", "ink", "muted", "faint", "rule", "plate", "floor", "wall", "uncharted", "unknown", "mover", "arrow", "robot", "belief", "path", "sensed", "lidar", "contact", "series"];
      this.style = Object.fromEntries(names.map((name) => [name, colour(name)]));
      this.style.family = computed.fontFamily;
      this.style.edition = ++this.edition;
      // Slanted lines: an obstacle that the map does not know.
      const tile = make("canvas", { width: 8, height: 8 });
      const t = tile.getContext("2d");
      t.strokeStyle = this.style.unknown;
      t.lineWidth = 1.5;
      for (const shift of [-8, 0, 8]) {
        t.moveTo(shift - 1, 9);
        t.lineTo(shift + 9, -1);
      }
      t.stroke();
      this.style.hatch = (c) => c.createPattern(tile, "repeat");
      this.mapImages.forget();
      for (const { world, strips } of this.panes) for (const { surface } of [world, strips]) surface.fit(ratio);
      this.draw();
    }

    invalidate() {
      if (!this.request) this.request = requestAnimationFrame((now) => this.tick(now));
    }

    tick(now) {
      this.request = 0;
      if (this.playing && this.panes.length) {
        // After a pause of the page it goes on where it was.
        if (this.last) this.time += this.rate * Math.min((now - this.last) / 1000, 0.25);
        this.last = now;
        if (this.time >= this.duration()) this.jump(this.duration());
        else this.invalidate();
      }
      this.draw();
    }

    draw() {
      if (!this.panes.length) return;
      const [duration_s, drive] = [this.duration(), this.longest()];
      for (const pane of this.panes) {
        pane.draw(this.time, duration_s);
        pane.canvas.style.touchAction = this.view ? "none" : "pan-y";
      }
      const [tick] = locate(drive, this.time);
      this.scrub.value = tick;
      this.scrub.style.setProperty("--replay-done", `${(100 * tick) / Math.max(1, drive.count - 1)}%`);
      const text = `${this.time.toFixed(1)} / ${duration_s.toFixed(1)} s`;
      if (this.timeLabel.value !== text) this.timeLabel.value = text;
      if (!this.playing) this.scrub.setAttribute("aria-valuetext", `${this.time.toFixed(1)} of ${duration_s.toFixed(1)} seconds`);
      if (this.root.dataset.playing !== String(this.playing)) {
        this.root.dataset.playing = this.playing;
        const label = this.playing ? "pause (space)" : "play (space)";
        this.playButton.replaceChildren(icon(this.playing ? "pause" : "play"));
        this.playButton.setAttribute("aria-label", label);
        this.playButton.title = label;
      }
      this.root.dataset.time = this.time;
    }

    say(text) { this.status.textContent = text; }

    async copy(text, button) {
      await copy(text);
      button.textContent = "Copied";
      this.say("The command is in the clipboard.");
      setTimeout(() => { button.textContent = "Copy"; }, 1500);
    }

    // -- permalink

    /** Writes episode, time and companion into the fragment, without a step of the history. */
    settle() {
      const plain = (id) => id.replace(/[^\w.+~:@,;()!*'-]/g, encodeURIComponent);
      const [first, second] = this.panes.map(({ drive }) => drive.entry.id);
      const fragment = `#${plain(first)}${this.time > 0 ? `&t=${+this.time.toFixed(3)}` : ""}${second ? `&vs=${plain(second)}` : ""}`;
      if (fragment === location.hash) return;
      this.written = fragment;
      try {
        history.replaceState(history.state, "", fragment);
      } catch {
        location.replace(fragment);
      }
    }

    /** Goes where the fragment points; false if it names no episode. */
    readFragment() {
      if (location.hash === this.written) return true;
      const [name, ...rest] = location.hash.slice(1).split("&");
      const id = this.idOf(name);
      if (!id) return false;
      const options = Object.fromEntries(rest.map((part) => [part.split("=")[0], part.slice(part.indexOf("=") + 1)]));
      this.select(id, { time: Number(options.t ?? 0), vs: options.vs && this.idOf(options.vs), play: false, focus: true });
      return true;
    }
  }

  let player = null;

  function json(document, id) {
    const element = document.getElementById(id);
    return element ? JSON.parse(element.textContent) : undefined;
  }

  /** Builds the player into `<section id="replay">`. */
  function mount(document) {
    const root = document.getElementById("replay");
    const entries = (json(document, "episodes") ?? []).filter(({ data }) => data);
    if (!root) return;
    let unable = entries.length ? "" : "No drive was recorded.";
    try {
      new DecompressionStream("deflate-raw");
    } catch {
      unable = "This browser cannot unpack the drives: it has no DecompressionStream for deflate-raw. Chrome 103, Firefox 113, Safari 16.4 and later ones have.";
    }
    if (unable) root.replaceChildren(make("p", { class: "replay-unable" }, unable));
    else player = new Player(root, entries, json(document, "maps") ?? {});
  }

  /** The pose that is shown of episode `id` at `tick`. */
  async function frame(id, tick) {
    const { x, y, heading } = poseAt((await player.drive(id)).pose, tick);
    return { x_m: x, y_m: y, heading_rad: heading };
  }

  return { mount, frame };
})();
