// Appended to a copy of every page whose style is that of print, as wide as a sheet: nothing is cut where nobody can scroll, what is closed
// on a screen is there but the list of every reason, and what is for a hand is not.
window.addEventListener("load", () => {
  for (const box of document.querySelectorAll(".scroll, .profile, pre, figure")) {
    const out = box.scrollWidth - box.clientWidth;
    if (out > 1) throw new Error(`${out} pixels of a ${box.className || box.tagName} are cut on paper`);
  }
  for (const inside of document.querySelectorAll("details:not(.every) > :not(summary)")) {
    if (!inside.getBoundingClientRect().height) throw new Error("closed details are not on paper");
  }
  for (const control of document.querySelectorAll(".transport, .rows")) {
    if (control.getClientRects().length) throw new Error(`${control.className} is on paper`);
  }
});
