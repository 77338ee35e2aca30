// The look of the page of charts, and its script.
#include "measure/chart_page_parts.hpp"

namespace raig::page {

const char* const style = R"(
:root { --accent: #1f5fbf; --shadow: 0 1px 2px #0002; }
@media (prefers-color-scheme: dark) { :root { --accent: #8ab4f8; --shadow: none; } }
html { scroll-behavior: smooth; scroll-padding-top: 1rem; -webkit-text-size-adjust: 100%; }
@media (prefers-reduced-motion: reduce) { html { scroll-behavior: auto; } }
body { padding: 2.5rem 1.5rem 4rem; max-width: 78rem; line-height: 1.55; overflow-wrap: break-word; }
h1 { font-size: 2rem; line-height: 1.2; letter-spacing: -0.015em; margin: 0 0 0.75rem; }
h2 { font-size: 1.4rem; letter-spacing: -0.01em; margin: 3.5rem 0 1rem; padding-top: 1.25rem;
  border-top: 1px solid var(--line); }
h3 { font-size: 1.15rem; line-height: 1.35; margin: 0 0 0.4rem; }
h3 small { display: block; font-size: 0.8rem; font-weight: 600; letter-spacing: 0.04em; color: var(--soft); }
p { margin: 0.5rem 0; } a { color: var(--accent); text-underline-offset: 0.15em; }
a:not(:hover) { text-decoration-color: color-mix(in srgb, currentColor 40%, transparent); }
:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; border-radius: 3px; }
sup { line-height: 0; font-size: 0.7em; }
.verdict { font-size: 1.25rem; margin: 0.25rem 0; }
main > h3 { margin: 2rem 0 0.7rem; } .note { font-size: 0.875rem; }
nav ol { display: flex; flex-wrap: wrap; gap: 0.3rem 1.4rem; margin: 1.5rem 0 0; padding: 0; list-style: none;
  font-size: 0.9rem; }
nav li { margin: 0; }
.broke { margin: 1rem 0; padding: 0.6rem 1rem; border-left: 3px solid var(--bad); border-radius: 0 6px 6px 0;
  background: var(--badband); }
.broke ul, .missing ul { margin: 0; } .missing { margin: 1rem 0; padding: 0.6rem 1rem; border-left: 3px solid var(--line);
  border-radius: 0 6px 6px 0; background: var(--band); font-size: 0.9rem; } .missing li, .broke li { margin: 0.2rem 0; }
.wide { overflow: auto; } details .wide { max-height: 34rem; } th.what, td.what { text-align: left; } td.none { color: var(--soft); }
thead th { position: sticky; top: 0; z-index: 1; vertical-align: bottom; } thead th:first-child { z-index: 2; }
details { border: 0; } details .wide { margin: 0.3rem 0 0.8rem; }
summary { color: var(--soft); font-size: 0.9rem; } summary:hover { color: var(--ink); }
td.reason { white-space: normal; min-width: 14rem; }
th button { all: unset; cursor: pointer; } th button:hover { color: var(--ink); }
th button:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; border-radius: 3px; }
th button::after { content: "↕"; padding-left: 0.3em; opacity: 0.35; font-weight: 400; }
th[aria-sort=ascending] button::after { content: "↑"; opacity: 1; }
th[aria-sort=descending] button::after { content: "↓"; opacity: 1; } th[aria-sort] { color: var(--ink); }
section { margin: 0 0 3.5rem; } figure { margin: 0; min-width: 0; }
.panels { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 28rem), 1fr)); gap: 1.25rem;
  margin: 1.25rem 0 0.75rem; }
.panels.one { max-width: 48rem; grid-template-columns: 1fr; }
.panels figure { border: 1px solid var(--line); border-radius: 8px; box-shadow: var(--shadow); overflow: hidden; }
.panels img { display: block; width: 100%; height: auto; }
.panels figcaption { display: flex; flex-wrap: wrap; justify-content: space-between; gap: 0 1rem; padding: 0.5rem 0.9rem;
  border-top: 1px solid var(--line); background: var(--band); font-size: 0.875rem; }
.files { font-size: 0.8125rem; white-space: nowrap; } .files a + a { margin-left: 0.7rem; }
.data { margin: 0.25rem 0; } .data > .files { float: right; padding-top: 0.5rem; }
.views { display: grid; gap: 1rem 2rem; align-items: start; }
.stage { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fit, minmax(min(100%, 20rem), 1fr)); }
.stage img { display: block; width: 100%; height: auto; border-radius: 6px; background: var(--band); }
.stage img.small { image-rendering: pixelated; }
.stage figcaption { padding: 0.3rem 0; font-size: 0.875rem; color: var(--soft); }
.scale { display: inline-block; width: 6rem; height: 0.7em; margin: 0 0.4em; border-radius: 2px;
  background: linear-gradient(90deg, #000004, #51127c, #b73779, #fc8961, #fcfdbf); }
.numbers { margin: 0; grid-template-columns: max-content max-content; font-variant-numeric: tabular-nums; }
.numbers dd { text-align: right; margin: 0; }
.cut, .handle, .picker { display: none; }
.js .views.both { --cut: 50%; } .js .picker { display: inline-flex; margin: 0 0 0.75rem; border: 1px solid var(--line);
  border-radius: 8px; overflow: hidden; font-size: 0.875rem; }
.picker label { position: relative; padding: 0.3rem 0.9rem; cursor: pointer; color: var(--soft); }
.picker input { position: absolute; opacity: 0; }
.picker label + label { border-left: 1px solid var(--line); }
.picker label:has(:checked) { background: var(--band); color: var(--ink); font-weight: 600; }
.picker label:has(:focus-visible) { outline: 2px solid var(--accent); outline-offset: -2px; border-radius: 8px; }
.js .both .stage { position: relative; grid-template-columns: 1fr; max-width: min(100%, 80vh * var(--ratio)); }
.js .both .device, .js .both .reference { grid-area: 1 / 1; position: relative; }
.js .both .device { clip-path: inset(0 calc(100% - var(--cut)) 0 0); z-index: 1; }
.js .both .device figcaption, .js .both .reference figcaption { position: absolute; bottom: 0.6rem; padding: 0.15rem 0.6rem;
  border-radius: 4px; background: #000a; color: #fff; font-size: 0.8125rem; }
.js .both .device figcaption { left: 0.6rem; } .js .both .reference figcaption { right: 0.6rem; }
.js .both .difference { display: none; } .js .both .apart .difference { display: block; }
.js .both .apart :is(.device, .reference, .cut, .handle) { display: none; }
.js .both .cut { display: block; position: absolute; inset: 0 -10px; width: calc(100% + 20px); height: 100%; margin: 0;
  opacity: 0; cursor: ew-resize; touch-action: pan-y; z-index: 3; }
.cut::-webkit-slider-thumb { width: 20px; height: 100vh; } .cut::-moz-range-thumb { width: 20px; height: 100vh; border: 0; }
.js .both .handle { display: block; position: absolute; inset: 0 auto 0 var(--cut); width: 2px; margin-left: -1px;
  background: #fff; box-shadow: 0 0 0 1px #0005; pointer-events: none; z-index: 2; }
.handle::after { content: "‹ ›"; position: absolute; top: 50%; left: 50%; translate: -50% -50%; width: 2.4rem;
  height: 2.4rem; border-radius: 50%; background: #fff; color: #1c2024; box-shadow: 0 1px 4px #0008;
  font: 600 1.1rem/2.15rem system-ui, sans-serif; text-align: center; letter-spacing: 0.1em; text-indent: 0.1em; white-space: nowrap; }
.cut:focus-visible + .handle::after { outline: 3px solid var(--accent); outline-offset: 2px; }
@media (min-width: 62rem) { .js .views.both { grid-template-columns: minmax(0, 48rem) 1fr; } }
@media (max-width: 30rem) { body { padding: 1.25rem 0.75rem 3rem; } h1 { font-size: 1.6rem; } table { font-size: 0.8125rem; }
  h2 { margin-top: 2.5rem; } .js .both .more { display: none; }
  .numbers { grid-template-columns: 1fr max-content; gap: 0.2rem 1rem; } th, td { padding: 0.3rem 0.45rem; }
  td:first-child { min-width: 7rem; max-width: 9rem; white-space: normal; overflow-wrap: anywhere; }
  .panels { margin-inline: -0.75rem; } .panels figure { border-radius: 0; border-inline: 0; box-shadow: none; } }
@media print { .wide { max-height: none; overflow: visible; } }
)";

const char* const script = R"(
'use strict';
{
  const collator = new Intl.Collator(undefined, { numeric: true });
  // Numbers before texts, and what is not there last, whichever way is sorted.
  const rank = cell => cell.classList.contains('none') ? 2 : 'value' in cell.dataset ? 0 : 1;
  const compare = (a, b, sign) => rank(a) - rank(b) || sign * (rank(a) === 2 ? 0 : rank(a) === 0
    ? Number(a.dataset.value) - Number(b.dataset.value) : collator.compare(a.textContent, b.textContent));
  for (const table of document.querySelectorAll('table.sorts'))
    table.querySelectorAll('thead th').forEach((head, column) => {
      const button = document.createElement('button');
      button.type = 'button';
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener('click', () => {
        const order = head.getAttribute('aria-sort') === 'ascending' ? 'descending' : 'ascending';
        for (const other of table.querySelectorAll('[aria-sort]')) other.removeAttribute('aria-sort');
        head.setAttribute('aria-sort', order);
        const body = table.tBodies[0];
        body.append(...[...body.rows].sort((a, b) =>
          compare(a.cells[column], b.cells[column], order === 'ascending' ? 1 : -1)));
      });
    });
  for (const views of document.querySelectorAll('.views.both')) {
    const cut = views.querySelector('.cut'), stage = views.querySelector('.stage');
    const move = () => {
      views.style.setProperty('--cut', cut.value + '%');
      cut.setAttribute('aria-valuetext', Math.round(cut.value) + ' % device');
    };
    cut.addEventListener('input', move);
    move();
    const pick = () => stage.classList.toggle('apart', !!views.querySelector('[value=difference]:checked'));
    for (const radio of views.querySelectorAll('.picker input')) radio.addEventListener('change', pick);
    pick();
  }
}
)";

}  // namespace raig::page
