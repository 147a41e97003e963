// Elements are made here and nowhere else. Text reaches the page as text nodes only: names from files cannot become markup.

const SVG = 'http://www.w3.org/2000/svg';

function fill(element, properties, children) {
  for (const [name, value] of Object.entries(properties ?? {})) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name === 'style') for (const [key, v] of Object.entries(value)) element.style.setProperty(key, v);
    else if (name === 'text') element.textContent = value;
    else element.setAttribute(name, value === true ? '' : value);
  }
  append(element, children);
  return element;
}

function append(element, children) {
  for (const child of children) {
    if (Array.isArray(child)) append(element, child);
    else if (child !== undefined && child !== null && child !== false) element.append(child);
  }
}

/** An HTML element: h('p', {class: 'note', onclick}, 'text', child, [children]). */
export function h(tag, properties, ...children) {
  return fill(document.createElement(tag), properties, children);
}

/** An SVG element. */
export function s(tag, properties, ...children) {
  return fill(document.createElementNS(SVG, tag), properties, children);
}

export function clear(element) {
  element.replaceChildren();
  return element;
}

/** A select element; options are [value, text] or {label, options}. */
export function select(label, options, value, onchange) {
  const option = ([v, text]) => h('option', {value: v, selected: String(v) === String(value)}, text);
  const element = h('select', {'aria-label': label, onchange: (event) => onchange(event.target.value)},
    options.map((o) => (Array.isArray(o) ? option(o) : h('optgroup', {label: o.label}, o.options.map(option)))));
  return element;
}

/** Buttons of which one is pressed. */
export function segmented(label, options, value, onchange) {
  const group = h('div', {class: 'segmented', role: 'group', 'aria-label': label});
  for (const [v, text] of options) {
    group.append(h('button', {
      type: 'button', 'aria-pressed': String(v === value), 'data-value': v,
      onclick: () => {
        for (const button of group.children) button.setAttribute('aria-pressed', String(button.dataset.value === String(v)));
        onchange(v);
      },
    }, text));
  }
  return group;
}

/** Once, when the element comes near the view or the page is printed: what nobody looks at costs nothing. */
export function whenNear(element, action) {
  const act = () => {
    observer.disconnect();
    removeEventListener('beforeprint', act);
    action();
  };
  const observer = new IntersectionObserver((entries) => entries.some((entry) => entry.isIntersecting) && act(), {rootMargin: '500px'});
  observer.observe(element);
  addEventListener('beforeprint', act);
}

/** A place that scrolls sideways; its edge fades out where there is more to see. */
export function scroller(...children) {
  const place = h('div', {class: 'scroll'}, children);
  const mark = () => {
    const room = place.scrollWidth - place.clientWidth;
    place.classList.toggle('more-left', place.scrollLeft > 2);
    place.classList.toggle('more-right', room - place.scrollLeft > 2);
    // Without a mouse it is scrolled by the arrow keys.
    if (room > 2) place.tabIndex = 0;
    else place.removeAttribute('tabindex');
  };
  place.addEventListener('scroll', mark, {passive: true});
  const sizes = new ResizeObserver(mark);
  sizes.observe(place);
  const watch = () => {
    for (const child of place.children) sizes.observe(child);
    mark();
  };
  new MutationObserver(watch).observe(place, {childList: true});
  watch();
  return place;
}

export function section(id, title, note, ...children) {
  return h('section', {id, 'aria-labelledby': `${id}-title`},
    h('h2', {id: `${id}-title`}, title), note && h('p', {class: 'note'}, note), children);
}
