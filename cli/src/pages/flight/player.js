"use strict";
// Chooses a frame: by slider, by table, by pointing at the track or at the curve of errors.
(() => {
  const find = (what) => document.querySelector(what);
  const rows = JSON.parse(find("#rows").textContent), count = rows.frame.length;
  if (!count) return;
  const player = find("#player"), slider = player.querySelector("input"), output = player.querySelector("output");
  const cards = [...document.querySelectorAll("#pictures .card")], pictures = find("#pictures"), missing = document.createElement("span"), tip = find("#tip"), box = find("#table");
  const metres = (value) => value === null ? "–" : value.toFixed(2);
  const outcome = (i) => rows.why[i] ? rows.why[i].replaceAll("_", " ") : rows.is_wrong[i] ? "wrong" : "fix";
  const words = (i) => `Frame ${rows.frame[i]}, ${rows.s[i].toFixed(2)} s: ` + (rows.why[i]
    ? `refused, ${outcome(i)}`
    : `${outcome(i)}, ${metres(rows.off[i])} m off, σ ${metres(rows.sigma[i])} m`);

  // A plot says where its inside lies and what it ranges over; `at` says where a frame lies in it.
  const plot = (id, at, line) => {
    const svg = find(`#${id} svg`);
    if (!svg) return null;
    const [left, top, wide, high] = svg.dataset.inside.split(" ").map(Number);
    const [x0, x1, y0, y1] = svg.dataset.ranges.split(" ").map(Number);
    const place = (i) => {
      const [x, y] = at(i);
      return [left + wide * (x - x0) / (x1 - x0), top + high * (y1 - y) / (y1 - y0)];
    };
    svg.insertAdjacentHTML("beforeend", line ? "<path class=here />" : "<circle class=here />");
    const mark = svg.lastElementChild;
    const nearest = (event) => {
      const { left: x, top: y, width } = svg.getBoundingClientRect();
      const scale = svg.viewBox.baseVal.width / width;
      const [px, py] = [(event.clientX - x) * scale, (event.clientY - y) * scale];
      let best = -1, least = line ? Infinity : 40 * scale;
      for (let i = 0; i < count; i++) {
        const [a, b] = place(i), far = line ? Math.abs(a - px) : Math.hypot(a - px, b - py);
        if (far < least) [best, least] = [i, far];
      }
      return best;
    };
    const point = (event) => {
      const i = nearest(event);
      tip.hidden = i < 0;
      if (i < 0) return;
      tip.textContent = words(i);
      tip.style.left = `${Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 4)}px`;
      tip.style.top = `${event.clientY + 14}px`;
    };
    svg.addEventListener("pointermove", point);
    svg.addEventListener("pointerleave", () => { tip.hidden = true; });
    svg.addEventListener("click", (event) => { const i = nearest(event); if (i >= 0) choose(i); });
    return (i) => {
      const [x, y] = place(i);
      if (line) mark.setAttribute("d", `M${x} ${top}V${top + high}`);
      else for (const [name, value] of [["cx", x], ["cy", y], ["r", 20]]) mark.setAttribute(name, value);
    };
  };
  const plots = [
    plot("track", (i) => rows.fix[i] || rows.truth[i], false),
    plot("timeline", (i) => [rows.frame[i], rows.off[i] || 0], true),
  ].filter(Boolean);

  const table = document.createElement("table");
  table.innerHTML = "<thead><tr><th class=r>Frame<th class=r>Time (s)<th>Outcome<th class=r>Off (m)<th class=r>σ (m)<th class=r>Correlation</tr></thead>";
  const body = table.createTBody();
  for (let i = 0; i < count; i++) {
    const row = body.insertRow(), bad = rows.why[i] || rows.is_wrong[i];
    const cells = [rows.frame[i], rows.s[i].toFixed(2), outcome(i), metres(rows.off[i]), metres(rows.sigma[i]), rows.score[i] === null ? "–" : rows.score[i].toFixed(3)];
    cells.forEach((text, k) => {
      const cell = row.insertCell();
      cell.textContent = text;
      cell.className = k === 2 ? (bad ? "bad" : "good") : "n";
    });
    row.tabIndex = -1;
    row.addEventListener("click", () => choose(i));
  }
  box.append(table);
  table.addEventListener("keydown", (event) => {
    const now = Number(slider.value);
    const to = { ArrowUp: now - 1, ArrowDown: now + 1, PageUp: now - 10, PageDown: now + 10, Home: 0, End: count - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    choose(to);
    body.rows[Number(slider.value)].focus();
  });

  let chosen = 0;
  missing.className = "warn";
  const choose = (wanted) => {
    const i = Math.max(0, Math.min(count - 1, wanted));
    slider.value = i;
    for (const mark of plots) mark(i);
    // Of a frame without pictures those of the nearest one that has them.
    const far = (card) => Math.abs(card.dataset.frame - rows.frame[i]);
    const nearest = cards.reduce((best, card) => best && far(best) <= far(card) ? best : card, null);
    for (const card of cards) card.classList.toggle("shown", card === nearest);
    const isOther = nearest && far(nearest);
    pictures.classList.toggle("other", isOther);
    output.textContent = words(i) + (isOther ? ". " : "");
    missing.textContent = isOther ? `No pictures of it were kept: those below are of frame ${nearest.dataset.frame}.` : "";
    output.append(missing);
    const [before, row] = [body.rows[chosen], body.rows[i]];
    before.removeAttribute("aria-current");
    before.tabIndex = -1;
    row.setAttribute("aria-current", "true");
    row.tabIndex = 0;
    chosen = i;
    const head = table.tHead.offsetHeight;
    if (row.offsetTop < box.scrollTop + head) box.scrollTop = row.offsetTop - head;
    if (row.offsetTop + row.offsetHeight > box.scrollTop + box.clientHeight) box.scrollTop = row.offsetTop + row.offsetHeight - box.clientHeight;
  };
  slider.addEventListener("input", () => choose(Number(slider.value)));
  for (const button of player.querySelectorAll("button")) {
    button.addEventListener("click", () => choose(Number(slider.value) + Number(button.dataset.step)));
  }
  document.body.classList.add("playing");
  player.hidden = box.hidden = false;
  choose(cards.length ? Math.max(0, rows.frame.indexOf(Number(cards[0].dataset.frame))) : 0);
})();
