// Geometry, camera and drawing of a scene on a canvas. Lengths in metres.
const SceneView = (() => {
  const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
  const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const scale = (a, k) => [a[0] * k, a[1] * k, a[2] * k];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const norm = (a) => Math.hypot(a[0], a[1], a[2]);
  const unit = (a) => scale(a, 1 / (norm(a) || 1));
  const mix = (a, b, t) => a.map((x, i) => x + (b[i] - x) * t);

  // Axes x, y and z of a cross-section, by its quaternion w, x, y, z.
  const axes = ([w, x, y, z]) => {
    const n = 2 / (w * w + x * x + y * y + z * z || 1);
    return [
      [1 - n * (y * y + z * z), n * (x * y + w * z), n * (x * z - w * y)],
      [n * (x * y - w * z), 1 - n * (x * x + z * z), n * (y * z + w * x)],
      [n * (x * z + w * y), n * (y * z - w * x), 1 - n * (x * x + y * y)],
    ];
  };

  const pose = (p) => ({ at: [p[0] / 1e4, p[1] / 1e4, p[2] / 1e4], turn: [p[3], p[4], p[5], p[6]] });

  // Pose between two poses: straight in position, along the shorter way in orientation.
  const blend = (from, to, t) => {
    const [a, b] = [pose(from), pose(to)];
    const sign = a.turn.reduce((sum, x, i) => sum + x * b.turn[i], 0) < 0 ? -1 : 1;
    return { at: mix(a.at, b.at, t), turn: mix(a.turn, b.turn.map((x) => x * sign), t) };
  };

  // The frame of a scene at a time: poses between two frames, all else of the earlier one.
  const frameAt = (frames, time) => {
    let low = 0;
    let high = frames.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (frames[middle].time_s <= time + 1e-9) low = middle; else high = middle - 1;
    }
    const [from, to] = [frames[low], frames[Math.min(low + 1, frames.length - 1)]];
    const gap = to.time_s - from.time_s;
    const share = gap > 0 && time > from.time_s ? Math.min((time - from.time_s) / gap, 1) : 0;
    const [one, two] = [from.poses || [], to.poses || []];
    const poses = one.map((p, i) => (two.length === one.length ? blend(p, two[i], share) : pose(p)));
    const tip = from.tip_m && to.tip_m ? mix(from.tip_m, to.tip_m, share) : from.tip_m;
    return { index: low, frame: from, poses, tip, tensions: from.tensions_n || [], target: from.target_m, measured: from.measured_m || [] };
  };

  // Largest drawn thickness of a disk over its radius.
  const THIN = 0.15;
  const COLOURS = {
    light: { paper: '#ffffff', ink: '#262626', soft: '#57606a', grid: '#dfe3e8', ground: '#f4f6f8', shadow: 'rgba(40,50,60,.16)',
      plate: '#8a939e', disk: '#9fc4dd', diskEdge: '#2d5f7f', side: '#6d9dbd', tube: '#1d3f57', core: '#5b9fc9', light: '#d3e8f5',
      taut: '#c14b00', slack: '#6f7a86', target: '#00785a', trail: '#0072b2', measured: '#a0489b', wall: '#b8860b' },
    dark: { paper: '#14171c', ink: '#e4e7eb', soft: '#9aa4b0', grid: '#2c323b', ground: '#181c22', shadow: 'rgba(0,0,0,.5)',
      plate: '#6b7480', disk: '#41708f', diskEdge: '#9fd0ef', side: '#2d526b', tube: '#0b1a25', core: '#62aede', light: '#d6eeff',
      taut: '#f08a45', slack: '#8b96a3', target: '#3fd0a4', trail: '#58b4f0', measured: '#e39ae0', wall: '#d9a832' },
  };

  // A view from `distance` on `centre`; turned by `yaw` about the vertical and `pitch` above the horizontal.
  class Camera {
    constructor(scenes) {
      this.fit(scenes);
      this.reset();
    }

    fit(scenes) {
      const points = [];
      for (const { robot, frames } of scenes) {
        const step = Math.max(1, Math.floor(frames.length / 60));
        frames.forEach((frame, i) => {
          if (i % step) return;
          for (const p of frame.poses || []) points.push(pose(p).at);
          for (const p of [frame.tip_m, frame.target_m, ...(frame.measured_m || [])]) if (p) points.push(p);
        });
        for (const shape of robot.obstacles) if (shape.sphere) points.push(shape.sphere.center_m);
      }
      if (!points.length) points.push([0, 0, 0], [0, 0, 0.2]);
      const low = [0, 1, 2].map((k) => Math.min(...points.map((p) => p[k])));
      const high = [0, 1, 2].map((k) => Math.max(...points.map((p) => p[k])));
      const rim = Math.max(0, ...scenes.flatMap(({ robot }) => robot.stations.map((one) => one.disk_radius_m || one.radius_m)));
      const { robot, frames } = scenes[0];
      this.home = scale(add(low, high), 0.5);
      this.radius = Math.max(0.5 * norm(sub(high, low)) + 1.5 * rim, 0.35 * robot.length_m, 1e-3);
      this.up = unit(robot.up);
      const first = frames.find((frame) => frame.poses && frame.poses.length);
      const along = first ? axes(pose(first.poses[0]).turn)[2] : [0, 0, 1];
      let ahead = sub(along, scale(this.up, dot(along, this.up)));
      if (norm(ahead) < 0.1) ahead = Math.abs(this.up[0]) < 0.9 ? cross(this.up, [1, 0, 0]) : cross(this.up, [0, 1, 0]);
      this.ahead = unit(ahead);
      this.aside = cross(this.up, this.ahead);
      this.floor = Math.min(...points.map((p) => dot(p, this.up))) - 1.15 * rim - 0.02 * this.radius;
    }

    reset() {
      Object.assign(this, { centre: this.home, yaw: -1.05, pitch: 0.36, zoom: 1 });
    }

    turn(yaw, pitch) {
      this.yaw += yaw;
      this.pitch = Math.max(-0.2, Math.min(1.5, this.pitch + pitch));
    }

    magnify(factor) {
      this.zoom = Math.max(0.3, Math.min(12, this.zoom * factor));
    }

    // Projection onto a canvas: of a point, x and y in pixels, depth and pixels per metre.
    projection(wide, high) {
      const [c, s] = [Math.cos(this.pitch), Math.sin(this.pitch)];
      const flat = add(scale(this.ahead, Math.cos(this.yaw)), scale(this.aside, Math.sin(this.yaw)));
      const back = add(scale(flat, c), scale(this.up, s));
      const distance = 4.2 * this.radius;
      const eye = add(this.centre, scale(back, distance));
      const right = unit(cross(this.up, flat));
      const above = cross(back, right);
      const focal = 0.5 * Math.min(wide, high * 1.25) * this.zoom * (distance / this.radius);
      const project = (point) => {
        const v = sub(point, eye);
        const depth = Math.max(-dot(v, back), 0.05 * distance);
        const size = focal / depth;
        return { x: wide / 2 + size * dot(v, right), y: high / 2 - size * dot(v, above), depth, size };
      };
      return { project, eye, right, above, distance, perMetre: focal / distance };
    }
  }

  const hull = (points) => {
    const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
    const half = (list) => {
      const out = [];
      for (const p of list) {
        while (out.length > 1) {
          const [a, b] = [out[out.length - 2], out[out.length - 1]];
          if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0) break;
          out.pop();
        }
        out.push(p);
      }
      return out.slice(0, -1);
    };
    return [...half(sorted), ...half(sorted.reverse())];
  };

  const nice = (length) => {
    const power = 10 ** Math.floor(Math.log10(length));
    return [5, 2, 1].map((k) => k * power).find((step) => step <= length) || power;
  };

  // Draws one scene; `now` is what `frameAt` returns, `trail` the tips until then.
  class Painter {
    constructor(context, wide, high, camera, dark) {
      Object.assign(this, { context, wide, high, camera, ink: COLOURS[dark ? 'dark' : 'light'] });
      Object.assign(this, camera.projection(wide, high));
      this.items = [];
    }

    path(points, closed) {
      this.context.beginPath();
      points.forEach((p, i) => (i ? this.context.lineTo(p.x, p.y) : this.context.moveTo(p.x, p.y)));
      if (closed) this.context.closePath();
    }

    stroke(points, colour, width, dash = [], cap = 'round') {
      this.path(points);
      this.context.setLineDash(dash);
      Object.assign(this.context, { strokeStyle: colour, lineWidth: width, lineJoin: 'round', lineCap: dash.length ? 'butt' : cap });
      this.context.stroke();
      this.context.setLineDash([]);
    }

    fill(points, colour, alpha = 1) {
      this.path(points, true);
      this.context.globalAlpha = alpha;
      this.context.fillStyle = colour;
      this.context.fill();
      this.context.globalAlpha = 1;
    }

    later(depth, draw) {
      this.items.push({ depth, draw });
    }

    scene(robot, now, trails) {
      const { context, ink } = this;
      context.fillStyle = ink.paper;
      context.fillRect(0, 0, this.wide, this.high);
      this.ground(now);
      robot.obstacles.forEach((obstacle) => this.obstacle(obstacle));
      if (now.poses.length) this.robot(robot, now);
      this.items.sort((a, b) => b.depth - a.depth).forEach((item) => item.draw());
      this.items = [];
      for (const trail of trails) this.trail(trail);
      this.marks(now);
      this.head();
      if (!now.poses.length && robot.stations.length) this.message('no solution at this time');
    }

    message(words) {
      Object.assign(this.context, { font: '600 15px system-ui, sans-serif', textAlign: 'center', fillStyle: this.ink.ink });
      this.context.fillText(words, this.wide / 2, this.high / 3);
    }

    ground(now) {
      const { camera, ink, project } = this;
      const step = nice(camera.radius / 2.5);
      const half = Math.ceil((1.35 * camera.radius) / step);
      const base = add(sub(camera.home, scale(camera.up, dot(camera.home, camera.up))), scale(camera.up, camera.floor));
      const place = (i, j) => project(add(base, add(scale(camera.ahead, i * step), scale(camera.aside, j * step))));
      this.fill([place(-half, -half), place(half, -half), place(half, half), place(-half, half)], ink.ground);
      for (let i = -half; i <= half; i += 1) {
        this.stroke([place(i, -half), place(i, half)], ink.grid, 1);
        this.stroke([place(-half, i), place(half, i)], ink.grid, 1);
      }
      const drop = (p) => project(add(p, scale(camera.up, camera.floor - dot(p, camera.up))));
      if (now.poses.length) this.stroke(now.poses.map((p) => drop(p.at)), ink.shadow, 5);
      this.step = step;
    }

    robot(robot, now) {
      const { ink, project, eye } = this;
      const frames = now.poses.map((p) => ({ at: p.at, axes: axes(p.turn) }));
      const stations = robot.stations;
      const widest = Math.max(...stations.map((one) => one.disk_radius_m || 0), 4 * stations[0].radius_m);
      this.disk(frames[0], -0.35 * widest, 0, 1.5 * widest, ink.plate, ink.plate, ink.ink, 0.95);
      stations.forEach((station, k) => {
        if (!station.disk_radius_m) return;
        // Thick disks are drawn thinner, so that the backbone can be seen between them.
        const half = 0.5 * Math.min(station.disk_thickness_m || 0.08 * station.disk_radius_m, THIN * station.disk_radius_m);
        this.disk(frames[k], -half, half, station.disk_radius_m, ink.disk, ink.side, ink.diskEdge, 0.4);
      });
      for (let k = 0; k + 1 < frames.length; k += 1) this.span(frames[k], frames[k + 1], stations[k], stations[k + 1]);
      robot.tendons.forEach((tendon, index) => this.tendon(tendon, frames, (now.tensions[index] ?? 1) > 0, eye));
      const tip = project(frames[frames.length - 1].at);
      this.later(tip.depth - 1e-3, () => {
        this.dot(tip, Math.max(3, stations[stations.length - 1].radius_m * tip.size * 1.3), ink.tube);
        this.dot(tip, Math.max(1.6, stations[stations.length - 1].radius_m * tip.size * 0.8), ink.light);
      });
    }

    dot(p, radius, colour) {
      this.context.beginPath();
      this.context.arc(p.x, p.y, radius, 0, 2 * Math.PI);
      this.context.fillStyle = colour;
      this.context.fill();
    }

    disk({ at, axes: [x, y, z] }, from, to, radius, face, side, edge, alpha) {
      const { project, eye } = this;
      const circle = (height) => Array.from({ length: 28 }, (_, k) => {
        const angle = (k * 2 * Math.PI) / 28;
        return project(add(add(at, scale(z, height)), add(scale(x, radius * Math.cos(angle)), scale(y, radius * Math.sin(angle)))));
      });
      const [low, high] = [circle(from), circle(to)];
      const towards = dot(z, sub(eye, at)) > 0 ? high : low;
      this.later(project(add(at, scale(z, (from + to) / 2))).depth, () => {
        this.fill(hull([...low, ...high]), side, alpha);
        this.fill(towards, face, alpha);
        this.stroke([...towards, towards[0]], edge, 0.8);
      });
    }

    // A piece of the backbone as a cubic Hermite spline by the tangents at its ends.
    span(one, two, from, to) {
      const { ink, project } = this;
      const chord = norm(sub(two.at, one.at));
      const points = Array.from({ length: 7 }, (_, k) => {
        const t = k / 6;
        const [t2, t3] = [t * t, t * t * t];
        const tangents = add(scale(one.axes[2], chord * (t3 - 2 * t2 + t)), scale(two.axes[2], chord * (t3 - t2)));
        return project(add(tangents, add(scale(one.at, 2 * t3 - 3 * t2 + 1), scale(two.at, 3 * t2 - 2 * t3))));
      });
      const width = Math.max(2.4, (from.radius_m + to.radius_m) * points[3].size);
      const lit = points.map((p) => ({ x: p.x - 0.14 * width, y: p.y - 0.14 * width }));
      this.later(points[3].depth, () => {
        this.stroke(points, ink.tube, width + 2, [], 'butt');
        this.stroke(points, ink.core, width, [], 'butt');
        this.stroke(lit, ink.light, Math.max(0.8, 0.3 * width), [], 'butt');
      });
    }

    tendon({ first, holes_m: holes }, frames, taut) {
      const { ink, project } = this;
      const place = (k) => {
        const { at, axes: [x, y] } = frames[first + k];
        return project(add(at, add(scale(x, holes[k][0]), scale(y, holes[k][1]))));
      };
      for (let k = 0; k + 1 < holes.length && first + k + 1 < frames.length; k += 1) {
        const [a, b] = [place(k), place(k + 1)];
        const points = taut ? [a, b] : this.wave(a, b);
        this.later((a.depth + b.depth) / 2 - 1e-4, () => (taut ? this.stroke(points, ink.taut, 1.5) : this.stroke(points, ink.slack, 1.3, [4, 3])));
      }
      if (!holes.length) return;
      const end = place(Math.min(holes.length, frames.length - first) - 1);
      this.later(end.depth - 2e-4, () => this.dot(end, 2.2, taut ? ink.taut : ink.slack));
    }

    wave(a, b) {
      const [dx, dy] = [b.x - a.x, b.y - a.y];
      const length = Math.hypot(dx, dy) || 1;
      const size = Math.min(3, 0.12 * length);
      return Array.from({ length: 13 }, (_, k) => {
        const t = k / 12;
        const off = size * Math.sin(2 * Math.PI * t);
        return { x: a.x + dx * t - (off * dy) / length, y: a.y + dy * t + (off * dx) / length };
      });
    }

    obstacle(shape) {
      const { camera, ink, project, context } = this;
      if (shape.sphere) {
        const p = project(shape.sphere.center_m);
        const radius = shape.sphere.radius_m * p.size;
        this.later(p.depth, () => {
          const shade = context.createRadialGradient(p.x - radius / 3, p.y - radius / 3, radius / 8, p.x, p.y, radius);
          shade.addColorStop(0, '#fff6dd');
          shade.addColorStop(1, ink.wall);
          context.globalAlpha = 0.75;
          this.dot(p, radius, shade);
          context.globalAlpha = 1;
        });
      } else if (shape.half_space) {
        const { normal, offset_m: offset } = shape.half_space;
        const foot = add(camera.home, scale(normal, offset - dot(camera.home, normal)));
        const one = unit(cross(normal, Math.abs(normal[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
        const other = cross(normal, one);
        const place = (i, j) => project(add(foot, add(scale(one, i * camera.radius), scale(other, j * camera.radius))));
        this.later(project(foot).depth + camera.radius, () => {
          this.fill([place(-1, -1), place(1, -1), place(1, 1), place(-1, 1)], ink.wall, 0.3);
          for (let k = -4; k <= 4; k += 1) {
            this.stroke([place(k / 4, -1), place(k / 4, 1)], ink.wall, 0.6);
            this.stroke([place(-1, k / 4), place(1, k / 4)], ink.wall, 0.6);
          }
        });
      } else if (shape.rod) {
        const [a, b] = shape.rod.ends_m.map(project);
        const middle = project(scale(add(...shape.rod.ends_m), 0.5));
        this.later(middle.depth, () => {
          Object.assign(context, { globalAlpha: 0.6, lineCap: shape.rod.round ? 'round' : 'butt', strokeStyle: ink.wall, lineWidth: 2 * shape.rod.radius_m * middle.size });
          this.path([a, b]);
          context.stroke();
          context.globalAlpha = 1;
        });
      }
    }

    trail({ points, colour, dash, even }) {
      if (even) {
        this.stroke(points.map(this.project), this.ink[colour], 1.3, dash);
        return;
      }
      const chunk = Math.max(2, Math.ceil(points.length / 12));
      for (let start = 0; start + 1 < points.length; start += chunk - 1) {
        this.context.globalAlpha = 0.2 + (0.8 * (start + chunk)) / (points.length + chunk);
        this.stroke(points.slice(start, start + chunk).map(this.project), this.ink[colour], 1.6, dash);
      }
      this.context.globalAlpha = 1;
    }

    marks(now) {
      const { ink, project } = this;
      if (now.target) {
        const p = project(now.target);
        this.context.beginPath();
        this.context.arc(p.x, p.y, 7, 0, 2 * Math.PI);
        Object.assign(this.context, { strokeStyle: ink.target, lineWidth: 1.8 });
        this.context.stroke();
        this.stroke([{ x: p.x - 11, y: p.y }, { x: p.x + 11, y: p.y }], ink.target, 1.4);
        this.stroke([{ x: p.x, y: p.y - 11 }, { x: p.x, y: p.y + 11 }], ink.target, 1.4);
      }
      for (const point of now.measured) {
        const p = project(point);
        const corners = (r) => [[0, -r], [r, 0], [0, r], [-r, 0]].map(([x, y]) => ({ x: p.x + x, y: p.y + y }));
        this.fill(corners(7.5), ink.paper);
        this.fill(corners(5.5), ink.measured);
      }
      if (now.tip && now.measured.length) this.stroke([project(now.tip), project(now.measured[0])], ink.measured, 1.4, [2, 2]);
    }

    // Axes in a corner and the size of the grid in words.
    head() {
      const { context, ink, right, above } = this;
      const centre = { x: 34, y: this.high - 34 };
      Object.assign(context, { font: '600 12px system-ui, sans-serif', textAlign: 'center', textBaseline: 'middle', fillStyle: ink.ink });
      ['x', 'y', 'z'].forEach((name, k) => {
        const axis = [0, 1, 2].map((i) => (i === k ? 1 : 0));
        const [dx, dy] = [dot(axis, right), -dot(axis, above)];
        const tip = { x: centre.x + 19 * dx, y: centre.y + 19 * dy };
        this.stroke([centre, tip], ink.ink, 1.4);
        context.fillText(name, centre.x + 27 * dx, centre.y + 27 * dy);
      });
      Object.assign(context, { font: '12px system-ui, sans-serif', textAlign: 'right', fillStyle: ink.soft });
      context.fillText(`grid ${Number((1e3 * this.step).toPrecision(2))} mm`, this.wide - 10, this.high - 12);
    }
  }

  // Draws on a canvas at its size on the page.
  const paint = (canvas, camera, robot, now, trails, dark) => {
    const ratio = window.devicePixelRatio || 1;
    const [wide, high] = [canvas.clientWidth, canvas.clientHeight];
    if (!wide || !high) return;
    if (canvas.width !== Math.round(wide * ratio)) canvas.width = Math.round(wide * ratio);
    if (canvas.height !== Math.round(high * ratio)) canvas.height = Math.round(high * ratio);
    const context = canvas.getContext('2d');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    new Painter(context, wide, high, camera, dark).scene(robot, now, trails);
  };

  // Orbit and zoom by pointer, touch, wheel and keys. The page still scrolls where the wheel turns without Ctrl
  // over a canvas that has no focus.
  const controls = (canvas, camera, changed) => {
    const pointers = new Map();
    canvas.addEventListener('pointerdown', (event) => {
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener('pointermove', (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const spread = () => {
        const [a, b] = [...pointers.values()];
        return Math.hypot(a[0] - b[0], a[1] - b[1]) || 1;
      };
      if (pointers.size === 2) {
        const wide = spread();
        pointers.set(event.pointerId, [event.clientX, event.clientY]);
        camera.magnify(spread() / wide);
      } else {
        pointers.set(event.pointerId, [event.clientX, event.clientY]);
        camera.turn((before[0] - event.clientX) * 0.008, (event.clientY - before[1]) * 0.008);
      }
      changed();
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
    canvas.addEventListener('wheel', (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return;
      event.preventDefault();
      camera.magnify(Math.exp(-event.deltaY * 0.0015));
      changed();
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => {
      const act = {
        ArrowLeft: () => camera.turn(-0.1, 0), ArrowRight: () => camera.turn(0.1, 0),
        ArrowUp: () => camera.turn(0, 0.1), ArrowDown: () => camera.turn(0, -0.1),
        '+': () => camera.magnify(1.15), '=': () => camera.magnify(1.15), '-': () => camera.magnify(1 / 1.15),
        0: () => camera.reset(),
      }[event.key];
      if (!act || event.metaKey || event.altKey) return;
      event.preventDefault();
      act();
      changed();
    });
  };

  const scheme = window.matchMedia('(prefers-color-scheme: dark)');
  const millimetres = (point) => ['x', 'y', 'z'].map((name, k) => `${name} ${(1e3 * point[k]).toFixed(1)}`).join(', ') + ' mm';
  const slackText = (tensions) => {
    const slack = tensions.flatMap((tension, k) => (tension > 0 ? [] : [k + 1]));
    if (!tensions.length) return '';
    if (!slack.length) return 'all tendons taut';
    return `tendon${slack.length > 1 ? 's' : ''} ${slack.join(', ')} slack`;
  };
  return { Camera, controls, frameAt, millimetres, norm, paint, pose, scheme, slackText, sub };
})();
