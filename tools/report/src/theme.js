// Light and dark: of the system until somebody chooses, and light on paper.

const LIGHT = ['#0b6bb5', '#d1530b', '#0a8f63', '#b5478a', '#b07d00', '#3d8fb8', '#6f4bb8', '#8a5340', '#5a7d0a', '#b3223c'];
const DARK = ['#58aef2', '#ff9350', '#38cf9c', '#ef8fc4', '#f2c14a', '#8fd3f5', '#b99bf5', '#d3a491', '#abd34f', '#ff8094'];
const query = matchMedia('(prefers-color-scheme: dark)');
let chosen = null, printing = false;
const listeners = [];

export function dark() {
  return !printing && (chosen ?? (query.matches ? 'dark' : 'light')) === 'dark';
}

export function onPaper() {
  return printing;
}

function apply() {
  document.documentElement.dataset.theme = dark() ? 'dark' : 'light';
  for (const listener of listeners) listener();
}

export function onTheme(listener) {
  listeners.push(listener);
}

export function toggleTheme() {
  chosen = dark() ? 'light' : 'dark';
  apply();
}

/** On paper everything is as wide as the sheet, drawn before the browser takes the page: it does not wait for observers. */
function print(on) {
  printing = on;
  document.documentElement.classList.toggle('printing', on);
  apply();
}

export function startTheme() {
  query.addEventListener('change', apply);
  addEventListener('beforeprint', () => print(true));
  addEventListener('afterprint', () => print(false));
  apply();
}

/** Colour of the n-th method. */
export function colourOf(n) {
  const colours = dark() ? DARK : LIGHT;
  return colours[n % colours.length];
}

/** A colour of the style sheet. */
export function ink(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

const RAMP = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

/** Viridis at x in [0, 1], as [r, g, b] in [0, 1]. */
export function ramp(x) {
  const at = Math.min(Math.max(x, 0), 1) * (RAMP.length - 1), i = Math.min(Math.floor(at), RAMP.length - 2);
  return RAMP[i].map((c, k) => (c + (at - i) * (RAMP[i + 1][k] - c)) / 255);
}

export function rampText(x) {
  return `rgb(${ramp(x).map((c) => Math.round(255 * c)).join(' ')})`;
}
