'use strict';
// The page of a comparison: filters, a summary, plots and all results. Everything is in the page; nothing is loaded.
const data = JSON.parse(document.getElementById('data').textContent);
const { rows, tools, defects } = data;
rows.forEach((row, index) => { row.index = index; row.problems = row.defects ? row.defects.reduce((a, b) => a + b, 0) : null; });
const tool = new Map(tools.map((it, index) => [it.name, { ...it, index }]));
const state = {
  hidden: new Set(), mesh: '', class: '', target: '', bad: false,
  base: data.base, measure: 'mean', relative: true, chosen: -1,
  sort: { cells: ['mesh', 1], summary: ['', 1] },
};

// Elements, with text as text only.
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, '');
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}
function drawn(name, attributes = {}, ...children) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) made.addEventListener(key.slice(2), value);
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}
const place = id => document.getElementById(id);
const distinct = values => [...new Set(values)];
const count = (list, test) => list.reduce((sum, it) => sum + (test(it) ? 1 : 0), 0);

// A number with about three digits that count.
function told(x) {
  if (x === null || x === undefined || !Number.isFinite(x)) return '–';
  const size = Math.abs(x);
  if (size === 0) return '0';
  if (size >= 1e5 || size < 1e-4) return x.toExponential(2);
  return String(Number(x.toPrecision(3)));
}

// The colour of a tool: hues a golden angle apart, ours in full strength.
function color(name) {
  const { index, ours } = tool.get(name);
  return `hsl(${(index * 137.5) % 360} ${ours ? 85 : 50}% ${index % 2 ? 42 : 54}%)`;
}
// A point of a tool: its shape tells tools of similar colours apart.
function mark(name, x, y, r, more = {}) {
  const shapes = [
    [[-1, 0], [-0.7, -0.7], [0, -1], [0.7, -0.7], [1, 0], [0.7, 0.7], [0, 1], [-0.7, 0.7]],
    [[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
    [[0, -1.2], [1.1, 0.8], [-1.1, 0.8]],
    [[0, -1.25], [1.25, 0], [0, 1.25], [-1.25, 0]],
    [[0, 1.2], [1.1, -0.8], [-1.1, -0.8]],
  ];
  const points = shapes[tool.get(name).index % shapes.length].map(([dx, dy]) => `${(x + r * dx).toFixed(1)},${(y + r * dy).toFixed(1)}`);
  return drawn('polygon', { points: points.join(' '), fill: color(name), class: 'point', ...more });
}

const measures = {
  mean: 'mean distance', rms: 'RMS distance', max: 'largest distance', normals: 'angle of normals',
};
const key = row => `${row.mesh}\n${row.target}`;
const is_bad = row => row.failure !== null || row.missed || row.problems > 0;

// The rows that the filters leave, with hidden tools or without.
function left(all = false) {
  return rows.filter(row =>
    (all || !state.hidden.has(row.tool)) && (!state.mesh || row.mesh === state.mesh) && (!state.class || row.class === state.class)
    && (!state.target || row.target === state.target) && (!state.bad || is_bad(row)));
}
// The comparable rows of the base, by mesh and target.
function bases() {
  return new Map(rows.filter(row => row.tool === state.base && row.comparable).map(row => [key(row), row]));
}
function ratio(row, base, field) {
  const of = it => Math.max(it[field], 1e-12);
  return of(row) / of(base);
}
function mean_ratio(pairs, field) {
  const known = pairs.filter(([row, base]) => row[field] !== null && base[field] !== null);
  if (!known.length) return null;
  return Math.exp(known.reduce((sum, [row, base]) => sum + Math.log(ratio(row, base, field)), 0) / known.length);
}

// One line for each tool.
function summary() {
  const shown = left(), base = bases();
  const least = new Map();
  for (const row of shown) {
    const best = least.get(key(row));
    if (row.comparable && !(best <= row[state.measure])) least.set(key(row), row[state.measure]);
  }
  return tools.filter(it => shown.some(row => row.tool === it.name)).map(it => {
    const own = shown.filter(row => row.tool === it.name), sound = own.filter(row => row.comparable);
    const pairs = sound.filter(row => base.has(key(row))).map(row => [row, base.get(key(row))]);
    return {
      name: it.name, version: it.version ?? '', runs: own.length, pairs: pairs.length,
      time: mean_ratio(pairs, 'time'), mean: mean_ratio(pairs, 'mean'), rms: mean_ratio(pairs, 'rms'),
      max: mean_ratio(pairs, 'max'), normals: mean_ratio(pairs, 'normals'),
      best: count(sound, row => row[state.measure] <= least.get(key(row))),
      failed: count(own, row => row.failure !== null), missed: count(own, row => row.missed),
      defective: count(own, row => row.problems > 0), problems: own.reduce((sum, row) => sum + (row.problems ?? 0), 0),
    };
  });
}

// Sorts by a field: numbers before gaps, words by the alphabet with numbers in them by size.
function sorted(list, [field, way]) {
  if (!field) return list;
  const words = new Intl.Collator('en', { numeric: true });
  return [...list].sort((a, b) => {
    const [x, y] = [a[field], b[field]], gaps = (x === null || x === undefined) - (y === null || y === undefined);
    if (gaps) return gaps;
    return way * (typeof x === 'number' ? x - y : words.compare(x, y)) || (a.index ?? 0) - (b.index ?? 0);
  });
}

// A table whose heads sort it. A column: field, title, words or not, and the content of a cell.
function table(id, columns, list, row_class) {
  const sort = state.sort[id];
  const heads = columns.map(([field, title, words, , hint]) => {
    const is_it = sort[0] === field;
    const button = element('button', { type: 'button', title: hint ?? false, onclick: () => {
      state.sort[id] = [field, is_it ? -sort[1] : 1];
      draw();
      place(id).querySelectorAll('thead button')[columns.findIndex(it => it[0] === field)].focus();
    } }, title + (is_it ? (sort[1] > 0 ? ' ↑' : ' ↓') : ''));
    return element('th', { scope: 'col', class: words ? 'words' : false, 'aria-sort': is_it ? (sort[1] > 0 ? 'ascending' : 'descending') : false }, button);
  });
  const lines = sorted(list, sort).map(it => element('tr', row_class(it), ...columns.map(([field, , words, content]) => {
    const cell = content ? content(it) : told(it[field]);
    return cell instanceof HTMLTableCellElement ? cell : element('td', { class: words ? 'words' : false }, cell);
  })));
  place(id).replaceChildren(element('thead', {}, element('tr', {}, ...heads)), element('tbody', {}, ...lines));
}

function draw_summary() {
  const share = (field, of = 'runs') => it => element('td', { class: it[field] > 0 && of === 'runs' ? 'wrong' : false }, `${it[field]}`);
  table('summary', [
    ['name', 'tool', true, it => it.name], ['version', 'version', true, it => it.version],
    ['runs', 'runs', false, it => `${it.runs}`], ['pairs', 'compared', false, it => `${it.pairs}`, 'Runs whose number of faces is right, for the tool and for the base'],
    ['time', 'time'], ['mean', 'mean'], ['rms', 'RMS'], ['max', 'largest'], ['normals', 'normals'],
    ['best', 'lowest', false, share('best', 'cells'), `Cells in which no tool that is shown has a lower ${measures[state.measure]}`],
    ['failed', 'failed', false, share('failed')], ['missed', 'other number', false, share('missed'), 'Runs with another number of faces than asked for'],
    ['defective', 'with defects', false, share('defective'), 'Runs with defects that the input did not have'], ['problems', 'defects', false, it => `${it.problems}`],
  ], summary(), it => ({ class: tool.get(it.name).ours ? 'ours' : false, 'data-tool': it.name }));
}

function draw_cells(shown) {
  const percent = field => row => (row[field] === null ? '–' : told(100 * row[field]));
  const found = row => row.defects.map((n, i) => (n ? `${n} ${defects[i]}` : '')).filter(Boolean).join(', ');
  table('cells', [
    ['mesh', 'mesh', true, row => row.mesh], ['class', 'kind', true, row => row.class ?? ''], ['target', 'target', true, row => row.target],
    ['tool', 'tool', true, row => row.tool], ['view', 'meshes', true, row => (row.view ? element('a', { href: row.view }, 'open') : '')],
    ['faces', 'faces', false, row => `${row.faces ?? '–'}`], ['time', 'time, s'],
    ['mean', 'mean, %', false, percent('mean')], ['rms', 'RMS, %', false, percent('rms')], ['max', 'largest, %', false, percent('max')],
    ['normals', 'normals, °'], ['bytes', 'bytes/face', false, row => (row.bytes === null ? '–' : String(Math.round(row.bytes)))],
    ['area', 'area, %', false, percent('area')], ['volume', 'volume, %', false, percent('volume')],
    ['problems', 'defects', false, row => element('td', { class: row.problems > 0 ? 'wrong' : false }, `${row.problems ?? '–'}`)],
    ['failure', 'what is wrong', true, row => element('td', { class: 'why' }, row.failure ?? [row.missed ? `${row.wanted} faces were asked for` : '', found(row)].filter(Boolean).join('; '))],
  ], shown, row => ({ class: [tool.get(row.tool).ours && 'ours', row.index === state.chosen && 'chosen'].filter(Boolean).join(' ') || false, 'data-row': row.index }));
}

// The row of a point comes into view.
function choose(row) {
  state.chosen = row.index;
  draw();
  place('cells').querySelector('.chosen')?.scrollIntoView({ block: 'center' });
}

// A scale of powers of ten, with its lines.
function logarithmic(values, [from, to]) {
  const logs = values.map(Math.log10);
  let low = Math.min(...logs), high = Math.max(...logs);
  const room = Math.max(0.04 * (high - low), 0.05);
  low -= room; high += room;
  const at = x => from + (to - from) * (Math.log10(x) - low) / (high - low);
  const steps = high - low > 2.5 ? [1] : high - low > 1 ? [1, 3] : [1, 1.5, 2, 3, 5, 7];
  const lines = [];
  for (let power = Math.floor(low); power <= high; power++)
    for (const step of steps) { const x = step * 10 ** power; if (Math.log10(x) >= low && Math.log10(x) <= high) lines.push(x); }
  return { at, lines };
}

const [WIDTH, HEIGHT, LEFT, BELOW] = [560, 380, 58, 40];
function scatter(id, points, x_title, y_title, joined) {
  const plot = place(id);
  if (!points.length) { plot.replaceChildren(drawn('text', { x: 20, y: 30 }, 'Nothing to show')); return; }
  const x = logarithmic(points.map(p => p.x), [LEFT, WIDTH - 8]), y = logarithmic(points.map(p => p.y), [HEIGHT - BELOW, 8]);
  const parts = [];
  for (const line of x.lines) parts.push(drawn('line', { class: 'grid', x1: x.at(line), x2: x.at(line), y1: 8, y2: HEIGHT - BELOW }), drawn('text', { x: x.at(line), y: HEIGHT - BELOW + 15, 'text-anchor': 'middle' }, told(line)));
  for (const line of y.lines) parts.push(drawn('line', { class: 'grid', x1: LEFT, x2: WIDTH - 8, y1: y.at(line), y2: y.at(line) }), drawn('text', { x: LEFT - 5, y: y.at(line) + 4, 'text-anchor': 'end' }, told(line)));
  parts.push(drawn('text', { class: 'name', x: (LEFT + WIDTH) / 2, y: HEIGHT - 6, 'text-anchor': 'middle' }, x_title));
  parts.push(drawn('text', { class: 'name', x: 0, y: 0, 'text-anchor': 'middle', transform: `translate(12 ${(HEIGHT - BELOW) / 2}) rotate(-90)` }, y_title));
  if (joined) for (const name of distinct(points.map(p => p.row.tool))) for (const mesh of distinct(points.map(p => p.row.mesh))) {
    const own = points.filter(p => p.row.tool === name && p.row.mesh === mesh).sort((a, b) => a.x - b.x);
    if (own.length > 1) parts.push(drawn('polyline', { class: 'path', stroke: color(name), points: own.map(p => `${x.at(p.x).toFixed(1)},${y.at(p.y).toFixed(1)}`).join(' ') }));
  }
  for (const { row, x: px, y: py } of points) {
    const name = `${row.tool}, ${row.mesh} to ${row.target}: ${told(px)}, ${told(py)}`;
    parts.push(mark(row.tool, x.at(px), y.at(py), 4, { onclick: () => choose(row), 'data-row': row.index, 'data-x': px, 'data-y': py }));
    parts.at(-1).append(drawn('title', {}, name));
  }
  plot.replaceChildren(...parts);
}

// Runs with something wrong, of each tool.
function bars(id) {
  const lines = summary(), plot = place(id), most = Math.max(1, ...lines.map(it => it.runs)), step = 19;
  plot.setAttribute('viewBox', `0 0 ${WIDTH} ${step * lines.length + 6}`);
  const parts = [], [from, to] = [150, WIDTH - 44];
  lines.forEach((it, line) => {
    const y = 4 + step * line;
    parts.push(drawn('text', { class: 'name', x: from - 6, y: y + 11, 'text-anchor': 'end' }, it.name));
    const kinds = [['failed', it.failed], ['missed', it.missed], ['defect', it.defective]];
    kinds.forEach(([kind, n], i) => {
      const bar = drawn('rect', { class: kind, x: from, y: y + 4.6 * i, height: 4, width: (to - from) * n / most, 'data-tool': it.name, 'data-count': n });
      bar.append(drawn('title', {}, `${it.name}: ${n} of ${it.runs} runs`));
      parts.push(bar);
    });
    parts.push(drawn('line', { class: 'grid', x1: from, x2: from, y1: y, y2: y + 15 }));
    const worst = Math.max(...kinds.map(([, n]) => n));
    parts.push(drawn('text', { x: from + 5 + (to - from) * worst / most, y: y + 11 }, kinds.map(([, n]) => n).join(' ')));
  });
  plot.replaceChildren(...parts);
}

function draw() {
  const shown = left(), base = bases(), { measure, relative } = state;
  const y = row => (relative ? (base.has(key(row)) ? ratio(row, base.get(key(row)), measure) : null) : row[measure] * (measure === 'normals' ? 1 : 100));
  const sound = shown.filter(row => row.comparable);
  const usable = p => p.x > 0 && p.y > 0 && Number.isFinite(p.x) && Number.isFinite(p.y);
  const unit = measure === 'normals' ? ', °' : ', % of the diagonal';
  const y_title = measures[measure] + (relative ? ` / ${state.base}` : unit);
  const time = row => (relative ? (base.has(key(row)) ? ratio(row, base.get(key(row)), 'time') : null) : row.time);
  scatter('by-time', sound.map(row => ({ row, x: time(row), y: y(row) })).filter(usable), relative ? `time / ${state.base}` : 'time, s', y_title, false);
  scatter('by-faces', shown.filter(row => row.failure === null).map(row => ({ row, x: row.faces, y: row[measure] * (measure === 'normals' ? 1 : 100) })).filter(usable), 'faces reached', measures[measure] + unit, true);
  bars('failures');
  draw_summary();
  draw_cells(shown);
  place('count').textContent = `${shown.length} of ${rows.length} runs`;
}

// The controls.
function choice(id, label, options, value, set) {
  const select = element('select', { id, onchange: () => { set(select.value); draw(); } }, ...options.map(([it, text]) => element('option', { value: it, selected: it === value }, text)));
  return element('label', {}, label, select);
}
function box(id, label, is_on, set, ...more) {
  const input = element('input', { type: 'checkbox', id, checked: is_on, onchange: () => { set(input.checked); draw(); } });
  return element('label', {}, input, ...more, label);
}
const options = (field, all) => [['', all], ...distinct(rows.map(row => row[field]).filter(Boolean)).map(it => [it, it])];
place('controls').append(
  element('div', { class: 'line' },
    choice('mesh', 'Mesh', options('mesh', 'all'), '', it => { state.mesh = it; }), choice('class', 'Kind', options('class', 'all'), '', it => { state.class = it; }),
    choice('target', 'Target', options('target', 'all'), '', it => { state.target = it; }), choice('measure', 'Error', Object.entries(measures), 'mean', it => { state.measure = it; }),
    choice('base', 'Ratios to', tools.map(it => [it.name, it.name]), state.base, it => { state.base = it; }),
    box('relative', 'plot time against error as ratios', state.relative, it => { state.relative = it; }), box('bad', 'only runs with something wrong', false, it => { state.bad = it; }),
    element('output', { id: 'count' })),
  element('fieldset', { id: 'tools' }, element('legend', {}, 'Tools'), element('div', { class: 'line' },
    ...tools.map(it => box(`tool-${it.name}`, it.name, true, is_on => { state.hidden[is_on ? 'delete' : 'add'](it.name); }, drawn('svg', { width: 14, height: 14, 'aria-hidden': 'true' }, mark(it.name, 7, 7, 5)))),
    element('button', { type: 'button', id: 'no-tools', onclick: () => {
      const boxes = [...place('tools').querySelectorAll('input')], is_on = !boxes.some(it => it.checked);
      boxes.forEach(it => { it.checked = is_on; });
      state.hidden = new Set(is_on ? [] : tools.map(it => it.name));
      draw();
    } }, 'all or none'))));
draw();
window.ready = true;
