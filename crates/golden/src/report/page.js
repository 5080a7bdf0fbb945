'use strict';
(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const $ = (id) => document.getElementById(id);
  const VIEWS = [
    ['three', 'Three-up'], ['swipe', 'Swipe'], ['onion', 'Onion skin'], ['flip', 'Flip'],
    ['heat', 'Heat map'], ['difference', 'Difference'], ['zoom', 'Zoom 8×'], ['histogram', 'Histogram'],
  ];
  const BACKGROUNDS = ['checker', 'black', 'white'];
  const SCALES = [0, 1, 2, 4, 8]; // 0: fit
  const state = {
    entry: null, view: 'three', scale: 0, share: 50, period: 700, paused: false, showActual: false,
    background: 0, place: null, sort: 'worst', descending: true, all: data.entries.every((e) => e.good),
  };
  let timer = 0;

  const make = (tag, attributes = {}, ...children) => {
    const node = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes)) {
      if (key === 'text') node.textContent = value;
      else if (key.startsWith('on')) node.addEventListener(key.slice(2), value);
      else node.setAttribute(key, value);
    }
    node.append(...children);
    return node;
  };

  // The list.

  const visible = () => {
    const words = $('search').value.toLowerCase();
    const entries = data.entries.filter((e) =>
      (state.all || !e.good || e === state.entry) && e.name.toLowerCase().includes(words));
    if (state.sort === 'worst') return state.descending ? entries : entries.reverse();
    const column = Number(state.sort);
    // Infinite (PSNR of equal pictures) sorts above all, no number below.
    const value = (e) => (e.numbers ? (e.numbers[column][0] ?? Infinity) : -Infinity);
    entries.sort((a, b) => (value(a) < value(b) ? -1 : value(a) > value(b) ? 1 : 0));
    return state.descending ? entries.reverse() : entries;
  };

  const drawList = () => {
    const entries = visible();
    $('rows').replaceChildren(...entries.map((entry) => {
      const first = make('td', { colspan: entry.numbers ? 1 : 6 },
        make('span', { class: `verdict ${entry.class}`, text: entry.verdict }), entry.name);
      const cells = entry.numbers ? [4, 0, 1, 2, 3].map((k) => make('td', { text: entry.numbers[k][1] })) : [];
      const row = make('tr', { 'aria-selected': entry === state.entry }, first, ...cells);
      row.addEventListener('click', () => open(entry));
      return row;
    }));
    $('nothing').hidden = entries.length > 0;
    for (const th of document.querySelectorAll('th')) {
      if (th.dataset.sort === state.sort) th.setAttribute('aria-sort', state.descending ? 'descending' : 'ascending');
      else th.removeAttribute('aria-sort');
    }
  };

  const open = (entry, stay) => {
    if (entry !== state.entry) state.place = null;
    state.entry = entry;
    if (!stay) document.body.classList.add('open');
    const selected = () => document.querySelector('tr[aria-selected=true]');
    drawList();
    if (selected()) selected().scrollIntoView({ block: 'nearest' });
    drawViewer();
  };

  const step = (by) => {
    const entries = visible();
    if (entries.length === 0) return;
    const at = entries.indexOf(state.entry) + by;
    open(entries[Math.max(0, Math.min(entries.length - 1, at))], true);
  };

  // The viewer.

  const can = (view) => {
    const v = state.entry && state.entry.views;
    if (!v) return false;
    switch (view) {
      case 'three': return true;
      case 'heat': return Boolean(v.heat);
      case 'difference': return Boolean(v.difference);
      case 'histogram': return Boolean(v.histogram);
      // Pictures of different sizes have no place in common.
      default: return Boolean(v.expected && v.actual && !v.actual_size);
    }
  };

  const drawViewer = () => {
    const { entry } = state;
    clearInterval(timer);
    $('stage').replaceChildren();
    $('controls').style.visibility = entry && entry.views ? 'visible' : 'hidden';
    $('name').textContent = entry ? entry.name : 'Choose a file';
    const v = entry && entry.views;
    $('facts').textContent = v ? `${v.width} × ${v.height}, ${v.kind}` : '';
    $('reasons').replaceChildren(...(entry ? entry.reasons : []).map((text) => make('li', { text })));
    const view = can(state.view) ? state.view : 'three';
    $('views').replaceChildren(...VIEWS.map(([id, label], k) => {
      const button = make('button', { role: 'tab', 'aria-selected': id === view, 'data-view': id },
        make('kbd', { text: k + 1 }), label);
      button.disabled = !can(id);
      button.addEventListener('click', () => { state.view = id; drawViewer(); });
      return button;
    }));
    $('slider').style.visibility = ['swipe', 'onion', 'flip'].includes(view) ? 'visible' : 'hidden';
    $('pause').style.display = view === 'flip' ? '' : 'none';
    $('scale-box').style.visibility = ['zoom', 'histogram'].includes(view) ? 'hidden' : 'visible';
    $('scale').textContent = state.scale ? `${state.scale}×` : 'fit';
    $('which').textContent = '';
    $('slider').value = view === 'flip' ? 100 - (state.period - 100) / 19 : state.share;
    $('slider').setAttribute('aria-label', view === 'flip' ? 'Speed' : 'Share of the actual picture');
    if (entry) history.replaceState(null, '', `#${view}/${encodeURIComponent(entry.name)}`);
    if (!v) {
      if (entry) $('stage').append(make('p', { text: entry.good ? 'Every sample is the same.' : 'No pictures.' }));
      return;
    }
    ({ three, swipe, onion, flip, heat, difference, zoom, histogram })[view](v);
  };

  const picture = (source, alt, className = '') => make('img', { src: source, alt, class: className, draggable: 'false' });

  /** The width at which a picture fits the stage beside `others`; small ones are enlarged by whole numbers up to 8. */
  const fittingWidth = (v, others) => {
    const stage = $('stage');
    const narrow = matchMedia('(max-width: 760px)').matches;
    const room = (stage.clientWidth - 28) / (narrow ? 1 : 1 + others) - (others && !narrow ? 7 : 0);
    const high = narrow ? Infinity : Math.max(220, stage.clientHeight - 60) * v.width / v.height;
    const fit = Math.min(room, high);
    return fit < v.width ? fit : v.width * Math.min(8, Math.floor(fit / v.width));
  };

  /** A box for pictures on top of each other, in the chosen size; a click chooses the place to enlarge. */
  const frame = (v, ...images) => framed(v, 0, images);
  const framed = (v, others, images) => {
    const box = make('div', { class: `frame ${BACKGROUNDS[state.background]}` }, ...images);
    if (state.scale) {
      box.classList.add('scaled');
      box.style.width = `${v.width * state.scale}px`;
    } else {
      const width = fittingWidth(v, others);
      box.style.width = `${width}px`;
      box.classList.toggle('smooth', width < v.width);
    }
    box.addEventListener('click', (event) => {
      if (box.classList.contains('swipe')) return;
      const bounds = box.getBoundingClientRect();
      const size = v.block;
      const at = (place, extent) => Math.max(0, Math.min(extent - size, Math.round(place * extent - size / 2)));
      state.place = [at((event.clientX - bounds.left) / bounds.width, v.width), at((event.clientY - bounds.top) / bounds.height, v.height)];
      document.querySelectorAll('.box').forEach(placeBox(v));
    });
    return box;
  };

  const place = (v) => state.place || v.worst || [0, 0];

  const placeBox = (v) => (box) => {
    const [x, y] = place(v);
    const share = (a, b) => `${100 * Math.min(1, a / b)}%`;
    Object.assign(box.style, { left: share(x, v.width), top: share(y, v.height), width: share(v.block, v.width), height: share(v.block, v.height) });
  };

  const marked = (v) => {
    const box = make('div', { class: 'box' });
    placeBox(v)(box);
    return box;
  };

  const figure = (caption, content) =>
    make('figure', { class: 'fixed' }, make('figcaption', { text: caption }), content);

  const three = (v) => {
    const panels = make('div', { class: 'panels' });
    const others = [v.expected, v.difference, v.actual].filter(Boolean).length - 1;
    const add = (caption, ...images) => panels.append(figure(caption, framed(v, others, images)));
    if (v.expected) add('Expected', picture(v.expected, 'Expected'));
    if (v.difference) add('Difference: red little, white much', picture(v.difference, 'Difference'), marked(v));
    if (v.actual) {
      const [width, height] = v.actual_size || [v.width, v.height];
      const caption = v.actual_size ? `Actual, ${width} × ${height}` : 'Actual';
      panels.append(figure(caption, framed({ ...v, width, height }, others, [picture(v.actual, 'Actual')])));
    }
    $('stage').append(panels);
  };

  const swipe = (v) => {
    const top = picture(v.actual, 'Actual', 'over');
    const divider = make('div', { class: 'divider' });
    const box = frame(v, picture(v.expected, 'Expected'), top, divider,
      make('span', { class: 'tag left', text: 'expected' }), make('span', { class: 'tag right', text: 'actual' }));
    box.classList.add('swipe');
    const update = () => {
      top.style.clipPath = `inset(0 0 0 ${state.share}%)`;
      divider.style.left = `${state.share}%`;
      $('slider').value = state.share;
      $('which').textContent = `${Math.round(state.share)} %`;
    };
    const follow = (event) => {
      const bounds = box.getBoundingClientRect();
      state.share = Math.max(0, Math.min(100, 100 * (event.clientX - bounds.left) / bounds.width));
      update();
    };
    box.addEventListener('pointerdown', (event) => { box.setPointerCapture(event.pointerId); follow(event); });
    box.addEventListener('pointermove', (event) => { if (event.pointerType === 'mouse' || event.buttons) follow(event); });
    onSlide = update;
    $('stage').append(box);
    update();
  };

  const onion = (v) => {
    const top = picture(v.actual, 'Actual', 'over');
    const below = picture(v.expected, 'Expected');
    $('stage').append(frame(v, below, top));
    onSlide = () => {
      top.style.opacity = state.share / 100;
      // Translucent pictures would shine through each other.
      below.style.opacity = state.share === 100 ? 0 : 1;
      $('which').textContent = `${Math.round(state.share)} % actual`;
    };
    onSlide();
  };

  const flip = (v) => {
    const images = [picture(v.expected, 'Expected'), picture(v.actual, 'Actual', 'over')];
    const tag = make('span', { class: 'tag left' });
    $('stage').append(frame(v, ...images, tag));
    const show = () => {
      images.forEach((image, k) => { image.style.visibility = (k === 1) === state.showActual ? 'visible' : 'hidden'; });
      tag.textContent = state.showActual ? 'actual' : 'expected';
      $('which').textContent = state.paused ? 'stopped' : `${(state.period / 1000).toFixed(1)} s`;
      $('pause').textContent = state.paused ? 'Flip' : 'Pause';
    };
    const start = () => {
      clearInterval(timer);
      if (!state.paused) timer = setInterval(() => { state.showActual = !state.showActual; show(); }, state.period);
      show();
    };
    onSlide = () => { state.period = 100 + 19 * (100 - $('slider').value); start(); };
    start();
  };

  const heat = (v) => {
    $('stage').append(
      make('div', { class: 'legend', title: 'FLIP' }),
      make('div', { class: 'legend-text' }, make('span', { text: '0 not seen' }), make('span', { text: 'FLIP' }), make('span', { text: '1' })),
      frame(v, picture(v.heat, 'FLIP'), marked(v)));
  };

  const difference = (v) => {
    $('stage').append(frame(v, picture(v.difference, 'Difference'), marked(v)));
  };

  const zoom = (v) => {
    const [x, y] = place(v);
    const size = [Math.min(v.block, v.width), Math.min(v.block, v.height)];
    const panels = make('div', { class: 'panels' });
    for (const [caption, source] of [['Expected', v.expected], ['Difference', v.difference], ['Actual', v.actual]]) {
      if (!source) continue;
      const canvas = make('canvas', { width: 8 * size[0], height: 8 * size[1], class: BACKGROUNDS[state.background], role: 'img', 'aria-label': caption });
      const image = new Image();
      image.onload = () => {
        const context = canvas.getContext('2d');
        context.imageSmoothingEnabled = false;
        context.drawImage(image, x, y, size[0], size[1], 0, 0, canvas.width, canvas.height);
        canvas.dataset.drawn = 'yes';
      };
      image.src = source;
      panels.append(make('figure', { class: 'fixed' }, make('figcaption', { text: caption }), canvas));
    }
    const what = state.place ? 'The place that was chosen' : 'The block that differs most';
    $('stage').append(make('p', { text: `${what}: columns ${x} to ${x + size[0] - 1}, rows ${y} to ${y + size[1] - 1}` }), panels);
  };

  const histogram = (v) => {
    const [counts, most] = v.histogram;
    const ns = $('plot').namespaceURI;
    const svg = document.createElementNS(ns, 'svg');
    const [width, height, base, left] = [720, 260, 226, 46];
    svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    const add = (tag, attributes, text) => {
      const node = document.createElementNS(ns, tag);
      for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
      if (text !== undefined) node.textContent = text;
      svg.append(node);
      return node;
    };
    const top = Math.log10(1 + Math.max(...counts));
    const y = (count) => base - (base - 16) * (top ? Math.log10(1 + count) / top : 0);
    for (let power = 0; power <= top; power += 1) {
      add('line', { x1: left, x2: width, y1: y(10 ** power), y2: y(10 ** power) });
      add('text', { x: left - 6, y: y(10 ** power) + 4, 'text-anchor': 'end' }, 10 ** power >= 1e4 ? `10^${power}` : 10 ** power);
    }
    const bar = (width - left) / counts.length;
    const label = (value) => (value >= 100 ? value.toFixed(0) : Number(value.toPrecision(3)).toString());
    counts.forEach((count, k) => {
      if (!count) return;
      const node = add('rect', { x: left + k * bar + 1, y: y(count), width: bar - 2, height: base - y(count) });
      const title = document.createElementNS(ns, 'title');
      title.textContent = `${count} pixels`;
      node.append(title);
    });
    const end = most === null ? '∞' : label(most);
    add('text', { x: left, y: base + 18 }, '0');
    if (most !== null) add('text', { x: left + (width - left) / 2, y: base + 18, 'text-anchor': 'middle' }, label(most / 2));
    add('text', { x: width, y: base + 18, 'text-anchor': 'end' }, end);
    $('stage').append(make('p', { text: 'Pixels (logarithmic) by the largest difference of a channel; equal pixels are not counted' }), svg);
  };

  // Controls.

  let onSlide = () => {};

  $('slider').addEventListener('input', () => {
    if (state.view !== 'flip') state.share = Number($('slider').value);
    onSlide();
  });
  $('pause').addEventListener('click', () => { state.paused = !state.paused; drawViewer(); });
  const rescale = (by) => {
    const at = SCALES.indexOf(state.scale) + by;
    state.scale = by === 0 ? 0 : SCALES[Math.max(0, Math.min(SCALES.length - 1, at))];
    drawViewer();
  };
  $('smaller').addEventListener('click', () => rescale(-1));
  $('larger').addEventListener('click', () => rescale(1));
  const back = () => { document.body.classList.remove('open'); drawList(); };
  $('back').addEventListener('click', back);
  $('help-button').addEventListener('click', () => $('help').showModal());
  $('search').addEventListener('input', drawList);
  $('all').checked = state.all;
  $('all').addEventListener('change', () => { state.all = $('all').checked; drawList(); });
  for (const th of document.querySelectorAll('th')) {
    th.firstElementChild.addEventListener('click', () => {
      if (state.sort === th.dataset.sort) state.descending = !state.descending;
      else [state.sort, state.descending] = [th.dataset.sort, true];
      drawList();
    });
  }

  const slide = (by) => {
    if (!['swipe', 'onion', 'flip'].includes(state.view)) return false;
    $('slider').value = Number($('slider').value) + by;
    $('slider').dispatchEvent(new Event('input'));
    return true;
  };

  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || $('help').open) return;
    if (event.target === $('search')) {
      if (event.key === 'Escape' || event.key === 'Enter') $('search').blur();
      return;
    }
    const key = event.key;
    let used = true;
    if (key === 'ArrowDown' || key === 'j') step(1);
    else if (key === 'ArrowUp' || key === 'k') step(-1);
    else if (key === 'ArrowLeft' || key === 'ArrowRight') used = slide(key === 'ArrowLeft' ? -2 : 2);
    else if (key >= '1' && key <= String(VIEWS.length)) { if (can(VIEWS[key - 1][0])) { state.view = VIEWS[key - 1][0]; drawViewer(); } }
    else if (key === ' ') {
      if (state.view !== 'flip') used = false;
      else if (!state.paused) { state.paused = true; drawViewer(); }
      else { state.showActual = !state.showActual; drawViewer(); }
    } else if (key === '+' || key === '=') rescale(1);
    else if (key === '-') rescale(-1);
    else if (key === '0') rescale(0);
    else if (key === 'b') { state.background = (state.background + 1) % BACKGROUNDS.length; drawViewer(); }
    else if (key === 'a') $('all').click();
    else if (key === '/') $('search').focus();
    else if (key === '?') $('help').showModal();
    else if (key === 'Escape') back();
    else used = false;
    if (used) event.preventDefault();
  });

  let resizing = 0;
  addEventListener('resize', () => { clearTimeout(resizing); resizing = setTimeout(drawViewer, 150); });

  // The beginning.

  const counts = {};
  for (const entry of data.entries) counts[entry.verdict] = (counts[entry.verdict] || 0) + 1;
  const parts = Object.entries(counts).map(([verdict, count]) => `${count} ${verdict}`);
  const files = data.entries.length === 1 ? '1 file' : `${data.entries.length} files`;
  $('summary').textContent = `${files}: ${parts.join(', ')}. ${data.expected} → ${data.actual} (overcoat ${data.version})`;
  document.title = parts.length ? `${parts.join(', ')} – golden pictures` : document.title;
  const [view, ...rest] = location.hash.slice(1).split('/');
  if (VIEWS.some(([id]) => id === view)) state.view = view;
  let wanted = '';
  try { wanted = decodeURIComponent(rest.join('/')); } catch { /* A damaged address chooses nothing. */ }
  const named = data.entries.find((entry) => entry.name === wanted);
  drawList();
  const first = named || visible()[0];
  if (first) open(first, !named);
  else drawViewer();
})();
