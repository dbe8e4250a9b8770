(() => {
  "use strict";
  const data = @DATA@;
  const SPEEDS = [0.125, 0.25, 0.5, 1, 2, 4, 8, 16, 32];
  const MARKS = { owed: "\u25cb", met: "\u2713", kept: "\u2713", broken: "\u2715", unknown: "?" };
  const SAYS = { owed: "owed", met: "done", kept: "kept", broken: "can no longer hold", unknown: "not followed" };
  const isWide = () => window.innerWidth > 760;  // as in the style sheet
  const byId = (id) => document.getElementById(id);
  const part = (name) => byId("mission").querySelector("." + name);

  function made(kind, text, name) {
    const element = document.createElement(kind);
    element.textContent = text;
    if (name) element.className = name;
    return element;
  }

  // Where the run stands. Both kinds of run answer the same questions: `now()` says everything, the rest are orders.

  function recorded() {
    const animator = viewer.animator;
    let stopAt = Infinity;

    function revive() {  // what has played to its end would not go on
      for (const action of animator.actions) { action.paused = false; action.enabled = true; }
    }

    function seek(time) {
      stopAt = Infinity;
      animator.pause();
      revive();
      animator.time_scrubber.setValue(time);
      viewer.set_dirty();
    }

    function play() {
      if (animator.time >= animator.duration - 1e-3) seek(0);
      revive();
      animator.play();
    }

    function chapter(time) {
      let index = -1;
      while (index + 1 < data.chapters.length && data.chapters[index + 1].begin <= time + 1e-3) index++;
      return index;
    }

    function change(by) {
      const place = SPEEDS.findIndex((speed) => speed >= animator.mixer.timeScale);
      const next = (place < 0 ? SPEEDS.length : place) + by;
      animator.mixer.timeScale = SPEEDS[Math.min(Math.max(next, 0), SPEEDS.length - 1)];
    }

    return {
      now() {
        if (animator.playing && animator.time >= stopAt) seek(stopAt);
        if (animator.playing && animator.time >= animator.duration) animator.pause();
        const time = animator.time || 0, index = chapter(time), here = data.chapters[index];
        const activities = data.activities && Object.entries(data.activities).map(([name, changes]) =>
          [name, (changes.findLast(([since]) => since <= time + 1e-6) || ["", ""])[1]]);
        return {
          time, index, activities, heading: here ? here.heading : "", lines: here ? here.lines : [],
          goals: here ? here.goals : [], paused: !animator.playing, rate: "\u00d7" + animator.mixer.timeScale, note: "",
        };
      },
      pause() { stopAt = Infinity; animator.playing ? animator.pause() : play(); },
      step() {
        const next = data.chapters[chapter(animator.time) + 1];
        play();
        stopAt = next ? next.begin : Infinity;
      },
      slower() { change(-1); },
      faster() { change(1); },
      seek,
      duration: () => animator.duration,
    };
  }

  function live() {
    let known = { time: 0, index: -1, heading: "Connecting", lines: [], goals: [], activities: [], paused: false,
                  rate: "", note: "" };
    async function ask() {
      try {
        const clock = node(data.root, "clock");
        const seen = clock ? clock.object.position.x : "";  // the run waits for pages that are slow
        known = await (await fetch("status?" + seen, { cache: "no-store" })).json();
        setTimeout(ask, 100);
      } catch (error) {
        known = { ...known, rate: "", paused: true, note: "The program that ran this has ended." };
        for (const button of byId("controls").querySelectorAll("button")) button.disabled = true;
      }
    }
    ask();
    const press = (name) => () => viewer.connection.send(MeshCat.msgpack.encode({ type: "button", name: name }));
    return { now: () => known, pause: press("Pause / go on"), step: press("Single step"),
             slower: press("Slower"), faster: press("Faster"), duration: () => 0 };
  }

  function node(...names) {  // of the scene's tree, looked up without creating it
    let found = viewer.scene_tree;
    for (const name of names) found = found && found.children[name];
    return found;
  }

  const run = data.live ? live() : recorded();

  // What the page says.

  function bar() {
    const ends = data.chapters.slice(1).map((chapter) => chapter.begin);
    const lengths = data.live ? data.steps.map(() => 1) : ends.map((end, i) => end - data.chapters[i].begin);
    const texts = data.live ? data.steps : ends.map((_, i) => data.chapters[i].lines.join("; "));
    const items = lengths.map((length, index) => {
      const button = made("button", index + 1);
      button.title = texts[index];
      button.style.flexGrow = Math.max(length, 1e-3);
      const item = made("li", texts[index]);
      if (data.live) {
        button.disabled = true;
        if (index === data.loop) { item.className = "loop"; item.title = "repeated for ever from here on"; }
      } else {
        const go = () => run.seek(data.chapters[index].begin);
        button.onclick = item.onclick = go;
        item.tabIndex = 0;
        item.onkeydown = (event) => { if (event.key === "Enter") go(); };
      }
      byId("steps").append(button);
      byId("plan").querySelector("ol").append(item);
      return [button, item];
    });
    if (!items.length) byId("plan").hidden = true;
    return items;
  }

  function fill() {
    part("title").textContent = data.title;
    const members = byId("members").querySelector("table");
    const rows = new Map(data.legend.map(([name, colour]) => {
      const row = members.insertRow(), cell = row.insertCell();
      cell.textContent = name;
      cell.className = "name";
      cell.style.setProperty("--colour", colour);
      return [name, row.insertCell()];
    }));
    if (!rows.size) byId("members").hidden = true;
    const colours = new Map(data.legend);
    const goals = byId("goals").querySelector("table");
    const marks = data.demands.map(([owner, formula, meaning]) => {
      const row = goals.insertRow(), mark = row.insertCell(), name = row.insertCell(), text = row.insertCell();
      row.title = meaning;
      mark.className = "mark";
      name.className = "name";
      name.textContent = owner;
      if (colours.has(owner)) name.style.setProperty("--colour", colours.get(owner));
      text.append(made("span", formula), made("div", "", "left"));
      return [row, mark, text.lastChild];
    });
    if (!marks.length) byId("goals").hidden = true;
    byId("members").open = byId("goals").open = isWide();
    byId("plan").open = window.innerWidth > 1050;
    return { rows, marks };
  }

  const items = bar(), { rows, marks } = fill();
  if (data.live) byId("scrubber").remove();
  else byId("scrubber").oninput = (event) => run.seek(Number(event.target.value));
  for (const order of ["pause", "step", "slower", "faster"]) byId(order).onclick = run[order];
  if (!data.live) document.addEventListener("keydown", (event) => {
    if (/^(INPUT|SELECT|BUTTON)$/.test(event.target.tagName)) return;
    const order = { " ": "pause", n: "step", "-": "slower", "+": "faster" }[event.key];
    if (order) { event.preventDefault(); run[order](); }
  });

  let shown = "";
  function show(now) {
    part("clock").textContent = now.time.toFixed(1) + " s";
    byId("pause").textContent = now.paused ? "Go on" : "Pause";
    byId("rate").textContent = now.rate;
    if (!data.live && document.activeElement !== byId("scrubber")) {
      byId("scrubber").max = run.duration();
      byId("scrubber").value = now.time;
    }
    for (const [name, text] of now.activities || []) {
      const cell = rows.get(name);
      if (cell && cell.textContent !== text) cell.textContent = text;
    }
    const state = JSON.stringify([now.index, now.heading, now.lines, now.goals, now.note]);
    if (state === shown) return;
    shown = state;
    part("heading").textContent = now.heading;
    part("actions").replaceChildren(...now.lines.map((line) => made("div", line)));
    part("note").textContent = now.note;
    part("note").hidden = !now.note;
    items.forEach(([button, item], place) => {
      button.classList.toggle("now", place === now.index);
      item.classList.toggle("now", place === now.index);
      if (place === now.index && byId("plan").open) item.scrollIntoView({ block: "nearest" });
    });
    let owed = 0;
    marks.forEach(([row, mark, left], place) => {
      const [standing, rest] = now.goals[place] || ["unknown", ""];
      row.className = standing;
      mark.textContent = MARKS[standing];
      mark.title = SAYS[standing];
      left.textContent = standing === "owed" ? "still: " + rest : standing === "broken" ? SAYS[standing] : "";
      owed += standing === "owed";
    });
    byId("goals").querySelector(".count").textContent = now.goals.length ? `(${owed} still to reach)` : "";
  }

  // The scene: cameras, and names that face the reader.

  const children = (found) => found ? Object.values(found.children) : [];
  const named = (found) => found.flatMap((owner) => owner.children.name ? [owner.children.name.object] : []);
  const place = (object) => object.getWorldPosition(viewer.camera.position.clone());

  function free() {  // the part of the window between the panels, in pixels
    const panel = byId("mission").getBoundingClientRect(), plan = byId("plan").getBoundingClientRect();
    const width = window.innerWidth, bottom = byId("controls").getBoundingClientRect().top;
    if (!isWide()) return { left: 0, right: width, top: panel.bottom + 8, bottom: (plan.top || bottom) - 8 };
    return { left: panel.right + 8, right: byId("plan").open && plan.width ? plan.left - 8 : width, top: 0, bottom };
  }

  function spread() {  // the whole workspace fits there
    const { left, right, top, bottom } = free(), height = window.innerHeight;
    return Math.min(Math.max(1, 1.05 * height / (right - left), 0.9 * height / (bottom - top)), 6);
  }

  function centre() {  // the camera's target is seen in the middle of it
    const { left, right, top, bottom } = free(), width = window.innerWidth, height = window.innerHeight;
    const aside = (width - left - right) / 2, up = isWide() ? 0 : (height - top - bottom) / 2;
    viewer.camera.setViewOffset(width, height, aside, up, width, height);
  }

  const CAMERAS = {
    overview() {
      const away = 3.2 * data.radius * spread(), tilt = 54 * Math.PI / 180;
      aim([0, 0, 0.12 * data.radius], [0, away * Math.sin(tilt), away * Math.cos(tilt)]);
    },
    top() { aim([0, 0, 0.02 * data.radius], [0, 3.5 * data.radius * spread(), 1e-3]); },
  };

  function aim(target, away) {  // in Meshcat's own axes: y up, z towards the reader
    centre();
    viewer.controls.target.set(...target);
    viewer.camera.position.set(...target.map((value, axis) => value + away[axis]));
    viewer.controls.update();
    viewer.set_dirty();
  }

  let followed = null, last = null;
  function choose(name) {
    const [kind, member] = name.split(" ");
    followed = kind === "follow" ? member : null;
    last = null;
    if (CAMERAS[kind]) CAMERAS[kind]();
  }

  function follow() {
    const found = followed && node(data.root, "members", followed);
    if (!found) return;
    const here = place(found.object);
    if (!last) aim(here.toArray(), [0, 0.36 * data.radius * spread(), 0.36 * data.radius * spread()]);
    else if (here.distanceTo(last) > 1e-9) {
      const moved = here.clone().sub(last);
      viewer.camera.position.add(moved);
      viewer.controls.target.add(moved);
      viewer.controls.update();
      viewer.set_dirty();
    }
    last = here;
  }

  const camera = byId("camera");
  for (const name of ["overview", "top", ...data.legend.map(([member]) => "follow " + member)]) {
    camera.append(made("option", name));
  }
  if (!data.radius) camera.parentElement.remove();
  camera.onchange = () => choose(camera.value);

  function size(mesh) {
    if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
    return mesh.geometry.boundingBox.max.y - mesh.geometry.boundingBox.min.y;
  }

  function legible(plate, towards) {  // between 15 and 26 pixels high, and turned to the camera if `towards` is given
    const distance = place(plate).distanceTo(place(viewer.camera));
    const pixel = 2 * distance * Math.tan(viewer.camera.fov * Math.PI / 360) / window.innerHeight;
    const turned = towards && plate.getWorldQuaternion(towards.clone()).invert().multiply(towards);
    for (const child of plate.children) {
      if (turned) child.quaternion.copy(turned);
      child.traverse((mesh) => {
        if (mesh.geometry) {
          child.scale.setScalar(Math.max(15 * pixel / size(mesh), Math.min(1, 26 * pixel / size(mesh))));
        }
      });
    }
  }

  let seen = "";
  function face() {
    const towards = viewer.camera.getWorldQuaternion(viewer.camera.quaternion.clone());
    const view = [...towards.toArray(), ...place(viewer.camera).toArray()].join();
    if (view !== seen) viewer.set_dirty();
    seen = view;
    for (const plate of named(children(node(data.root, "members")))) legible(plate, towards);
    for (const plate of named(children(node(data.root, "regions")))) legible(plate, null);
  }

  let placed = false;
  function tick() {
    if (!placed && data.radius && children(node(data.root, "members")).length) {
      placed = true;
      CAMERAS.overview();
    }
    show(run.now());
    follow();
    face();
    requestAnimationFrame(tick);
  }
  window.addEventListener("resize", () => { if (!followed) choose(camera.value); });
  tick();
})();
