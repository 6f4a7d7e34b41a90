// The card with the numbers of the probe.

import { count, metres, number } from './format.js';

const BANDS = [['R', '#e0726a'], ['G', '#7fc27a'], ['B', '#6f9be8']];

const element = (tag, text = '', name = '') => Object.assign(document.createElement(tag), { textContent: text, className: name });

function row(name, values, sub = false, text = number) {
  const tr = element('tr');
  const th = element('th', name, sub ? 'sub' : '');
  th.scope = 'row';
  tr.append(th, ...values.map((v) => element('td', text(v))));
  return tr;
}

function group(text) {
  const tr = element('tr', '', 'group');
  const th = element('th', text);
  th.colSpan = 4;
  tr.append(th);
  return tr;
}

/** Fills `card` with the result of a probe. */
export function showProbe(card, found, close) {
  const head = element('header');
  const button = element('button', '×', 'icon small');
  button.type = 'button';
  button.setAttribute('aria-label', 'Close the probe');
  button.addEventListener('click', close);
  head.append(element('strong', found.surface), button);
  const where = element('div', `zone ${count(found.zone)} · ${found.position.map(metres).join(', ')} m`, 'where');
  const table = element('table');
  const thead = element('thead');
  const top = element('tr');
  const unit = element('th', 'W/m²');
  unit.scope = 'col';
  top.append(unit, ...BANDS.map(([name, colour]) => {
    const th = element('th', '');
    th.scope = 'col';
    const dot = element('i');
    dot.style.background = colour;
    th.append(dot, name);
    return th;
  }));
  thead.append(top);
  const body = element('tbody');
  if (found.here.radiosity) body.append(group('at this point'), row('Radiosity', found.here.radiosity));
  else body.append(group('at this point'));
  body.append(row('Irradiance', found.here.irradiance), row('indirect', found.here.indirect, true), row('direct', found.here.direct, true));
  const m = found.mean;
  body.append(group('mean of the zone'), row('Radiosity', m.radiosity), row('Irradiance', m.irradiance), row('indirect', m.indirect, true), row('direct', m.direct, true), row('error', m.error, true, (e) => (Number.isFinite(e) ? number(e) : 'unknown')));
  table.append(thead, body);
  card.replaceChildren(head, where, table);
  card.append(element('div', 'error: estimate for the irradiance, as solved', 'note'));
  if (found.through.length) card.append(element('div', `seen through ${found.through.join(', ')}`, 'note'));
  if (found.back) card.append(element('div', 'back of a one-sided surface; the numbers are those of its front', 'note'));
  card.hidden = false;
}
