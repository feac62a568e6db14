// Appended to every page, behind what is checked of it alone: no picture is broken, and nothing is wider than a narrow screen.
window.addEventListener("load", () => {
  for (const picture of document.images) {
    if (!picture.complete || !picture.naturalWidth) throw new Error(`a picture is broken: ${picture.alt}`);
  }
  const wide = document.documentElement.scrollWidth;
  if (wide > innerWidth) throw new Error(`the page is ${wide} wide in a window of ${innerWidth}`);
  document.body.dataset.checked = "yes";
});
