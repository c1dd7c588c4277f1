"use strict";
// Unpacks the plotting library and draws each figure when it comes near, in the colours of the theme.
(async () => {
  const packed = Uint8Array.from(atob(document.getElementById("library").textContent), (c) => c.charCodeAt(0));
  const source = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const library = document.createElement("script");
  library.textContent = await new Response(source).text();
  document.head.append(library);

  const figures = [...document.querySelectorAll("figure.plot")];
  const drawn = new Set();
  const buttons = ["toImage", "zoom2d", "pan2d", "resetScale2d"];
  const config = {displaylogo: false, responsive: true, modeBarButtons: [buttons]};

  function draw(figure, width) {
    const colours = getComputedStyle(document.documentElement);
    const text = figure.querySelector("script").textContent
      .replace(/var\((--[\w-]+)\)/g, (_, name) => colours.getPropertyValue(name).trim());
    const {data, layout} = JSON.parse(text);
    const canvas = figure.querySelector(".canvas");
    drawn.add(figure);
    return Plotly.react(canvas, data, {...layout, height: canvas.clientHeight, width}, config);
  }

  const near = new IntersectionObserver((entries) => {
    for (const {isIntersecting, target} of entries) {
      if (isIntersecting && !drawn.has(target)) draw(target);
    }
  }, {rootMargin: "1200px"});
  figures.forEach((figure) => near.observe(figure));

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawn.forEach((figure) => draw(figure)));

  // On paper everything is open, in the colours of the light theme. What is as wide as a sheet is measured there: figures are
  // drawn as on the screen and made smaller, further where a page is too low, and so are tables that are too wide.
  const smaller = 0.72;
  const tallest = 960;
  const paper = document.getElementById("paper");
  const tables = [...document.querySelectorAll("table")];

  function drawOnPaper(figure) {
    const canvas = figure.querySelector(".canvas");
    const scale = Math.min(smaller, tallest / canvas.clientHeight);
    draw(figure, canvas.clientWidth / scale);
    canvas.style.setProperty("--scale", scale);
  }

  function fit(table) {
    const room = table.parentElement.clientWidth;
    table.classList.toggle("wide", table.offsetWidth > room / smaller);
    table.style.setProperty("--scale", Math.min(1, room / table.offsetWidth));
  }

  addEventListener("beforeprint", () => {
    paper.media = "all";
    document.documentElement.classList.add("paper");
    document.querySelectorAll("details:not([open])").forEach((fold) => { fold.dataset.closed = ""; fold.open = true; });
    figures.forEach(drawOnPaper);
    tables.forEach(fit);
  });
  addEventListener("afterprint", () => {
    paper.media = "print";
    document.documentElement.classList.remove("paper");
    document.querySelectorAll("details[data-closed]").forEach((fold) => { delete fold.dataset.closed; fold.open = false; });
    tables.forEach((table) => table.style.removeProperty("--scale"));
    drawn.clear();
    figures.forEach((figure) => {
      const canvas = figure.querySelector(".canvas");
      canvas.style.removeProperty("--scale");
      Plotly.purge(canvas);
      near.unobserve(figure);
      near.observe(figure);
    });
  });
})();
