"""What is put into an exported Meshcat page: caption, clock, legend, a bar of the steps, names that face the reader.

It asks for nothing outside the page. `@DATA@` stands for the JSON of `recorded_page.with_overlay`.
"""

OVERLAY = """
<style>
  #mission { position: fixed; left: 16px; top: 14px; max-width: min(46ch, 60vw); pointer-events: none; z-index: 5;
    font: 14px/1.4 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; color: #22282e;
    background: rgba(255, 255, 255, .86); border-radius: 8px; padding: 10px 14px;
    box-shadow: 0 1px 6px rgba(30, 45, 60, .18); }
  #mission .top { display: flex; justify-content: space-between; gap: 1.5em; color: #5a646d; font-size: 12px; }
  #mission .clock { font-variant-numeric: tabular-nums; white-space: nowrap; }
  #mission .heading { font-weight: 600; margin-top: 2px; }
  #mission .legend { margin-top: 6px; font-size: 12px; display: flex; flex-wrap: wrap; gap: 2px 12px; }
  #mission .legend span::before { content: ""; display: inline-block; width: 10px; height: 10px; border-radius: 5px;
    margin-right: 5px; background: var(--colour); }
  #steps { position: fixed; left: 16px; right: 16px; bottom: 12px; height: 22px; display: flex; gap: 2px; z-index: 5;
    font: 11px/22px system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; }
  #steps button { all: unset; box-sizing: border-box; min-width: 3px; overflow: hidden; text-align: center;
    color: #22282e; background: rgba(255, 255, 255, .8); border-radius: 3px; cursor: pointer; flex-basis: 0;
    box-shadow: 0 0 2px rgba(30, 45, 60, .35); }
  #steps button:hover, #steps button:focus-visible { background: #dbe6ef; }
  #steps button.now { background: #0072b2; color: white; }
</style>
<div id="mission" role="status"><div class="top"><span class="title"></span><span class="clock"></span></div>
  <div class="heading"></div><div class="actions"></div><div class="legend"></div></div>
<nav id="steps" aria-label="steps of the plan"></nav>
<script>
(() => {
  const data = @DATA@;
  const box = document.getElementById("mission"), bar = document.getElementById("steps");
  const part = (name) => box.querySelector("." + name);
  const line = (text) => { const div = document.createElement("div"); div.textContent = text; return div; };
  part("title").textContent = data.title;
  for (const [name, colour] of data.legend) {
    const item = document.createElement("span");
    item.textContent = name;
    item.style.setProperty("--colour", colour);
    part("legend").append(item);
  }

  function seek(time) {
    viewer.animator.pause();
    viewer.animator.time_scrubber.setValue(time);
    viewer.set_dirty();
  }

  const ends = data.captions.slice(1).map(([begin]) => begin);
  const buttons = data.captions.slice(0, ends.length).map(([begin, lines], index) => {
    const button = document.createElement("button");
    button.textContent = index + 1;
    button.title = lines.join("\\n");
    button.style.flexGrow = Math.max(ends[index] - begin, 1e-3);
    button.onclick = () => seek(begin);
    bar.append(button);
    return button;
  });

  let shown = -1;
  function caption(time) {
    let index = -1;
    while (index + 1 < data.captions.length && data.captions[index + 1][0] <= time + 1e-6) index++;
    part("clock").textContent = time.toFixed(1) + " s";
    if (index === shown) return;
    shown = index;
    const lines = index < 0 ? [] : data.captions[index][1];
    part("heading").textContent = lines[0] || "";
    part("actions").replaceChildren(...lines.slice(1).map(line));
    buttons.forEach((button, place) => button.classList.toggle("now", place === index));
  }

  function plates() {  // the moving names; looked up without creating nodes
    let node = viewer.scene_tree;
    for (const name of [data.root, "members"]) node = node && node.children[name];
    const members = node ? Object.values(node.children) : [];
    return members.flatMap((member) => member.children.name ? [member.children.name.object] : []);
  }

  const place = (node) => node.getWorldPosition(viewer.camera.position.clone());
  let seen = "";
  function height(mesh) {
    if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
    return mesh.geometry.boundingBox.max.y - mesh.geometry.boundingBox.min.y;
  }

  function face() {  // turn every name towards the camera and keep it small for who comes close
    const towards = viewer.camera.getWorldQuaternion(viewer.camera.quaternion.clone());
    const view = [...towards.toArray(), ...place(viewer.camera).toArray()].join();
    if (view !== seen) viewer.set_dirty();
    seen = view;
    for (const plate of plates()) {
      const largest = 0.03 * place(plate).distanceTo(place(viewer.camera));
      const turned = plate.getWorldQuaternion(towards.clone()).invert().multiply(towards);
      for (const child of plate.children) {
        child.quaternion.copy(turned);
        child.traverse((part) => {
          if (part.geometry) child.scale.setScalar(Math.min(1, largest / height(part)));
        });
      }
    }
  }

  function tick() {
    caption(viewer.animator.time || 0);
    face();
    requestAnimationFrame(tick);
  }
  tick();
})();
</script>
"""
