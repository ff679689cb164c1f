"use strict";
// Contents are folded where they would fill a phone, and after a choice.
const menu = document.querySelector(".menu"), narrow = matchMedia("(max-width: 1000px)");
const fold = () => { menu.open = !narrow.matches; };
narrow.addEventListener("change", fold);
fold();
menu.addEventListener("click", event => { if (event.target.tagName === "A") { fold(); } });
// A link opens the folded parts that it leads into.
const unfold = () => {
  const aim = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!aim) { return; }
  for (let part = aim.closest("details"); part; part = part.parentElement.closest("details")) { part.open = true; }
  aim.scrollIntoView();
};
addEventListener("hashchange", unfold);
unfold();
// The view of a figure of curves: x, y, width and height of what is seen of it.
for (const card of document.querySelectorAll(".zooms")) {
  const drawn = card.querySelector("svg");
  const whole = drawn.getAttribute("viewBox").split(/[ ,]+/).map(Number);
  let view = [...whole], from = null;
  const show = () => drawn.setAttribute("viewBox", view.join(" "));
  const move = (x, y) => {
    view[0] = Math.min(Math.max(view[0] + x * view[2], whole[0]), whole[0] + whole[2] - view[2]);
    view[1] = Math.min(Math.max(view[1] + y * view[3], whole[1]), whole[1] + whole[3] - view[3]);
    show();
  };
  const zoom = (factor, x = 0.5, y = 0.5) => {  // about a point, in parts of what is seen
    const width = Math.min(Math.max(view[2] * factor, whole[2] / 40), whole[2]);
    const part = width / view[2];
    view = [view[0] + (1 - part) * x * view[2], view[1] + (1 - part) * y * view[3], width, part * view[3]];
    move(0, 0);
  };
  const place = event => {
    const box = drawn.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };
  // The wheel scrolls the page until the figure was chosen by a click, or with Ctrl.
  card.addEventListener("wheel", event => {
    if (document.activeElement !== card && !event.ctrlKey) { return; }
    event.preventDefault();
    zoom(Math.exp(event.deltaY / 500), ...place(event));
  }, { passive: false });
  card.addEventListener("pointerdown", event => {
    if (event.pointerType !== "mouse" || event.button !== 0) { return; }
    from = place(event);
    card.setPointerCapture(event.pointerId);
  });
  card.addEventListener("pointermove", event => {
    if (from === null || view[2] === whole[2]) { return; }
    const [x, y] = place(event);
    move(from[0] - x, from[1] - y);
    from = [x, y];
  });
  for (const end of ["pointerup", "pointercancel"]) { card.addEventListener(end, () => { from = null; }); }
  card.addEventListener("dblclick", () => { view = [...whole]; show(); });
  const keys = {
    "+": () => zoom(0.8), "=": () => zoom(0.8), "-": () => zoom(1.25), "0": () => { view = [...whole]; show(); },
    ArrowLeft: () => move(-0.1, 0), ArrowRight: () => move(0.1, 0),
    ArrowUp: () => move(0, -0.1), ArrowDown: () => move(0, 0.1),
  };
  card.addEventListener("keydown", event => {
    const whatever = view[2] === whole[2] && event.key.startsWith("Arrow");  // these scroll the page
    if (keys[event.key] && !whatever && !event.ctrlKey && !event.metaKey) { event.preventDefault(); keys[event.key](); }
  });
}
