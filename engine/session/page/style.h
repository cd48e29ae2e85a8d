// The report's style sheet. Data has a contrast of at least 3:1 in light and dark mode.
#pragma once

namespace typodont::session {

inline constexpr const char* kStyle = R"css(
:root{color-scheme:light dark;--page:#fbfaf7;--card:#fff;--ink:#1d2126;--soft:#5a6370;--rule:#dcdad3;--accent:#0b6bcb;
--force:#c2410c;--speed:#0f766e;--spindle:#7e22ce;--depth:#0b6bcb;--removed:#7a4a21;--timing:#5b5bd6;--warn-ink:#7a2e00;--warn:#fff1e0;--good:#2f7d32;--bad:#b3261e;
--t-enamel:#8fa3b8;--t-dentin:#d99a1c;--t-caries:#6b3a12;--t-pulp:#c9344f;--t-cortical_bone:#a08f6a;--t-cancellous_bone:#c77f5e;
--t-gingiva:#e0709a;--t-amalgam:#6f7780;--t-composite:#3f9d94}
@media (prefers-color-scheme:dark){:root{--page:#14171b;--card:#1d2228;--ink:#e9ecef;--soft:#a5afba;--rule:#363d46;
--accent:#6db3ff;--force:#ff8a4c;--speed:#5eead4;--spindle:#d8b4fe;--depth:#6db3ff;--removed:#d6a06c;--timing:#a7a4ff;--warn-ink:#ffd9b0;--warn:#3d2a14;--good:#7ccf80;--bad:#ff8f85;
--t-enamel:#b9c8d8;--t-dentin:#f0b94a;--t-caries:#b5773f;--t-pulp:#ff6f86;--t-cortical_bone:#cdbb92;--t-cancellous_bone:#e5a182;
--t-gingiva:#ff9cc0;--t-amalgam:#a8b1bb;--t-composite:#6fd0c6}}
*{box-sizing:border-box}
html{font:16px/1.5 system-ui,-apple-system,"Segoe UI","Noto Sans","Noto Sans CJK SC","PingFang SC","Microsoft YaHei",sans-serif}
body{margin:0;background:var(--page);color:var(--ink)}
a{color:var(--accent)}
:focus-visible{outline:3px solid var(--accent);outline-offset:2px;border-radius:4px}
.skip{position:absolute;left:-99rem}.skip:focus{left:1rem;top:1rem;background:var(--card);padding:.5rem 1rem;z-index:1}
header,main,footer,nav{max-width:62rem;margin:0 auto;padding:0 1.25rem}
header{padding-top:2rem;padding-bottom:.5rem}
h1{font-size:1.9rem;line-height:1.2;margin:0}h2{font-size:1.25rem;margin:0 0 .75rem}h3{font-size:1rem;margin:1rem 0 .25rem}
.where{color:var(--soft);margin:.35rem 0 0}
nav ul{display:flex;flex-wrap:wrap;gap:.25rem 1.1rem;list-style:none;margin:1rem 0;padding:0}
section{background:var(--card);border:1px solid var(--rule);border-radius:12px;padding:1.25rem;margin:0 0 1.25rem}
.warn{background:var(--warn);color:var(--warn-ink);border-radius:10px;padding:.6rem 1rem;margin:0 0 1rem}.warn p{margin:.2rem 0}
.top{display:grid;grid-template-columns:minmax(12rem,1fr) 3fr;gap:1.5rem;align-items:center}
.big{margin:0;font-size:3.4rem;font-weight:700;line-height:1;white-space:nowrap;font-variant-numeric:tabular-nums}.big small{font-size:1.4rem;font-weight:500;color:var(--soft)}
.soft{color:var(--soft);margin:.3rem 0 0}
.gauge{height:10px;border-radius:5px;background:var(--rule);position:relative;margin:.7rem 0 0}.gauge i{display:block;height:100%;border-radius:5px;background:var(--good)}
.gauge.missed i{background:var(--bad)}.gauge b{position:absolute;top:-4px;bottom:-4px;width:2px;background:var(--ink)}
.missed{color:var(--bad)}.verdict{font-weight:700;margin:.5rem 0 0}.back{margin:0 0 1rem}
@media screen{@supports selector(:has(*)){#technical{display:none}#technical:target,#technical:has(:target){display:block}
main:has(#technical:target) #report,main:has(#technical :target) #report{display:none}}}
dl.key{display:grid;grid-template-columns:repeat(auto-fit,minmax(9rem,1fr));gap:.9rem;margin:0}
dl.key div{border-left:3px solid var(--rule);padding-left:.7rem}dl.key dt{color:var(--soft);font-size:.85rem}
dl.key dd{margin:0;font-size:1.25rem;font-weight:600;font-variant-numeric:tabular-nums}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
caption{text-align:left;color:var(--soft);padding-bottom:.4rem;font-size:.9rem}
th,td{text-align:right;white-space:nowrap;padding:.35rem .6rem;border-bottom:1px solid var(--rule);vertical-align:top}
th:first-child,td.text,th.text{text-align:left}td.text,th{white-space:normal}thead th{color:var(--soft);font-weight:600;font-size:.85rem}tbody th{font-weight:500}
tfoot th,tfoot td{font-weight:700;border-bottom:0}
tr.key th,tr.key td{font-weight:700}
td .gauge{width:6rem;height:6px;margin:.5rem 0 0 auto}
.source{color:var(--soft);font-size:.85rem;max-width:18rem}
.swatch{display:inline-block;width:.8em;height:.8em;border-radius:3px;margin-right:.5em;vertical-align:-.05em;border:1px solid var(--rule)}
.pictures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(17rem,100%),1fr));gap:1rem}
figure{margin:0}figure img{width:100%;height:auto;border-radius:8px;display:block;border:1px solid var(--rule)}
figcaption{color:var(--soft);font-size:.9rem;margin-top:.3rem}
svg{width:100%;height:auto;display:block}svg text{fill:var(--soft);font-size:12px;font-family:inherit}svg .unit{font-weight:600}
.grid{stroke:var(--rule);stroke-width:1}.band{opacity:.28;stroke:none}.line{fill:none;stroke-width:1.6;stroke-linejoin:round}
.plot.force .band,.force .key{fill:var(--force)}.plot.force .line{stroke:var(--force)}
.plot.speed .band{fill:var(--speed)}.plot.speed .line{stroke:var(--speed)}
.plot.spindle .band{fill:var(--spindle)}.plot.spindle .line{stroke:var(--spindle)}
.plot.depth .band{fill:var(--depth)}.plot.depth .line{stroke:var(--depth)}
.plot.removed .band{fill:var(--removed)}.plot.removed .line{stroke:var(--removed)}
.curves{display:grid;grid-template-columns:repeat(auto-fit,minmax(19rem,1fr));gap:1.2rem;margin-bottom:1.2rem}
.curves figcaption{text-align:center}.plot.sessions .line{stroke:var(--accent)}.plot.sessions circle{fill:var(--accent)}
.bar{fill:var(--timing)}.frame{fill:none;stroke:var(--rule)}
.mark{stroke:var(--soft);stroke-width:1.2;stroke-dasharray:3 3}.mark.fault{stroke:var(--force);stroke-dasharray:none}
.s-enamel{fill:var(--t-enamel);background:var(--t-enamel)}.s-dentin{fill:var(--t-dentin);background:var(--t-dentin)}
.s-caries{fill:var(--t-caries);background:var(--t-caries)}.s-pulp{fill:var(--t-pulp);background:var(--t-pulp)}
.s-cortical_bone{fill:var(--t-cortical_bone);background:var(--t-cortical_bone)}
.s-cancellous_bone{fill:var(--t-cancellous_bone);background:var(--t-cancellous_bone)}
.s-gingiva{fill:var(--t-gingiva);background:var(--t-gingiva)}.s-amalgam{fill:var(--t-amalgam);background:var(--t-amalgam)}
.s-composite{fill:var(--t-composite);background:var(--t-composite)}
.steps{margin:.4rem 0 0;padding-left:2.1rem}
.colorbar{display:grid;grid-template-columns:1fr 1fr 1fr;font-size:.85rem;color:var(--soft);margin:.6rem 0 1rem}
.colorbar i{grid-column:1/4;height:12px;border-radius:6px;border:1px solid var(--rule)}.colorbar span:nth-of-type(2){text-align:center}
.colorbar span:nth-of-type(3){text-align:right}
#viewer canvas{width:100%;aspect-ratio:1/.66;display:block;background:var(--page);border:1px solid var(--rule);border-radius:8px;touch-action:none;cursor:grab}
.buttons{display:flex;flex-wrap:wrap;gap:.4rem;align-items:center;margin:.4rem 0}
button{font:inherit;color:var(--ink);background:var(--page);border:1px solid var(--soft);border-radius:8px;padding:.25rem .8rem;cursor:pointer}
button[aria-pressed=true]{background:var(--accent);color:var(--card);border-color:var(--accent)}
.hush{position:absolute;left:-99rem}
svg.section path{fill:none;stroke-linecap:round}svg.section .was{stroke:var(--soft);stroke-width:1.2;stroke-dasharray:3 3}
svg.section .ideal{stroke:var(--accent);stroke-width:1.6}svg.section .is{stroke:var(--ink);stroke-width:2.4}svg.section .ruler{stroke:var(--soft);stroke-width:3}
.k-was::before,.k-is::before,.k-ideal::before{content:"";display:inline-block;width:1.6em;margin-right:.4em;vertical-align:.25em;border-top:2px dashed var(--soft)}
.k-is::before{border-top:3px solid var(--ink)}.k-ideal::before{border-top:2px solid var(--accent)}
.legend{display:flex;flex-wrap:wrap;gap:.2rem 1rem;list-style:none;margin:.3rem 0 0;padding:0;font-size:.9rem;color:var(--soft)}
details{margin:.5rem 0}summary{cursor:pointer;color:var(--accent)}
dl.list{display:grid;grid-template-columns:max-content 1fr;gap:.3rem 1.2rem;margin:0}dl.list dt{color:var(--soft)}
dl.list dd{margin:0;overflow-wrap:anywhere}code{font-family:ui-monospace,"DejaVu Sans Mono",monospace;font-size:.88em}
footer{color:var(--soft);font-size:.9rem;padding-bottom:2.5rem}
@media (max-width:44rem){.top{grid-template-columns:1fr}.plot:not(.sessions),.strip{min-width:38rem}.source{min-width:12rem}caption{max-width:80vw}dl.list{grid-template-columns:1fr}dl.list dd{margin-bottom:.5rem}}
@media print{:root{color-scheme:light;--page:#fff;--card:#fff;--ink:#000;--soft:#444;--rule:#bbb;--force:#c2410c;--speed:#0f766e;--spindle:#7e22ce;--depth:#0b6bcb;
--removed:#7a4a21;--timing:#5b5bd6;--good:#2f7d32;--bad:#b3261e}
#technical{break-before:page}html{font-size:10.5pt}nav,.back,.skip,details:not([open]),.buttons,#viewer .soft{display:none}section{border:0;padding:0;margin:0 0 1rem;border-radius:0}
section,figure,tr,.plot{break-inside:avoid}section.long{break-inside:auto}h2,h3,h3+p{break-after:avoid}tfoot{display:table-row-group}header{margin-bottom:1.2rem}.scroll{overflow:visible}
th,td{white-space:normal;padding:.25rem .4rem}.source{max-width:none}.pictures{grid-template-columns:repeat(2,1fr)}*{print-color-adjust:exact;-webkit-print-color-adjust:exact}header,main,footer{max-width:none;padding:0}}
)css";

}  // namespace typodont::session
