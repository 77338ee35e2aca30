/// What raig's pages have in common: the palette, for light and for dark, and how text and tables look.
#pragma once

namespace raig {

inline constexpr const char* pageStyle = R"(
:root { color-scheme: light dark; --ink: #1c2024; --soft: #60656b; --line: #d8dce0; --paper: #fff; --band: #f4f6f8;
  --bad: #b3261e; --badband: #fde7e5; --good: #1a6b35; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e7ea; --soft: #9aa1a8; --line: #363c42; --paper: #16191c; --band: #1f2428; --bad: #ff8a80;
    --badband: #43201d; --good: #7fd69a; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1rem; max-width: 75rem; color: var(--ink); background: var(--paper);
  font: 16px/1.45 system-ui, sans-serif; }
h1 { font-size: 1.5rem; margin: 0.5rem 0; } h2 { font-size: 1.15rem; margin: 2rem 0 0.5rem; }
p { max-width: 46rem; } .soft { color: var(--soft); } .bad { color: var(--bad); } .good { color: var(--good); }
.verdict { font-size: 1.1rem; font-weight: 600; }
.wide { overflow-x: auto; border: 1px solid var(--line); border-radius: 6px; }
table { border-collapse: collapse; width: 100%; font-size: 0.875rem; font-variant-numeric: tabular-nums; }
th, td { padding: 0.3rem 0.6rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
tr:last-child td, tr:last-child th { border-bottom: 0; }
thead th { background: var(--band); color: var(--soft); font-weight: 600; }
th:first-child, td:first-child { text-align: left; position: sticky; left: 0; background: var(--paper); }
thead th:first-child { background: var(--band); }
td.zero { color: var(--soft); } td.bad { background: var(--badband); font-weight: 600; }
details { border-bottom: 1px solid var(--line); } summary { padding: 0.4rem 0.2rem; cursor: pointer; }
details .wide { margin: 0 0 0.8rem; } code { font-size: 0.85em; overflow-wrap: anywhere; }
ul { padding-left: 1.1rem; } li { margin: 0.4rem 0; overflow-wrap: anywhere; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0.3rem 1rem; font-size: 0.9rem; }
dt { color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; }
@media (max-width: 30rem) { body { padding: 0.7rem; } dl { grid-template-columns: 1fr; gap: 0; } dd { margin-bottom: 0.5rem; } }
)";

}  // namespace raig
