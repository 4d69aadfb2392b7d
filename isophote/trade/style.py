"""The page's style sheet. Colours of the plots: Okabe and Ito (2008), lighter in dark mode."""

STYLE = """
:root { color-scheme: light dark; --bg: #fff; --fg: #1b1b1f; --soft: #5c5f66; --rule: #d9dbe0; --card: #f6f7f9;
 --c0: #1b1b1f; --c1: #6b6f76; --c2: #0072b2; --c3: #d55e00; --c4: #7a7a00; --c5: #009e73; --c6: #b0558f; --c7: #3a3ab0;
 --c8: #8a5a2b; --c9: #b00020; --good: #00734f; --trade: #8a5a00; --bad: #a13030; }
@media (prefers-color-scheme: dark) { :root { --bg: #16171a; --fg: #e9eaee; --soft: #a3a7b0; --rule: #3a3d44;
 --card: #1f2125; --c0: #f2f2f5; --c1: #9aa0a8; --c2: #56b4e9; --c3: #ff9a4d; --c4: #e0d84a; --c5: #2fd6a5;
 --c6: #e59ac8; --c7: #a3a3ff; --c8: #cfa06a; --c9: #ff7a8a; --good: #46d6a3; --trade: #f0b84a; --bad: #ff8f8f; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--bg); color: var(--fg); font: 16px/1.5 system-ui, "Segoe UI", Roboto, sans-serif; }
main { max-width: 60rem; margin: 0 auto; padding: 1.5rem 1.2rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: .5rem 0; } h1 em { font-style: normal; color: var(--c2); }
h2 { font-size: 1.3rem; margin: 2.4rem 0 .6rem; padding-top: .8rem; border-top: 1px solid var(--rule); }
h3 { font-size: 1.05rem; margin: 0 0 .3rem; } section > h3 { margin-top: 1.4rem; }
p { margin: .4rem 0; } .sub, .small, figcaption, .ends { color: var(--soft); } .small { font-size: .9rem; }
.warn { border-left: 4px solid var(--trade); padding: .3rem .8rem; background: var(--card); }
.short li { margin: .45rem 0; }
.pair, .row { display: grid; gap: .8rem; margin-top: .6rem; } .pair { grid-template-columns: 1fr 1fr; }
.row { grid-template-columns: repeat(3, 1fr); }
figure { margin: 0; }
figure img { width: 100%; height: auto; display: block; border-radius: 4px; image-rendering: pixelated; }
figcaption { font-size: .85rem; padding-top: .2rem; }
article { background: var(--card); border-radius: 8px; padding: .9rem 1rem 1rem; margin: .8rem 0; }
.tag { font-size: .75rem; font-weight: 600; border: 1px solid currentColor; border-radius: 99px; padding: .05rem .55rem;
 margin-left: .4rem; white-space: nowrap; color: var(--soft); }
.tag.good { color: var(--good); } .tag.trade { color: var(--trade); } .tag.bad { color: var(--bad); }
table { border-collapse: collapse; width: 100%; margin: .8rem 0; font-size: .92rem; }
th, td { text-align: left; padding: .35rem .6rem .35rem 0; border-bottom: 1px solid var(--rule); vertical-align: top; }
tr th:first-child { white-space: nowrap; }
.wide { overflow-x: auto; } .wide table { font-size: .8rem; white-space: nowrap; } .wide td { padding-right: 1rem; }
.blue { color: #0852ab; font-weight: 600; } .orange { color: #bf4a00; font-weight: 600; }
@media (prefers-color-scheme: dark) { .blue { color: #7db4ff; } .orange { color: #ffa264; } }
a { color: var(--c2); } summary { cursor: pointer; }
svg { width: 100%; height: auto; display: block; margin: .6rem 0; font-size: 13px; }
svg text { fill: var(--fg); } svg .tick { fill: var(--soft); font-size: 12px; }
.grid { stroke: var(--rule); } .zero { stroke: var(--fg); } .whisker { stroke: var(--fg); stroke-width: 1.4; }
.line { fill: none; stroke-width: 1.2; opacity: .55; } .pareto { fill: none; stroke: var(--fg); stroke-width: 1.6;
 stroke-dasharray: 5 4; } .dot { stroke: var(--bg); stroke-width: 1; }
.dot.front { stroke: var(--fg); stroke-width: 1.6; }
.bar { opacity: .75; }
.swatch { display: inline-block; width: .8rem; height: .8rem; border-radius: 2px; margin-right: .5rem; }
""" + "".join(f"polyline.c{k} {{ stroke: var(--c{k}); }} .dot.c{k}, .bar.c{k} {{ fill: var(--c{k}); }} "
              f".swatch.c{k} {{ background: var(--c{k}); }}\n" for k in range(10)) + """
@media (max-width: 40rem) { .row, .pair { grid-template-columns: 1fr; } }
@media print { details { display: block; } article { break-inside: avoid; } }
"""
