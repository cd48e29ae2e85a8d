// The rotatable view of the result: draws the triangles with a z-buffer into a canvas, without a graphics card and
// without external files.
(() => {
const data = JSON.parse(document.getElementById('model-data').textContent);
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
const meshes = data.meshes.map(m => ({
  position: new Int16Array(bytes(m.position)), normal: new Int8Array(bytes(m.normal)), tissue: new Uint8Array(bytes(m.tissue)),
  off: new Int8Array(bytes(m.off)), index: new Uint32Array(bytes(m.index)), labels: unpacked(m.labels)}));
function unpacked(labels) {  // Expands runs: label in the upper four bits, length in the lower twelve.
  const tissue = new Uint8Array(labels.size[0] * labels.size[1] * labels.size[2]);
  let at = 0;
  for (const run of new Uint16Array(bytes(labels.runs))) { tissue.fill(run >> 12, at, at + (run & 4095)); at += run & 4095; }
  return {size: labels.size, offset: labels.offset, scale: labels.scale, tissue};
}
const root = document.getElementById('viewer'), canvas = root.querySelector('canvas'), said = root.querySelector('[aria-live]');
const pen = canvas.getContext('2d');
const start = data.view;
const cross = (a, b) => [a[1]*b[2]-a[2]*b[1], a[2]*b[0]-a[0]*b[2], a[0]*b[1]-a[1]*b[0]];
const dot = (a, b) => a[0]*b[0] + a[1]*b[1] + a[2]*b[2];
const unit = a => { const l = Math.hypot(...a); return a.map(v => v / l); };
// Turntable camera: azimuth about the vertical axis, elevation from below to above. Angles in rad; both are 0 for the front view.
const vertical = unit(start.front.up), ahead = unit(start.front.back), aside = cross(vertical, ahead);
let azimuth, elevation, zoom, mode = data.has_ideal ? 'difference' : 'result', cut = 1;
let right, up, back;  // axes of the view, in W
function turn(by_azimuth, by_elevation) {
  azimuth += by_azimuth;
  elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, elevation + by_elevation));
  const c = Math.cos(azimuth), s = Math.sin(azimuth), ce = Math.cos(elevation), se = Math.sin(elevation);
  right = ahead.map((a, i) => c * aside[i] - s * a);
  back = ahead.map((a, i) => ce * (c * a + s * aside[i]) + se * vertical[i]);
  up = cross(back, right);
}
function look(view) {
  const to = unit(view.back), level = Math.hypot(dot(to, ahead), dot(to, aside));
  const from = level > 1e-6 ? to : view.up.map(v => dot(to, vertical) > 0 ? -v : v);  // A view from directly above or below uses its up vector.
  elevation = Math.atan2(dot(to, vertical), level);
  azimuth = Math.atan2(dot(from, aside), dot(from, ahead));
  turn(0, 0);
}
function reset() { look(start.angled); zoom = 1.6; cut = 1; const s = root.querySelector('[name=cut]'); if (s) s.value = 100; }
function colors(mesh, kind) {
  const n = mesh.tissue.length, out = new Float32Array(3 * n);
  for (let i = 0; i < n; ++i) {
    let c;
    if (kind === 'difference') {
      const s = mesh.off[i] / 127, end = s > 0 ? data.difference[0] : data.difference[2], a = Math.abs(s);
      c = data.difference[1].map((v, k) => v + a * (end[k] - v));
    } else c = data.tissues[mesh.tissue[i]];
    out.set(c, 3 * i);
  }
  return out;
}
const painted = meshes.map(m => ({result: colors(m, 'result'), difference: data.has_ideal ? colors(m, 'difference') : null}));
let reach = 0;  // largest distance of the result from the centre, along the normal of the slice plane
for (const m of meshes) for (let k = 0; k < m.position.length; k += 3) {
  reach = Math.max(reach, Math.abs((m.position[k]-data.focus[0])*start.slice[0] + (m.position[k+1]-data.focus[1])*start.slice[1] + (m.position[k+2]-data.focus[2])*start.slice[2]));
}
let wide = 0, high = 0, image, depth, pixels, inside;
function size() {
  const w = Math.max(160, Math.min(1100, Math.round(canvas.clientWidth * Math.min(2, devicePixelRatio || 1)))), h = Math.round(w * 0.66);
  if (w === wide) return;
  wide = canvas.width = w; high = canvas.height = h;
  image = pen.createImageData(w, h); pixels = new Uint32Array(image.data.buffer); depth = new Float32Array(w * h); inside = new Uint8Array(w * h);
}
// The tissue with the largest trilinear weight among the eight samples around a point; air is ignored.
const weight = new Float32Array(data.tissues.length);
function tissue_at(labels, px, py, pz) {
  const n = labels.size, o = labels.offset, f = data.focus, k = labels.scale;
  const gx = (px + f[0]) * k + o[0], gy = (py + f[1]) * k + o[1], gz = (pz + f[2]) * k + o[2];
  const x0 = Math.floor(gx), y0 = Math.floor(gy), z0 = Math.floor(gz);
  weight.fill(0);
  for (let corner = 0; corner < 8; ++corner) {
    const x = x0 + (corner & 1), y = y0 + (corner >> 1 & 1), z = z0 + (corner >> 2);
    if (x < 0 || y < 0 || z < 0 || x >= n[0] || y >= n[1] || z >= n[2]) continue;
    weight[labels.tissue[(x * n[1] + y) * n[2] + z]] += (1 - Math.abs(gx - x)) * (1 - Math.abs(gy - y)) * (1 - Math.abs(gz - z));
  }
  let most = 0;
  for (let t = 1; t < weight.length; ++t) if (weight[t] > (most ? weight[most] : 0)) most = t;
  return most;
}
function draw() {
  size();
  const mesh = meshes[mode === 'ideal' ? 1 : 0], paint = painted[mode === 'ideal' ? 1 : 0][mode === 'difference' ? 'difference' : 'result'];
  const n = mesh.tissue.length, x = new Float32Array(n), y = new Float32Array(n), z = new Float32Array(n), shade = new Float32Array(n), side = new Float32Array(n);
  const scale = 0.9 * Math.min(wide, high) * zoom / data.extent * data.step;
  const light = unit(back.map((b, i) => b + 0.5 * up[i] - 0.4 * right[i]));
  const last = cut === 1 ? Infinity : (2 * cut - 1) * reach;  // Points farther than this along the slice's normal are cut off.
  for (let i = 0, k = 0; i < n; ++i, k += 3) {
    const p0 = mesh.position[k] - data.focus[0], p1 = mesh.position[k+1] - data.focus[1], p2 = mesh.position[k+2] - data.focus[2];
    x[i] = wide / 2 + scale * (p0*right[0] + p1*right[1] + p2*right[2]);
    y[i] = high / 2 - scale * (p0*up[0] + p1*up[1] + p2*up[2]);
    z[i] = p0*back[0] + p1*back[1] + p2*back[2];
    side[i] = p0*start.slice[0] + p1*start.slice[1] + p2*start.slice[2];
    const l = (mesh.normal[k]*light[0] + mesh.normal[k+1]*light[1] + mesh.normal[k+2]*light[2]) / 127;
    shade[i] = 0.42 + 0.58 * Math.max(0, l);
  }
  depth.fill(-1e9); pixels.fill(0); inside.fill(0);
  const index = mesh.index, t = 3;
  for (let k = 0; k < index.length; k += t) {
    const a = index[k], b = index[k+1], c = index[k+2];
    if (side[a] > last && side[b] > last && side[c] > last) continue;
    const area = (x[b]-x[a])*(y[c]-y[a]) - (x[c]-x[a])*(y[b]-y[a]);
    const inner = area > 0;  // back face: visible only through the cut
    if (area === 0 || (inner && cut === 1)) continue;
    const x0 = Math.max(0, Math.floor(Math.min(x[a],x[b],x[c]))), x1 = Math.min(wide-1, Math.ceil(Math.max(x[a],x[b],x[c])));
    const y0 = Math.max(0, Math.floor(Math.min(y[a],y[b],y[c]))), y1 = Math.min(high-1, Math.ceil(Math.max(y[a],y[b],y[c])));
    for (let py = y0; py <= y1; ++py) for (let px = x0; px <= x1; ++px) {
      const u = ((x[b]-px)*(y[c]-py) - (x[c]-px)*(y[b]-py)) / area, v = ((x[c]-px)*(y[a]-py) - (x[a]-px)*(y[c]-py)) / area, w = 1-u-v;
      if (u < 0 || v < 0 || w < 0 || u*side[a] + v*side[b] + w*side[c] > last) continue;
      const at = py * wide + px, d = u*z[a] + v*z[b] + w*z[c];
      if (d <= depth[at]) continue;
      depth[at] = d; inside[at] = inner ? 1 : 0;
      if (inner) continue;  // This pixel shows the cut face.
      const s = u*shade[a] + v*shade[b] + w*shade[c];
      const r = s*(u*paint[3*a]+v*paint[3*b]+w*paint[3*c]), g = s*(u*paint[3*a+1]+v*paint[3*b+1]+w*paint[3*c+1]),
            l = s*(u*paint[3*a+2]+v*paint[3*b+2]+w*paint[3*c+2]);
      pixels[at] = 0xff000000 | Math.min(255, l) << 16 | Math.min(255, g) << 8 | Math.min(255, r);
    }
  }
  const facing = dot(back, start.slice);
  if (facing > 0) {  // Pixels with a back face show the cut face: draw the tissue there.
    const across = dot(right, start.slice), along = dot(up, start.slice), s = 0.93;  // constant brightness, as in a drawing
    for (let at = 0; at < inside.length; ++at) {
      if (!inside[at]) continue;
      const h = (at % wide + 0.5 - wide / 2) / scale, v = (high / 2 - Math.floor(at / wide) - 0.5) / scale;
      const d = (last - h * across - v * along) / facing;
      const color = data.tissues[tissue_at(mesh.labels, h*right[0] + v*up[0] + d*back[0], h*right[1] + v*up[1] + d*back[1], h*right[2] + v*up[2] + d*back[2])];
      pixels[at] = 0xff000000 | s * color[2] << 16 | s * color[1] << 8 | s * color[0];
    }
  }
  pen.putImageData(image, 0, 0);
  draw_strokes(scale);
  root.dataset.drawn = mode;
}
// The places of defects, and the chosen stroke at its time `played` (s).
let chosen = null, played = 0, spots = [];
function flat(p, scale) {  // pixels
  const q = [p[0] - data.focus[0], p[1] - data.focus[1], p[2] - data.focus[2]];
  return [wide / 2 + scale * dot(q, right), high / 2 - scale * dot(q, up)];
}
function line(a, b, width, color) {
  pen.strokeStyle = color; pen.lineWidth = width; pen.beginPath(); pen.moveTo(...a); pen.lineTo(...b); pen.stroke();
}
function draw_strokes(scale) {
  const em = wide / 50, ink = '#1f5fbf', hot = '#b3261e';
  if (chosen) {
    const {stroke} = chosen, path = stroke.path.length ? stroke.path : [stroke.at];
    let k = 0;
    while (k + 1 < path.length && path[k + 1][0] <= played) ++k;
    for (let i = 1; i <= k; ++i) line(flat(path[i-1].slice(1), scale), flat(path[i].slice(1), scale), 2, ink);
    const now = path[k], p = now.slice(1, 4), along = length => flat(p.map((v, i) => v + length * now[4 + i]), scale);
    pen.globalAlpha = 0.55;
    line(along(stroke.half), along(stroke.half + 0.006 / data.step), 0.0016 / data.step * scale, '#777');
    line(along(-Math.max(stroke.half, 1)), along(stroke.half), 2 * stroke.radius * scale, '#999');
    pen.globalAlpha = 1;
    pen.font = em + 'px sans-serif'; pen.textAlign = 'left'; pen.fillStyle = '#888';
    pen.fillText(now[0].toFixed(2) + ' s   ' + now[7].toFixed(2) + ' N', em / 2, 1.4 * em);
  }
  pen.textAlign = 'center'; pen.textBaseline = 'middle'; pen.font = 'bold ' + 0.8 * em + 'px sans-serif';
  spots = data.defects.map((d, i) => {
    const at = flat(d.place, scale);
    pen.beginPath(); pen.arc(at[0], at[1], 0.7 * em, 0, 7);
    pen.fillStyle = chosen && chosen.defect === i ? hot : ink; pen.globalAlpha = 0.85; pen.fill(); pen.globalAlpha = 1;
    pen.fillStyle = '#fff'; pen.fillText(i + 1, ...at);
    return at;
  });
  pen.textBaseline = 'alphabetic';
}
function play(defect, number) {
  const stroke = data.defects[defect].strokes[number];
  if (!stroke) return;
  const mine = chosen = {defect, stroke};
  const still = matchMedia('(prefers-reduced-motion: reduce)').matches || stroke.path.length < 2;
  played = still ? stroke.at[0] : stroke.path[0][0];
  const end = still ? played : stroke.path[stroke.path.length - 1][0];
  let before = null;
  function step(now) {
    if (chosen !== mine) return;
    if (before !== null) played = Math.min(end, played + (now - before) / 1000);
    before = now;
    draw();
    if (played < end) requestAnimationFrame(step);
    else { played = stroke.at[0]; redraw(); }
  }
  root.dataset.stroke = defect + '.' + number;
  requestAnimationFrame(step);
}
for (const b of document.querySelectorAll('[data-stroke]')) {
  if (b === root) continue;
  b.hidden = false;
  b.addEventListener('click', () => {
    root.scrollIntoView({block: 'nearest'});
    play(...b.dataset.stroke.split('.').map(Number));
  });
}
let asked = false;
function redraw() { if (asked) return; asked = true; requestAnimationFrame(() => { asked = false; draw(); }); }
function choose(next) {
  mode = next;
  for (const b of root.querySelectorAll('[data-mode]')) b.setAttribute('aria-pressed', String(b.dataset.mode === mode));
  said.textContent = root.querySelector('[data-mode=' + mode + ']').textContent;
  redraw();
}
for (const b of root.querySelectorAll('[data-mode]')) b.addEventListener('click', () => choose(b.dataset.mode));
for (const b of root.querySelectorAll('[data-look]')) b.addEventListener('click', () => {
  if (b.dataset.look === 'reset') reset(); else look(start[b.dataset.look]);
  said.textContent = b.textContent; redraw();
});
root.querySelector('[name=cut]').addEventListener('input', e => { cut = e.target.value / 100; redraw(); });
canvas.addEventListener('keydown', e => {
  const step = 0.12, keys = {ArrowLeft: () => turn(step, 0), ArrowRight: () => turn(-step, 0), ArrowUp: () => turn(0, -step),
    ArrowDown: () => turn(0, step), '+': () => zoom *= 1.15, '-': () => zoom /= 1.15, Home: reset};
  const act = keys[e.key];
  if (!act) return;
  e.preventDefault(); act(); redraw();
});
const held = new Map();  // position of each pressed pointer, by its id
canvas.addEventListener('pointerdown', e => { held.set(e.pointerId, [e.clientX, e.clientY]); canvas.setPointerCapture(e.pointerId); });
canvas.addEventListener('pointermove', e => {
  const before = held.get(e.pointerId), now = [e.clientX, e.clientY];
  if (!before) return;
  held.delete(e.pointerId);
  const [other] = held.values(), away = p => Math.max(1, Math.hypot(p[0] - other[0], p[1] - other[1]));
  if (other) zoom *= away(now) / away(before);  // pinch
  else turn((now[0] - before[0]) * -0.01, (now[1] - before[1]) * 0.01);
  held.set(e.pointerId, now); redraw();
});
for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, e => held.delete(e.pointerId));
canvas.addEventListener('click', e => {
  const k = wide / canvas.clientWidth, x = e.offsetX * k, y = e.offsetY * k;
  const hit = spots.findIndex(at => Math.hypot(at[0] - x, at[1] - y) < wide / 50);
  if (hit >= 0) play(hit, 0);
});
canvas.addEventListener('wheel', e => { e.preventDefault(); zoom *= Math.exp(-0.0015 * e.deltaY); redraw(); }, {passive: false});
addEventListener('resize', redraw);
root.hidden = false;
reset(); choose(mode); draw();
})();
