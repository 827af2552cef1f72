// Pictures of one scene lie above each other; a button, or a click on the picture, shows another.
for (const flip of document.querySelectorAll(".flip")) {
  const images = [...flip.querySelectorAll("img")];
  const bar = document.createElement("div");
  bar.className = "buttons";
  const show = (chosen) => images.forEach((image, i) => {
    image.classList.toggle("shown", i === chosen);
    bar.children[i].setAttribute("aria-pressed", i === chosen);
  });
  images.forEach((image, i) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = image.dataset.label;
    button.onclick = () => show(i);
    image.onclick = () => show(i === 0 ? 1 : 0);
    bar.append(button);
  });
  flip.append(bar);
  flip.classList.add("ready");
  show(1);
}
