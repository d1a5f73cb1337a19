// Runs in a copy of a report after its last element: what a reader would see wrong, as a list of sentences.
const found = [];
const name = (element) => `"${element.textContent.trim().slice(0, 40)}"`;
const overlap = (a, b) =>
  Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2;
document.querySelectorAll("details").forEach((details) => (details.open = true));
for (const svg of document.querySelectorAll("svg")) {
  const of = ` in "${svg.getAttribute("aria-label")}"`;
  const frame = svg.getBoundingClientRect();
  const texts = [...svg.querySelectorAll("text")].filter((text) => text.textContent.trim());
  const boxes = texts.map((text) => text.getBoundingClientRect());
  boxes.forEach((box, i) => {
    const inside = box.left > frame.left - 1 && box.right < frame.right + 1 && box.top > frame.top - 1 && box.bottom < frame.bottom + 1;
    if (!inside) found.push(`${name(texts[i])} leaves the drawing${of}`);
    for (let j = 0; j < i; j++) if (overlap(box, boxes[j])) found.push(`${name(texts[i])} lies over ${name(texts[j])}${of}`);
  });
  if (!svg.getAttribute("aria-label") && !svg.getAttribute("aria-hidden")) found.push("a drawing has no name for screen readers");
  if (/NaN|Infinity/.test(svg.innerHTML)) found.push(`a position is no number${of}`);
}
const channels = (colour) => (colour.match(/[\d.]+/g) ?? []).map(Number);
const light = (colour) => {
  const [r, g, b] = channels(colour).map((c) => (c / 255 <= 0.03928 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const behind = (element) => {
  for (let at = element; at; at = at.parentElement) {
    const colour = getComputedStyle(at).backgroundColor;
    if (channels(colour)[3] !== 0) return colour;
  }
  return "rgb(255, 255, 255)";
};
const seen = new Set();
for (const element of document.querySelectorAll("main *")) {
  if (![...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim())) continue;
  if (element.tagName === "title") continue;
  const style = getComputedStyle(element);
  const colours = [element.closest("svg") ? style.fill : style.color, behind(element)];
  const [dark, bright] = colours.map(light).sort((a, b) => a - b);
  const contrast = (bright + 0.05) / (dark + 0.05);
  if (contrast < 4.5 && !seen.has(colours.join())) {
    seen.add(colours.join());
    found.push(`${name(element)} has a contrast of ${contrast.toFixed(1)}, less than 4.5`);
  }
}
const ids = [...document.querySelectorAll("[id]")].map((element) => element.id);
ids.filter((id, i) => ids.indexOf(id) < i).forEach((id) => found.push(`two elements have the name ${id}`));
if (document.documentElement.scrollWidth > innerWidth + 1) found.push("the page is wider than the window");
const loaded = performance.getEntriesByType("resource");
loaded.filter((entry) => location.protocol === "file:" || !entry.name.startsWith(location.origin)).forEach((entry) => found.push(`${entry.name} was loaded from outside`));
const result = document.createElement("pre");
result.id = "page-check";
result.textContent = JSON.stringify({ dark: matchMedia("(prefers-color-scheme: dark)").matches, found });
document.body.append(result);
