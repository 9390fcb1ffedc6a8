// Plays scenes side by side on one clock and with one camera.
const ScenePlayer = (() => {
  const TRAIL = 400;

  class Player {
    constructor(root) {
      this.root = root;
      this.scenes = JSON.parse(root.querySelector('.scene-data').textContent);
      this.camera = new SceneView.Camera(this.scenes);
      this.start = Math.min(...this.scenes.map(({ frames }) => frames[0].time_s));
      this.end = Math.max(...this.scenes.map(({ frames }) => frames[frames.length - 1].time_s));
      Object.assign(this, { time: this.end, playing: false, speed: 1, due: false, printing: false });
      // The way of the target, where it moves.
      this.paths = this.scenes.map(({ frames }) => {
        const targets = frames.flatMap(({ target_m: target }) => (target ? [target] : []));
        const moves = targets.some((target) => SceneView.norm(SceneView.sub(target, targets[0])) > 1e-4);
        return moves ? targets : [];
      });
      const part = (name) => root.querySelector(`.scene-${name}`);
      Object.assign(this, { button: part('play'), range: part('time'), clock: part('clock'), state: part('state') });
      this.panels = [...root.querySelectorAll('.scene-panel')].map((panel) => ({
        canvas: panel.querySelector('canvas'), output: panel.querySelector('output'),
      }));
      this.listen(part('speed'), part('reset'));
      root.classList.add('scene-ready');
      this.announce();
      this.draw();
    }

    listen(speed, reset) {
      this.range.min = this.start;
      this.range.max = this.end;
      this.range.step = 'any';
      this.range.addEventListener('input', () => this.seek(Number(this.range.value), true));
      this.button.addEventListener('click', () => this.toggle());
      speed.addEventListener('change', () => { this.speed = Number(speed.value); });
      reset.addEventListener('click', () => { this.camera.reset(); this.draw(); });
      for (const { canvas } of this.panels) {
        SceneView.controls(canvas, this.camera, () => this.draw());
        canvas.addEventListener('keydown', (event) => {
          if (event.key !== ' ') return;
          event.preventDefault();
          this.toggle();
        });
      }
      new ResizeObserver(() => this.draw()).observe(this.root);
      SceneView.scheme.addEventListener('change', () => this.draw());
      const print = (printing) => () => {
        this.printing = printing;
        if (printing) this.seek(this.end, true);
        this.paint();
      };
      window.addEventListener('beforeprint', print(true));
      window.addEventListener('afterprint', print(false));
    }

    toggle() {
      this.playing = !this.playing;
      if (this.playing && this.time >= this.end) this.time = this.start;
      this.before = null;
      this.button.textContent = this.playing ? 'Pause' : 'Play';
      if (!this.playing) this.announce();
      this.draw();
    }

    seek(time, announced) {
      if (this.playing && announced) this.toggle();
      this.time = Math.max(this.start, Math.min(this.end, time));
      if (announced) this.announce();
      this.draw();
    }

    draw() {
      if (this.due) return;
      this.due = true;
      requestAnimationFrame((now) => {
        this.due = false;
        if (this.playing) this.advance(now);
        this.paint();
        if (this.playing) this.draw();
      });
    }

    advance(now) {
      const passed = this.before === null ? 0 : (now - this.before) / 1e3;
      this.before = now;
      this.time = Math.min(this.end, this.time + passed * this.speed);
      if (this.time >= this.end) this.toggle();
    }

    trails({ frames }, index, tip, path) {
      const past = frames.slice(Math.max(0, index + 1 - TRAIL), index + 1);
      const tips = past.flatMap((frame) => (frame.tip_m ? [frame.tip_m] : []));
      const measured = past.flatMap((frame) => (frame.measured_m ? [frame.measured_m[0]] : []));
      const targets = { points: path, colour: 'target', dash: [5, 4], even: true };
      return [targets, { points: measured, colour: 'measured', dash: [2, 3] }, { points: tip ? [...tips, tip] : tips, colour: 'trail', dash: [] }];
    }

    paint() {
      const dark = !this.printing && SceneView.scheme.matches;
      this.scenes.forEach((scene, k) => {
        const now = SceneView.frameAt(scene.frames, this.time);
        SceneView.paint(this.panels[k].canvas, this.camera, scene.robot, now, this.trails(scene, now.index, now.tip, this.paths[k]), dark);
        this.panels[k].output.textContent = this.describe(now, scene);
      });
      this.range.value = this.time;
      const words = `${this.time.toFixed(1)} of ${this.end.toFixed(1)} s`;
      this.range.setAttribute('aria-valuetext', words);
      this.clock.textContent = words;
    }

    describe({ tip, target, measured, poses }, { frames, robot }) {
      const from = (point) => `${(1e3 * SceneView.norm(SceneView.sub(tip, point))).toFixed(1)} mm`;
      const parts = [];
      const last = frames[frames.length - 1].time_s;
      if (this.time > last + 1e-6) parts.push(`finished at ${last.toFixed(1)} s`);
      if (!tip) {
        if (!poses.length && robot.stations.length) parts.push('no solution at this time');
        if (measured.length) parts.push(`measured tip ${SceneView.millimetres(measured[0])}`);
        return parts.join('; ') || 'no solution at this time';
      }
      parts.push(`tip ${SceneView.millimetres(tip)}`);
      if (target) parts.push(`${from(target)} from the target`);
      if (measured.length) parts.push(`${from(measured[0])} from the measured tip`);
      return parts.join('; ');
    }

    announce() {
      const each = this.scenes.map((scene) => {
        const now = SceneView.frameAt(scene.frames, this.time);
        return `${scene.name}: ${[this.describe(now, scene), SceneView.slackText(now.tensions)].filter(Boolean).join('; ')}.`;
      });
      this.state.textContent = `At ${this.time.toFixed(1)} s. ${each.join(' ')}`;
    }
  }

  return { start: (root) => new Player(root) };
})();
document.querySelectorAll('.scene-player:not(.scene-ready)').forEach((root) => { root.player = ScenePlayer.start(root); });
