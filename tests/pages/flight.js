// Appended to a flight's page: the slider, the table and the plots choose a frame together. What does not hold is thrown, and so stands in
// the browser's console.
window.addEventListener("load", () => {
  const holds = (is, what) => { if (!is) throw new Error(what); };
  const find = (what) => document.querySelector(what), all = (what) => [...document.querySelectorAll(what)];
  const slider = find("#player input"), output = find("#player output");
  const rows = JSON.parse(find("#rows").textContent), last = rows.frame.length - 1;
  const current = () => all("#table tbody tr").findIndex((row) => row.hasAttribute("aria-current"));
  const shown = () => all("#pictures .card").filter((card) => getComputedStyle(card).display !== "none");
  const says = (i) => output.textContent.startsWith(`Frame ${rows.frame[i]},`) && current() === i && Number(slider.value) === i;
  holds(last > 0 && all("#table tbody tr").length === last + 1, "a row a frame");
  holds(shown().length === 1, "one frame's pictures are shown");
  for (const i of [last, 0, Math.floor(last / 2)]) {
    slider.value = i;
    slider.dispatchEvent(new Event("input"));
    holds(says(i), `the slider chooses frame ${i}: ${output.textContent}`);
    holds(shown().length === 1, `one frame's pictures are shown at ${i}`);
  }
  slider.value = 0;
  slider.dispatchEvent(new Event("input"));
  const before = find("#track .here").getAttribute("cx");
  find("#table table").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowDown" }));
  holds(says(1) && document.activeElement === all("#table tbody tr")[1], "a key chooses the next row");
  find("#player button[data-step='1']").click();
  holds(says(2), "a button chooses the next frame");
  holds(find("#track .here").getAttribute("cx") !== before, "the mark on the track moves");
  all("#table tbody tr")[last].click();
  holds(says(last), "a row chooses its frame");
  const svg = find("#timeline svg"), box = svg.getBoundingClientRect(), [left] = svg.dataset.inside.split(" ").map(Number);
  const at = { clientX: box.left + left * box.width / svg.viewBox.baseVal.width, clientY: box.top + 20, bubbles: true };
  svg.dispatchEvent(new PointerEvent("pointermove", at));
  holds(!find("#tip").hidden && find("#tip").textContent.startsWith(`Frame ${rows.frame[0]},`), "pointing tells of a frame");
  svg.dispatchEvent(new MouseEvent("click", at));
  holds(says(0), "a click chooses it");
});
