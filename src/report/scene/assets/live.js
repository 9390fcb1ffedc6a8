// The live view: sends what the sliders ask for, draws what the solver answers.
const view = JSON.parse(document.getElementById('live-data').textContent);
const element = (id) => document.getElementById(`live-${id}`);
const canvas = element('canvas');
const camera = new SceneView.Camera([{ frames: [], robot: view.robot }]);
let robot = view.robot;
let frame = null;
let fitted = false;
let due = false;
let trail = [];
// Tendons that are slack, from 0, and whether rigid tendons could share their pull otherwise.
let slack = [];
let undetermined = false;
const TRAIL = 600;

const make = (name, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
};

const paint = () => {
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    if (!frame) return;
    const trails = [{ points: trail, colour: 'trail', dash: [] }];
    const now = { ...SceneView.frameAt([frame], frame.time_s), tensions: tautness() };
    SceneView.paint(canvas, camera, robot, now, trails, SceneView.scheme.matches);
  });
};

const number = (value, digits) => value.toFixed(digits).replace('-', '−');
const shown = (value, unit) => {
  if (unit === 'm') return `${number(1e3 * value, 2)} mm`;
  if (unit === 'rad') return `${number((180 / Math.PI) * value, 1)}°`;
  if (unit === 'kg') return `${number(1e3 * value, 1)} g`;
  if (unit === 'flag') return value ? 'yes' : 'no';
  const words = String(Number(value.toPrecision(4))).replace('-', '−');
  return unit === '1' || unit === 'number' ? words : `${words} ${unit}`;
};

// A parameter's name without its unit, components by their axes: `force_n[0]` is `force x`.
const named = (name, unit) => {
  const [word, index] = name.split(/[[\]]/);
  const ending = `_${unit.toLowerCase().replace(/[/ ]/g, '_')}`;
  const plain = word.endsWith(ending) ? word.slice(0, -ending.length) : word;
  return `${plain.replaceAll('_', ' ')}${index ? ` ${'xyz'[index]}` : ''}`;
};

let slider = 0;
const addSlider = (parent, { name, unit, low, high, step, value }, changed) => {
  slider += 1;
  const input = make('input', { type: 'range', id: `slider-${slider}`, min: low, max: high, step, value });
  input.dataset.name = name;
  const output = make('output', { htmlFor: input.id });
  const tell = () => {
    output.textContent = shown(Number(input.value), unit);
    input.setAttribute('aria-valuetext', output.textContent);
  };
  input.addEventListener('input', () => { tell(); changed(); });
  tell();
  parent.append(make('div', { className: 'live-slider' }, make('label', { htmlFor: input.id, textContent: named(name, unit) }), input, output));
  return { input, tell };
};

const ask = (restart = false) => {
  if (!socket || socket.readyState !== WebSocket.OPEN) return;
  const on = effects.filter((effect) => effect.box.checked);
  socket.send(JSON.stringify({
    displacements: controls.map(({ input }) => Number(input.value)),
    at_rest: element('static').checked,
    effects: on.map(({ name, sliders }) => ({ name, values: sliders.map(({ input }) => Number(input.value)) })),
    restart,
  }));
};

const controls = view.controls.map(({ name, unit, travel, opposite }) => {
  const made = addSlider(element('controls'), { name, unit, low: -travel, high: travel, step: travel / 400, value: 0 }, () => {
    const other = opposite === null ? null : controls[opposite];
    if (other && element('opposite').checked) {
      other.input.value = -Number(made.input.value);
      other.tell();
    }
    ask();
  });
  return made;
});
element('opposite').parentElement.hidden = view.controls.every(({ opposite }) => opposite === null);

const effects = view.effects.map((effect) => {
  const box = make('input', { type: 'checkbox', checked: effect.on });
  const group = make('div', { hidden: !effect.on });
  group.setAttribute('role', 'group');
  group.setAttribute('aria-label', effect.name);
  const entry = { name: effect.name, box, sliders: effect.parameters.map((parameter) => addSlider(group, parameter, () => ask())) };
  box.addEventListener('change', () => { group.hidden = !box.checked; ask(); });
  const label = make('label', {}, box, make('span', { textContent: effect.name.replaceAll('_', ' ') }));
  element('effects').append(make('div', { className: 'live-effect' }, label, make('p', { className: 'scene-hint', textContent: effect.missing }), group));
  return entry;
});

// In place of tensions: 0 for a slack tendon. One that is held without tension is not slack.
const tautness = () => frame.tensions_n.map((_, k) => (slack.includes(k) ? 0 : 1));

// Values of an earlier state are dimmed.
const NO_SOLUTION = 'no solution at this time';
const mark = (stale) => document.querySelector('.live').classList.toggle('live-stale', stale);

const receive = (answer) => {
  if (answer.robot) ({ robot } = answer);
  if (answer.restarted) trail = [];
  element('error').textContent = answer.error || '';
  if (answer.error || answer.frame) mark(Boolean(answer.error));
  if (answer.error && !answer.frame) element('time').textContent = NO_SOLUTION;
  if (answer.status) element('status').textContent = answer.status;
  if (answer.frame) {
    ({ frame, slack, undetermined } = answer);
    if (!fitted) {
      fitted = true;
      camera.fit([{ frames: [frame], robot }]);
      // Room to bend.
      camera.radius *= 1.3;
      camera.floor -= 0.2 * robot.length_m;
      camera.reset();
    }
    trail.push(frame.tip_m);
    if (trail.length > TRAIL) trail.shift();
    element('tip').textContent = SceneView.millimetres(frame.tip_m);
    const split = undetermined ? '; rigid tendons leave the split undetermined: the smallest tensions are shown' : '';
    element('tensions').textContent = `${frame.tensions_n.map((n) => n.toFixed(2)).join(', ')} N; ${SceneView.slackText(tautness())}${split}`;
    element('time').textContent = answer.pace < 0.95 ? `${frame.time_s.toFixed(1)} s, slower than real time (×${answer.pace.toFixed(2)})` : `${frame.time_s.toFixed(1)} s`;
    element('tip').dataset.tip = JSON.stringify(frame.tip_m);
  }
  paint();
};

// Every two seconds, for readers of the screen, where something has changed.
setInterval(() => {
  if (!frame) return;
  const stale = document.querySelector('.live-stale') ? `${element('error').textContent} Before: ` : '';
  const words = `${stale}Tip ${SceneView.millimetres(frame.tip_m)}; ${SceneView.slackText(tautness())}; solver ${element('status').textContent}.`;
  if (element('state').textContent !== words) element('state').textContent = words;
}, 2000);

element('static').addEventListener('change', () => ask());
element('home').addEventListener('click', () => {
  controls.forEach(({ input, tell }) => { input.value = 0; tell(); });
  ask();
});
element('restart').addEventListener('click', () => ask(true));
element('view').addEventListener('click', () => { camera.reset(); paint(); });
SceneView.controls(canvas, camera, paint);
SceneView.scheme.addEventListener('change', paint);
new ResizeObserver(paint).observe(canvas);

const socket = new WebSocket(`ws://${location.host}${location.pathname}socket`);
socket.addEventListener('open', () => ask());
socket.addEventListener('message', (event) => receive(JSON.parse(event.data)));
socket.addEventListener('close', () => {
  mark(true);
  element('status').textContent = 'disconnected';
  element('error').textContent = 'The program has ended; the values are those before. Start it again to go on.';
});
