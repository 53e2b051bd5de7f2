"""What tests of pages run in the browser."""

# How many pixels of the view have a colour.
COUNT = """(wanted) => {
  const view = document.getElementById("view"), copy = document.createElement("canvas");
  Object.assign(copy, { width: view.width, height: view.height });
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(view, 0, 0);
  const p = context.getImageData(0, 0, view.width, view.height).data;
  let n = 0;
  for (let i = 0; i < p.length; i += 4) {
    const away = Math.abs(p[i] - wanted[0]) + Math.abs(p[i + 1] - wanted[1]) + Math.abs(p[i + 2] - wanted[2]);
    n += away < 12 && p[i + 3] > 200;
  }
  return n;
}"""
