// The little Markdown that verdicts are written in: headings, paragraphs, lists, tables, bold, code. Nothing else is
// understood, and what is not stays text.
import {h} from './dom.js';

function inline(text) {
  const parts = [];
  let rest = text;
  for (let match; (match = /\*\*(.+?)\*\*|`([^`]+)`/.exec(rest)); rest = rest.slice(match.index + match[0].length)) {
    parts.push(rest.slice(0, match.index), match[1] !== undefined ? h('strong', null, match[1]) : h('code', null, match[2]));
  }
  return [...parts, rest];
}

const cellsOf = (line) => line.replace(/^\||\|\s*$/g, '').split(/(?<!\\)\|/).map((cell) => cell.replaceAll('\\|', '|').trim());

function table(lines) {
  const [head, , ...body] = lines.map(cellsOf);
  return h('div', {class: 'scroll'}, h('table', {class: 'plain'},
    h('thead', null, h('tr', null, head.map((cell) => h('th', {scope: 'col'}, inline(cell))))),
    h('tbody', null, body.map((cells) => h('tr', null, cells.map((cell) => h('td', null, inline(cell))))))));
}

export function markdown(text) {
  const out = [];
  for (const block of text.split(/\n\s*\n/)) {
    const lines = block.split('\n').filter((line) => line.trim());
    if (!lines.length) continue;
    const heading = /^(#{1,4})\s+(.*)$/.exec(lines[0]);
    if (heading) {
      out.push(h('h3', null, inline(heading[2])));
      lines.shift();
    }
    if (!lines.length) continue;
    if (lines.every((line) => line.startsWith('|')) && lines.length > 1) out.push(table(lines));
    else if (lines.every((line) => /^[-*] /.test(line))) out.push(h('ul', null, lines.map((line) => h('li', null, inline(line.slice(2))))));
    else out.push(h('p', null, inline(lines.join(' '))));
  }
  return out;
}
