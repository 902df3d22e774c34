// A cursor over each chart with the values at the nearest step. The page says all without it.
(() => {
  const tip = document.querySelector(".tip");
  for (const chart of document.querySelectorAll("svg[data-hover]")) {
    const points = JSON.parse(chart.dataset.hover);
    const cursor = chart.querySelector(".cursor");
    if (!points.length || !cursor) continue;
    const leave = () => {
      cursor.classList.remove("on");
      tip.hidden = true;
    };
    chart.addEventListener("pointerleave", leave);
    chart.addEventListener("pointercancel", leave);
    chart.addEventListener("pointermove", (event) => {
      const box = chart.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * chart.viewBox.baseVal.width;
      const near = points.reduce((a, b) => (Math.abs(b[0] - x) < Math.abs(a[0] - x) ? b : a));
      cursor.setAttribute("x1", near[0]);
      cursor.setAttribute("x2", near[0]);
      cursor.classList.add("on");
      tip.textContent = [near[1], ...near[2]].join("\n");
      tip.hidden = false;
      const left = event.clientX + 16;
      const over = left + tip.offsetWidth > window.innerWidth - 8;
      tip.style.left = `${Math.max(8, over ? event.clientX - 16 - tip.offsetWidth : left)}px`;
      tip.style.top = `${Math.max(8, event.clientY - tip.offsetHeight - 12)}px`;
    });
  }
})();
